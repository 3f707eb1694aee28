"""Beside other programs, shown: what each takes over what ours does, at equal error."""
from bristle_ros.report.curves import cost_of, Point, ratio_at
from bristle_ros.report.figure import bars, legend, log_axes, new_panel, plot, real_time, svg
from bristle_ros.report.timing import group_slowness, quartiles
from bristle_ros.report.verdict import widen

from .comparison import LEVELS

INSTALL = ('`./run.sh report --peers` sets them up in the environment of a checkout; elsewhere '
           '`pip install -r requirements-report.txt` does.')


def points_of(entry):
    """Return the Points of a program's rows that were timed."""
    return [Point(row['error'], tuple(row['timing']['walls'])) for row in entry['rows']
            if row.get('timing') and row.get('error')]


def _slowest(*entries):
    return max(group_slowness(row.get('timing') for row in entry['rows']) for entry in entries)


def ratios(data):
    """Return rows: scene, program, level, and the Measured run time over ours, or None."""
    rows = []
    for scene in data['scenes']:
        ours = scene['programs']['bristle_ros']
        for level in LEVELS:
            mine = widen(cost_of(points_of(ours), level, ours['own'] or 0.0), _slowest(ours))
            for program, entry in scene['programs'].items():
                if program == 'bristle_ros':
                    continue
                own = entry['own'] or 0.0, ours['own'] or 0.0
                found = ratio_at(points_of(entry), points_of(ours), level, own)
                rows.append({
                    'scene': scene['name'], 'program': program, 'level': level, 'ours': mine,
                    'theirs': widen(cost_of(points_of(entry), level, own[0]), _slowest(entry)),
                    'ratio': widen(found, _slowest(entry, ours)),
                    'remark': '' if found else 'this error is not reached, or not clear of the '
                    'own error of a converged run'})
    return rows


def panel(scene):
    """Return the SVG of all programs on a scene."""
    title = 'error of the impulse [%]' if scene['contact'] else 'error of the tip path [%]'
    figure, axes = new_panel(scene['name'], 'wall seconds per simulated second', title)
    for program, entry in scene['programs'].items():
        rows = [row for row in entry['rows'] if row.get('timing') and row.get('error')]
        walls = [quartiles(row['timing']['walls']) for row in rows]
        if rows:
            errors = [row['error'] for row in rows]
            plot(axes, program, [wall.value for wall in walls], errors)
            bars(axes, program, [wall.value for wall in walls], errors,
                 [wall.low for wall in walls], [wall.high for wall in walls])
    real_time(axes)
    log_axes(axes)
    return svg(figure, f'{scene["name"]}: {title} against run time, all programs')


def _run_rows(data):
    for scene in data['scenes']:
        for program, entry in scene['programs'].items():
            for row in entry['rows']:
                timing = row.get('timing')
                remark = row['note'] or ('' if timing else 'too long to be timed in turns')
                if timing and timing['disturbed']:
                    remark = f'{timing["disturbed"]} of {len(timing["walls"])} timings disturbed'
                yield {'scene': scene['name'], 'program': program, 'label': row['label'],
                       'error': row.get('error'), 'scatter': row.get('scatter'),
                       'wall': quartiles(timing['walls']) if timing else None, 'remark': remark}


def _converged_rows(data):
    for scene in data['scenes']:
        for program, entry in scene['programs'].items():
            yield {'scene': scene['name'], 'program': program, 'how': entry['how'],
                   'own': entry['own'], 'path': entry['apart'].get('path'),
                   'impulse': entry['apart'].get('impulse')}


def show(page, data, results):
    """Put the part on the page."""
    page.heading('Beside exudyn and MuJoCo')
    absent = data['absent']
    if absent:
        page.says(f'Not installed here: {", ".join(absent)}. {INSTALL}', marked=True)
    if not data['scenes']:
        page.says(f'Programs compared: {len(data["versions"])}.')
        return
    page.explain('The same scenes in the same run, on the same core, in turns. Each program '
                 'against its own converged run; costs are interpolated along the curves of both, '
                 'between the settings that pay. Other programs solve the scenes the way that is '
                 'fastest for them: in the rotating frame, the clamp at rest.')
    page.says('Versions: ' + ', '.join(f'{name} {version}' for name, version
                                       in data['versions'].items()) + '.')
    show_scenes(page, data)


def show_scenes(page, data, prefix=''):
    """Put the figure and the tables of some scenes on the page; prefix : of the tables' names."""
    page.figure([panel(scene) for scene in data['scenes']],
                'Error against run time of all programs; lower left is better.',
                legend(['bristle_ros', *data['versions']]))
    page.table(prefix + 'peers_equal_error', ratios(data), {
        'scene': 'scene', 'program': 'program', 'level': 'error level [%]',
        'ours': 'ours, wall time per simulated second [s]',
        'theirs': 'theirs, wall time per simulated second [s]',
        'ratio': 'theirs over ours', 'remark': 'remark'},
        'Run time at equal error: above 1 ours is the faster.')
    page.table(prefix + 'peers_converged', list(_converged_rows(data)), {
        'scene': 'scene', 'program': 'program', 'how': 'converged run',
        'own': 'its own error [%]', 'path': 'its path from ours [%]',
        'impulse': 'its impulse from ours [%]'},
        'How far the converged runs of the programs lie apart.')
    page.fold('All runs of all programs')
    page.table(prefix + 'peers', list(_run_rows(data)), {
        'scene': 'scene', 'program': 'program', 'label': 'setting', 'error': 'error [%]',
        'scatter': 'scatter over start angles [%]',
        'wall': 'wall time per simulated second [s]', 'remark': 'remark'},
        'Every run of every program: error and run time (quartiles).')
    page.unfold()
