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
from bristle_ros.report.figure import legend, new_panel, plot, svg
from bristle_ros.report.workers import Failed, Job
import numpy as np

from .subjects import scene_of

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


def measure(context, cases=CASES, schemes=SCHEMES):
    """Return the part's data: the steps looked at, and how many were done in sub-steps."""
    random = np.random.default_rng(SEED)
    jobs, places = [], []
    for scene, duration, its_values in cases:
        for its in its_values[:1] if context.quick else its_values:
            for scheme, keys in schemes.items():
                count = round(duration / its)
                steps = np.unique(random.integers(count // 20, count, 2 if context.quick else 8))
                jobs.append(Job(look_at, (scene, its, keys, steps.tolist())))
                places.append((scene, scheme, its, steps))
    answers = context.crew.run(jobs, show=lambda value, job, done, total: context.progress.count(
        done, total, f'{job.arguments[0]}, single steps'))
    found, split = [], 0
    for (scene, scheme, its, steps), looks in zip(places, answers):
        for number, looked in zip(steps, () if isinstance(looks, Failed) else looks):
            if looked is None:
                split += 1
                continue
            estimate, true, touching = looked
            found.append(Step(scene, scheme, its, float(number * its), touching, estimate,
                              true)._asdict())
    return {'steps': found, 'split': split}


def summary(found):
    """Return rows: how far estimates and true errors are apart, per kind of step and in all."""
    def row(kind, steps):
        ratios = np.array([step.ratio for step in steps])
        outside = int(((ratios > BAND) | (ratios < 1.0 / BAND)).sum())
        return {'kind': kind, 'count': len(steps),
                'smallest_ratio': float(ratios.min()), 'median_ratio': float(np.median(ratios)),
                'largest_ratio': float(ratios.max()), 'outside': outside}
    kinds = [('free', [s for s in found if not s.touching]),
             ('on the road', [s for s in found if s.touching])]
    kinds += [(f'{name}, all', [s for s in found if s.scheme == name])
              for name in dict.fromkeys(s.scheme for s in found)]
    return [row(kind, steps) for kind, steps in (*kinds, ('all', found)) if steps]


def _panel(found, touching, title):
    figure, axes = new_panel(title, 'true local error, per length of the bristle',
                             'estimate, per length of the bristle')
    values = [v for s in found for v in (s.estimate, s.true) if v > 0.0]
    ends = np.array([10.0 ** math.floor(math.log10(min(values))),
                     10.0 ** math.ceil(math.log10(max(values)))])
    axes.fill_between(ends, ends / BAND, ends * BAND, color='#e4e4e4', lw=0)
    axes.plot(ends, ends, color='k', lw=0.8)
    points = [s for s in found if s.touching == touching]
    plot(axes, 'on the road' if touching else 'free', [s.true for s in points],
         [s.estimate for s in points], line=False)
    axes.set(xscale='log', yscale='log', xlim=ends, ylim=ends)
    return svg(figure, f'estimate against true local error, {title}')


def show(page, data, results):
    """Put the part on the page."""
    found = [Step(**step) for step in data['steps']]
    page.heading('Estimate of the local error')
    page.explain('The estimate that the stepper gives for a step, against its true error, that to '
                 f'the same step from the same state in {PARTS} parts. Both are local, root mean '
                 'square over the mass that moved, per length of the bristle. Left out are steps '
                 'done in sub-steps, which estimate only their last one.')
    rows = summary(found)
    if not rows:
        page.says(f'{len(found)} steps, {data["split"]} left out.')
        return
    whole = rows[-1]
    page.says(f'{len(found)} single steps of {len({(s.scene, s.its, s.scheme) for s in found})} '
              f'runs, {data["split"]} left out. Estimate over true error: '
              f'{whole["smallest_ratio"]:.2g} to {whole["largest_ratio"]:.2g}, median '
              f'{whole["median_ratio"]:.3g}; {whole["outside"]} outside a factor {BAND:g}.')
    page.figure([_panel(found, False, 'free'), _panel(found, True, 'tip on the road')],
                f'Every point is a step; in the grey band estimate and truth are within a factor '
                f'{BAND:g}.', legend(('free', 'on the road')))
    page.table('local_error', rows, {
        'kind': 'steps looked at', 'count': 'count', 'smallest_ratio': 'smallest ratio',
        'median_ratio': 'median ratio', 'largest_ratio': 'largest ratio',
        'outside': f'outside a factor {BAND:g}'}, 'Estimate over true error, by kind of step.')
    page.data('local_error_steps', [{**s._asdict(), 'ratio': s.ratio} for s in found], {
        'scene': 'scene', 'scheme': 'scheme', 'its': 'integration step [s]', 't': 'time [s]',
        'touching': 'on the road', 'estimate': 'estimate, per length', 'true':
        'true error, per length', 'ratio': 'estimate over true error'}, 'Every step looked at.')
