"""When a step is due: at a factor of a steady clock, or in lockstep with a followed clock."""
from collections import deque
import math

BACKLOG_CHUNKS = 4              # what may be caught up after a delay: this many chunks,
BACKLOG_NS = 50_000_000         # [ns] or this much time, if more; the rest is given up
CATCH_UP_NS = 1_000_000_000     # [ns] that a followed clock may be ahead for a while,
PATIENCE_NS = 2_000_000_000     # [ns] of wall time: then no more than above
WINDOW_NS = 1_000_000_000       # [ns] over which a rate is taken
MARK_NS = 50_000_000            # [ns] between the marks inside that window: memory stays bounded


class Rate:
    """How fast a value has grown over about the last second of wall time."""

    def __init__(self):
        self._marks = deque()   # (wall [ns], value)

    def __len__(self):
        """Return how many marks are kept."""
        return len(self._marks)

    def clear(self):
        """Forget all marks."""
        self._marks.clear()

    def add(self, wall, value):
        """Mark `value` at the wall time [ns]."""
        marks = self._marks
        # The newest mark is always there; older ones stand MARK_NS apart.
        if len(marks) >= 2 and marks[-1][0] - marks[-2][0] < MARK_NS:
            marks.pop()
        marks.append((wall, value))
        while len(marks) > 2 and wall - marks[1][0] >= WINDOW_NS:
            marks.popleft()

    def per_second(self, now=None):
        """Return the growth per second; 0 without two marks, or when none is near `now` [ns]."""
        marks = self._marks
        if len(marks) < 2 or (now is not None and now - marks[-1][0] > WINDOW_NS):
            return 0.0
        (wall, value), (last_wall, last_value) = marks[0], marks[-1]
        return (last_value - value) * 1e9 / max(1, last_wall - wall)


class OwnPace:
    """
    Steps at a real-time factor of a steady clock; 0 is as fast as it goes.

    Deadlines count from an anchor, the wall time at which a step was or is due, and never from the
    last deadline: no drift, no summed error.
    """

    follows = False
    origin = 0      # [ns] to be added to simulation time in stamps

    def __init__(self, clock, its, chunk, factor):
        """clock() -> int [ns]; its [s]: a step; chunk [steps]."""
        self._clock, self._its, self._chunk = clock, its, chunk
        self._factor = factor
        self.given_up = 0       # [ns] of wall time, for good
        self.start(0)

    def start(self, step):
        """Take `step` as due now; what came before is gone."""
        self._anchor = self._clock(), step

    def factor(self):
        """Return the simulated seconds per second of wall time that are asked for."""
        return self._factor

    def set_factor(self, factor, step):
        """Change the factor; the step reached keeps the wall time at which it was due."""
        self._anchor = (self._due_at(step) if self._factor > 0.0 else self._clock()), step
        self._factor = factor

    def deadline(self, end):
        """Return when [ns] the chunk that ends at step `end` is due."""
        return self._due_at(end) if self._factor > 0.0 else self._clock()

    def begin(self, end):
        """Take note that a chunk begins that ends at `end`: give up what is too late for it."""
        if self._factor == 0.0:
            return
        deadline = self._due_at(end)
        period = self._due_at(end + self._chunk) - deadline
        excess = self._clock() - deadline - max(BACKLOG_CHUNKS * period, BACKLOG_NS)
        if excess > 0:
            self.given_up += excess
            wall, step = self._anchor
            self._anchor = wall + excess, step

    def begin_single(self, end):
        """Take note that a single step begins: it follows no deadline."""

    def late(self, end):
        """Return whether the chunk after the one that ended at `end` should have ended too."""
        return self._factor > 0.0 and self._clock() > self._due_at(end + self._chunk)

    def _due_at(self, step):
        wall, anchor_step = self._anchor
        return wall + round((step - anchor_step) * self._its * 1e9 / self._factor)


class FollowedPace:
    """
    Steps in lockstep with an outside clock: a chunk is due when that clock has reached its end.

    The step reached and the clock are tied together by `origin`, the clock's time at step 0, which
    is also what makes stamps of steps: so no stamp is ever ahead of the clock. It is fixed by the
    first time heard after a start. It moves when the clock goes back (to the clock's new time) and
    when time is given up: more than CATCH_UP_NS at once, or what could not be made up for within
    PATIENCE_NS. Steps are never left out and never turned back.
    """

    follows = True

    def __init__(self, clock, its, chunk):
        """clock() -> int [ns], steady, for rates alone; its [s]: a step; chunk [steps]."""
        self._clock, self._its, self._chunk = clock, its, chunk
        self._limit = max(round(BACKLOG_CHUNKS * chunk * its * 1e9), BACKLOG_NS)
        self._end = 0           # the last step of the chunk that began last
        self.given_up = 0       # [ns] of the clock's time, for good
        self.jumps_back = 0
        self.time = None        # [ns] the clock's, when last heard
        self.start(0)

    def start(self, step):
        """Take `step` as reached when the clock is heard next."""
        self._anchored, self._end = False, step
        self._tick, self._in_time = 0, self._clock()
        self._rate = Rate()
        self.origin = 0 if self.time is None else self._origin(step)

    def tick(self, time):
        """Take the clock's time [ns]; return by how much it went back [ns], as a rule 0."""
        now = self._clock()
        if self.behind(self._end) < self._limit:  # equal when the rest has just been given up
            self._in_time = now
        before, self.time = self.time, time
        back = 0 if before is None else max(0, before - time)
        if back:
            self.jumps_back += 1
            self._rate.clear()
        if back or not self._anchored:
            # A chunk that runs already ends now, on the clock's new time.
            self.origin, self._anchored = self._origin(self._end), True
            self._tick, self._in_time = 0, now
        else:
            self._tick = time - before
        self._rate.add(now, time)
        return back

    def factor(self):
        """Return the clock's seconds per second of wall time; 0 while it stands still."""
        return self._rate.per_second(self._clock()) * 1e-9

    def behind(self, step):
        """Return by how much [ns] the clock is ahead of a step; below 0 for one not due yet."""
        return self.time - self._due_at(step) if self._anchored else 0

    def deadline(self, end):
        """Return now [ns] when the clock has reached the step `end`, else None: it must tick."""
        return self._clock() if self._anchored and self._due_at(end) <= self.time else None

    def begin(self, end):
        """Take note that a chunk begins that ends at `end`: give up what is too late for it."""
        self._end = end
        patient = self._clock() - self._in_time < PATIENCE_NS
        excess = self.behind(end) - (max(CATCH_UP_NS, self._limit) if patient else self._limit)
        if excess > 0:
            self.given_up += excess
            self.origin += excess

    def begin_single(self, end):
        """Take note that a single step begins: it ends on the clock's present time."""
        self._end = end
        self.origin = self._origin(end)

    def late(self, end):
        """Return whether the chunk after the one that ended at `end` should have ended too."""
        return self.behind(end + self._chunk) > self._tick

    def _origin(self, step):
        return self.time - round(step * self._its * 1e9)

    def _due_at(self, step):
        return self.origin + round(step * self._its * 1e9)


def check_factor(factor):
    """Raise ValueError unless it is a factor for OwnPace."""
    if not 0.0 <= factor < math.inf:
        raise ValueError(f'real-time factor = {factor!r}: must be 0 (as fast as it goes) or '
                         'more, and finite')
