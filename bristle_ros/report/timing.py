"""
Run times that can be trusted: settings take turns, and a fixed loop tells how the machine was.

All that is compared with each other is a group. In each round every setting of the group is timed
once, each program in a process of its own, all on the same core and never two at a time. Before
and after each timing a calibration loop runs in the same process: where it takes longer than its
best, or the timing itself waited for its core, the machine was disturbed; then the timing is done
again, a few times, and where that does not help it is kept and marked. On a machine that is never
quiet doing it again is in vain: it takes no more than AGAIN_SHARE of a group's time.
"""
from contextlib import contextmanager
import time
from typing import NamedTuple

from .verdict import Measured, spread
from .workers import cores, Failed, Worker

TURNS = 40_000          # of the calibration loop: some milliseconds
LOOPS = 3               # of which the best counts
SLOW = 1.15             # times the best calibration: from there on a timing is disturbed
WAITED = 0.05           # share of a timing in which the process did not run
AGAIN = 2               # more attempts at a disturbed timing
AGAIN_SHARE = 0.5       # of a group's run time so far: when more attempts have taken it they end
ALL_CORES = 'bristle_ros on all cores'    # the one program that is not kept on one
LONG = 4.0          # [s] from which on it is not: the report has to end
SHORT = 0.02            # [s] below which a run is repeated until it has lasted as long


class Timed(NamedTuple):
    """A setting to be timed: prepare(*arguments) in its program's process gives run()."""

    key: str
    prepare: object     # returns a function without arguments, which returns its wall time [s]
    arguments: tuple
    program: str = 'bristle_ros'
    per: float = 1.0    # what a wall time is divided by, such as the simulated time [s]


def calibrate(clock=time.perf_counter):
    """Return the wall time [s] of a fixed loop of floating-point work, the best of a few."""
    times = []
    for _ in range(LOOPS):
        began = clock()
        x = 0.5
        for _ in range(TURNS):
            x = 3.7 * x * (1.0 - x)
        times.append(clock() - began)
    return min(times)


_prepared = {}


def time_once(key, prepare, arguments):
    """Return (wall time, share of it that the process waited, calibrations); in a worker."""
    run = _prepared.get(key)
    if run is None:
        run = _prepared[key] = prepare(*arguments)
        run()       # the first has caches to fill
    before = calibrate()
    total, count = 0.0, 0
    wall, cpu = time.perf_counter(), time.process_time()
    while count == 0 or (total < SHORT and count < 50):
        total += run()
        count += 1
    wall, cpu = time.perf_counter() - wall, time.process_time() - cpu
    return total / count, max(0.0, 1.0 - cpu / wall), before, calibrate()


def forget():
    """Drop what was prepared; in a worker."""
    _prepared.clear()


class Timer:
    """Times groups of settings; one process for each program, all on one core."""

    def __init__(self, repeats, progress=lambda text: None):
        """Time each setting `repeats` times."""
        self.repeats = repeats
        self.best = None        # [s] of the calibration loop in this run
        self._workers = {}
        self._progress = progress

    def _worker(self, program):
        if program not in self._workers:
            self._workers[program] = Worker(None if program == ALL_CORES else cores()[-1])
        return self._workers[program]

    def _once(self, timed):
        """Return a sample as a dict, or Failed."""
        found = self._worker(timed.program).call(
            time_once, timed.key, timed.prepare, timed.arguments)
        if isinstance(found, Failed):
            return found
        wall, waited, before, after = found
        self.best = min(self.best or before, before, after)
        return {'wall': wall / timed.per, 'slow': max(before, after) / self.best,
                'waited': waited}

    def _sample(self, timed, spent):
        """Return the least disturbed of some samples, or Failed; spent: [first, more] [s]."""
        kept = None
        for attempt in range(1 + AGAIN):
            sample = self._once(timed)
            if isinstance(sample, Failed):
                return sample
            spent[attempt > 0] += sample['wall'] * timed.per
            if kept is None or _disturbance(sample) < _disturbance(kept):
                kept = sample
            if (not is_disturbed(kept) or sample['wall'] * timed.per > LONG
                    or spent[1] > AGAIN_SHARE * spent[0]):
                break
        return kept

    def group(self, timed, repeats=None):
        """
        Time a group of Timed; return {key: dict of walls, disturbed, slowest}, without failures.

        Every list of walls has the same length: entry i of each is from round i.
        """
        repeats = repeats or self.repeats
        for program in dict.fromkeys(each.program for each in timed):
            first = self._worker(program).call(calibrate)
            self.best = min(self.best or first, first)
        samples, spent = {each.key: [] for each in timed}, [0.0, 0.0]
        for round_ in range(repeats):
            for number, each in enumerate(timed):
                if each.key not in samples:
                    continue
                self._progress(f'timing, round {round_ + 1} of {repeats}: {each.key} '
                               f'({number + 1} of {len(timed)})')
                sample = self._sample(each, spent)
                if isinstance(sample, Failed):
                    del samples[each.key]
                    continue
                samples[each.key].append(sample)
        for worker in self._workers.values():
            worker.call(forget)
        return {key: {'walls': [sample['wall'] for sample in found],
                      'disturbed': sum(is_disturbed(sample) for sample in found),
                      'slowest': max(sample['slow'] / (1.0 - min(0.9, sample['waited']))
                               for sample in found)}
                for key, found in samples.items()}

    def end(self):
        """End the processes."""
        while self._workers:
            self._workers.popitem()[1].end()


def _disturbance(sample):
    return (sample['slow'] - 1.0) / (SLOW - 1.0) + sample['waited'] / WAITED


def is_disturbed(sample):
    """Whether the machine was disturbed around a sample."""
    return sample['slow'] > SLOW or sample['waited'] > WAITED


@contextmanager
def timer(repeats, progress):
    """Give a Timer, and end its processes afterwards."""
    made = Timer(repeats, progress)
    try:
        yield made
    finally:
        made.end()


def quartiles(walls):
    """Return the Measured of wall times: median, and the quartiles (interpolated)."""
    ordered = sorted(walls)

    def at(share):
        place = share * (len(ordered) - 1)
        i = int(place)
        j = min(i + 1, len(ordered) - 1)
        return ordered[i] + (place - i) * (ordered[j] - ordered[i])
    return Measured(at(0.5), at(0.25), at(0.75))


def ratio(one, other):
    """
    Return the Measured ratio of two timings of a group, in pairs of the same round.

    The interval is that of all rounds: from 7 rounds it holds the median of many with 98 %, from
    3 with 75 % (sign test); a disturbed timing widens it by how slow the machine was.
    """
    found = spread([a / b for a, b in zip(one['walls'], other['walls'])])
    wider = max(slowness(one), slowness(other))
    return Measured(found.value, found.low / wider, found.high * wider)


def slowness(timing):
    """Return by how much disturbed timings widen an interval: 1 where there is none."""
    return max(1.0, timing['slowest']) if timing['disturbed'] else 1.0


def group_slowness(timings):
    """
    Return by how much the intervals of a whole group widen: the upper quartile of its timings.

    A single disturbed timing is in the interval of its rounds already.
    """
    found = sorted(slowness(timing) for timing in timings if timing)
    return found[(3 * (len(found) - 1)) // 4] if found else 1.0
