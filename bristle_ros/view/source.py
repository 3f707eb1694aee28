"""Where frames come from: what a page asks of each kind of source, and the simulated scene."""
from collections import deque
import multiprocessing
import threading

from bristle_ros.scene import bristle_count, SceneError
from bristle_ros.simulation import check_command
import numpy as np

from . import child
from .frame import COLUMNS, Status, tracked, Update

ENDING = 5.0    # [s] that a process may take to end


class Process:
    """A process that makes frames, and what it has told since it was last asked."""

    def __init__(self, make, *arguments):
        """Start; `make` and arguments as child.main takes them."""
        context = multiprocessing.get_context('spawn')
        self._connection, theirs = context.Pipe()
        self._process = context.Process(target=child.main, args=(theirs, make, *arguments),
                                        name='bristle_ros view', daemon=True)
        self._process.start()
        theirs.close()
        self._told, self._telling = deque(), threading.Lock()
        threading.Thread(target=self._listen, name='listen', daemon=True).start()

    def _listen(self):
        try:
            while True:
                self._told.append(self._connection.recv())
        except (EOFError, OSError):
            self._told.append((child.FAILED, child.GONE))

    def told(self):
        """Yield (kind, what) in the order in which they came."""
        while self._told:
            yield self._told.popleft()

    def tell(self, *order):
        """Have it obey an order, when it can."""
        try:
            with self._telling:     # callbacks of several browsers
                self._connection.send(order)
        except OSError:
            pass    # it has ended, and `told` says so

    def close(self):
        """End it."""
        self.tell(*child.END)
        self._process.join(ENDING)
        if self._process.is_alive():
            self._process.kill()
            self._process.join()


class SceneSource:
    """
    A scene that is simulated while it is looked at.

    What all sources have: `scene`, None until it is known; `duration` [s], None unless it is
    played; `update()`, what is new; `pause`, `set_factor` and `close`. What can be commanded has
    `command`, which raises CommandRefused in the scene's own words, `step` and `reset`; what is
    played has `seek`.
    """

    duration = None

    def __init__(self, scene):
        """Start; the first frame comes when the scene has been compiled."""
        if scene.log.path:
            raise SceneError('a view keeps no log: start brush_node with it, and view --node',
                             key='log.path', value=scene.log.path)
        self.scene = scene
        self._status = Status(asked=scene.run.real_time_factor)
        self._process = Process(child.Run, scene)

    def update(self):
        """Return the Update since the last call."""
        frame, rows = None, []
        for kind, what in self._process.told():
            if kind == child.SHOWN:
                newest, more, self._status = what
                frame = newest or frame
                rows += more
            elif self._status.state != 'ended':
                self._status = self._status._replace(state='ended', text=what)
        return update_of(frame, rows, self._status, self.scene)

    def command(self, topic, values):
        """Follow a command from the next chunk on."""
        self._process.tell('command', topic, check_command(self.scene, topic, values))

    def pause(self, hold):
        """Hold, or go on."""
        self._process.tell('pause' if hold else 'resume')

    def step(self):
        """Simulate one chunk, while paused."""
        self._process.tell('step')

    def reset(self):
        """Go back to the scene's start."""
        self._process.tell('reset')

    def set_factor(self, factor):
        """Take another real-time factor; 0 is as fast as it goes."""
        self._process.tell('factor', factor)

    def close(self):
        """End the process that simulates."""
        self._process.close()


def update_of(frame, rows, status, scene):
    """Return the Update of rows (row, trail) as they came."""
    points = len(tracked(bristle_count(scene)))
    return Update(
        frame, np.array([row for row, _ in rows]).reshape(len(rows), len(COLUMNS)),
        np.array([trail for _, trail in rows]).reshape(len(rows), points, 3), status)
