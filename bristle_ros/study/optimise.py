"""
Optimises by generations: rows asked for at once, and told at once, in their order.

So a seed gives one result, whatever finishes first; what a study has kept of earlier generations
is told again, and the next is asked for as it would have been.
"""
import math

import optuna

from . import store
from .measure import MEASURES
from .study_file import GENERATION


def generations(study, folder):
    """
    Yield (first row, list of tuples of values) of each generation; its rows are told afterwards.

    What was run before is among them: the caller runs what is missing.
    """
    search = _search(study)
    for first in range(0, study.samples, GENERATION):
        size = min(GENERATION, study.samples - first)
        trials = [search.ask() for _ in range(size)]
        yield first, [tuple(_suggest(trial, factor) for factor in study.factors)
                      for trial in trials]
        rows = store.rows_between(folder, first, first + size)
        if len(rows) < size:
            return      # interrupted
        for trial, row in zip(trials, rows):
            _tell(study, search, trial, row)


def _search(study):
    optuna.logging.set_verbosity(optuna.logging.ERROR)
    if len(study.objectives) == 1:
        sampler = optuna.samplers.TPESampler(
            seed=study.seed, n_startup_trials=min(GENERATION, study.samples),
            multivariate=True, constant_liar=True)
    else:
        sampler = optuna.samplers.NSGAIISampler(
            seed=study.seed, population_size=GENERATION)
    direction = 'maximize' if study.maximise else 'minimize'
    return optuna.create_study(sampler=sampler, directions=[direction] * len(study.objectives))


def _suggest(trial, factor):
    if factor.values is not None:
        places = list(range(len(factor.values)))
        return factor.values[trial.suggest_categorical(factor.key, places)]
    if factor.whole:
        return trial.suggest_int(factor.key, int(factor.low), int(factor.high), log=factor.log)
    return trial.suggest_float(factor.key, factor.low, factor.high, log=factor.log)


def numbers_of(study, row):
    """Return what expressions see of a row: measures, varied keys, and the scene's other keys."""
    from bristle_ros.scene import to_parameters
    numbers = dict(to_parameters(study.scene))
    numbers.update({factor.key: row[factor.key] for factor in study.factors})
    numbers.update({name: row[name] for name in MEASURES})
    return numbers


def _tell(study, search, trial, row):
    numbers = numbers_of(study, row)
    values = [each.value(numbers) for each in study.objectives]
    for each in study.constraints:
        excess = each.excess(numbers)
        # a constraint that has no value is not met
        trial.set_constraint(each.text, math.inf if math.isnan(excess) else excess)
    if row['status'] != 'finished' or not all(map(math.isfinite, values)):
        search.tell(trial, state=optuna.trial.TrialState.FAIL)
    else:
        search.tell(trial, values)


def best(study, rows):
    """
    Return the best rows, as dicts: with one objective the best, with two the front between them.

    rows : list of dicts, of the study's table. Those that break a constraint do not count.
    """
    judged = []
    for row in rows:
        if row['status'] != 'finished':
            continue
        numbers = numbers_of(study, row)
        values = [each.value(numbers) for each in study.objectives]
        met = all(each.excess(numbers) <= 0.0 for each in study.constraints)
        if met and all(map(math.isfinite, values)):
            judged.append(([-v for v in values] if study.maximise else values, row))
    if len(study.objectives) == 1:
        return [row for _, row in sorted(judged, key=lambda each: each[0][0])[:10]]
    front = []
    for values, row in sorted(judged, key=lambda each: each[0]):
        if not front or values[1] < front[-1][0][1]:
            front.append((values, row))
    return [row for _, row in front]
