"""The campaign, shown: counts, the bound on the rate of wrong, causes, and a map of the cases."""
from collections import Counter
from html import escape
import math

from . import cases as campaign_cases
from .campaign import KINDS

COLOURS = {'finished': '#cfe8cf', 'stopped': '#f4a261', 'cut': '#bcd4ee', 'refused': '#dddddd',
           'wrong': '#ff8a8a'}
CONFIDENCE = 0.95


def count_kinds(rows):
    """Return how many rows there are of each kind."""
    return {kind: sum(row['kind'] == kind for row in rows) for kind in KINDS}


def upper_bound(wrong, count, confidence=CONFIDENCE):
    """
    Return the upper bound of Clopper and Pearson on a rate (Biometrika 26 (1934), 404).

    The rate at which `wrong` or fewer of `count` have the probability 1 - confidence. One-sided.
    """
    if count == 0:
        return 1.0
    if wrong >= count:
        return 1.0
    low, high = 0.0, 1.0
    for _ in range(60):
        rate = 0.5 * (low + high)
        if _at_most(wrong, count, rate) > 1.0 - confidence:
            low = rate
        else:
            high = rate
    return high


def _at_most(wrong, count, rate):
    """Return the probability of at most `wrong` of `count` events of a rate."""
    return sum(math.exp(math.lgamma(count + 1) - math.lgamma(k + 1) - math.lgamma(count - k + 1)
                        + k * math.log(rate) + (count - k) * math.log1p(-rate))
               for k in range(wrong + 1))


def problem_of(data):
    """
    Return why a campaign is not a pass, or an empty text.

    A case that was cut off tells nothing about the rest of its time, and no case tells nothing.
    """
    if data is None:
        return ''
    kinds = count_kinds(data['cases'])
    total = sum(kinds.values())
    texts = [f'{kinds[kind]} of {total} cases {words}' for kind, words in (
        ('wrong', 'are wrong'), ('cut', 'were cut off by the limit')) if kinds[kind]]
    if not kinds['finished'] + kinds['stopped']:
        texts.append(f'none of {total} cases ran to its end')
    return ', '.join(texts)


def summary(data):
    """Return a sentence with counts and the bound."""
    kinds = count_kinds(data['cases'])
    drawn = [row for row in data['cases'] if row['drawn']]
    wrong = sum(row['kind'] == 'wrong' for row in drawn)
    bound = upper_bound(wrong, len(drawn))
    return (f'{len(data["cases"])} cases: ' + ', '.join(
        f'{count} {kind}' for kind, count in kinds.items() if count or kind == 'wrong')
        + (f'; of {len(drawn)} drawn at random {wrong} wrong, so the rate is below '
           f'{100 * bound:.2g} % with 95 % confidence' if drawn else ''))


def _counts(rows):
    drawn = [row for row in rows if row['drawn']]
    for title, part in (('listed', [row for row in rows if not row['drawn']]),
                        ('drawn at random', drawn), ('of these on a surface',
                                                     [row for row in drawn if is_uneven(row)])):
        if part:
            kinds = count_kinds(part)
            yield {'cases': title, 'count': len(part), **kinds, 'bound': 100 * upper_bound(
                kinds['wrong'], len(part)) if part[0]['drawn'] else None}


def is_uneven(row):
    """Whether a case's road is not level."""
    return row.get('surface', 'level') != 'level'


def _causes(rows):
    """Return the rows that did not finish, with a cause each, the worst kind first."""
    odd = [row for row in rows if row['kind'] in ('wrong', 'stopped', 'cut', 'refused')]
    return sorted(odd, key=lambda row: KINDS[::-1].index(row['kind']))


def _lines(rows):
    """Return {label of a line of the map: rows}, parameters first."""
    names = {campaign_cases.spell_key(key) for key in campaign_cases.AXES}
    lines = {}
    for row in rows:
        base, _, rest = row['name'].partition(': ')
        words = rest.rsplit(' ', 1)
        if row['drawn']:
            key = 'drawn at random'
        elif rest.startswith('on a surface'):
            key = 'on a surface'
        elif rest.startswith('touching'):
            key = 'starts that touch'
        elif ',' in rest:
            key = 'pairs of extremes'
        else:
            key = words[0] if len(words) == 2 and words[0] in names else 'commands and others'
        value = words[1] if key in names else ''
        lines.setdefault((key not in names, f'{key} / {base}'), []).append((value, row))
    return {label: found for (_, label), found in sorted(lines.items())}


def case_map(rows):
    """Return the campaign as HTML: a cell for each case, its colour what became of it."""
    out = ['<div class="map">']
    for label, found in _lines(rows).items():
        cells = []
        for value, row in found:
            rate = row['newton'] / row['steps'] if row['steps'] else 0.0
            text = f'{value}: {rate:.2g}' if value else f'{rate:.2g}'
            if row['kind'] != 'finished':
                text += f' {row["kind"]}'
            cells.append(f'<span style="background:{COLOURS[row["kind"]]}" '
                         f'title="{escape(row["name"], quote=True)}">{escape(text)}</span>')
        out.append(f'<div><b>{escape(label)}</b>{"".join(cells)}</div>')
    return ''.join(out) + '</div>'


COLUMNS = {
    'name': 'case', 'surface': 'road', 'kind': 'what became of it', 'reason': 'cause',
    'reached': 'simulated [s]', 'duration': 'asked for [s]',
    'spent': 'processor time of stepping [s]',
    'warnings': 'warnings of the run', 'steps': 'steps',
    'newton': 'Newton iterations', 'substeps': 'sub-steps',
    'worst_step_newton': 'most iterations in a step', 'worst_step_s': 'longest call [s]',
    'energy_gain': 'energy from nowhere, share', 'energy_loss': 'energy lost, share',
    'cone_excess': 'friction beyond its cone, share', 'stretch': 'stretch of the chord',
    'law_excess': 'contact force against penetration', 'entered_m': 'depth in the road [m]',
    'work_made': 'work that the contact made, share', 'wire_entered_m': 'depth of the wire [m]',
    'looks': 'outputs looked at', 'wire_points': 'places along wires looked at',
    'largest_force_n': 'largest contact force [N]'}


def show(page, data, results):
    """Put the part on the page."""
    rows = data['cases']
    page.heading('Stability')
    page.explain('Stiff and extreme scenes, listed one parameter and one pair of extremes at a '
                 'time, and drawn at random on slopes, kerbs, edges, waves and sums of them, with '
                 'tables of speeds, rows of bristles, commands, resets, load steps longer than '
                 'ITS, all integrators and both load cases. Wrong is a case that came to its end, '
                 'or did not come back, although a check of it is violated.')
    page.explain('Checked from the outputs alone, and from the surface written a second time: '
                 'finite values; energy balance; friction inside its cone and a road that only '
                 'pushes; the contact force that the penetration explains; a contact that gives '
                 'no more work than its spring; a rigid road not entered; wires, where all of '
                 'them touches, nowhere deeper in the surface than their forces explain; no step '
                 'from a clamp inside it; the bristle as long as its loads make it.')
    page.says(f'{summary(data)}. Seed {data["seed"]}, at most {data["case_limit"]:g} s of a '
              'processor each.')
    page.says(f'Looked at: {sum(row.get("looks") or 0 for row in rows)} outputs, and '
              f'{sum(row.get("wire_points") or 0 for row in rows)} places along wires that touch '
              f'with all their length; on surfaces {sum(is_uneven(row) for row in rows)} cases.')
    if data.get('builds'):
        page.says(f'The drawn cases need {data["builds"]} sets of compiled functions'
                  + (f': once {data["of_builds"]} had come, cases that need another were drawn '
                     'again, as compiling takes longer than running.' if data['of_builds']
                     else '.'))
    problem = problem_of(data)
    if problem:
        page.says(f'Not a pass: {problem}.', marked=True)
    if rows:
        worst = max(rows, key=lambda row: row['worst_step_newton'])
        page.says(f'Most iterations in one step: {worst["worst_step_newton"]} ({worst["name"]}); '
                  f'longest call {max(row["worst_step_s"] for row in rows):.2g} s.')
    warned = Counter(kind for row in rows for kind in (row.get('warnings') or '').split(', '))
    del warned['']
    if warned:
        page.says('Cases that warned of their own results: ' + ', '.join(
            f'{kind} {count}' for kind, count in warned.most_common()) + '.')
    page.table('campaign_counts', list(_counts(rows)), {
        'cases': 'cases', 'count': 'count', **{kind: kind for kind in KINDS},
        'bound': 'rate of wrong, upper bound with 95 % confidence [%]'},
        'What became of the cases; the bound is that of Clopper and Pearson.')
    page.table('campaign_not_finished', _causes(rows), {
        'name': 'case', 'kind': 'what became of it', 'reason': 'cause'},
        'Cases that were stopped, cut off, refused or wrong, and why.')
    page.fold('Map of all cases: value and Newton iterations per step')
    page.raw(case_map(rows))
    page.unfold()
    page.data('campaign', rows, COLUMNS, 'Every case of the campaign.')
