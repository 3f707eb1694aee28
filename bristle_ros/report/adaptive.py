"""Adaptive steps against fixed ones, from those rows of work_precision.py that sweep both."""
import math

import numpy as np

from .page import new_figure
from .work_precision import SWEPT

MEASURES = {'tip_error_percent': 'error of the tip path [%]',
            'impulse_error_percent': 'error of the impulse per 5 ms [%]'}

LINE = 0.05     # between two labels, of the panel's height


def _points(rows, scene, family, key):
    return [row for row in rows if row['scene'] == scene and row['family'] == family
            and row.get(key, math.nan) > 0.0]


def wall_at(fixed, error, key='tip_error_percent'):
    """
    Return the wall time at which fixed steps have this error, between the runs that pay.

    fixed : rows of runs.  A run pays when none is both faster and better. NaN where none is as
    good; where the fastest is better than asked, its wall time.
    """
    paying, best = [], math.inf
    for row in sorted(fixed, key=lambda row: row[key]):     # from good to bad
        if row['wall_per_simulated_s'] < best:
            best = row['wall_per_simulated_s']
            paying.append((math.log(row[key]), math.log(best)))
    errors, walls = zip(*paying)
    return float(math.exp(np.interp(math.log(error), errors, walls, left=math.nan)))


def compare(rows):
    """Return rows: what each adaptive run costs, and what fixed steps cost at its errors."""
    found = []
    for scene in SWEPT:
        for run in _points(rows, scene, 'adaptive', 'tip_error_percent'):
            row = {'scene': scene, 'error_tolerance': run['label'].removeprefix('tol '),
                   'longest_step_us': run['ITS_us'],
                   'wall_per_simulated_s': run['wall_per_simulated_s']}
            for key in MEASURES:
                fixed = _points(rows, scene, 'step', key)
                if not fixed or not run[key] > 0.0:
                    continue
                row[key] = run[key]
                row[f'fixed_over_adaptive_at_this_{key.partition("_")[0]}_error'] = wall_at(
                    fixed, run[key], key) / run['wall_per_simulated_s']
            found.append(row)
    return found


def verdict(compared):
    """Return a sentence for each scene: how often adaptive steps were the cheaper ones."""
    said = []
    for scene in SWEPT:
        for measure in ('tip', 'impulse'):
            ratios = [row.get(f'fixed_over_adaptive_at_this_{measure}_error', math.nan)
                      for row in compared if row['scene'] == scene]
            ratios = [ratio for ratio in ratios if not math.isnan(ratio)]
            if ratios:
                said.append(
                    f'{scene}, {measure}: adaptive steps cheaper in {sum(r > 1 for r in ratios)} '
                    f'of {len(ratios)} runs, fixed over adaptive {min(ratios):.2g} to '
                    f'{max(ratios):.2g}')
    return '; '.join(said) + '.'


def _labelled(points, key):
    """Return (x, y, label) of points, those that are the same run again under one label."""
    found = []
    for point in points:
        label = point['label'].removeprefix('tol ')
        if found and found[-1][1] == point[key]:
            x, y, before = found[-1]
            found[-1] = min(x, point['wall_per_simulated_s']), y, f'{before}, {label}'
        else:
            found.append((point['wall_per_simulated_s'], point[key], label))
    return found


def _few_ticks(panel):
    from matplotlib.ticker import FuncFormatter, LogLocator, NullFormatter
    for axis in (panel.xaxis, panel.yaxis):
        axis.set_major_locator(LogLocator(subs=(1.0, 2.0, 5.0), numticks=20))
        axis.set_major_formatter(FuncFormatter(lambda value, _: f'{value:g}'))
        axis.set_minor_formatter(NullFormatter())


def _label(panel, points, side, colour):
    """Write the labels apart, in a column at a side of the panel, with lines to the points."""
    to_panel = panel.transData + panel.transAxes.inverted()
    wanted = sorted((float(to_panel.transform((x, y))[1]), x, y, label) for x, y, label in points)
    heights = []
    for height, *_ in wanted:
        heights.append(max(height, heights[-1] + LINE if heights else 0.03))
    below = 0.97
    for i in reversed(range(len(heights))):     # what grew out of the top goes down again
        heights[i] = min(heights[i], below)
        below = heights[i] - LINE
    for height, (_, x, y, label) in zip(heights, wanted):
        panel.annotate(
            label, (x, y), xytext=(0.02 if side == 'left' else 0.98, height),
            textcoords='axes fraction', fontsize=7, color=colour, ha=side, va='center',
            arrowprops={'arrowstyle': '-', 'lw': 0.4, 'color': colour, 'shrinkA': 1, 'shrinkB': 3})


def draw(rows, references=()):
    """Return a figure: fixed and adaptive steps on the plane of error and run time."""
    figure, axes = new_figure(len(SWEPT), 2, 10.5, 3.7)
    legend = None
    for column, scene in enumerate(SWEPT):
        for line, (key, title) in enumerate(MEASURES.items()):
            panel = axes[line, column]
            if not _points(rows, scene, 'step', key):
                panel.set_axis_off()
                legend = panel
                continue
            panel.set(title=scene, ylabel=title, xlabel='wall seconds per simulated second')
            for family, colour, marker, name in (
                    ('step', '#1f77b4', 'o', 'fixed steps, labelled with ITS'),
                    ('adaptive', '#9467bd', 'v',
                     'adaptive steps, labelled with error_tolerance')):
                points = _labelled(_points(rows, scene, family, key), key)
                panel.loglog([p[0] for p in points], [p[1] for p in points], marker=marker,
                             color=colour, lw=1, ms=5, label=name)
            panel.margins(x=0.6, y=0.12)
            for row in references:
                if row['scene'] == scene and row['its_own_' + key] > 0.0:
                    panel.axhline(row['its_own_' + key], color='#888', ls=':', lw=1,
                                  label="the converged run's own error")
            panel.autoscale_view()      # now: the labels are placed by the limits
            _few_ticks(panel)
            _label(panel, _labelled(_points(rows, scene, 'step', key), key), 'left', '#1f77b4')
            _label(panel, _labelled(_points(rows, scene, 'adaptive', key), key), 'right',
                   '#9467bd')
    handles, labels = axes[0, 0].get_legend_handles_labels()
    if legend is not None:
        legend.legend(handles, labels, loc='center')
    return figure
