"""Error against run time, shown: one panel for each scene, the tables, and what rose."""
from bristle_ros.report.curves import cost_of, Point, ratio_at
from bristle_ros.report.figure import (bars, legend, log_axes, new_panel, plot, real_time, svg)
from bristle_ros.report.timing import group_slowness, quartiles
from bristle_ros.report.verdict import widen

from .subjects import HALVED

FAMILIES = ('step', 'elements', 'integrator', 'load case', 'adaptive', 'halved')
OURS = ('step', 'elements', 'adaptive', 'halved')     # that a user would choose from, for speed
LABELS = {'step': 'fixed steps (12 elements, spectral radius 0.8)', 'elements': 'other meshes',
          'integrator': 'other integrators', 'load case': 'displacement load case',
          'adaptive': 'adaptive steps',
          'halved': f'fixed steps, in halves above {HALVED:g} (solver.largest_error)'}
RING = ('larger error than with the next longer step', '#c00000', '\u25ef')
TITLES = {'tip': 'error of the tip path [%]', 'impulse': 'error of the impulse per 5 ms [%]'}
COLUMNS = {
    'scene': 'scene', 'family': 'family', 'label': 'setting', 'its': 'integration step [us]',
    'tip': 'error of the tip path [%]', 'impulse': 'error of the impulse per 5 ms [%]',
    'wall': 'wall time per simulated second [s]', 'times': 'times real time',
    'step_us': 'wall time per step [us]', 'newton_per_step': 'Newton iterations per step',
    'estimate': 'largest estimate of the local error [% of the length]', 'remark': 'remark'}


def points_of(entry, families, key='tip'):
    """Return the Points of a scene's rows of some families that were timed."""
    return [Point(row[key], tuple(row['timing']['walls'])) for row in entry['rows']
            if row['family'] in families and row.get(key) and row.get('timing')]


def slowest(entry):
    """Return by how much the intervals of a scene's group are wider for a disturbed machine."""
    return group_slowness(row.get('timing') for row in entry['rows'])


def cost(entry, level, families=OURS, key='tip'):
    """Return the Measured wall time per simulated second at an error [%], or None."""
    found = cost_of(points_of(entry, families, key), level, entry['own'].get(key) or 0.0)
    return widen(found, slowest(entry))


def coarsest(entry, families=OURS, key='tip'):
    """Return the largest error [%] of a scene's runs."""
    return max((point.error for point in points_of(entry, families, key)), default=0.0)


def remark(row, entry):
    """Return what has to be said of a row's numbers."""
    texts = [row['note']] if row.get('note') else []
    for key, name in (('tip', 'path'), ('impulse', 'impulse')):
        own = entry['own'].get(key)
        if row.get(key) is not None and own is not None and row[key] <= own:
            texts.append(f'{name}: at or below {own:.2g} %, the own error of the converged run')
    for rise in entry['rises']:
        if row['family'] == 'step' and row['label'] == rise['fine']:
            texts.append(_rise_text(rise))
    timing = row.get('timing')
    if timing and timing['disturbed']:
        texts.append(f'{timing["disturbed"]} of {len(timing["walls"])} timings disturbed')
    return '; '.join(texts)


def _rise_text(rise):
    name = {'tip': 'path', 'impulse': 'impulse'}[rise['error']]
    text = (f'error of the {name} up from {rise["from"]:.2g} to {rise["to"]:.2g} % against '
            f'{rise["coarse"]}: ')
    (least, most), (low, high) = rise['coarse_spread'], rise['fine_spread']
    near = (f'steps close to these give {least:.2g} to {most:.2g} and {low:.2g} to {high:.2g} %')
    return text + (near if rise['overlap'] else f'unexplained ({near})')


def table_rows(data):
    """Return the rows of the table of all runs."""
    rows = []
    for entry in data['subjects']:
        for row in entry['rows']:
            shown = {**row, 'scene': entry['name'], 'its': 1e6 * row['its'],
                     'remark': remark(row, entry)}
            if row.get('timing'):
                wall = quartiles(row['timing']['walls'])
                each = 1e6 * entry['duration'] / row['steps']
                shown.update(wall=wall, times=1.0 / wall.value,
                             step_us=wall._replace(value=wall.value * each, low=wall.low * each,
                                                   high=wall.high * each))
            rows.append(shown)
    return rows


def _ring(axes, entry, key):
    """Mark the runs whose error is larger than with the next longer step."""
    risen = {rise['fine'] for rise in entry['rises'] if rise['error'] == key}
    for row in entry['rows']:
        if row['family'] == 'step' and row['label'] in risen and row.get('timing'):
            axes.plot(quartiles(row['timing']['walls']).value, row[key], 'o', ms=13, mfc='none',
                      color=RING[1])


def panel(entry, key):
    """Return the SVG of a scene's error against run time."""
    figure, axes = new_panel(entry['name'], 'wall seconds per simulated second', TITLES[key])
    for family in FAMILIES:
        rows = [row for row in entry['rows'] if row['family'] == family and row.get(key)
                and row.get('timing')]
        walls = [quartiles(row['timing']['walls']) for row in rows]
        if rows:
            plot(axes, family, [wall.value for wall in walls], [row[key] for row in rows],
                 line=family == 'step', zorder=3 if family == 'step' else 2)
            bars(axes, family, [wall.value for wall in walls], [row[key] for row in rows],
                 [wall.low for wall in walls], [wall.high for wall in walls])
    _ring(axes, entry, key)
    own = entry['own'].get(key)
    if own:
        axes.axhline(own, color='#888', ls=':', lw=1.2)
    real_time(axes)
    log_axes(axes)
    return svg(figure, f'{entry["name"]}: {TITLES[key]} against wall seconds per simulated second')


def _converged_rows(data):
    for entry in data['subjects']:
        yield {'scene': entry['name'], 'what': entry['what'], 'elements': entry.get('elements'),
               'its': 1e6 * entry.get('its', 0.0), 'second': entry.get('second'),
               'tip': entry['own'].get('tip'), 'impulse': entry['own'].get('impulse'),
               'mesh_tip': entry.get('mesh', {}).get('tip'),
               'mesh_impulse': entry.get('mesh', {}).get('impulse'),
               'failed': entry.get('failed', '')}


def controlled_rows(data):
    """Return rows: what fixed steps cost over adaptive or halved ones, at equal error."""
    rows = []
    for entry in data['subjects']:
        for key in ('tip', 'impulse') if entry.get('contact') else ('tip',):
            own = entry['own'].get(key) or 0.0
            fixed = points_of(entry, ('step',), key)
            for level in (3.0, 1.0, 0.3, 0.1, 0.03):
                row = {'scene': entry['name'], 'error': TITLES[key], 'level': level}
                for family in ('adaptive', 'halved'):
                    found = level <= coarsest(entry, ('step',), key) and ratio_at(
                        fixed, points_of(entry, (family,), key), level, (own, own))
                    if found:
                        row[family] = widen(found, slowest(entry))
                if 'adaptive' in row or 'halved' in row:
                    rows.append(row)
    return rows


def show(page, data, results):
    """Put the part on the page."""
    page.heading('Error against run time')
    page.explain('Every point is a run; lower left is better. Its error is that against a '
                 'converged run of the same scene, its run time the median of rounds in turns, '
                 "the bar behind it their quartiles. The dotted line is the converged run's own "
                 'error: what a second discretisation (another integrator, and without contact '
                 'other elements) differs by. Left of the black line is faster than real time.')
    entries = [entry for entry in data['subjects'] if entry['rows']]
    page.figure([panel(entry, 'tip') for entry in entries],
                'Error of the tip path: how much a finer step or mesh buys, for each scene.',
                [*legend(FAMILIES, LABELS), RING])
    contact = [entry for entry in entries if entry['contact']]
    if contact:
        page.figure([panel(entry, 'impulse') for entry in contact],
                    'Error of the normal impulse in windows of 5 ms, scenes with contact.',
                    [*legend(FAMILIES, LABELS), RING])
    marked = [f'{entry["name"]}: {_rise_text(rise)}' for entry in data['subjects']
              for rise in entry['rises']]
    page.says(f'Smaller steps with a larger error than the next longer one: {len(marked)}'
              + ('; ' + '; '.join(marked) if marked else '') + '.')
    page.heading('Adaptive and halved against fixed steps', 3)
    page.table('controlled_against_fixed', controlled_rows(data), {
        'scene': 'scene', 'error': 'error', 'level': 'error level [%]',
        'adaptive': 'run time, fixed over adaptive steps',
        'halved': f'run time, fixed steps over those halved above {HALVED:g}'},
        'Run time of fixed steps over steps that mind their local error, at equal error: above 1 '
        'it pays to mind it.')
    page.heading('Converged runs', 3)
    page.table('converged_runs', list(_converged_rows(data)), {
        'scene': 'scene', 'what': 'what it is', 'elements': 'elements',
        'its': 'integration step [us]', 'second': 'second discretisation',
        'tip': 'own error of the tip path [%]', 'impulse': 'own error of the impulse [%]',
        'mesh_tip': 'twice the elements change the path by [%]',
        'mesh_impulse': 'twice the elements change the impulse by [%]', 'failed': 'remark'},
        'What errors are measured against, and how sure that is. With contact all runs of a scene '
        'have its mesh, but those of other meshes: their errors are those of time.')
    page.fold('All runs')
    page.table('work_precision', table_rows(data), COLUMNS,
               'Every run: error, run time (quartiles), iterations, and what is to be said of it.')
    page.unfold()
