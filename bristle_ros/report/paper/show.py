"""The paper's claims, shown: the table of verdicts, then the figures and tables behind it."""
from bristle_ros.report.figure import colour, legend, log_axes, new_panel, plot, svg
from bristle_ros.report.timing import quartiles
from bristle_ros.report.verdict import Measured

from . import claims
from .experiments import law

# Peaks [N] of two independent planar models of the same wire, made with numpy before this program
# was written: TS [s], ITS [s]: Newmark with an amplitude decay of 0.005, spectral radius 0.
PLANAR = {
    (1e-3, 1e-5): (114.0, 1.1), (1e-3, 5e-6): (100.0, 2.1), (1e-3, 1e-6): (138.0, 9.0),
    (1e-4, 1e-5): (107.0, 0.14), (5e-5, 1e-5): (0.2, None), (5e-5, 5e-6): (80.0, 0.13),
    (1e-5, 1e-5): (0.015, 0.016), (1e-5, 5e-6): (80.0, 0.03), (1e-5, 1e-6): (33.0, 0.10),
    (1e-6, 1e-6): (0.015, None)}
PLANAR_OF = {'Newmark 0.005': 0, 'spectral radius 0': 1}


def damping_rows(rows):
    """Return the table of figure 4, the largest forces first."""
    found = []
    for row in rows:
        planar = PLANAR.get((row['TS'], row['ITS']), (None, None))
        place = PLANAR_OF.get(row['integrator'])
        found.append({
            'load_case': row['load_case'], 'TS': 1e3 * row['TS'], 'ITS': 1e6 * row['ITS'],
            'integrator': row['integrator'], 'extreme': row['extreme'], 'low': row['low'],
            'high': row['high'], 'whole_error': row['whole_error'], 'tip_error': row['tip_error'],
            'planar': planar[place] if place is not None and row['load_case'] != 'inertia'
            else None, 'duration': 1e3 * row['duration']})
    return sorted(found, key=lambda row: -abs(row['extreme']))


def against_planar(rows):
    """Return a sentence: our peaks of figure 4 over those of the planar models."""
    said = []
    for name, place in PLANAR_OF.items():
        ratios = sorted(abs(row['extreme']) / PLANAR[row['TS'], row['ITS']][place] for row in rows
                        if row['integrator'] == name and row['load_case'] == 'displacement'
                        and PLANAR.get((row['TS'], row['ITS']), (None, None))[place])
        if ratios:
            said.append(f'{name} {ratios[0]:.2g} to {ratios[-1]:.2g} in {len(ratios)} runs')
    return f'Our peaks over theirs: {"; ".join(said) or "none in common"}.'


def _friction_panel(series):
    import numpy as np
    figure, axes = new_panel('Figure 3', 'slip speed [m/s]', 'coefficient of friction')
    slip = np.linspace(0.0, 4.0, 100)
    plot(axes, 'theory', slip, law(slip))
    for _, points in series:
        if points:
            plot(axes, 'on the road', *zip(*points), line=False)
    axes.set_ylim(0.0, 0.8)
    return svg(figure, 'friction coefficient against slip speed: eq. (1), and simulated tips')


def _damping_panels(series):
    for title, integrator, time_step in (
            ('Newmark 0.005, TS 1 ms', 'Newmark 0.005', 1e-3),
            ('Newmark 0.005, TS 0.1 ms', 'Newmark 0.005', 1e-4),
            ('Newmark 0.005, TS 0.01 ms', 'Newmark 0.005', 1e-5),
            ('spectral radius 0, TS 1 ms', 'spectral radius 0', 1e-3)):
        figure, axes = new_panel(title, 'time [ms]', 'radial damping force [N]')
        for load_case, ts, width in (('displacement', time_step, 1.0), ('inertia', 0.0, 1.6)):
            for each in series:
                if (each['load_case'], each['TS'], each['integrator']) == (load_case, ts,
                                                                           integrator):
                    axes.plot([1e3 * t for t in each['t']], each['force'], lw=width,
                              color=colour(load_case))
        yield svg(figure, f'radial damping force at the clamp, {title}, ITS 10 us')


def _load_case_panels(series):
    for key, title in (('force', 'normal tip force [N], 0.2 ms mean'),
                       ('radial', 'radial tip displacement [mm]')):
        figure, axes = new_panel('Penetration 40 mm', 'time [s]', title)
        for each in series:
            if each['penetration'] > 1e-3:
                axes.plot(each['t'], each[key], color=colour(each['load_case']),
                          lw=1.8 if each['load_case'] == 'inertia' else 0.8, alpha=0.8)
        yield svg(figure, f'{title} against time, both load cases')


def _kind(row):
    if row['load_case'] == 'inertia':
        return 'inertia'
    return f'displacement, TS {"=" if row["TS"] == row["ITS"] else ">"} ITS'


def _cost_panel(found, title, label):
    figure, axes = new_panel(title, 'wall seconds per simulated second', label)
    for kind in ('inertia', 'displacement, TS = ITS', 'displacement, TS > ITS'):
        rows = [row for row in found['rows'] if _kind(row) == kind and row.get('timing')]
        if rows:
            plot(axes, kind, [quartiles(row['timing']['walls']).value for row in rows],
                 [row['error'] for row in rows], line=False)
    log_axes(axes)
    return svg(figure, f'{title}: {label} against run time of both load cases')


def _cost_rows(data):
    for name, key in (('path', 'rotation_cost'), ('damping force', 'force_cost')):
        for row in data[key]['rows']:
            yield {'quantity': name, 'load_case': row['load_case'], 'TS': 1e3 * row['TS'],
                   'ITS': 1e6 * row['ITS'], 'integrator': row.get('integrator',
                                                                  'spectral radius 0.8'),
                   'error': row['error'],
                   'wall': quartiles(row['timing']['walls']) if row.get('timing') else None}


def _load_case_rows(rows):
    for row in rows:
        ours, theirs = zip(*row['impulses'])
        yield {'penetration': 1e3 * row['penetration'], 'first_touch': row['first_touch'],
               'inertia': 1e3 * ours[0], 'displacement': 1e3 * theirs[0],
               'until_touch': _range(row['until_touch']), 'whole_run': _range(row['whole_run'])}


def _range(values):
    return Measured(values[0], min(values), max(values))


CLAIMS = {'claim': "the paper's words", 'reading': 'how it is read here', 'measured': 'measured',
          'verdict': 'verdict', 'cause': 'what this run shows beside it'}


def show(page, data, results):
    """Put the part on the page."""
    page.heading("The paper's claims")
    page.explain('Comparison of two finite element models of bristles of gutter brushes for '
                 'street sweeping. Displacement load case: the clamp moves along a polygon with '
                 'corners at multiples of TS; inertia load case: the frame turns. ITS is the '
                 'integration step in both. "Much less" is read as at least '
                 f'{claims.MUCH:g} times.')
    page.table('paper_claims', claims.judge(data), CLAIMS,
               'Claim by claim; a verdict whose interval crosses its threshold is left open.')
    page.heading('Run time of both load cases at equal error', 3)
    page.figure([_cost_panel(data['rotation_cost'], 'Free rotation', 'error of the tip path [%]'),
                 _cost_panel(data['force_cost'], 'Scene of figure 4',
                             'error of the damping force [%]')],
                'Every point is a setting; lower left is better.',
                legend(('inertia', 'displacement, TS = ITS', 'displacement, TS > ITS')))
    page.says("The converged runs' own errors: path "
              f'{data["rotation_cost"]["own"]:.2g} %, damping force '
              f'{data["force_cost"]["own"]:.2g} %.')
    _figures(page, data)
    page.fold('Sensitivities of the sweeping run, and run times of both load cases')
    own = data['sensitivities']['own'] or [None, None]
    page.table('paper_sensitivities', [
        {**row, 'value': row['value'] if row['what'] == 'elements' else 1e6 * row['value'],
         'own_tip': own[0], 'own_impulse': own[1]} for row in data['sensitivities']['rows']], {
        'what': 'what is changed', 'value': 'value [us, or elements]',
        'tip': 'error of the tip path [%]', 'impulse': 'error of the impulse per 5 ms [%]',
        'own_tip': 'converged run, own error of the path [%]',
        'own_impulse': 'converged run, own error of the impulse [%]'},
        'Sweeping run with 1 ms of damping: errors against ITS, mesh and TS.')
    page.table('paper_run_time', list(_cost_rows(data)), {
        'quantity': 'error of', 'load_case': 'load case', 'TS': 'TS [ms]', 'ITS': 'ITS [us]',
        'integrator': 'integrator', 'error': 'error [%]',
        'wall': 'wall time per simulated second [s]'},
        'Error and run time of both load cases, every setting.')
    page.unfold()


def _keep_series(page, series):
    """Keep what the figures draw as tables."""
    page.data('paper_friction', [
        {'rpm': rpm, 'slip': slip, 'coefficient': coefficient}
        for rpm, points in series['friction'] for slip, coefficient in points], {
        'rpm': 'brush speed [rpm]', 'slip': 'slip speed [m/s]', 'coefficient':
        'coefficient of friction'}, 'Figure 3: simulated tips while they slipped.')
    page.data('paper_damping_histories', [
        {**each, 'TS': 1e3 * each['TS'], 't': 1e3 * t, 'force': force}
        for each in series['damping'] for t, force in zip(each['t'], each['force'])], {
        'load_case': 'load case', 'TS': 'TS [ms]', 'integrator': 'integrator', 't': 'time [ms]',
        'force': 'radial damping force [N]'}, 'Figure 4: damping force against time, ITS 10 us.')
    page.data('paper_load_case_histories', [
        {**each, 'penetration': 1e3 * each['penetration'], 't': t, 'force': force,
         'radial': radial} for each in series['load_cases']
        for t, force, radial in zip(each['t'], each['force'], each['radial'])], {
        'load_case': 'load case', 'penetration': 'penetration [mm]', 't': 'time [s]',
        'force': 'normal tip force [N]', 'radial': 'radial tip displacement [mm]'},
        'Figure 5: tip force (0.2 ms mean) and displacement against time.')


def _figures(page, data):
    series = data.get('series')
    page.heading('Figure 4: damping force at the clamp', 3)
    if series:
        _keep_series(page, series)
        page.figure(list(_damping_panels(series['damping'])),
                    'Scene of figure 4, ITS 10 us: the clamp on a polygon against the turning '
                    'frame.', legend(('displacement', 'inertia')))
    page.explain('At a corner of the polygon the velocity of the clamp jumps by r w^2 TS, which a '
                 'step spreads. The planar models are two independent programs of the same wire '
                 'in its plane, made before this one; their peaks are constants of the source.')
    page.says(against_planar(data['damping']))
    page.fold('All runs of figure 4')
    page.table('paper_damping_force', damping_rows(data['damping']), {
        'load_case': 'load case', 'TS': 'TS [ms]', 'ITS': 'ITS [us]', 'integrator': 'integrator',
        'extreme': 'damping force, largest magnitude [N]', 'low': 'least [N]',
        'high': 'largest [N]', 'whole_error': 'error of the whole clamp force [N]',
        'tip_error': 'error of the tip path [%]', 'planar': 'planar models [N]',
        'duration': 'simulated [ms]'}, 'Forces at the clamp, the largest first.')
    page.unfold()
    page.heading('Figures 3 and 5', 3)
    if series:
        page.figure([_friction_panel(series['friction'])], "The law of eq. (1) with the paper's "
                    'fit, and what simulated tips did while they slipped.',
                    legend(('theory', 'on the road'), {'theory': 'eq. (1)', 'on the road':
                                                       'simulated tips, 60 to 140 rpm'}))
        page.figure(list(_load_case_panels(series['load_cases'])),
                    'The sweeping run of figure 5: TS 1 ms (inertia), 0.01 ms (displacement).',
                    legend(('inertia', 'displacement')))
    page.table('paper_load_cases', list(_load_case_rows(data['load_cases'])), {
        'penetration': 'penetration [mm]', 'first_touch': 'first touch [s]',
        'inertia': 'impulse, inertia [mN s]', 'displacement': 'impulse, displacement [mN s]',
        'until_touch': 'paths apart until the first touch [%]',
        'whole_run': 'paths apart over the whole run [%]'},
        'Both load cases side by side; intervals over start angles 1e-4 rad apart.')
