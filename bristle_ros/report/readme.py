"""README's figures, from the results of one kept report."""
from .lean import show as lean
from .paper import claims
from .peers import show as peers
from .precision import show as precision
from .road import show as road
from .stability import show as stability
from .timing import quartiles

BEGIN, END = '<!-- figures: begin -->', '<!-- figures: end -->'
STEPS = (('cutting_brush', '200 us'), ('cutting_brush', '100 us'), ('S2', '1000 us'),
         ('S1', '500 us'), ('S5', '500 us'))
ABSENT = 'not measured'


def _row(what, value):
    return f'| {what} | {value} |'


def _steps(data):
    """Return rows of error and cost at fixed steps."""
    for name, label in STEPS:
        entry = next((e for e in data['subjects'] if e['name'] == name), None)
        row = next((r for r in (entry['rows'] if entry else ()) if r['label'] == label), None)
        if row is None or not row.get('timing'):
            continue
        wall = quartiles(row['timing']['walls'])
        errors = [f'tip {_error(row["tip"], entry["own"].get("tip"))}']
        if row.get('impulse') is not None:
            errors.append(f'5 ms impulse {_error(row["impulse"], entry["own"].get("impulse"))}')
        yield _row(f'{entry["what"]} (`{name}`), steps of {label}',
                   f'{", ".join(errors)}; {1.0 / wall.value:.0f} times real time')


def _road(data):
    """Return rows of what the limits of the road's scenes cost."""
    for row in road.cost_rows(data):
        value = (f'{row["setting"]}: tip {row["tip"]:.2g} %, 5 ms impulse {row["impulse"]:.2g} %; '
                 f'{row["times"]} times real time' if row.get('times') else row['setting'])
        yield _row(f'{row["what"]} (`{row["scene"]}`), path within {row["limit_tip"]:g} %, '
                   f'impulse within {row["limit_impulse"]:g} %', value)


def _error(value, own):
    if own is not None and value <= own:
        return f'at or below {own:.2g} %'
    return f'{value:.2g} %'


def _peers(data):
    if not data['scenes']:
        yield _row('other programs', 'not installed for this run')
        return
    for row in peers.ratios(data):
        if row['ratio']:
            yield _row(f'{row["program"]} {data["versions"][row["program"]]}, {row["scene"]}, at '
                       f'{row["level"]:g} % error: its run time over ours', str(row['ratio']))


def _cost(data):
    for row in lean.feature_rows(data)[:5]:
        if row['cost']:
            yield _row(f'{row["feature"]}: adds to a step', f'{row["cost"]} %')
    one, every = lean.broom_factor(data, 'one core'), lean.broom_factor(data, 'all cores')
    if one:
        yield _row('whole broom of 104 bristles, times real time on one core; on all',
                   f'{one}; {every or ABSENT}')


def _paper(data):
    for level, ratio in claims.cost_ratios(data['rotation_cost'], claims.LEVELS['path']):
        yield _row(f'displacement over inertia load case, run time at {level:g} % error',
                   str(ratio) if ratio else ABSENT)


def figures(results):
    """Return the lines of README's figures, from results as results.json has them."""
    about, parts = results['about'], results['parts']
    machine = about['machine'].get('cpu', 'unknown').split(',')[0]
    lines = [f'{"Quick" if about["quick"] else "Full"} report of {about["date"]} on '
             f'{about["cores"]} cores of an {machine}; errors are against converged runs, '
             'intervals those of its rounds of timing.', '', '| what | value |', '| --- | --- |']
    if 'precision' in parts:
        lines += _steps(parts['precision'])
        for entry in parts['precision']['subjects']:
            cost = precision.cost(entry, 1.0)
            if cost:
                more = 'at least ' if precision.coarsest(entry) < 1.0 else ''
                lines.append(_row(f'`{entry["name"]}`, cheapest setting at 1 % error of the path',
                                  f'{more}{1.0 / cost.value:.0f} times real time'))
    for name, make in (('road', _road), ('peers', _peers), ('cost', _cost), ('paper', _paper)):
        if name in parts:
            lines += make(parts[name])
    if 'stability' in parts:
        lines.append(_row('stability', stability.summary(parts['stability'])))
    return lines


def replaced(text, results):
    """Return README's text with its figures made from results."""
    before, _, rest = text.partition(BEGIN)
    _, _, after = rest.partition(END)
    return '\n'.join([before + BEGIN, *figures(results), END + after])
