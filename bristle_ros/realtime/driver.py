"""Wall time to whole chunks of steps: pacing, overload, commands, resets, samples."""
from collections import deque
import threading
import time
from typing import NamedTuple

from bristle_ros.simulation import CommandRefused, StepFailure

from .budget import LoadBudget
from .pace import check_factor, FollowedPace, OwnPace, Rate


_MOVING = {'cmd_vel', 'cmd_mount'}      # without these for a while, the sweeper stops


class Event(NamedTuple):
    """What changed the course of the run, with the step at whose start it took effect."""

    step: int               # total steps before it
    kind: str               # 'command', 'timeout', 'reset' or 'load': an error tolerance
    topic: str = ''         # of a command or timeout: 'cmd_vel', 'cmd_brush_speed', ...
    values: tuple = ()      # what was applied, SI


class Chunk(NamedTuple):
    """What one chunk gave. Steps are total, in its snapshots too: they go on through resets."""

    start: int
    end: int                # lower than asked when the simulation could not go on
    samples: tuple          # Snapshots at the sample marks, in order
    last: object            # Snapshot at `end`
    events: tuple           # Events in the order in which they took effect
    failure: object = None  # StepFailure, or None
    mount: object = None    # Pose of the mount over the road at `end`, if the driver follows it
    wrench: object = None   # (6,) mean over it of the brush on the sweeper, if that is followed


class Driver:
    """
    Runs a simulation chunk by chunk; knows when the next one is due, but never sleeps.

    simulation : Simulation     advanced by this object only
    clock : () -> int [ns]      steady; turned by hand in tests
    sample : int                steps between samples inside chunks; 0: none, only chunk ends
    paced : bool                False: as fast as it goes and no command timeout, whatever the
                                scene says, so that an offline run depends on no clock
    follow : bool               True: chunks are due by a clock whose times `follow` is given

    One thread calls `run_chunk`; everything else may be called from others meanwhile.
    """

    def __init__(self, simulation, *, clock=time.monotonic_ns, sample=0, paced=True,
                 follow=False):
        run = simulation.scene.run
        self.simulation = simulation
        self.its = simulation.its                                   # [s]
        self.chunk = max(1, round(run.chunk / self.its))            # [steps]
        self.sample = sample
        self.late_chunks = 0            # ended after the next one was due
        self.refused = 0                # commands
        self.stepping = 0               # [ns] spent in advance() alone
        self.resets = 0
        self.mount = None               # MountPath to follow to each chunk's end, or None
        self.mean = None                # MeanWrench, or None
        self.on_refusal = None          # told of commands that are refused when they take effect
        self.watch = None               # RunWatch that sees each sample, or None
        self._clock = clock
        self._lock = threading.Lock()   # commands come from another thread than chunks
        self._total = 0                 # steps since the start of the run
        self._until = 0                 # step at which the chunk that runs ends, else the same
        self._base = -simulation.step   # total step = base + simulation.step
        self._pending = {}              # topic: values; the newest wins, so it cannot grow
        self._reset = False
        self._schedule = deque()        # Events to come, by step
        self._lockstep = paced and run.carried
        self._ways = {}                 # in lockstep: the chunk's last step: its cmd_mount or None
        self._last_way = None           # what came last
        self._timeout = round(run.command_timeout * 1e9) if paced and not run.carried else 0
        self._timed_out = False
        self._paused = False
        self._single = False
        self.budget = None
        if paced and run.max_load > 0.0:
            self.budget = LoadBudget(run.max_load, simulation.scene.solver.error_tolerance)
        self._marks = Rate()            # of total steps, at chunk ends
        self.pace = (                   # others read it, and change nothing
            FollowedPace(clock, self.its, self.chunk) if follow else
            OwnPace(clock, self.its, self.chunk, float(run.real_time_factor)
                    if paced and not run.carried else 0.0))
        self.start()

    def start(self):
        """Take now as the time at which the step reached is due; what came before is gone."""
        with self._lock:
            self._start()

    def _start(self):
        # A chunk that runs already ends where it ends: its stamps must not be ahead of the clock.
        self.pace.start(self._until)
        self._last_velocity = self._clock()     # [ns] when cmd_vel was last heard
        self._marks.clear()
        if self.budget:
            self.budget.forget()

    def follow(self, time):
        """
        Take the time [ns] of the clock that is followed; return by how much it went back [ns].

        Whoever sleeps until the next chunk has to look again when one is `due` now.
        """
        with self._lock:
            return self.pace.tick(time)

    def behind(self):
        """[ns] by which the followed clock is ahead of the step reached."""
        with self._lock:
            return self.pace.behind(self._total)

    @property
    def shed(self):
        """[ns] of wall time, or of the followed clock's, given up for good."""
        return self.pace.given_up

    @property
    def total_step(self):
        """Return steps since the start of the run; resets do not turn it back."""
        return self._total

    def now(self):
        """[ns] on the driver's clock."""
        return self._clock()

    @property
    def real_time_factor(self):
        """
        Return the simulated seconds per wall second asked for; 0 is as fast as it goes.

        Where a clock is followed it is that clock's, measured; 0 while it stands still.
        """
        with self._lock:
            return self.pace.factor()

    @real_time_factor.setter
    def real_time_factor(self, factor):
        check_factor(factor)
        with self._lock:
            self.pace.set_factor(float(factor), self._total)

    def next_deadline(self):
        """[ns] on the clock when the next chunk is due; None while only a call can change that."""
        with self._lock:
            if self.waits:
                return None
            if self._single:
                return self._clock()
            return None if self._paused else self.pace.deadline(self._total + self.chunk)

    @property
    def waits(self):
        """Whether the next chunk cannot run before its cmd_mount has come, in lockstep."""
        return self._lockstep and self._until + self.chunk not in self._ways

    def due(self):
        """Whether a chunk should run now."""
        deadline = self.next_deadline()
        return deadline is not None and self._clock() >= deadline

    def reached(self):
        """Real-time factor reached over about the last second; 0 while paused."""
        with self._lock:
            # A followed clock may stand still, and so do we then.
            now = self._clock() if self.pace.follows else None
            return 0.0 if self._paused else self._marks.per_second(now) * self.its

    def command(self, topic, values):
        """
        Take a command for the next chunk's start; of several on one topic the newest counts.

        Raises CommandRefused (and counts it) when it is not finite, out of limits or misshapen.
        """
        values = tuple(float(value) for value in values)
        try:
            self.simulation.check_command(topic, values)
        except CommandRefused:
            self.count_refusal()
            raise
        with self._lock:
            self._pending.pop(topic, None)  # keeps the order of arrival
            self._pending[topic] = values
            if topic in _MOVING:
                self._last_velocity = self._clock()

    def carry(self, end, values):
        """
        In lockstep, take the cmd_mount of the chunk that ends at the total step `end`.

        Raises CommandRefused (and counts it). One that is of the next chunk, but cannot be
        followed otherwise, lets that run with the velocity that there is: nobody waits for ever.
        """
        values = tuple(float(value) for value in values)
        if (end, values) == self._last_way:
            return      # sent twice, by one who was not sure to be heard
        try:
            with self._lock:
                wanted = self._until + self.chunk
                if end != wanted or end in self._ways:
                    which = 'there is one for' if end == wanted else 'the next chunk is'
                    raise CommandRefused(
                        f'cmd_mount: stamped {end * self.its:.9g} s, and {which} the chunk that '
                        f'ends at {wanted * self.its:.9g} s')
                self._ways[end], self._last_way = None, (end, values)
            self.simulation.check_command('cmd_mount', values)
            with self._lock:
                self._ways[end] = values
        except CommandRefused:
            self.count_refusal()
            raise

    def count_refusal(self):
        """Count a command that was refused, by whichever thread."""
        with self._lock:
            self.refused += 1

    def reset(self):
        """Back to the scene's start at the next chunk's start; drops commands not yet applied."""
        with self._lock:
            self._reset = True
            self._pending.clear()

    def schedule(self, events):
        """
        Take events to be applied at exactly their (total) step, also inside a chunk.

        Raises CommandRefused, or ValueError when one lies before the step reached.
        """
        events = sorted(events, key=lambda event: event.step)  # stable: same step, same order
        for event in events:
            if event.step < self._total:
                raise ValueError(f'{event.topic or event.kind} at step {event.step}: the run is '
                                 f'already at step {self._total}')
            if event.topic:
                self.simulation.check_command(event.topic, event.values)
        with self._lock:
            self._schedule = deque(sorted([*self._schedule, *events],
                                          key=lambda event: event.step))

    @property
    def scheduled(self):
        """How many scheduled events have not taken effect."""
        return len(self._schedule)

    @property
    def paused(self):
        """Whether nothing is due but single steps."""
        return self._paused

    def pause(self):
        """Hold after the chunk that is running."""
        with self._lock:
            self._paused = True

    def resume(self):
        """Go on from here, as if no time had passed."""
        with self._lock:
            if self._paused:
                self._paused = self._single = False
                self._start()

    def step_once(self):
        """Make one chunk due while paused; False (and nothing) if not, or without a clock."""
        with self._lock:
            self._single = self._paused and not (self.pace.follows and self.pace.time is None)
            return self._single

    def run_chunk(self, steps=None):
        """
        Advance one chunk (or `steps` steps) and say what happened in it.

        Returns Chunk; when the simulation could not go on, `failure` says why and the rest of it
        is what was reached. Never raises StepFailure.
        """
        start = self._total
        end = start + (self.chunk if steps is None else steps)
        with self._lock:
            self._until = end
            single, self._single = self._single, False
            paced = not single and not self._paused
            if paced:
                self.pace.begin(start + self.chunk)
            elif single:
                self.pace.begin_single(end)
        events = self._begin(start)
        samples, failure = [], None
        while failure is None and self._total < end:
            self._apply_scheduled(events)
            try:
                self._advance(self._next_stop(end))
            except StepFailure as error:
                failure = error
                break
            if self.sample and self._total % self.sample == 0:
                samples.append(self._snapshot())
                self.simulation.begin_sample()
                self.look(samples[-1])
        reached = self._total
        last = samples[-1] if samples and samples[-1].step == reached else self._snapshot()
        if not self.sample:
            self.look(last)
        mount = self.mount and self.mount.follow(self.simulation, self.resets)
        wrench = self.mean and self.mean.follow(self.simulation, self.resets)
        self._end(paced, end)
        return Chunk(start, reached, tuple(samples), last, tuple(events), failure, mount, wrench)

    def look(self, snapshot):
        """Let the watch see a snapshot."""
        if self.watch:
            with self._lock:
                self.watch.take(snapshot)

    def warnings(self, *, ended=True):
        """Return what RunWatch.warnings says of the run so far; without a watch nothing."""
        with self._lock:
            return self.watch.warnings(ended=ended) if self.watch else []

    def _begin(self, start):
        with self._lock:
            pending, self._pending = self._pending, {}
            reset, self._reset = self._reset, False
            silent = self._clock() - self._last_velocity
            way = self._ways.pop(start + self.chunk, None)
        events = []
        if reset:
            self._apply(Event(start, 'reset'), events)
            silent = 0 if _MOVING.isdisjoint(pending) else silent
        if way is not None:
            pending['cmd_mount'] = way
        for topic, values in pending.items():
            self._apply(Event(start, 'command', topic, values), events)
        if self._timeout and not self._timed_out and silent > self._timeout:
            topic, rest = ('cmd_mount', 6) if self.simulation.carried else ('cmd_vel', 3)
            self._apply(Event(start, 'timeout', topic, (0.0,) * rest), events)
            self._timed_out = True
        # As fast as it goes, stepping takes all there is whatever it is given.
        if self.budget and self.real_time_factor > 0.0:
            tolerance = self.budget.decide(self._clock(), self.stepping)
            if tolerance is not None:
                self._apply(Event(start, 'load', '', (tolerance,)), events)
        return events

    def _apply(self, event, events):
        if event.kind == 'reset':
            self.simulation.reset()
            self._base = self._total - self.simulation.step
            self.resets += 1
            if self.watch:
                with self._lock:
                    self.watch.restart(self._total * self.its)
            self._last_velocity, self._timed_out = self._clock(), False
        elif event.kind == 'load':
            self.simulation.set_error_tolerance(*event.values)
        else:
            try:
                self.simulation.command(event.topic, event.values)
            except CommandRefused as refused:  # checked when it came, but the state moved on
                self.count_refusal()
                if self.on_refusal:
                    self.on_refusal(str(refused))
                return
            if event.kind == 'command' and event.topic in _MOVING:
                self._timed_out = False
        events.append(event)

    def _apply_scheduled(self, events):
        while self._schedule and self._schedule[0].step <= self._total:
            self._apply(self._schedule.popleft(), events)

    def _next_stop(self, end):
        now = self._total
        if self.sample:
            end = min(end, now + self.sample - now % self.sample)
        if self._schedule:
            end = min(end, self._schedule[0].step)
        return end - now

    def _advance(self, n):
        began = self._clock()
        try:
            self.simulation.advance(n)
        finally:
            self.stepping += self._clock() - began
            self._total = self._base + self.simulation.step

    def _snapshot(self):
        snapshot = self.simulation.snapshot()
        if self._base:
            step = self._total
            snapshot = snapshot._replace(step=step, t=step * self.its)
        return snapshot

    def _end(self, paced, end):
        with self._lock:
            self._until = self._total
            self.late_chunks += paced and self.pace.late(end)
            self._marks.add(self._clock(), self._total)
