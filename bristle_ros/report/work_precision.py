"""
Error against run time of our own settings: step, mesh, integrator, load case, adaptive steps.

Every error is against a converged run of the same scene, whose own error is stated. Without
contact it is that of the tip path; with contact also that of the normal impulse in windows of
5 ms, which stays meaningful where single impacts do not repeat.
"""
import math
from typing import NamedTuple

from bristle_ros.report.peers.scenes import our_scene, RPM
from bristle_ros.scene import Contact, Damping, Drive, Road, Run, Scene, Solver

from .page import new_figure, whole_decades
from .runs import impulse_error, run, tip_error

STYLES = {      # family: colour and marker, the same in every diagram
    'step': ('#1f77b4', 'o'), 'elements': ('#2ca02c', 's'), 'integrator': ('#ff7f0e', '^'),
    'load case': ('#d62728', 'D'), 'adaptive': ('#9467bd', 'v')}
TOLERANCES = (1e-3, 1e-4, 1e-5, 1e-6, 1e-7)     # of adaptive steps, per length of the bristle
SWEPT = ('S2', 'cutting_brush', 'S4')   # scenes whose tolerance is swept in either form


class Subject(NamedTuple):
    """A scene whose error against run time is drawn."""

    name: str
    duration: float     # [s]
    contact: bool
    steps: tuple        # ITS [s], coarse to fine
    usual: float        # [s] the ITS at which the other things are varied
    reference: tuple    # elements and ITS [s] of the converged run
    check: tuple        # the same of the run that tells the converged run's own error


SUBJECTS = (
    Subject('S1', 0.5, False, (4e-3, 2e-3, 1e-3, 5e-4, 2e-4, 1e-4), 5e-4, (32, 2e-5), (24, 4e-5)),
    Subject('S2', 0.5, False, (4e-3, 2e-3, 1e-3, 5e-4, 2e-4, 1e-4), 5e-4, (32, 2e-5), (24, 4e-5)),
    Subject('S3', 0.3, True, (5e-4, 2e-4, 1e-4, 5e-5, 2e-5, 1e-5), 5e-5, (12, 1e-6), (12, 2e-6)),
    Subject('S4', 0.24, True, (5e-4, 2e-4, 1e-4, 5e-5, 2e-5, 1e-5), 5e-5, (12, 1e-6), (12, 2e-6)),
    Subject('S5', 0.5, False, (4e-3, 2e-3, 1e-3, 5e-4, 2e-4, 1e-4), 5e-4, (32, 2e-5), (24, 4e-5)),
    Subject('cutting_brush', 0.3, True, (1e-3, 5e-4, 2e-4, 1e-4, 5e-5, 2e-5), 1e-4, (12, 2e-6),
            (12, 4e-6)),
)


def scene_of(name, its, **solver):
    """Return the Scene of a subject with this step; solver: keys of its solver section."""
    if name != 'cutting_brush':
        return our_scene(name, its, **solver)
    # as config/cutting_brush.yaml, but with the road up after 0.1 s
    return Scene(road=Road(penetration=0.02, approach_time=0.1), contact=Contact(),
                 damping=Damping(stiffness=1e-3), drive=Drive(mean_speed=100 * RPM),
                 solver=Solver(integration_time_step=its, **solver),
                 run=Run(chunk=max(5e-3, its), sample=max(1e-3, its)))


def _variants(subject, quick):
    """Return (family, label, ITS, solver keys) of the runs to make."""
    usual = subject.usual
    every = subject.steps[:-1] if quick else subject.steps
    found = [('step', f'{its * 1e6:g} us', its, {}) for its in every]
    for elements in (4, 8) if quick else (2, 4, 6, 8, 16, 24):
        found.append(('elements', f'{elements} el', usual, {'elements': elements}))
    makes = [('rho 0', {'spectral_radius': 0.0}), ('rho 0.95', {'spectral_radius': 0.95}),
             ('HHT', {'integrator': 'hht', 'amplitude_decay': 0.1}),
             ('Newmark', {'integrator': 'newmark'})]
    for label, keys in makes[-2:] if quick else makes:
        found.append(('integrator', label, usual, keys))
    for label, step in (('TS 0', 0.0), ('TS 1 ms', 1e-3)) if not quick else (('TS 0', 0.0),):
        found.append(('load case', f'displacement, {label}', usual,
                      {'load_case': 'displacement', 'time_step': step}))
    for tolerance in (1e-5,) if quick and subject.name not in SWEPT else TOLERANCES:
        found.append(('adaptive', f'tol {tolerance:g}', subject.steps[0],
                      {'step': 'adaptive', 'error_tolerance': tolerance}))
    return found


def measure(progress, *, quick=False, repeats=5, subjects=SUBJECTS):
    """Return rows of all runs, and rows of the converged runs with their own errors."""
    rows, references = [], []
    for subject in subjects:
        progress(f'{subject.name}: converged run')
        elements, its = subject.reference
        coarser, longer = subject.check
        if quick:
            its, longer = 2.5 * its, 2.5 * longer
        reference = run(scene_of(subject.name, its, elements=elements), subject.duration)
        check = run(scene_of(subject.name, longer, elements=coarser), subject.duration)
        references.append({
            'scene': subject.name, 'elements': elements, 'ITS_us': its * 1e6,
            'its_own_tip_error_percent': 100 * tip_error(check, reference),
            'its_own_impulse_error_percent':
                100 * impulse_error(check, reference) if subject.contact else math.nan,
            'wall_per_simulated_s': reference.wall / subject.duration})
        for family, label, step, keys in _variants(subject, quick):
            progress(f'{subject.name}: {family} {label}')
            row = {'scene': subject.name, 'family': family, 'label': label, 'ITS_us': step * 1e6}
            try:
                path = run(scene_of(subject.name, step, **keys), subject.duration, repeats=repeats)
            except (RuntimeError, ValueError) as error:
                rows.append({**row, 'note': str(error)})
                continue
            rows.append({
                **row, 'tip_error_percent': 100 * tip_error(path, reference),
                'impulse_error_percent':
                    100 * impulse_error(path, reference) if subject.contact else math.nan,
                'wall_per_simulated_s': path.wall / subject.duration,
                'times_real_time': subject.duration / path.wall,
                'step_us': 1e6 * path.wall / path.steps,
                'newton_per_step': path.newton / path.steps,
                'estimate_percent': 100 * path.estimate, 'note': ''})
    return rows, references


def draw(rows, references):
    """Return a figure for each error measure: one panel for each scene."""
    figures = []
    for key, title in (('tip_error_percent', 'error of the tip path [%]'),
                       ('impulse_error_percent', 'error of the impulse per 5 ms [%]')):
        names = [r['scene'] for r in references
                 if any(row['scene'] == r['scene'] and _positive(row.get(key)) for row in rows)]
        if not names:
            continue
        columns = min(3, len(names))
        figure, axes = new_figure(columns, -(-len(names) // columns), 10.5, 3.7)
        for panel in axes.flat[len(names):]:
            panel.set_visible(False)
        for name, panel in zip(names, axes.flat):
            _draw_panel(panel, name, [row for row in rows if row['scene'] == name], key)
            own = next(r for r in references if r['scene'] == name)['its_own_' + key]
            if _positive(own):
                panel.axhline(own, color='#888', ls=':', lw=1)
            panel.set_ylabel(title)
        handles, labels = {}, []
        for panel in axes.flat:
            for handle, label in zip(*panel.get_legend_handles_labels()):
                handles.setdefault(label, handle)
        labels = list(handles)
        figure.legend([handles[x] for x in labels], labels, loc='outside lower center',
                      ncols=len(labels))
        figures.append((figure, f'work-precision: {title}'))
    return figures


def _positive(value):
    return value is not None and not math.isnan(value) and value > 0.0


def _draw_panel(panel, name, rows, key):
    for family, (colour, marker) in STYLES.items():
        points = [row for row in rows if row['family'] == family and _positive(row.get(key))]
        if not points:
            continue
        panel.loglog([p['wall_per_simulated_s'] for p in points], [p[key] for p in points],
                     marker=marker, color=colour, ls='-' if family == 'step' else 'none', ms=5,
                     label={'step': 'step (12 elements, rho 0.8)'}.get(family, family))
        if family in ('step', 'load case'):
            # ends of the line tell the range; everything else is in the table
            ends = {id(p): p for p in (points[0], points[-1])}.values()
            for p, below in zip(ends, (4, -9)):     # they may be close to each other
                panel.annotate(p['label'].replace('displacement, ', ''), fontsize=7,
                               xy=(p['wall_per_simulated_s'], p[key]), xytext=(4, below),
                               textcoords='offset points', color=colour)
    panel.axvline(1.0, color='k', lw=0.8)
    panel.set_title(name)
    panel.set_xlabel('wall seconds per simulated second')
    panel.margins(y=0.1)    # room for the labels
    whole_decades(panel)
