"""One run of ours for the report: path, impulse, best run time, and errors between runs."""
from contextlib import contextmanager
import os
import time
from typing import NamedTuple

from bristle_ros.scene import steps
import numpy as np

SAMPLE = 1e-3   # [s] between the samples that errors are taken at
WINDOW = 5e-3   # [s] over which contact impulses are compared


class Path(NamedTuple):
    """What a run gave, and how long it took."""

    t: np.ndarray           # (n,) [s], the start included
    tip: np.ndarray         # (n, 3) [m] of bristle 0, brush axes
    impulse: np.ndarray     # (n, 3) [N s] of bristle 0, road axes
    wall: float             # [s] of stepping, the best of the repeats
    steps: int
    newton: int
    estimate: float         # largest error estimate seen, relative to the bristle's length


def run(scene, duration, *, sample=SAMPLE, repeats=1, clock=time.perf_counter):
    """
    Run a scene and return its Path.

    sample : [s], made longer to a whole step where the step is longer
    repeats : int, timed repeats; the path is from the first
    Raises StepFailure.
    """
    from bristle_ros.simulation import Simulation  # from here on the compiler is needed
    simulation = Simulation(scene)
    every = steps(scene, max(sample, simulation.its), 'sample')
    count = round(duration / (every * simulation.its))
    first = simulation.snapshot()
    rows, wall = [first], 0.0
    for _ in range(count):
        began = clock()
        simulation.advance(every)
        wall += clock() - began
        rows.append(simulation.snapshot())
    for _ in range(repeats - 1):
        simulation.reset()
        again = 0.0
        for _ in range(count):
            began = clock()
            simulation.advance(every)
            again += clock() - began
        wall = min(wall, again)
    return Path(np.array([row.t for row in rows]), np.array([row.tip_position[0] for row in rows]),
                np.array([row.contact_impulse[0] for row in rows]), wall, simulation.step,
                rows[-1].newton_iterations, max(row.error_estimate for row in rows))


def _common(t, reference_t):
    """Return the rows of both that stand at the same times."""
    at = np.searchsorted(reference_t, t - 1e-9)
    good = at < len(reference_t)
    good[good] = np.abs(reference_t[at[good]] - t[good]) < 1e-8
    if good.sum() < 0.5 * len(t):
        raise ValueError('the runs have too few times in common')
    return np.flatnonzero(good), at[good]


def tip_error(path, reference, until=None):
    """
    Return the relative error of the tip path: |x - x_ref| over |x_ref - x_straight|, root of sums.

    until : [s], only the path up to there
    """
    mine, theirs = _common(path.t, reference.t)
    if until is not None:
        early = path.t[mine] <= until
        mine, theirs = mine[early], theirs[early]
    difference = path.tip[mine] - reference.tip[theirs]
    moved = reference.tip[theirs] - reference.tip[0]
    return float(np.sqrt((difference ** 2).sum() / (moved ** 2).sum()))


def impulse_error(path, reference, window=WINDOW):
    """Return the error of the normal impulse per window: sum of deviations over the sum of all."""
    mine, theirs = _common(path.t, reference.t)
    t = path.t[mine]
    marks = np.unique(np.searchsorted(t, np.arange(0.0, t[-1] + 0.5 * window, window) - 1e-9))
    marks = marks[marks < len(t)]
    ours = np.diff(path.impulse[mine][marks, 2])
    exact = np.diff(reference.impulse[theirs][marks, 2])
    total = np.abs(exact).sum()
    return float(np.abs(ours - exact).sum() / total) if total > 0.0 else 0.0


def total_impulse(path):
    """Return the normal impulse over the whole run [N s]."""
    return float(path.impulse[-1, 2])


@contextmanager
def one_core():
    """Keep this process on one of its cores meanwhile, where the system can."""
    try:
        before = os.sched_getaffinity(0)
        os.sched_setaffinity(0, {max(before)})
    except (AttributeError, OSError):
        yield
        return
    try:
        yield
    finally:
        os.sched_setaffinity(0, before)
