"""Runs a batch of rows, one after the other, and writes their part of the table."""
from pathlib import Path
import time

from bristle_ros import __version__
from bristle_ros.log import provenance
from bristle_ros.scene import SceneError
from bristle_ros.simulation import StepFailure

from . import design, store
from .history import AUTO, plan, Run
from .measure import measure, MEASURES

SHARE = 100             # one row in so many is run at half the step as well,
LEAST = 3               # but at least so many


def run_scene(study, scene):
    """
    Simulate a scene for a study; return (row of measures, History).

    With turns: auto it goes on until the means have settled, or most_turns are over.
    """
    whole, every, settle, auto = plan(study, scene)
    run = Run(scene, every)
    until = whole
    run.go(until)
    history = run.history()
    row = measure(history, scene, settle, study.fatigue)
    while auto and row['settled'] != 'yes' and row['turns'] + AUTO <= study.most_turns:
        until += whole
        run.go(until)
        history = run.history()
        row = measure(history, scene, settle, study.fatigue)
    row['wall_time'] = run.wall_time
    return row, history


def is_halved(number, runs):
    """Whether a row is among those that are run at half the step, too."""
    every = max(1, min(SHARE, runs // LEAST))
    return number % every == every // 2


def run_batch(study, folder, first, end, values=None, run=run_scene):
    """
    Run rows `first` to `end` - 1 and write their part; return (rows, not finished, seconds).

    values : list of tuples, or None: as the design has them
    run : makes a row of measures and a History of (study, scene); tests put a formula here
    """
    began = time.perf_counter()
    target = provenance()['target']
    found, halved = [], []
    for number, row in zip(range(first, end), values or design.rows(study, first, end)):
        given = {factor.key: factor.column(value) for factor, value in zip(study.factors, row)}
        made = _row(study, row, run, folder, number)
        found.append({'run': number, **given, **made, 'version': __version__, 'target': target})
        if made['status'] == 'finished' and is_halved(number, study.runs):
            again = _row(study, row, run, None, number, halve=True)
            halved.append({**found[-1], **dict.fromkeys(MEASURES), **again})
    schema = store.schema_of(study)
    if halved:
        store.write_part(folder, store.HALVED, schema, first, end, halved)
    store.write_part(folder, store.RUNS, schema, first, end, found)
    failed = sum(row['status'] != 'finished' for row in found)
    return len(found), failed, time.perf_counter() - began


def _row(study, values, run, folder, number, *, halve=False):
    """Return the measures of one row, or why there are none."""
    try:
        scene = study.scene_of(values)
        if halve:
            scene = _half_step(scene)
        made, history = run(study, scene)
    except SceneError as error:
        return {'status': 'refused', 'message': str(error)}
    except StepFailure as error:
        return {'status': 'stopped', 'message': str(error)}
    except (MemoryError, FloatingPointError) as error:
        return {'status': 'stopped', 'message': type(error).__name__}
    if study.keep and folder:
        store.write_curves(study, folder, number, lambda name: getattr(history, name))
    return {'status': 'finished', 'message': '', **made}


def _half_step(scene):
    from dataclasses import replace
    its = 0.5 * scene.solver.integration_time_step
    return replace(scene, solver=replace(scene.solver, integration_time_step=its))


def seconds_of(study, numbers):
    """Return how long runs of these rows take, without compiling [s]: (number, s) of each."""
    found = []
    for number in numbers:
        values = design.rows(study, number, number + 1)[0]
        began = time.perf_counter()
        try:
            row = run_scene(study, study.scene_of(values))[0]
            took = row['wall_time']
        except (SceneError, StepFailure):
            took = time.perf_counter() - began
        found.append((number, took))
    return found


def is_there(folder):
    """Whether a worker sees the study's directory, as it must to write into it."""
    return (Path(folder) / store.DESCRIPTION).exists()
