"""What each feature costs, shown: a row for each, with and without it, how it is left out."""
from bristle_ros.report.timing import quartiles, ratio
from bristle_ros.report.verdict import Measured, spread

from .features import FEATURES

COLUMNS = {
    'feature': 'feature', 'cost': 'it adds to the time of a step [%]',
    'how': 'how it is left out',
    'present': 'step with it [us]', 'absent': 'step without it [us]',
    'start': 'start-up with it [s]', 'start_less': 'start-up without it [s]',
    'memory': 'memory with it [MB]', 'memory_less': 'memory without it [MB]',
    'bytes': 'bytes per simulated second', 'remark': 'remark'}
# How each topic is left out of what is published; a log has all but /tf always.
VIEWED = {'/tf': 'run.publish_tf: none; in a log log.tf: false; made only for subscribers',
          'bristle_markers': 'run.marker_rate: 0; made only for subscribers, never in a log'}


def _micro(measured):
    return Measured(*(1e6 * value for value in measured))


def cost_of(row):
    """Return the Measured time that a feature adds to a step [%], or None."""
    if not row['present'] or not row['absent']:
        return None
    found = ratio(row['present'], row['absent'])
    return Measured(*(100.0 * (value / row['bristles'] - 1.0) for value in found))


def feature_rows(data):
    """Return the rows of the table of features, the dearest first."""
    how = {feature.name: feature.how for feature in FEATURES}
    full, lean = data['log_bytes']
    sizes = {'log at 1 kHz': full, 'transforms in the log': full - lean if full and lean else None}
    rows = []
    for row in data['features']:
        shown = {'feature': row['name'], 'how': how.get(row['name'], ''), 'cost': cost_of(row),
                 'bytes': sizes.get(row['name']), 'remark': ''}
        for key in ('present', 'absent'):
            if row[key]:
                wall = _micro(quartiles(row[key]['walls']))
                share = row['bristles'] if key == 'present' else 1
                shown[key] = Measured(*(value / share for value in wall))
        disturbed = sum(row[key]['disturbed'] for key in ('present', 'absent') if row[key])
        if disturbed:
            shown['remark'] = f'{disturbed} timings disturbed'
        started = data['started'].get(row['name'])
        if started:
            for key, less in (('present', ''), ('absent', '_less')):
                seconds, memory = started[key]
                if seconds:
                    shown[f'start{less}'] = spread(seconds)
                    shown[f'memory{less}'] = spread(memory)
        rows.append(shown)
    rows += _estimate_rows(data)
    return sorted(rows, key=lambda row: -(row['cost'].value if row['cost'] else -1e9))


def _estimate_rows(data):
    """Return the row of the error estimate, which is a kernel of each step."""
    for row in data['profile']:
        if row['scene'] == 'cutting_brush' and row['kernel'] == 'local error':
            share = row['share']
            yield {'feature': 'error estimate (its kernel alone, steps of 0.2 ms)',
                   'cost': Measured(*(3 * (100.0 * share / (100.0 - share),))),
                   'how': 'it is always there: steps are halved by it', 'remark': ''}


def message_rows(data):
    """Return the rows of the table of topics."""
    return [{'topic': row['topic'], 'bytes': row['bytes'],
             'time': _micro(quartiles(row['timing']['walls'])) if row['timing'] else None,
             'how': VIEWED.get(row['topic'], 'made only for subscribers; a log has it always')}
            for row in data['messages']]


def broom_factor(data, key):
    """Return the Measured times real time of the whole broom, or None."""
    timing = data['broom'].get(key)
    if not timing:
        return None
    wall = quartiles(timing['walls'])
    return Measured(1.0 / wall.value, 1.0 / wall.high, 1.0 / wall.low)


def show(page, data, results):
    """Put the part on the page."""
    page.heading('What it costs to leave things in')
    page.explain('The default scene (one bristle, 12 elements, steps of 0.1 ms) with one thing '
                 'changed at a time; with and without were timed in turns. Start-up is from the '
                 'start of a new process to its first step, with a warm compile cache; memory is '
                 'the most that this process had. Both are taken of what changes what is '
                 'imported or compiled, and are empty elsewhere.')
    rows = feature_rows(data)
    dear = [row for row in rows if row['cost'] and row['cost'].low > 5.0]
    page.says(f'{len(dear)} of {len(rows)} features add more than 5 % to a step: '
              + ('; '.join(f'{row["feature"]} {row["cost"]} %' for row in dear) or 'none') + '.')
    page.table('features', rows, COLUMNS, 'What each feature costs and how it is left out, the '
               'dearest first.')
    page.heading('Messages', 3)
    page.table('messages', message_rows(data), {
        'topic': 'topic', 'bytes': 'bytes of a message', 'time': 'time to make one [us]',
        'how': 'how it is left out'}, 'What a message of each topic costs, one bristle.')
    page.heading('The whole broom', 3)
    one, every = broom_factor(data, 'one core'), broom_factor(data, 'all cores')
    page.says('config/full_brush.yaml, 104 bristles: ' + (
        f'{one} times real time on one core, {every or "not measured"} on all.' if one
        else 'not measured.'))
    page.fold('Where the time of a step goes')
    page.table('profile', data['profile'], {
        'scene': 'scene', 'kernel': 'kernel', 'call_us': 'time of a call [us]',
        'calls_per_step': 'calls per step', 'step_us': 'time in a step [us]',
        'share': 'share of a step [%]'}, 'One bristle, 12 elements, steps of 0.2 ms; each kernel '
        'timed by itself, less an empty call, times how often a step calls it.')
    page.unfold()
