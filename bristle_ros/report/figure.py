"""Panels of the figures: SVG with text as text, one colour and mark for each thing drawn."""
from html import escape
import io
import math
import re

# Label: colour, matplotlib's marker and the character of the legend. The same everywhere.
MARKS = {
    'bristle_ros': ('#1f77b4', 'o', '\u25cf'), 'exudyn': ('#d62728', 's', '\u25a0'),
    'mujoco': ('#2ca02c', '^', '\u25b2'),
    'step': ('#1f77b4', 'o', '\u25cf'), 'elements': ('#8c564b', 'D', '\u25c6'),
    'integrator': ('#ff7f0e', 'v', '\u25bc'), 'load case': ('#9467bd', 'P', '\u271a'),
    'adaptive': ('#17a2b8', 'X', '\u2716'), 'halved': ('#e377c2', '*', '\u2605'),
    'inertia': ('#1f77b4', 'o', '\u25cf'), 'displacement': ('#9467bd', 'P', '\u271a'),
    'displacement, TS = ITS': ('#9467bd', 'P', '\u271a'),
    'displacement, TS > ITS': ('#e377c2', '*', '\u2605'),
    '6 elements': ('#bcbd22', 'v', '\u25bc'), '8 elements': ('#2ca02c', '^', '\u25b2'),
    '12 elements': ('#1f77b4', 'o', '\u25cf'), '16 elements': ('#d62728', 's', '\u25a0'),
    'whole wire': ('#1f77b4', 'o', '\u25cf'), 'tip alone': ('#ff7f0e', 'v', '\u25bc'),
    'road lying': ('#1f77b4', 'o', '\u25cf'), 'road kerb': ('#d62728', 's', '\u25a0'),
    'road sine': ('#2ca02c', '^', '\u25b2'), 'road rough': ('#ff7f0e', 'v', '\u25bc'),
    'road edge': ('#9467bd', 'D', '\u25c6'),
    'theory': ('#444444', '', '\u2014'), 'free': ('#1f77b4', 'o', '\u25cf'),
    'on the road': ('#ff7f0e', 'v', '\u25bc'),
    'sine': ('#2c7fb8', 'o', '\u25cf'), 'vap': ('#d95f0e', 's', '\u25a0')}
SIZE = (4.4, 3.3)       # [in] of a panel; it is shown at 330 to 520 px


def colour(name):
    """Return the colour of a thing."""
    return MARKS[name][0]


def legend(names, labels=None):
    """Return the legend's entries of things, as Page.figure wants them."""
    return [((labels or {}).get(name, name), MARKS[name][0], MARKS[name][2]) for name in names]


def new_panel(title='', x='', y='', size=SIZE):
    """Return a matplotlib figure of one panel, and its axes."""
    import matplotlib
    matplotlib.use('Agg')
    from matplotlib import pyplot
    pyplot.rcParams.update({
        'font.size': 10, 'axes.grid': True, 'grid.alpha': 0.3, 'axes.axisbelow': True,
        'svg.fonttype': 'none', 'font.family': 'sans-serif',
        'figure.constrained_layout.use': True})
    figure, axes = pyplot.subplots(figsize=size)
    axes.set(title=title, xlabel=x, ylabel=y)
    return figure, axes


def plot(axes, name, x, y, *, line=True, label=None, **style):
    """Draw points of a thing of MARKS in its colour and mark."""
    tint, marker, _ = MARKS[name]
    size = 6.5 if marker in ('X', 'P', '*') else 5.0
    axes.plot(x, y, marker=marker or None, color=tint, ms=size, lw=1.2 if line else 0.0,
              ls='-' if line else 'none', label=label or name, **style)


def bars(axes, name, x, y, low, high):
    """Draw intervals of x around points."""
    axes.hlines(y, low, high, color=MARKS[name][0], lw=2.2, alpha=0.45)


def log_axes(axes, x=True, y=True):
    """Make axes logarithmic, with plain numbers at decades (or at 1, 2, 5 within one)."""
    from matplotlib.ticker import FuncFormatter, LogLocator, NullFormatter
    for axis, wanted, scale, limits in ((axes.xaxis, x, axes.set_xscale, axes.get_xlim),
                                        (axes.yaxis, y, axes.set_yscale, axes.get_ylim)):
        if not wanted:
            continue
        scale('log')
        low, high = limits()
        decades = math.log10(high / low) if low > 0.0 else 9.0
        subs = (1.0,) if decades > 1.3 else (1.0, 2.0, 5.0)
        axis.set_major_locator(LogLocator(subs=subs, numticks=8))
        axis.set_major_formatter(FuncFormatter(lambda value, _: f'{value:g}'))
        axis.set_minor_formatter(NullFormatter())


def real_time(axes):
    """Mark where a simulated second takes a second."""
    axes.axvline(1.0, color='k', lw=1.0)
    axes.annotate('real time', (1.0, 0.02), xycoords=('data', 'axes fraction'), xytext=(3, 0),
                  textcoords='offset points', fontsize=8, rotation=90, va='bottom')


def svg(figure, alt):
    """Return a matplotlib figure as an SVG element, and close it."""
    from matplotlib import pyplot
    buffer = io.StringIO()
    figure.savefig(buffer, format='svg', metadata={'Date': None, 'Creator': None})
    pyplot.close(figure)
    text = buffer.getvalue()
    text = text[text.index('<svg'):]
    used = set(re.findall(r'(?:url\(#|href="#)([^")]+)', text))
    text = re.sub(r' id="([^"]+)"', lambda found: found.group(0) if found.group(1) in used else '',
                  text)
    text = re.sub(r'<metadata>.*?</metadata>', '', text, flags=re.DOTALL)
    text = re.sub(r'<svg ([^>]*?)width="[^"]*" ', r'<svg \1', text, count=1)
    text = re.sub(r'<svg ([^>]*?)height="[^"]*" ', r'<svg \1', text, count=1)
    # coordinates: small enough to keep, precise enough to print; texts as they are
    text = re.sub(r'<[^>]*>', lambda tag: re.sub(r'(-?\d+\.\d\d)\d+', r'\1', tag.group(0)), text)
    return text.replace('<svg ', f'<svg role="img" aria-label="{escape(alt)}" ', 1)
