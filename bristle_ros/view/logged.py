"""A log that is played: its clock, and the frame of each time."""
from bisect import bisect_right
from pathlib import Path
import time

from bristle_ros.log import Recording
from bristle_ros.scene import bristle_count
import numpy as np

from . import log_run
from .curves import SPAN
from .frame import COLUMNS, Status, straight, tracked, Update
from .source import Process


class LogSource:
    """
    A log, also one that was cut off, as source.SceneSource is a source.

    path : of the log; clock() -> [s] steady, turned by hand in tests.
    """

    def __init__(self, path, clock=time.monotonic):
        """Read its scene, and start reading the rest; raises SceneError."""
        self.scene = Recording(path).scene
        self._name, self._clock = Path(path).name, clock
        self._logged, self._frames, self._times, self._trails = None, [], [], []
        self._note, self._failure = 'reading the log', ''
        self._playing, self._rate, self._simulating = True, 1.0, True
        self._t = self._shown = 0.0     # [s] where it is, and up to where rows have been given
        self._again, self._moved = True, True
        self._before = clock()
        self._process = Process(log_run.LogRun, path)

    @property
    def duration(self):
        """[s] of the log; 0 until it has been read."""
        return self._logged.duration if self._logged else 0.0

    def update(self):
        """Return the Update since the last call."""
        self._listen()
        self._go_on()
        if self._logged is None:
            empty = np.empty((0, len(COLUMNS))), np.empty((0, 1, 3))
            return Update(None, *empty, Status(self._failure and 'ended' or 'reading', 0.0, 1.0,
                                               text=self._failure, late=None, error=None))
        afresh, self._again = self._again, False
        begin = self._t - SPAN if afresh else self._shown
        times = self._logged.rows[:, 0]
        rows = self._logged.rows[(times > begin) & (times <= self._t + 1e-9)]
        self._shown = self._t
        trail = self._trail(begin)
        return Update(self._frame(), rows, trail, self._status(), afresh)

    def _listen(self):
        for kind, what in self._process.told():
            if kind == log_run.DATA:
                self._logged, self._before = what, self._clock()
                self._note = self._logged.note
            elif kind == log_run.FRAMES_MADE:
                for frame, trail in what:
                    self._frames.append(frame)
                    self._times.append(frame.t)
                    self._trails.append(trail)
                self._moved = True
            elif kind == log_run.NOTE:
                self._note, self._simulating = what or self._logged.note, False
            elif self._simulating:
                self._failure, self._simulating = what, False

    def _go_on(self):
        now, before = self._clock(), self._before
        self._before = now
        if self._logged is None or not self._playing:
            return
        if self._t >= self.duration:
            self.seek(0.0)      # once more
            return
        end = self.duration
        if self._simulating:    # wait for the wires
            end = max(self._t, self._times[-1] if self._times else 0.0)
        self._t = min(self._t + self._rate * (now - before), end)
        self._moved = True

    def _frame(self):
        if not self._moved:
            return None
        self._moved = False
        found = bisect_right(self._times, self._t + 1e-9) - 1
        gap = (self._times[1] - self._times[0]) if len(self._times) > 1 else self.scene.run.chunk
        if found >= 0 and self._t - self._times[found] <= 1.5 * gap:
            return self._frames[found]
        row = self._logged.at(self._t)
        return log_run.straight_frame(
            self._logged, row, straight(self.scene, float(self._logged.theta[row])))

    def _trail(self, begin):
        low, high = bisect_right(self._times, begin), bisect_right(self._times, self._t + 1e-9)
        points = len(tracked(bristle_count(self.scene)))
        return np.array(self._trails[low:high]).reshape(high - low, points, 3)

    def _status(self):
        texts = [self._failure or self._note]
        if self._simulating:
            reached = self._times[-1] if self._times else 0.0
            texts.append(f'simulating the wires again: {reached:.1f} of {self.duration:.1f} s')
        row = self._logged.at(self._t)
        return Status('playing' if self._playing else 'paused', self._t, self._rate,
                      self._rate if self._playing else 0.0, None, None,
                      float(self._logged.rows[row, 1]), '; '.join(filter(None, texts)))

    def seek(self, t):
        """Go to t [s]."""
        self._t = min(max(0.0, t), self.duration)
        self._again = self._moved = True

    def pause(self, hold):
        """Hold, or go on; at the end, from the beginning."""
        self._playing, self._before = not hold, self._clock()

    def set_factor(self, rate):
        """Play at this many seconds per second."""
        self._rate = rate

    def close(self):
        """End the process that simulates."""
        self._process.close()
