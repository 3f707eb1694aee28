"""One run of ours for the report: path, impulse, run time, and errors between runs."""
import time
from typing import NamedTuple

from bristle_ros.scene import steps
import numpy as np

SAMPLE = 1e-3   # [s] between the samples that errors are taken at
WINDOW = 5e-3   # [s] over which contact impulses are compared


class Path(NamedTuple):
    """What a run gave."""

    t: np.ndarray           # (n,) [s], the start included
    tip: np.ndarray         # (n, 3) [m] of bristle 0, brush axes
    impulse: np.ndarray     # (n, 3) [N s] of bristle 0, road axes
    steps: int
    newton: int
    estimate: float         # largest error estimate seen, relative to the bristle's length


def run(scene, duration, *, sample=SAMPLE):
    """
    Run a scene and return its Path.

    sample : [s], made longer to a whole step where the step is longer
    Raises StepFailure.
    """
    from bristle_ros.simulation import Simulation  # from here on the compiler is needed
    simulation = Simulation(scene)
    every = steps(scene, max(sample, simulation.its), 'sample')
    rows = [simulation.snapshot()]
    for _ in range(round(duration / (every * simulation.its))):
        simulation.advance(every)
        rows.append(simulation.snapshot())
    return Path(np.array([row.t for row in rows]), np.array([row.tip_position[0] for row in rows]),
                np.array([row.contact_impulse[0] for row in rows]), simulation.step,
                rows[-1].newton_iterations, float(max(row.error_estimate for row in rows)))


def prepare_run(scene, duration, clock=time.perf_counter):
    """Build a scene; return a function that runs it from its start and returns its wall time."""
    from bristle_ros.simulation import Simulation
    return timed(Simulation(scene), duration, clock)


def timed(simulation, duration, clock=time.perf_counter):
    """Return a function that runs a simulation from its start and returns its wall time [s]."""
    count = round(duration / simulation.its)

    def again():
        simulation.reset()
        began = clock()
        simulation.advance(count)
        return clock() - began
    return again


def _common_rows(t, reference_t):
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
    mine, theirs = _common_rows(path.t, reference.t)
    if until is not None:
        early = path.t[mine] <= until
        mine, theirs = mine[early], theirs[early]
    difference = path.tip[mine] - reference.tip[theirs]
    moved = reference.tip[theirs] - reference.tip[0]
    return float(np.sqrt((difference ** 2).sum() / (moved ** 2).sum()))


def impulse_error(path, reference, window=WINDOW):
    """Return the error of the normal impulse per window: sum of deviations over the sum of all."""
    ours, exact = (impulses[:, 2] for impulses in _window_impulses(path, reference, window))
    total = np.abs(exact).sum()
    return float(np.abs(ours - exact).sum() / total) if total > 0.0 else 0.0


def _window_impulses(path, reference, window):
    """Return the impulses of both in each window (m, 3) [N s]."""
    mine, theirs = _common_rows(path.t, reference.t)
    t = path.t[mine]
    marks = np.unique(np.searchsorted(t, np.arange(0.0, t[-1] + 0.5 * window, window) - 1e-9))
    marks = marks[marks < len(t)]
    return (np.diff(path.impulse[mine][marks], axis=0),
            np.diff(reference.impulse[theirs][marks], axis=0))


def whole_impulse_error(path, reference, window=WINDOW):
    """Return the error of the impulse vector per window: sum of deviations over that of sizes."""
    ours, exact = _window_impulses(path, reference, window)
    total = np.linalg.norm(exact, axis=1).sum()
    return float(np.linalg.norm(ours - exact, axis=1).sum() / total) if total > 0.0 else 0.0


def total_impulse(path):
    """Return the normal impulse over the whole run [N s]."""
    return float(path.impulse[-1, 2])
