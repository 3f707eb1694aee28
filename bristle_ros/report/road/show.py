"""The road's scenes, shown: error against run time, each refinement alone, and other programs."""
from bristle_ros.report.figure import (bars, legend, log_axes, new_panel, plot, real_time, svg)
from bristle_ros.report.peers import show as peers
from bristle_ros.report.timing import quartiles, slowness
from bristle_ros.report.verdict import Measured, widen

from . import assumption
from .subjects import CONVERGED, FINE_MESH, MESHES, NAMES, USUAL

TITLES = {'tip': 'error of the tip path [%]', 'impulse': 'error of the impulse per 5 ms [%]'}
USUAL_FAMILY = f'{USUAL[0]} elements'
FAMILIES = (*(f'{elements} elements' for elements in MESHES), 'adaptive')


def _timed(entry):
    return [row for row in entry['rows'] if row.get('timing') and row.get('tip')]


def cheapest(entry):
    """Return the row that meets both limits of a scene in the least time, or None."""
    limits = entry['limits']
    good = [row for row in _timed(entry) if all(row[key] <= limits[key] for key in limits)]
    return min(good, key=lambda row: quartiles(row['timing']['walls']).value, default=None)


def times_real_time(row):
    """Return the Measured simulated time over wall time of a row."""
    wall = quartiles(row['timing']['walls'])
    return widen(Measured(1.0 / wall.value, 1.0 / wall.high, 1.0 / wall.low),
                 slowness(row['timing']))


def cost_rows(data):
    """Return rows: the cheapest setting that meets a scene's limits."""
    rows = []
    for entry in data['subjects']:
        row = cheapest(entry)
        rows.append({
            'scene': entry['name'], 'what': entry['what'], 'limit_tip': entry['limits']['tip'],
            'limit_impulse': entry['limits']['impulse'], 'own_tip': entry['own'].get('tip'),
            'own_impulse': entry['own'].get('impulse'),
            **({'setting': row['label'], 'tip': row['tip'], 'impulse': row['impulse'],
                'times': times_real_time(row)} if row else {'setting': 'none that was tried'}),
            'remark': entry['failed']})
    return rows


def _panel(entry, key):
    figure, axes = new_panel(entry['name'], 'wall seconds per simulated second', TITLES[key])
    for family in FAMILIES:
        rows = [row for row in _timed(entry) if row['family'] == family and row[key] > 0.0]
        if rows:
            walls = [quartiles(row['timing']['walls']) for row in rows]
            errors = [row[key] for row in rows]
            plot(axes, family, [wall.value for wall in walls], errors)
            bars(axes, family, [wall.value for wall in walls], errors,
                 [wall.low for wall in walls], [wall.high for wall in walls])
    axes.axhline(entry['limits'][key], color='#c00000', ls='--', lw=1.0)
    if entry['own'].get(key):
        axes.axhline(entry['own'][key], color='#888', ls=':', lw=1.2)
    real_time(axes)
    log_axes(axes)
    return svg(figure, f'{entry["name"]}: {TITLES[key]} against wall seconds per simulated second')


def _refined(data, which, key, x):
    figure, axes = new_panel(f'{which} alone', x, TITLES[key])
    for entry in data['subjects']:
        rows = [row for row in entry[which] if row[key] > 0.0]
        if rows:
            plot(axes, f'road {entry["name"]}', [row['value'] for row in rows],
                 [row[key] for row in rows])
    log_axes(axes)
    if which == 'meshes':
        axes.set_xticks([*MESHES, CONVERGED[0]])
    return svg(figure, f'{TITLES[key]} against {x}, all scenes of the road')


def _refinement_rows(data):
    for entry in data['subjects']:
        for which, what in (('steps', f'step [us], {USUAL[0]} elements'),
                            ('meshes', f'elements, steps of {1e6 * entry["fine_step"]:g} us')):
            for row in entry[which]:
                yield {'scene': entry['name'], 'what': what, **row}


def _run_rows(data):
    for entry in data['subjects']:
        for row in entry['rows']:
            timing = row.get('timing')
            yield {**row, 'scene': entry['name'], 'wall': quartiles(timing['walls'])
                   if timing else None, 'remark': row['note'] or (
                       f'{timing["disturbed"]} of {len(timing["walls"])} timings disturbed'
                       if timing and timing['disturbed'] else '')}


def show(page, data, results):
    """Put the part on the page."""
    page.heading('On a road that is not level')
    page.explain('A wire that lies down, rubs along a kerb, follows waves and roughness, falls '
                 'over an edge. Errors are against a converged run of '
                 f'{CONVERGED[0]} elements; the dotted line is its own error, what '
                 'another integrator on another mesh differs by. The dashed red line is the error '
                 'that the first table tells the cost at. Impulses are those of the road on the '
                 'whole wire, three components, in windows of 5 ms.')
    page.table('road_cost', cost_rows(data), {
        'scene': 'scene', 'times': 'times real time', 'limit_tip': 'tip path to within [%]',
        'limit_impulse': 'impulse to within [%]', 'setting': 'cheapest setting that does it',
        'tip': 'its error of the tip path [%]', 'impulse': 'its error of the impulse [%]',
        'own_tip': 'own error of the converged path [%]',
        'own_impulse': 'own error of its impulse [%]', 'what': 'what it is', 'remark': 'remark'},
        'What both errors cost: times real time of one wire on one core.')
    entries = [entry for entry in data['subjects'] if _timed(entry)]
    for key in TITLES:
        page.figure([_panel(entry, key) for entry in entries
                     if any(row[key] > 0.0 for row in _timed(entry))],
                    f'{TITLES[key].capitalize()} against run time, mesh and step refined '
                    'together; lower left is better.', legend(
                        [family for family in FAMILIES if any(
                            row['family'] == family for entry in entries
                            for row in _timed(entry))]))
    page.heading('Each refinement alone', 3)
    page.explain(f'Left and right tell apart what the last figures mix: steps with {USUAL[0]} '
                 'elements against the finest of them, and meshes with one fine step against one '
                 f'of {FINE_MESH} elements.')
    for key, title in TITLES.items():
        page.figure([_refined(data, which, key, x) for which, x in (
            ('steps', 'integration step [us]'), ('meshes', 'elements along the wire'))],
            f'{title.capitalize()} that steps and meshes each leave, in all scenes.',
            legend([f'road {entry["name"]}' for entry in data['subjects']],
                   {f'road {name}': name for name in NAMES}))
    assumption.show(page, data.get('assumption'))
    if data['peers']:
        page.heading('Other programs on this road', 3)
        peers.show_scenes(page, data['peers'], 'road_')
    page.fold('All runs and refinements on the road')
    page.table('road_refinement', list(_refinement_rows(data)), {
        'scene': 'scene', 'what': 'what is refined', 'value': 'to', 'tip': TITLES['tip'],
        'impulse': TITLES['impulse']}, 'Refinements one at a time, against the finest of each.')
    page.table('road_runs', list(_run_rows(data)), {
        'scene': 'scene', 'label': 'setting', 'tip': TITLES['tip'], 'impulse': TITLES['impulse'],
        'wall': 'wall time per simulated second [s]',
        'newton_per_step': 'Newton iterations per step', 'remark': 'remark'},
        'Every run on the road: error and run time (quartiles).')
    page.unfold()
