"""The bag of a recorder in the order of the run: its own is that in which messages came."""
import heapq

from bristle_ros.messages import encode as messages, SCENE
from bristle_ros.scene import SceneError

_WINDOW = 5000  # messages by which topics may have overtaken each other, some seconds
_USED = {*(topic.name for topic in messages.TOPICS), SCENE}
_REFUSED = ('plot and replay can use it, --verify wants all of ~/events, or a log of log.path')


def in_order(recording):
    """
    Yield the entries of a recorder's bag as its node's log would have them.

    Commands come from `~/events`, which tells when they took effect. /tf is left out: others write
    it too. Raises SceneError where events are missing.
    """
    events = _events(recording)
    heap = []
    for count, entry in enumerate(recording.entries()):
        if entry.name not in _USED:
            continue
        # The scene comes whenever the recorder has found it; a state is before what it found.
        step = 0 if entry.name == SCENE else entry.step
        heapq.heappush(heap, (step, count, entry._replace(step=step)))
        if len(heap) > _WINDOW:
            yield from _up_to(heapq.heappop(heap)[2], events)
    while heap:
        yield from _up_to(heapq.heappop(heap)[2], events)


def _up_to(entry, events):
    """Yield the events that lie before an entry, and the entry."""
    while events and events[-1].step < entry.step:
        yield events.pop()
    yield entry


def _events(recording):
    """Return the entries of all events of the run, the last one first."""
    found = {}
    for entry in recording.entries():
        event = messages.decode_event(entry.message.data) if entry.name == messages.EVENTS else {}
        number, step = event.get('number'), event.get('step')
        if isinstance(number, int) and isinstance(step, int):
            found[number] = entry._replace(step=step)
            if event.get('event') == 'clock':
                raise SceneError(f'made by a recorder of a node that followed /clock: {_REFUSED}',
                                 source=str(recording.path))
    if not found or max(found) != len(found) - 1 or min(found):
        raise SceneError(f'made by a recorder, and events are missing: {_REFUSED}',
                         source=str(recording.path))
    return [found[number] for number in sorted(found, reverse=True)]
