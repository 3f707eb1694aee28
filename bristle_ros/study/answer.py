"""What a study says, in words: best designs or strongest influences, and how far to trust them."""
import math
from typing import NamedTuple

import numpy as np

from . import store
from .measure import MEASURES, measure_unit
from .optimise import best, numbers_of
from .sensitivity import indices as sobol_indices

MAIN = ('normal_force_mean', 'drive_torque_mean', 'drive_power', 'clamp_stress_range',
        'tip_radius_range', 'contact_share')
GROUPS = 8              # of a key's values, when its share of the variance is taken


class Answer(NamedTuple):
    """What is told: sentences, remarks on what they rest on, best rows, Sobol indices."""

    lines: list
    notes: list
    best: list
    indices: dict


def answer(study, folder, table):
    """Return the Answer of a study's table (pyarrow)."""
    lines, notes, found, indices = [], [], [], {}
    if study.objectives:
        found = best(study, table.to_pylist())
        lines += _of_best(study, found)
    if study.design == 'saltelli':
        indices, why = sobol_indices(study, folder)
        lines += [why] if why else _of_indices(indices)
    elif not study.objectives:
        lines += _of_ranges(study, table)
    status = table['status'].to_pylist()
    counts = {kind: status.count(kind) for kind in ('finished', 'refused', 'stopped')}
    notes.append(', '.join(f'{number} {kind}' for kind, number in counts.items() if number)
                 + f' of {study.runs} runs')
    if counts['refused'] or counts['stopped']:
        notes.append('the first of those that did not finish: ' + next(
            message for message in table['message'].to_pylist() if message))
    unsettled = table['settled'].to_pylist()
    for kind, told in (('no', 'had not settled: their means still drift'),
                       ('unknown', 'were too short to tell whether they had settled (4 turns)')):
        if kind in unsettled:
            notes.append(f'{unsettled.count(kind)} runs {told}')
    notes += _of_halved(folder, table)
    return Answer(lines, notes, found, indices)


def _of_best(study, rows):
    if not rows:
        return ['No run meets the constraints.']
    wanted = 'largest' if study.maximise else 'smallest'
    if len(study.objectives) == 2:
        rows = sorted(rows, key=lambda row: study.objectives[0].value(numbers_of(study, row)))
        ends = ', '.join(
            f'row {row["run"]} with ' + ' and '.join(
                f'{each.value(numbers_of(study, row)):.4g}' for each in study.objectives)
            for row in (rows[0], rows[-1]))
        return [f'{len(rows)} designs cannot be bettered in both '
                f'{study.objectives[0].text} and {study.objectives[1].text}: rows '
                + ', '.join(str(row['run']) for row in rows[:20]) + f'; at the ends {ends}.']
    [objective] = study.objectives
    row = rows[0]
    interval = row.get(f'{objective.text}_ci95')
    about = f' ± {interval:.2g}' if interval is not None and math.isfinite(interval) else ''
    value = objective.value(numbers_of(study, row))
    at = ', '.join(f'{factor.key} = {_short(row[factor.key])}' for factor in study.factors)
    where = ''.join(f', with {each.text}' for each in study.constraints)
    unit = MEASURES.get(objective.text, '')
    return [f'The {wanted} {objective.text}{where} is {value:.4g}{about}{unit and f" {unit}"}: '
            f'at {at} (row {row["run"]}).']


def _short(value):
    return f'{value:.4g}' if isinstance(value, float) else str(value)


def _of_indices(indices):
    lines = []
    for name in MAIN:
        if name not in indices:
            continue
        first, *others = sorted(indices[name], key=lambda each: -each['ST'])
        if not first['ST_ci95'] < first['ST']:
            lines.append(f'{name}: too few samples to tell what it follows (the largest total '
                         f'share of its variance is {first["ST"]:.2f} ± {first["ST_ci95"]:.2f}).')
            continue
        apart = first['ST'] - first['ST_ci95'] > max((each['ST'] for each in others), default=0.0)
        keys = first['key'] if apart or not others else f'{first["key"]} or {others[0]["key"]}'
        shares = ', '.join(f'{each["key"]} {each["ST"]:.2f} ± {each["ST_ci95"]:.2f}'
                           for each in (first, *others[:1]))
        lines.append(f'{name} follows {keys} most; total shares of its variance: {shares}.')
    return lines


def _of_ranges(study, table):
    lines = []
    run = table['run'].to_numpy()
    for name in MAIN:
        values = table[name].to_numpy(zero_copy_only=False).astype(float)
        there = np.isfinite(values)
        if not there.any() or float(np.ptp(values[there])) == 0.0:
            continue
        low, high = (int(np.flatnonzero(there)[pick(values[there])])
                     for pick in (np.argmin, np.argmax))
        line = (f'{name} goes from {values[low]:.4g} (row {run[low]}) to {values[high]:.4g} '
                f'{measure_unit(name)} (row {run[high]})')
        shares = {factor.key: share_of_variance(table[factor.key].to_pylist(), values, there)
                  for factor in study.factors}
        key = max(shares, key=shares.get)
        if len(shares) > 1:
            line += f'; {key} alone accounts for {shares[key]:.0%} of its variance'
        lines.append(line + '.')
    return lines


def share_of_variance(keys, values, there):
    """Return the correlation ratio: variance between a key's values over that of all rows."""
    picked = [key for key, is_there in zip(keys, there) if is_there]
    values = values[there]
    levels, group = np.unique(np.array(picked), return_inverse=True)
    if len(levels) > GROUPS:
        order = np.argsort(np.array(picked, dtype=float), kind='stable')
        group = np.empty(len(order), int)
        group[order] = np.arange(len(order)) * GROUPS // len(order)
    count = np.bincount(group)
    means = np.bincount(group, values) / np.maximum(count, 1)
    variance = float(values.var())
    return float((count * (means - values.mean()) ** 2).sum() / len(values) / variance)


def _of_halved(folder, table):
    """Say what half the step changed, in the rows that were run so as well."""
    if not store.parts(folder, store.HALVED):
        return []
    again = store.table(folder, ['run', 'status', *MAIN], store.HALVED).to_pylist()
    rows = dict(zip(table['run'].to_pylist(), table.select(MAIN).to_pylist()))
    told = []
    for name in MAIN:
        pairs = [(rows[row['run']][name], row[name]) for row in again
                 if row['status'] == 'finished' and row['run'] in rows]
        changes = [abs(b - a) for a, b in pairs
                   if a is not None and b is not None and math.isfinite(a + b)]
        scale = max((abs(a) for a, b in pairs if a is not None and math.isfinite(a)), default=0.0)
        if changes and scale > 0.0:
            told.append(f'{name} by {max(changes) / scale:.2g}')
    if not told:
        return []
    return [f'half the step, in {len(again)} of the runs, changed, at most and as a share of the '
            'largest value: ' + ', '.join(told)]
