"""What each feature costs, measured: time per step, start-up, memory and bytes."""
import time

from bristle_ros.report.timing import ALL_CORES, Timed
from bristle_ros.report.workers import Failed, Job, Worker

from . import probes, step_profile
from .features import FEATURES, STEP

# Features that change what is imported or compiled: for these start-up and memory are measured.
STARTED = ('contact', 'stiffness damping', 'several bristles (8), per bristle', 'log at 1 kHz',
           'energy accounts')


def _around(feature):
    """Return what is around the scene with a feature and without it."""
    if feature.around == 'log both':
        return 'log', 'log'
    if feature.around in ('log', 'commands'):
        return feature.around, 'driver'
    return feature.around, ''


def measure(context):
    """Return the part's data."""
    duration = 0.15 if context.quick else 0.3
    timed = []
    for feature in FEATURES:
        for place, (keys, around) in enumerate(zip((feature.present, feature.absent),
                                                   _around(feature))):
            timed.append(Timed(f'{feature.name}/{place}', probes.prepare,
                               (dict(keys), around, duration), per=duration / STEP))
    timings = context.timer.group(timed)
    context.progress.count(1, 4, 'messages')
    sizes = context.crew.run([Job(probes.message_bytes), *(
        Job(probes.log_bytes, (keys, 0.2)) for keys in ({}, {'log.tf': False}))])
    names = [] if isinstance(sizes[0], Failed) else list(sizes[0])
    messages = context.timer.group([Timed(name, probes.prepare_message, (name,))
                                    for name in names])
    context.progress.count(2, 4, 'start-up')
    started = _start_ups(context)
    context.progress.count(3, 4, 'profile')
    kernels = context.crew.run([
        Job(step_profile.profile, (name, duration, 3 if context.quick else 7))
        for name in step_profile.SCENES])
    return {
        'features': [{'name': feature.name, 'bristles': feature.bristles,
                      'present': timings.get(f'{feature.name}/0'),
                      'absent': timings.get(f'{feature.name}/1')} for feature in FEATURES],
        'messages': [{'topic': name, 'bytes': sizes[0][name], 'timing': messages.get(name)}
                     for name in names],
        'log_bytes': [None if isinstance(size, Failed) else size for size in sizes[1:]],
        'started': started, 'broom': _broom(context),
        'profile': [row for rows in kernels if not isinstance(rows, Failed) for row in rows]}


def _broom(context):
    """Return the timings of the whole broom on one core and on all."""
    duration = 0.02 if context.quick else 0.1
    found = context.timer.group([
        Timed('one core', probes.prepare_broom, (1, duration), per=duration),
        Timed('all cores', probes.prepare_broom, (None, duration), ALL_CORES, duration)])
    return {'duration': duration, **found}


def _start_ups(context):
    """Return {feature: [[seconds], [MB]] with it, the same without}; each in a new process."""
    repeats = 2 if context.quick else 5
    wanted = [feature for feature in FEATURES if feature.name in STARTED]
    cases = {'': ({}, '')}      # what all others are compared with, measured once
    for feature in wanted:
        if feature.present or feature.around:
            cases[feature.name] = (dict(feature.present), feature.around)
        else:
            cases[feature.name] = (dict(feature.absent), '')
    found = {name: [[], []] for name in cases}
    for round_ in range(repeats):
        for number, (name, arguments) in enumerate(cases.items()):
            context.progress(f'start-up, round {round_ + 1} of {repeats}, {number + 1} of '
                             f'{len(cases)}')
            began = time.perf_counter()
            worker = Worker()
            memory = worker.call(probes.start_up, *arguments)
            took = time.perf_counter() - began
            worker.end()
            if not isinstance(memory, Failed):
                found[name][0].append(took)
                found[name][1].append(memory)
    adds = {feature.name: bool(feature.present or feature.around) for feature in wanted}
    return {name: {'present': found[name if adds[name] else ''],
                   'absent': found['' if adds[name] else name]} for name in adds}
