"""
Measures of a run over its whole turns after it has settled, each mean with its 95 % interval.

Forces are means over the time between samples, from the contact's impulse: no peak is lost to
sampling. A turn is a batch: the interval of a mean is that of the means of single turns.
Source of batch means: Law and Kelton, Simulation Modeling and Analysis, 2000, sec. 9.5.3.
"""
import math

import numpy as np

# measure: unit. Means have batches; the others have no interval.
MEANS = {
    'normal_force_mean': 'N', 'side_force_mean_x': 'N', 'side_force_mean_y': 'N',
    'friction_force_mean': 'N', 'drive_torque_mean': 'N m', 'drive_power': 'W',
    'contact_share': '1', 'contact_length_mean': 'm', 'tip_slip_speed_mean': 'm/s',
    'impacts_per_turn': '1', 'friction_work_per_metre': 'J/m', 'tip_radius_mean': 'm',
    'mount_force_mean_x': 'N', 'mount_force_mean_y': 'N', 'mount_force_mean_z': 'N',
    'normal_force_rms': 'N'}
EXTREMES = {'normal_force_max': 'N', 'clamp_stress_max': 'Pa', 'clamp_stress_range': 'Pa',
            'clamp_life_hours': 'h', 'tip_radius_range': 'm'}
MEASURES = {**MEANS, **EXTREMES}
LEAST_TURNS = 5         # for an interval
AIR = 5e-4              # [s] without contact before a touch counts as an impact
DRIFT = 0.01            # of mean + scatter: a drift that is none
_WATCHED = ('normal_force_mean', 'drive_torque_mean', 'drive_power', 'tip_radius_mean')


def measure(history, scene, settle, fatigue=None):
    """
    Return the measures of a History by name, with NAME_ci95, `settled`, `turns`, local_error_max.

    settle [s] is left out; then the whole turns count. With none, all that is left counts, and
    intervals are NaN.
    """
    from .stress import clamp_stress, life
    start = min(int(np.searchsorted(history.t, settle - 1e-9)), len(history.t) - 2)
    part = type(history)(*(array[start:] for array in history))
    batch = _turns(part.theta)
    turns = int(batch[-1])
    inside = batch[:-1] < turns if turns else np.ones(len(batch) - 1, bool)
    last = int(np.flatnonzero(inside)[-1]) + 1
    series = {name: values[:last] for name, values in _series(part, scene).items()}
    batch = batch[:last] if turns else np.zeros(last, int)
    number = max(turns, 1)
    means = {name: _batch_means(values, batch, number) for name, values in series.items()}
    slip, touching = means.pop('slipped'), means.pop('touching')
    row = {}
    with np.errstate(invalid='ignore', divide='ignore'):
        means['tip_slip_speed_mean'] = slip / touching
    means['normal_force_rms'] = np.sqrt(means.pop('square'))
    for name, values in means.items():
        row[name] = float(series[name].mean()) if name in series else float(values.mean())
        row[f'{name}_ci95'] = half_width(values) if turns else math.nan
    total = series['touching'].sum()
    row['tip_slip_speed_mean'] = float(series['slipped'].sum() / total) if total else math.nan
    row['normal_force_rms'] = math.sqrt(series['square'].mean())
    _count_impacts(row, part, scene, batch, turns)
    stress = clamp_stress(part, scene)[:last + 1]
    row['normal_force_max'] = float(series['normal_force_mean'].max())
    row['clamp_stress_max'] = float(np.abs(stress).max())
    row['clamp_stress_range'] = float(np.ptp(stress, axis=0).max())
    duration = float(part.t[last] - part.t[0])
    row['clamp_life_hours'] = life(stress, duration, fatigue) if fatigue else math.nan
    radius = np.hypot(*part.tip_position[:last + 1].T[:2])
    row['tip_radius_range'] = float(np.ptp(radius, axis=1).mean())
    row['settled'] = _settled(series, means, turns)
    row['turns'] = turns
    row['local_error_max'] = float(history.error_estimate.max())
    return row


def _turns(theta):
    """Return how many whole turns lie before each sample."""
    travelled = np.maximum.accumulate(np.abs(theta - theta[0]))
    return np.floor(travelled / (2.0 * math.pi) + 1e-9).astype(int)


def _series(part, scene):
    """Return what the means are of: name to (n - 1,), one for each time between samples."""
    wires = scene.brush.wires_per_bristle
    step = np.diff(part.t)[:, None, None]
    force = np.diff(part.contact_impulse, axis=0) / step            # of the road on each wire
    across = np.linalg.norm(force[..., :2], axis=-1)
    velocity = np.diff(part.tip_position_road, axis=0)[..., :2] / step
    velocity = velocity + np.array(scene.sweeper.velocity)          # of the tips over the road
    slip = np.linalg.norm(velocity, axis=-1)
    touches = part.contact_force[..., 2] > 0.0
    touching = 0.5 * (touches[1:] + touches[:-1].astype(float))
    tips = part.tip_force[..., 2] > 0.0
    tips = 0.5 * (tips[1:] + tips[:-1].astype(float))
    normal = wires * force[..., 2].sum(axis=1)
    side = wires * force[..., :2].sum(axis=1)
    torque = -0.5 * (part.brush_torque[1:, 2] + part.brush_torque[:-1, 2])
    power = -part.brush_torque[:, 2] * part.omega
    mount = 0.5 * (part.brush_force[1:] + part.brush_force[:-1])
    friction = -wires * np.einsum('nbi,nbi->n', force[..., :2], velocity)   # [W]
    length = 0.5 * (part.contact_length[1:] + part.contact_length[:-1])
    friction[length.max(axis=1) > 0.0] = math.nan   # of the tips' slip: what lies slips elsewhere
    speed = math.hypot(*scene.sweeper.velocity)
    radius = np.hypot(part.tip_position[1:, :, 0], part.tip_position[1:, :, 1])
    return {
        'normal_force_mean': normal, 'square': normal * normal, 'side_force_mean_x': side[:, 0],
        'side_force_mean_y': side[:, 1], 'friction_force_mean': across.mean(axis=1),
        'drive_torque_mean': torque, 'drive_power': 0.5 * (power[1:] + power[:-1]),
        'contact_share': touching.mean(axis=1), 'contact_length_mean': length.mean(axis=1),
        'slipped': (slip * tips).mean(axis=1), 'touching': tips.mean(axis=1),
        'tip_radius_mean': radius.mean(axis=1),
        'friction_work_per_metre': friction / speed if speed else np.full(len(friction), math.nan),
        **{f'mount_force_mean_{axis}': mount[:, i] for i, axis in enumerate('xyz')}}


def _batch_means(values, batch, number):
    return np.bincount(batch, values, number) / np.bincount(batch, minlength=number)


def half_width(batches):
    """Return the half width of the 95 % interval of the mean of batches; NaN for fewer than 5."""
    if len(batches) < LEAST_TURNS or not np.isfinite(batches).all():
        return math.nan
    return _student(len(batches) - 1) * float(np.std(batches, ddof=1)) / math.sqrt(len(batches))


def _student(freedom):
    from scipy.special import stdtrit
    return float(stdtrit(freedom, 0.975))


def _count_impacts(row, part, scene, batch, turns):
    """Count touches after at least AIR s without one, a turn and wire."""
    row['impacts_per_turn'] = row['impacts_per_turn_ci95'] = math.nan
    if not turns:
        return
    touches = part.contact_force[:len(batch) + 1, :, 2] > 0.0
    least = max(1, math.ceil(AIR / (part.t[1] - part.t[0]) - 1e-6))
    counts = np.zeros(turns)
    for wire in touches.T:
        edges = np.flatnonzero(np.diff(wire.astype(np.int8)))
        for before, edge in zip([-1, *edges[:-1]], edges):
            if not wire[edge] and edge - before >= least and before >= 0:
                counts[batch[edge]] += 1.0
    counts /= touches.shape[1]
    row['impacts_per_turn'] = float(counts.mean())
    row['impacts_per_turn_ci95'] = half_width(counts)


def _settled(series, means, turns):
    """Say whether the later turns have the means of the earlier ones: yes, no or unknown."""
    if turns < 4:
        return 'unknown'
    for name in _WATCHED:
        early, late = np.array_split(means[name], 2)
        scatter = math.sqrt(early.var(ddof=1) / len(early) + late.var(ddof=1) / len(late))
        allowed = max(_student(turns - 2) * scatter,
                      DRIFT * (abs(means[name].mean()) + float(series[name].std())))
        if abs(late.mean() - early.mean()) > allowed:
            return 'no'
    return 'yes'


def measure_unit(name):
    """Return the unit of a measure, empty for a bare number."""
    return MEASURES[name] if MEASURES[name] != '1' else ''
