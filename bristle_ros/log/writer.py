"""A run on disk: samples, commands, events and the scene, written beside the run by a thread."""
from collections import deque
import threading
import time

from bristle_ros.messages import (encode as messages, encode_transforms, robot_description, SCENE,
                                  schema_text, TYPE_HASHES)
from bristle_ros.scene import SceneError

from .bag_metadata import qos_text
from .head import head_of

CAPACITY = 4096         # [samples] in the queue: 4 s at 1 kHz
CLOSE_TIMEOUT = 4.0     # [s] launch kills what has not ended 5 s after Ctrl-C
CONTRACT_NAME = 'bristle_ros'   # channel metadata: the topic's name before remapping
_LATCHED = {SCENE, messages.DESCRIPTION}


def _in_node(name):
    """Return the topic `name` of a node `/brush_node` as ROS resolves it."""
    return f'/brush_node/{name[2:]}' if name.startswith('~/') else f'/{name.lstrip("/")}'


class Log:
    """
    The log of a run. Use it as a context manager: leaving it completes the file.

    What is given is owned by the log from then on. Nothing here raises once the file is made:
    when it cannot be written any more, `failed` says why, and what comes later is dropped.
    Steps count from the run's start, through resets.
    """

    def __init__(self, path, scene, *, resolve=_in_node, origin=0, compression=None,
                 key='log.path', capacity=CAPACITY):
        """
        Make the bag directory `path`, or the file if it ends in `.mcap`.

        `resolve`: contract name -> full topic name; `origin` [ns]: added to simulation time;
        `key`: what a message about a bad path calls it. Raises SceneError.
        """
        from .bag import Bag, MEGABYTE, reason_of  # a node without a log needs no mcap
        self._reason_of = reason_of
        self.failed = None      # why logging ended, or None
        self.waited = 0         # calls that had to wait for the disk
        self._integration_time_step = scene.solver.integration_time_step
        self._origin = origin
        self._resolve = resolve
        self._channels = {}
        self._topics = messages.topics(scene.run.frame_prefix)
        self._commands = messages.command_types(scene.run.stamped_cmd_vel)
        self._frame_prefix = scene.run.frame_prefix
        self._prefix = scene.run.frame_prefix if scene.log.tf else None
        self._capacity = capacity
        self._queue, self._backlog = deque(), 0
        self._changed = threading.Condition()
        self._closing = False
        self._file = Bag(path, key, compression=compression or scene.log.compression,
                         max_size=round(scene.log.max_size * MEGABYTE))
        try:
            self._write_head(scene)
        except OSError as error:
            self._file.discard()
            raise SceneError(f'{reason_of(error)}; name another place', key=key,
                             value=str(path)) from None
        self._worker = threading.Thread(target=self._run, name='log', daemon=True)
        self._worker.start()

    @property
    def backlog(self):
        """Return samples that wait to be written."""
        return self._backlog

    def write(self, chunk):
        """
        Log a chunk's samples, events and failure; returns whether it had to wait for the disk.

        `chunk` has `samples`: Snapshots, `events`: (step, kind, topic, values) each, with kind
        `command`, `timeout` or `reset`, `failure`: None or an error with `reason`, and `mount`:
        None or a Pose, which gives /tf at the chunk's end.
        """
        weight = len(chunk.samples) + len(chunk.events) + (chunk.failure is not None)
        return weight > 0 and self._put(weight, self._store_chunk, chunk, time.time_ns())

    def event(self, step, event, **details):
        """Log a load decision or the like: JSON on `~/events`."""
        return self._put(1, self._store_message, step, messages.EVENTS, messages.STRING,
                         messages.encode_event(event, step, **details), time.time_ns())

    def message(self, step, topic, type_name, payload):
        """Log any other message, such as `/diagnostics`."""
        return self._put(1, self._store_message, step, topic, type_name, payload, time.time_ns())

    def close(self):
        """Write all that waits, complete the file, and return within 5 s; twice does no harm."""
        with self._changed:
            self._closing = True
            self._changed.notify_all()
        self._worker.join(CLOSE_TIMEOUT)
        if self._worker.is_alive() and self.failed is None:
            self.failed = (f'{self._file.place}: the disk did not take the rest within '
                           f'{CLOSE_TIMEOUT} s')

    def __enter__(self):
        """Return the log."""
        return self

    def __exit__(self, *_):
        """Complete the file."""
        self.close()

    def _put(self, weight, store, *arguments):
        with self._changed:
            waited = False
            # One call may be larger than the queue: it goes in alone.
            while self._backlog and self._backlog + weight > self._capacity:
                if self._closing or self.failed:
                    return waited
                waited = True
                self._changed.wait()
            if self._closing or self.failed:
                return waited
            self.waited += waited
            self._queue.append((weight, store, arguments))
            self._backlog += weight
            self._changed.notify_all()
        return waited

    def _run(self):
        try:
            while self._work():
                pass
            self._file.finish()
        except Exception as error:  # the run goes on whatever happens here
            self._fail(error)

    def _work(self):
        """Store what is in the queue; False when there is nothing left and no more to come."""
        with self._changed:
            if not self._queue and not self._closing:
                self._changed.wait(self._file.due())
            items = list(self._queue)
            self._queue.clear()
            last = self._closing
        for weight, store, arguments in items:
            store(*arguments)
            self._file.keep()
            with self._changed:
                self._backlog -= weight
                self._changed.notify_all()
        self._file.keep()
        return items or not last

    def _fail(self, error):
        with self._changed:
            self.failed = f'{self._file.place}: {self._reason_of(error)}'
            self._queue.clear()
            self._backlog = 0
            self._changed.notify_all()
        try:
            self._file.abandon()
        except OSError:
            pass  # `failed` has said it already; the messages are safe without their summary

    def _stamp(self, step):
        return messages.stamp_ns(step, self._integration_time_step, self._origin)

    def _store_chunk(self, chunk, wall):
        events = deque(chunk.events)
        for snapshot in chunk.samples:
            # At one step the sample comes first: it is the state that the event found.
            while events and events[0].step < snapshot.step:
                self._store_event(events.popleft(), wall)
            stamp = self._stamp(snapshot.step)
            for topic in self._topics:
                self._file.add(self._channel(topic.name, topic.type), stamp, wall,
                               topic.encode(snapshot, stamp))
        for event in events:
            self._store_event(event, wall)
        if self._prefix is not None and chunk.mount is not None and chunk.end > chunk.start:
            self._store_message(chunk.end, messages.TRANSFORMS, messages.TF, encode_transforms(
                self._stamp(chunk.end), self._prefix, chunk.last, chunk.mount, 'all'), wall)
        if chunk.wrench is not None and chunk.end > chunk.start:
            topic = messages.mean_wrench_topic(self._frame_prefix, lambda: chunk.wrench)
            self._store_message(chunk.end, topic.name, topic.type, topic.encode(
                chunk.last, self._stamp(chunk.end)), wall)
        if chunk.failure is not None:
            self._store_message(chunk.end, messages.EVENTS, messages.STRING, messages.encode_event(
                'failure', chunk.end, reason=str(chunk.failure)), wall)

    def _store_event(self, event, wall):
        step, kind, topic, values = event
        if topic:
            type_name = self._commands[topic]
            payload = messages.encode_command(type_name, values, self._stamp(step))
            self._store_message(step, topic, type_name, payload, wall)
        if kind != 'command':
            details = {'topic': topic} if topic else {}
            if kind == 'load':
                details['error_tolerance'] = values[0]
            self._store_message(step, messages.EVENTS, messages.STRING,
                                messages.encode_event(kind, step, **details), wall)

    def _store_message(self, step, topic, type_name, payload, wall):
        self._file.add(self._channel(topic, type_name), self._stamp(step), wall, payload)

    def _channel(self, name, type_name):
        if name not in self._channels:
            self._channels[name] = self._file.channel(
                self._resolve(name), type_name, schema_text(type_name).encode(),
                {'offered_qos_profiles': qos_text(latched=name in _LATCHED),
                 'topic_type_hash': TYPE_HASHES[type_name], CONTRACT_NAME: name})
        return self._channels[name]

    def _write_head(self, scene):
        head = head_of(scene, self._origin, self._resolve)
        self._file.add_metadata('bristle_ros.scene', {'yaml': head.yaml})
        self._file.add_metadata('bristle_ros.machine', head.machine)
        self._file.add_metadata('bristle_ros.run', head.run)
        self._file.add_attachment('scene.yaml', 'application/yaml', head.yaml.encode())
        # With this first message in the file, one that was killed at once has a channel to read.
        self._store_message(0, messages.EVENTS, messages.STRING,
                            messages.encode_event('start', 0), time.time_ns())
        self._latch(SCENE, messages.STRING, head.message)
        if scene.log.tf:
            self._latch(messages.DESCRIPTION, messages.STRING,
                        messages.encode_string(robot_description(scene)))
        self._file.flush()

    def _latch(self, topic, type_name, payload):
        self._file.latch(self._channel(topic, type_name), self._stamp(0), time.time_ns(), payload)
