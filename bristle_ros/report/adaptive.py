"""Adaptive steps against fixed ones: the rows of work_precision.py where both are swept, beside."""
import math

import numpy as np

from bristle_ros.report.page import new_figure, whole_decades
from bristle_ros.report.work_precision import SWEPT

MEASURES = {'tip_error_percent': 'error of the tip path [%]',
            'impulse_error_percent': 'error of the impulse per 5 ms [%]'}


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


def draw(rows):
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
            for family, colour, marker, place, name in (
                    ('step', '#1f77b4', 'o', (-5, -4), 'fixed steps, labelled with ITS'),
                    ('adaptive', '#9467bd', 'v', (5, 1),
                     'adaptive steps, labelled with error_tolerance')):
                points = _labelled(_points(rows, scene, family, key), key)
                panel.loglog([p[0] for p in points], [p[1] for p in points], marker=marker,
                             color=colour, lw=1, ms=5, label=name)
                for x, y, label in points:
                    panel.annotate(label, (x, y), xytext=place, textcoords='offset points',
                                   fontsize=7, color=colour, va='top' if place[0] < 0 else 'bottom',
                                   ha='right' if place[0] < 0 else 'left')
            panel.set(title=scene, ylabel=title, xlabel='wall seconds per simulated second')
            panel.margins(x=0.35, y=0.1)
            whole_decades(panel)
    handles, labels = axes[0, 0].get_legend_handles_labels()
    if legend is not None:
        legend.legend(handles, labels, loc='center')
    return figure
