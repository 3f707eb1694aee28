"""The paper's experiments, measured: friction, polygon, both load cases, sensitivities, cost."""
from bristle_ros.report.precision.subjects import OTHER
from bristle_ros.report.runs import impulse_error, tip_error, total_impulse
from bristle_ros.report.timing import Timed
from bristle_ros.report.workers import Failed, Job
import numpy as np

from . import experiments as run

TURNS = (0.0, -1e-4, 1e-4)      # [rad] of the start angle: what they change is scatter
DEEP, PRINTED = 0.04, 4e-5      # [m] penetration of figure 5: meant, and as printed
# cost of both load cases: polygons with so many integration steps per side
SIDES = (1, 2, 5, 10)


def measure(context):
    """Return the part's data."""
    steps = (_friction, _damping, _load_cases, _sensitivities, _rotation_cost, _force_cost)
    data = {'series': {}}
    for number, step in enumerate(steps):
        context.progress.count(number, len(steps), step.__name__[1:].replace('_', ' '))
        data[step.__name__[1:]] = step(context, data['series'])
    return data


def _good(values):
    return [value for value in values if not isinstance(value, Failed)]


def _friction(context, series):
    found = _good(context.crew.run([Job(run.friction, (rpm,)) for rpm in (60, 100, 140)]))
    series['friction'] = [(each['rpm'], each.pop('points')) for each in found]
    return found


def _damping(context, series):
    """Return rows of figure 4, each with its deviations from the inertia load case."""
    quick = context.quick
    jobs = []
    for time_step, its in run.POLYGON:
        if quick and its < 2e-6 and time_step > 5e-6:
            continue
        duration = 0.012 if quick else 0.02 if its < 5e-6 else 0.1
        jobs += [Job(run.damping, (time_step, its, 'displacement', integrator, duration))
                 for integrator in run.FIGURE4
                 if not quick or integrator != 'HHT 0.005']
    for time_step, its in ((0.0, 1e-5), (0.0, 5e-6), (1e-3, 1e-5), (1e-4, 1e-5)):
        jobs += [Job(run.damping, (time_step, its, 'inertia', integrator, 0.1))
                 for integrator in run.FIGURE4]
    rows = _good(context.crew.run(jobs, show=lambda value, job, done, total: context.progress(
        f'figure 4, {done} of {total}')))
    exact = next(row for row in rows if row['load_case'] == 'inertia' and row['TS'] == 0.0
                 and row['ITS'] == 5e-6 and row['integrator'] == 'spectral radius 0')
    whole, tip = np.array(exact['whole']), np.array(exact['tip']).reshape(-1, 3)
    series['damping'] = []
    for row in rows:
        n = len(row['whole'])
        row['whole_error'] = float(np.abs(np.array(row['whole']) - whole[:n]).max())
        path = np.array(row['tip']).reshape(-1, 3)
        moved = tip[:n] - tip[0]
        row['tip_error'] = 100 * float(np.sqrt(((path - tip[:n]) ** 2).sum()
                                               / (moved ** 2).sum()))
    for row in rows:
        drawn = row.pop('series')
        if row['ITS'] == 1e-5 and row['integrator'] != 'HHT 0.005':
            series['damping'].append({**{key: row[key] for key in (
                'TS', 'load_case', 'integrator')}, 't': drawn[0], 'force': drawn[1]})
        del row['whole'], row['tip']
    return rows


def _load_cases(context, series):
    """Return rows of figure 5: both load cases at both penetrations, from a few start angles."""
    cases = (('inertia', 1e-3), ('displacement', 1e-5))
    rows, series['load_cases'] = [], []
    for depth in (DEEP, PRINTED):
        turns = TURNS if depth == DEEP else TURNS[:1]
        paths = context.crew.run([Job(run.sweep, (load_case, time_step, depth, turn))
                                  for turn in turns for load_case, time_step in cases])
        pairs = [pair for pair in zip(paths[::2], paths[1::2]) if len(_good(pair)) == 2]
        if not pairs:
            continue
        one, other = pairs[0]
        touched = np.flatnonzero(one.impulse[:, 2] > 0.0)
        first = float(one.t[touched[0]]) if len(touched) else None
        rows.append({
            'penetration': depth, 'first_touch': first,
            'impulses': [[total_impulse(path) for path in pair] for pair in pairs],
            'until_touch': [100 * tip_error(b, a, first) for a, b in pairs],
            'whole_run': [100 * tip_error(b, a) for a, b in pairs]})
        for path, (load_case, time_step) in zip((one, other), cases):
            force = np.gradient(path.impulse[:, 2], path.t)
            series['load_cases'].append({
                'penetration': depth, 'load_case': load_case, 'TS': time_step,
                't': path.t[::2].tolist(), 'force': force[::2].tolist(),
                'radial': (1e3 * (path.tip[::2, 0] - path.tip[0, 0])).tolist()})
    return rows


def _sensitivities(context, series):
    """Return rows: errors of path and impulse of the sweeping run against ITS, TS and mesh."""
    quick, duration = context.quick, 0.24
    cases = [('ITS', its, {'its': its}) for its in (
        (2e-4, 1e-4, 5e-5, 2e-5, 1e-5, 5e-6) if quick
        else (5e-4, 2e-4, 1e-4, 5e-5, 2e-5, 1e-5, 5e-6))]
    cases += [('elements', n, {'elements': n}) for n in (
        (6, 12) if quick else (4, 6, 8, 12, 16, 24))]
    for load_case, values in (('inertia', (1e-3, 5e-4) if quick else (
            1e-2, 5e-3, 1e-3, 5e-4, 1e-4, 1e-5)),
            ('displacement', (1e-3, 1e-5) if quick else (5e-3, 1e-3, 1e-4, 1e-5))):
        cases += [(f'TS, {load_case}', ts, {'load_case': load_case, 'time_step': ts})
                  for ts in values]
    fine, second = (2e-6, {'elements': 16}), (2e-6, {'elements': 20, **OTHER})
    jobs = [Job(run.sensitivity, (*fine, duration)), Job(run.sensitivity, (*second, duration))]
    for _, _, keys in cases:
        keys = dict(keys)
        jobs.append(Job(run.sensitivity, (keys.pop('its', 1e-5), keys, duration)))
    reference, other, *paths = context.crew.run(jobs, show=lambda value, job, done, total:
                                                context.progress(f'sensitivities, {done} of '
                                                                 f'{total}'))
    if isinstance(reference, Failed):
        return {'own': None, 'rows': []}
    own = None if isinstance(other, Failed) else [100 * tip_error(other, reference),
                                                  100 * impulse_error(other, reference)]
    return {'own': own, 'rows': [
        {'what': what, 'value': value, 'tip': 100 * tip_error(path, reference),
         'impulse': 100 * impulse_error(path, reference)}
        for (what, value, _), path in zip(cases, paths) if not isinstance(path, Failed)]}


def _polygons(steps, inertia):
    """Return (load case, TS, ITS): inertia with its TS, and polygons of a few steps per side."""
    found = [('inertia', ts, its) for its in steps for ts in inertia if ts == 0.0 or ts >= its]
    found += [('displacement', n * its, its) for its in steps for n in SIDES]
    return found


def _rotation_cost(context, series):
    """Return error and cost of both load cases on the free rotation: the path."""
    steps = (4e-3, 2e-3, 1e-3, 5e-4, 2e-4) + (() if context.quick else (1e-4, 5e-5))
    duration = 0.5
    cases = _polygons(steps, (0.0, 1e-3))
    jobs = [Job(run.rotation, (1e-5 if not context.quick else 2e-5, 'inertia', 0.0, duration)),
            Job(run.rotation, (1e-5 if not context.quick else 2e-5, 'displacement', 0.0,
                               duration))]
    jobs += [Job(run.rotation, (its, load_case, ts, duration)) for load_case, ts, its in cases]
    reference, second, *paths = context.crew.run(jobs)
    rows = [{'load_case': load_case, 'TS': ts, 'ITS': its, 'error': 100 * tip_error(path,
                                                                                   reference)}
            for (load_case, ts, its), path in zip(cases, paths) if not isinstance(path, Failed)]
    _time(context, rows, 'path', lambda row: (run.prepare_rotation, (
        row['ITS'], row['load_case'], row['TS'], duration)), duration)
    return {'own': 100 * tip_error(second, reference), 'rows': rows}


def _force_cost(context, series):
    """Return error and cost of both load cases on the scene of figure 4: the damping force."""
    steps = (1e-4, 5e-5, 2e-5, 1e-5) + (() if context.quick else (5e-6,))
    duration, integrators = 0.02, ('Newmark 0.005', 'spectral radius 0.8')
    cases = [(*case, integrator) for case in _polygons(steps, (0.0, 1e-3))
             for integrator in integrators]
    fine = 1e-6
    jobs = [Job(run.force_path, (0.0, fine, 'inertia', integrator, duration))
            for integrator in integrators[::-1]]
    jobs += [Job(run.force_path, (ts, its, load_case, integrator, duration))
             for load_case, ts, its, integrator in cases]
    reference, second, *forces = context.crew.run(jobs)
    rows = []
    for (load_case, ts, its, integrator), force in zip(cases, forces):
        if not isinstance(force, Failed):
            rows.append({'load_case': load_case, 'TS': ts, 'ITS': its, 'integrator': integrator,
                         'error': 100 * run.relative_force_error(force, its, reference, fine)})
    _time(context, rows, 'force', lambda row: (run.prepare_force, (
        row['TS'], row['ITS'], row['load_case'], row['integrator'], duration)), duration)
    return {'own': 100 * run.relative_force_error(second, fine, reference, fine), 'rows': rows}


def _time(context, rows, name, call, duration):
    keys = [' '.join([name, *(str(row[key]) for key in ('load_case', 'TS', 'ITS', 'integrator')
                              if key in row)]) for row in rows]
    timings = context.timer.group([Timed(key, *call(row), per=duration)
                                   for key, row in zip(keys, rows)])
    for key, row in zip(keys, rows):
        row['timing'] = timings.get(key)
