"""The campaign as a map: one cell for each listed value, its colour what became of the case."""
from bristle_ros.report.page import new_figure

from . import cases as campaign_cases
from .campaign import KINDS

COLOURS = {'finished': '#cfe8cf', 'stopped': '#f4a261', 'cut': '#bcd4ee', 'refused': '#dddddd',
           'wrong': '#e63946'}


def draw(results):
    """Return a figure: a row for each parameter and base scene, the values along it."""
    lines = {}
    for result in results:
        base, _, rest = result.name.partition(': ')
        if rest.startswith('drawn'):
            key = 'drawn at random'
        elif rest.startswith('touching'):
            key = 'starts that touch'
        elif ',' in rest:
            key = 'pairs of extremes'
        else:
            words = rest.rsplit(' ', 1)
            key = words[0] if len(words) == 2 and words[0] in _AXES else 'commands and others'
        lines.setdefault((key, base), []).append(result)
    order = sorted(lines, key=lambda line: (line[0] not in _AXES, line))
    width = 12      # cells in a line; longer ones are folded
    cells, labels = [], []
    for key in order:
        group = lines[key]
        for at in range(0, len(group), width):
            labels.append(f'{key[0]} / {key[1]}' if at == 0 else '')
            cells.append(group[at:at + width])
    figure, axes = new_figure(1, 1, 10.5, 1.0 + 0.27 * len(cells))
    panel = axes[0, 0]
    for y, group in enumerate(cells):
        for x, result in enumerate(group):
            panel.barh(y, 0.96, left=x, height=0.92, color=COLOURS[result.kind])
            rate = result.newton / result.steps if result.steps else 0.0
            text = (f'{rate:.0f}' if rate >= 9.95 else f'{rate:.1f}') if rate else ''
            value = _value(result.name)
            panel.text(x + 0.48, y, f'{value}:  {text}' if value else text, ha='center',
                       va='center', fontsize=6)
    panel.set_yticks(range(len(cells)), labels, fontsize=6)
    panel.set_ylim(len(cells) - 0.4, -0.6)
    panel.set_xlim(0, width)
    panel.set_xticks([])
    panel.grid(False)
    panel.set_xlabel('value of the parameter: Newton iterations per step '
                     '(pairs and draws: in the order of campaign.csv)')
    for kind in KINDS:
        panel.bar(0, 0, color=COLOURS[kind],
                  label=f'{kind} ({sum(r.kind == kind for r in results)})')
    figure.legend(loc='outside upper center', ncols=len(KINDS), fontsize=8)
    return figure


def _value(name):
    """Return the value that a case of one changed parameter gives it, else an empty text."""
    words = name.partition(': ')[2].rsplit(' ', 1)
    return words[1] if len(words) == 2 and words[0] in _AXES else ''


def _names():
    return {campaign_cases.spell_key(key) for key in campaign_cases.AXES}


_AXES = _names()
