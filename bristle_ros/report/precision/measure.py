"""
Error against run time, measured: converged runs, the second discretisation, and every setting.

Errors and times are measured apart: a run's error does not depend on the machine, so all cores
work on errors; times are taken on one core, in turns (timing.py).
"""
from bristle_ros.report.curves import rises
from bristle_ros.report.runs import impulse_error, prepare_run, run, SAMPLE, tip_error
from bristle_ros.report.timing import Timed
from bristle_ros.report.workers import Failed, Job

from .subjects import OTHER, scene_of, settings, SUBJECTS

NEAR = (-2, -1, 1, 2)   # more samples' steps per ms: steps that are nearly the same
ERRORS = ('tip', 'impulse')


def solve(name, its, keys, duration):
    """Return the Path of a subject; in a worker."""
    return run(scene_of(name, its, **keys), duration)


def prepare(name, its, keys, duration):
    """Return what runs a subject and tells its wall time; in a worker."""
    return prepare_run(scene_of(name, its, **keys), duration)


def _converged_jobs(subject, quick):
    """Return the jobs of the converged run, of the second discretisation, and of other meshes."""
    (elements, its), (others, other_its) = subject.reference, subject.check
    if quick:
        its, other_its = 2.5 * its, 2.5 * other_its
    jobs = [Job(solve, (subject.name, its, {'elements': elements}, subject.duration)),
            Job(solve, (subject.name, other_its, {'elements': others, **OTHER}, subject.duration))]
    if subject.contact:     # there the mesh is one and the same: what it changes is told apart
        jobs.append(Job(solve, (subject.name, 10 * its, {'elements': 2 * elements},
                                subject.duration)))
        jobs.append(Job(solve, (subject.name, 10 * its, {'elements': elements},
                                subject.duration)))
    return jobs, elements, its


def errors_of(path, reference, contact):
    """Return the errors of a path [%], by name."""
    return {'tip': 100 * tip_error(path, reference),
            'impulse': 100 * impulse_error(path, reference) if contact else None}


def measure(context, subjects=SUBJECTS):
    """Return the part's data: {'subjects': [dict of name, converged run, rows, rises]}."""
    found = []
    for number, subject in enumerate(subjects):
        wanted = settings(subject, context.quick)
        converged, elements, its = _converged_jobs(subject, context.quick)
        jobs = converged + [Job(solve, (subject.name, step, keys, subject.duration), label=label)
                            for _, label, step, keys in wanted]
        paths = context.crew.run(jobs, show=lambda value, job, done, total, number=number:
                                 context.progress.count(number + 0.5 * done / total, len(subjects),
                                                        f'{subjects[number].name} {job.label}'))
        reference, second, *meshes = paths[:len(converged)]
        if isinstance(reference, Failed):
            found.append({'name': subject.name, 'what': subject.what, 'rows': [], 'rises': [],
                          'own': {}, 'failed': reference.reason})
            continue
        own = {} if isinstance(second, Failed) else errors_of(second, reference, subject.contact)
        rows = _rows(subject, wanted, paths[len(converged):], reference)
        _time(context, subject, rows)
        entry = {
            'name': subject.name, 'what': subject.what, 'contact': subject.contact,
            'duration': subject.duration, 'elements': elements, 'its': its, 'own': own,
            'second': f'{subject.check[0]} elements, HHT', 'rows': rows,
            'mesh': errors_of(meshes[1], meshes[0], True)
            if len(meshes) == 2 and not any(isinstance(m, Failed) for m in meshes) else {}}
        entry['rises'] = _explained(context, subject, entry, reference)
        found.append(entry)
    return {'subjects': found}


def _rows(subject, wanted, paths, reference):
    rows = []
    for (family, label, step, keys), path in zip(wanted, paths):
        row = {'family': family, 'label': label, 'its': step, 'keys': keys}
        if isinstance(path, Failed):
            rows.append({**row, 'note': path.reason})
            continue
        rows.append({**row, **errors_of(path, reference, subject.contact), 'note': '',
                     'newton_per_step': path.newton / path.steps, 'steps': path.steps,
                     'estimate': 100 * path.estimate})
    return rows


def _time(context, subject, rows):
    timed = [Timed(f'{subject.name} {row["label"]}', prepare,
                   (subject.name, row['its'], row['keys'], subject.duration),
                   per=subject.duration) for row in rows if 'tip' in row]
    timings = context.timer.group(timed)
    for row in rows:
        row['timing'] = timings.get(f'{subject.name} {row["label"]}')


def _explained(context, subject, entry, reference):
    """
    Return the rises of the error with a smaller step, with what explains each.

    The same scene with steps that are nearly the same: where their errors overlap, the error
    scatters from step to step, and the rise is part of that.
    """
    steps = [row for row in entry['rows'] if row['family'] == 'step' and 'tip' in row]
    found = []
    for key in ERRORS:
        if entry['own'].get(key) is None:
            continue
        for coarse, fine in rises(steps, key, entry['own'][key]):
            spreads = [_nearby(context, subject, row, key, reference) for row in (coarse, fine)]
            found.append({'error': key, 'coarse': coarse['label'], 'fine': fine['label'],
                          'from': coarse[key], 'to': fine[key], 'coarse_spread': spreads[0],
                          'fine_spread': spreads[1],
                          'overlap': spreads[1][0] <= spreads[0][1]})
    return found


def _nearby(context, subject, row, key, reference):
    """Return the least and the largest error of a row and of steps close to its own."""
    count = round(SAMPLE / row['its'])
    paths = context.crew.run([
        Job(solve, (subject.name, SAMPLE / (count + more), row['keys'], subject.duration))
        for more in NEAR if count + more > 0])
    errors = [errors_of(path, reference, subject.contact)[key] for path in paths
              if not isinstance(path, Failed)]
    return min([row[key], *errors]), max([row[key], *errors])
