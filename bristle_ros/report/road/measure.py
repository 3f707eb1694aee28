"""
Error against run time on the scenes of the road, and what each refinement does by itself.

The errors that cost is compared at are those against one converged run, finer in both mesh and
step. Beside them the steps alone are refined, all with the mesh of the usual setting, and the
meshes alone, all with one fine step: each against its own finest.
"""
from bristle_ros.report.peers import comparison
from bristle_ros.report.precision.subjects import OTHER
from bristle_ros.report.runs import prepare_run, run, tip_error, whole_impulse_error
from bristle_ros.report.timing import Timed
from bristle_ros.report.workers import Failed, Job

from . import assumption
from .subjects import (CONVERGED, FINE_MESH, FINE_STEP, MESHES, road_scene, SECOND, STEPS,
                       SUBJECTS, TOLERANCES, USUAL)

COARSE = STEPS[:4]      # with finer ones it is the mesh that errs, at any price

QUICK_PACE = 5.0        # times longer steps of converged runs in the quick form
IN_QUICK = ('lying', 'kerb', 'rough')
BESIDE_PEERS = ('lying', 'kerb')


def solve(name, its, keys, duration):
    """Return the Path of a scene; in a worker."""
    return run(road_scene(name, its, **keys), duration)


def prepare(name, its, keys, duration):
    """Return what runs a scene and tells its wall time; in a worker."""
    return prepare_run(road_scene(name, its, **keys), duration)


def settings(quick):
    """Return (family, label, ITS [s], solver keys) of the runs that are timed."""
    found = [(f'{elements} elements', f'{elements} elements, {its * 1e6:g} us', its,
              {'elements': elements})
             for elements in (MESHES[1:3] if quick else MESHES)
             for its in (STEPS[1:-1] if quick else STEPS if elements == USUAL[0] else COARSE)]
    return found + [('adaptive', f'adaptive, tolerance {tolerance:g}', STEPS[0],
                     {'step': 'adaptive', 'error_tolerance': tolerance, 'elements': USUAL[0]})
                    for tolerance in TOLERANCES]


def errors_of(path, reference):
    """Return the errors of a path [%], by name."""
    return {'tip': 100 * tip_error(path, reference),
            'impulse': 100 * whole_impulse_error(path, reference)}


def _runs(quick):
    """Return {what: (ITS [s], solver keys)} of the runs that others are compared with."""
    pace = QUICK_PACE if quick else 1.0
    return {
        'converged': (pace * CONVERGED[1], {'elements': CONVERGED[0]}),
        'second': (pace * SECOND[1], {'elements': SECOND[0], **OTHER}),
        'fine step': (pace * CONVERGED[1], {'elements': USUAL[0]}),
        **{elements: (2.5 * FINE_STEP if quick else FINE_STEP, {'elements': elements})
           for elements in (*MESHES, CONVERGED[0], FINE_MESH)}}


def measure(context, subjects=None):
    """Return the part's data: its scenes, what the assumption costs, and other programs."""
    subjects = subjects or [subject for subject in SUBJECTS
                            if not context.quick or subject.name in IN_QUICK]
    found = [_subject(context, number, subject, len(subjects))
             for number, subject in enumerate(subjects)]
    peers = None if context.quick else comparison.measure(context, BESIDE_PEERS)
    return {'subjects': found, 'assumption': assumption.measure(context), 'peers': peers}


def _subject(context, number, subject, count):
    wanted, others = settings(context.quick), _runs(context.quick)
    jobs = [Job(solve, (subject.name, its, keys, subject.duration))
            for its, keys in others.values()]
    jobs += [Job(solve, (subject.name, its, keys, subject.duration), label)
             for _, label, its, keys in wanted]
    paths = context.crew.run(jobs, show=lambda value, job, done, total: context.progress.count(
        number + 0.5 * done / total, count, f'{subject.name} {job.label}'))
    of = dict(zip(others, paths))
    entry = {'name': subject.name, 'what': subject.what, 'duration': subject.duration,
             'limits': {'tip': subject.tip, 'impulse': subject.impulse}, 'rows': [], 'own': {},
             'steps': [], 'meshes': [], 'failed': '', 'fine_step': others[FINE_MESH][0]}
    if isinstance(of['converged'], Failed):
        return {**entry, 'failed': of['converged'].reason}
    if not isinstance(of['second'], Failed):
        entry['own'] = errors_of(of['second'], of['converged'])
    for (family, label, its, keys), path in zip(wanted, paths[len(others):]):
        row = {'family': family, 'label': label, 'its': its, 'note': ''}
        if isinstance(path, Failed):
            entry['rows'].append({**row, 'note': path.reason})
            continue
        entry['rows'].append({**row, **errors_of(path, of['converged']), 'steps': path.steps,
                              'newton_per_step': path.newton / path.steps})
        if keys == {'elements': USUAL[0]} and not isinstance(of['fine step'], Failed):
            entry['steps'].append({'value': 1e6 * its, **errors_of(path, of['fine step'])})
    finest = of[FINE_MESH]
    entry['meshes'] = [{'value': elements, **errors_of(of[elements], finest)}
                       for elements in (*MESHES, CONVERGED[0])
                       if not isinstance(finest, Failed) and not isinstance(of[elements], Failed)]
    _time(context, subject, entry['rows'], wanted)
    return entry


def _time(context, subject, rows, wanted):
    timings = context.timer.group([
        Timed(f'{subject.name} {row["label"]}', prepare,
              (subject.name, row['its'], keys, subject.duration), per=subject.duration)
        for row, (_, _, _, keys) in zip(rows, wanted) if 'tip' in row])
    for row in rows:
        row['timing'] = timings.get(f'{subject.name} {row["label"]}')
