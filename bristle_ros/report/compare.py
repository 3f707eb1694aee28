"""What got faster, slower, better or worse since an earlier report, beyond the noise of both."""
from .paper import claims
from .stability import show as stability
from .timing import quartiles, slowness
from .verdict import contradict, Measured, widen

SAME = 1.05     # ratio of run times that counts as none, whatever the intervals say
ERROR = 1.01    # the same of errors, which do not depend on the machine


def _timings(results):
    """Return {(part, what): timing dict}."""
    parts, found = results['parts'], {}
    for part in ('precision', 'road'):
        for entry in parts.get(part, {}).get('subjects', ()):
            for row in entry['rows']:
                found[part, f'{entry["name"]} {row["label"]}'] = row.get('timing')
    for scene in parts.get('peers', {}).get('scenes', ()):
        for program, entry in scene['programs'].items():
            for row in entry['rows']:
                found['peers', f'{scene["name"]} {program} {row["label"]}'] = row.get('timing')
    for row in parts.get('cost', {}).get('features', ()):
        found['cost', row['name']] = row['present']
    return {key: timing for key, timing in found.items() if timing}


def _errors(results):
    """Return {(scene, setting, error): (value, own error of the converged run)}."""
    return {(entry['name'], row['label'], key): (row[key], entry['own'].get(key) or 0.0)
            for part in ('precision', 'road')
            for entry in results['parts'].get(part, {}).get('subjects', ())
            for row in entry['rows'] for key in ('tip', 'impulse') if row.get(key) is not None}


def time_ratio(new, old, pace):
    """Return the Measured ratio of two timings, new over old; pace: how the machines compare."""
    a, b = quartiles(new['walls']), quartiles(old['walls'])
    found = Measured(a.value / b.value, a.low / b.high, a.high / b.low)
    found = Measured(*(value / pace for value in found))
    return widen(found, max(slowness(new), slowness(old)))


def _beyond(ratio):
    """Return what a ratio of run times says, or an empty text."""
    if ratio.low > 1.0 and ratio.value > SAME:
        return 'slower'
    return 'faster' if ratio.high < 1.0 and ratio.value < 1.0 / SAME else ''


def time_rows(old, new):
    """Return rows of the run times that changed beyond the noise, and how many were compared."""
    pace = _pace(old, new)
    before, rows, count = _timings(old), [], 0
    for key, timing in _timings(new).items():
        if key in before:
            count += 1
            ratio = time_ratio(timing, before[key], pace)
            said = _beyond(ratio)
            if said:
                rows.append({'part': key[0], 'what': key[1], 'ratio': ratio, 'said': said})
    return sorted(rows, key=lambda row: row['ratio'].value), count


def _pace(old, new):
    """Return the time of the calibration loop, new over old."""
    ours, theirs = new['about'].get('calibration'), old['about'].get('calibration')
    return ours / theirs if ours and theirs else 1.0


def error_rows(old, new):
    """Return rows of the errors that changed beyond what the converged runs are sure to."""
    before, rows, count = _errors(old), [], 0
    for key, (value, own) in _errors(new).items():
        if key in before:
            count += 1
            was, own_then = before[key]
            change = value - was
            if abs(change) > own + own_then and max(value, was) > ERROR * min(value, was):
                rows.append({'scene': key[0], 'what': key[1], 'error': key[2], 'was': was,
                             'is': value, 'said': 'worse' if change > 0.0 else 'better'})
    return rows, count


def verdict_rows(old, new):
    """Return rows of the claims whose verdict changed."""
    if not ('paper' in old['parts'] and 'paper' in new['parts']):
        return []
    before = {(row['claim'], row['reading']): row['verdict']
              for row in claims.judge(old['parts']['paper'])}
    rows = []
    for row in claims.judge(new['parts']['paper']):
        was = before.get((row['claim'], row['reading']))
        if was is not None and was != row['verdict']:
            rows.append({'claim': row['claim'], 'was': was, 'is': row['verdict'],
                         'contradiction': contradict(was, row['verdict'])})
    return rows


def show(page, old, new):
    """Put the comparison on the page."""
    page.heading('Compared with an earlier report')
    same = old['about']['machine'].get('cpu') == new['about']['machine'].get('cpu')
    page.says(f'With that of {old["about"]["date"]}, on {"the same" if same else "another"} '
              'processor; run times are divided by that of the calibration loop, which took '
              f'{_pace(old, new):.3g} of what it did.')
    rows, count = time_rows(old, new)
    page.says(f'{len(rows)} of {count} run times changed beyond the noise.')
    page.table('compared_times', rows, {
        'part': 'part', 'what': 'what', 'ratio': 'run time, new over old', 'said': 'it got'},
        'Run times that changed by more than their quartiles and 5 %.')
    rows, count = error_rows(old, new)
    page.says(f'{len(rows)} of {count} errors changed beyond the own errors of the converged '
              'runs.')
    page.table('compared_errors', rows, {
        'scene': 'scene', 'what': 'setting', 'error': 'error of', 'was': 'it was [%]',
        'is': 'it is [%]', 'said': 'it got'}, 'Errors that changed.')
    rows = verdict_rows(old, new)
    page.says(f'{len(rows)} verdicts on claims changed.')
    page.table('compared_verdicts', rows, {
        'claim': "the paper's words", 'was': 'verdict then', 'is': 'verdict now',
        'contradiction': 'they exclude each other'}, 'Verdicts that changed.')
    for when, results in (('then', old), ('now', new)):
        data = results['parts'].get('stability')
        page.says(f'Stability {when}: {stability.summary(data) if data else "not measured"}.')
