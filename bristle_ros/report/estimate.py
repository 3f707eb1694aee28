"""
The stepper's estimate of its local error against the true one: single steps, done again finely.

From a state on a run's path one step is taken as it is; a second simulation takes the same state
over the same time in steps PARTS times shorter. How far the two end apart is the true local error
of that step, in the estimate's own measure: root mean square over the mass that moved. Neither
has anything to do with the global error, which a run accumulates.
"""
import math
from typing import NamedTuple

from bristle_ros.physics.contact import LEVEL, MATRIX_STEP, OPEN, STATE
from bristle_ros.physics.wire import LANES, MASS, ROWS, X
import numpy as np

from .page import new_figure
from .work_precision import scene_of

PARTS = 64      # fine steps that stand for the exact one
BAND = 3.0      # the factor within which an estimate serves to choose a step
SEED = 3        # of the places where steps are looked at

SCHEMES = {
    **{f'rho {radius:g}': {'integrator': 'generalized_alpha', 'spectral_radius': radius}
       for radius in (0.0, 0.3, 0.6, 0.8, 0.9)},
    'HHT 0.05': {'integrator': 'hht', 'amplitude_decay': 0.05},
    'Newmark 0.05': {'integrator': 'newmark', 'amplitude_decay': 0.05}}
CASES = (       # scene, duration [s], ITS [s]
    ('S1', 0.3, (1e-3, 2e-4)), ('S2', 0.3, (1e-3, 5e-4, 2e-4)), ('S5', 0.3, (5e-4,)),
    ('cutting_brush', 0.3, (5e-4, 2e-4, 1e-4)), ('S3', 0.3, (1e-4, 2e-5)),
    ('S4', 0.24, (1e-4, 2e-5)))


class Step(NamedTuple):
    """One step looked at."""

    scene: str
    scheme: str
    its: float          # [s]
    t: float            # [s] at its start
    touching: bool      # the tip was on the road before or after it
    estimate: float     # relative to the bristle's length, as the true error is
    true: float

    @property
    def ratio(self):
        """Estimate over true error."""
        return self.estimate / self.true


def _nodes(simulation):
    """Return positions (3, n) [m] and masses (n,) [kg] of all nodes of bristle 0."""
    rows = simulation.state.nodes[0].reshape(simulation.model.blocks, ROWS, LANES)
    return (rows[:, X:X + 3].transpose(1, 0, 2).reshape(3, -1), rows[:, MASS].reshape(-1))


def true_error(one, other, length):
    """Return how far apart two simulations stand, root mean square over the mass that differs."""
    (place, mass), (exact, _) = _nodes(one), _nodes(other)
    square = ((place - exact) ** 2).sum(axis=0)
    moved = mass[square > 0.0].sum()
    return math.sqrt((mass * square).sum() / moved) / length if moved > 0.0 else 0.0


def continue_finely(fine, coarse):
    """Put a simulation of PARTS times shorter steps where another one stands."""
    for into, values in zip(fine.state, coarse.state):
        into[...] = values
    fine.state.step[0] = coarse.step * PARTS
    fine.state.tip[:, MATRIX_STEP] = 0.0    # factorised for the longer step
    fine.state.tip[:, LEVEL] = 0.0


def look_at(scene, its, keys, steps):
    """
    Return (estimate, true error, touching) of single steps, None for one done in sub-steps.

    scene : name for work_precision.scene_of;  keys : of its solver section
    steps : numbers of the steps, ascending
    """
    from bristle_ros.simulation import Simulation
    coarse = Simulation(scene_of(scene, its, **keys))
    fine = Simulation(scene_of(scene, its / PARTS, **keys))
    found = []
    for number in steps:
        coarse.advance(int(number) - coarse.step)
        continue_finely(fine, coarse)
        touching = coarse.state.tip[0, STATE] != OPEN
        parts = coarse.snapshot().substeps
        coarse.advance(1)
        now = coarse.snapshot()
        if now.substeps > parts:    # then the estimate is that of the last sub-step
            found.append(None)
            continue
        fine.advance(PARTS)
        found.append((now.error_estimate, true_error(coarse, fine, coarse.scene.bristle.length),
                      bool(touching or coarse.state.tip[0, STATE] != OPEN)))
    return found


def measure(progress, *, quick=False, cases=CASES, schemes=SCHEMES):
    """Return the Steps looked at, and how many were left out as done in sub-steps."""
    random = np.random.default_rng(SEED)
    found, split = [], 0
    for scene, duration, its_values in cases:
        for its in its_values[:1] if quick else its_values:
            for scheme, keys in schemes.items():
                progress(f'estimate of the local error: {scene}, ITS {its * 1e6:g} us, {scheme}')
                count = round(duration / its)
                steps = np.unique(random.integers(count // 20, count, 2 if quick else 8))
                for number, looked in zip(steps, look_at(scene, its, keys, steps)):
                    if looked is None:
                        split += 1
                        continue
                    estimate, true, touching = looked
                    found.append(Step(scene, scheme, its, float(number * its), touching,
                                      estimate, true))
    return found, split


def summary(found):
    """Return rows: how far estimates and true errors are apart, per kind of step and in all."""
    def row(kind, steps):
        ratios = np.array([step.ratio for step in steps])
        outside = int(((ratios > BAND) | (ratios < 1.0 / BAND)).sum())
        return {'steps_looked_at': kind, 'count': len(steps),
                'smallest_ratio': float(ratios.min()), 'median_ratio': float(np.median(ratios)),
                'largest_ratio': float(ratios.max()), f'outside_a_factor_{BAND:g}': outside}
    kinds = [('free', [s for s in found if not s.touching]),
             ('on the road', [s for s in found if s.touching])]
    kinds += [(f'{name}, all', [s for s in found if s.scheme == name])
              for name in dict.fromkeys(s.scheme for s in found)]
    return [row(kind, steps) for kind, steps in (*kinds, ('all', found)) if steps]


def draw(found):
    """Return a figure: estimate against true error of every step, free and on the road."""
    figure, axes = new_figure(2, 1, 10.5, 4.4)
    values = [v for s in found for v in (s.estimate, s.true) if v > 0.0]
    low = 10.0 ** math.floor(math.log10(min(values)))
    high = 10.0 ** math.ceil(math.log10(max(values)))
    ends = np.array([low, high])
    marks = dict(zip(dict.fromkeys(s.scheme for s in found), 'osD^v<>PX*'))
    for panel, touching, title in zip(axes.flat, (False, True), ('free', 'tip on the road')):
        panel.fill_between(ends, ends / BAND, ends * BAND, color='#d9ead3', lw=0,
                           label=f'within a factor {BAND:g}')
        panel.plot(ends, ends, color='k', lw=0.8, label='estimate = true error')
        for at, (scheme, mark) in enumerate(marks.items()):
            points = [s for s in found if s.scheme == scheme and s.touching == touching]
            panel.loglog([s.true for s in points], [s.estimate for s in points], mark, ms=4,
                         color=f'C{at}', alpha=0.7, mew=0, label=scheme)
        panel.set(xlim=(low, high), ylim=(low, high), xscale='log', yscale='log',
                  title=title, ylabel='estimate, per length of the bristle',
                  xlabel='true local error, per length of the bristle')
    figure.legend(*axes[0, 0].get_legend_handles_labels(), loc='outside lower center', ncols=5)
    return figure
