"""The verb `fit`: finds parameters of a scene from measured rows."""
import json
from pathlib import Path
import sys

from bristle_ros.command_line import Parser, WholeFile
from bristle_ros.scene import keys, load, read_scalar, SceneError
import numpy as np

from .factor import Factor, read_factor
from .figures import page_of
from .measure import MEASURES
from .study_file import MOST_TURNS, Study
from .table_file import read_table

TASKS = 8               # for each worker, of the runs of a round
SHARE = 0.03            # deviation of a measure without one, of its mean magnitude
_KEYS = {key.name: key for key in keys()}


def _parse(arguments):
    parser = Parser('fit', 'Finds parameters of a scene by least squares from measured rows: a '
                    'CSV with columns that are keys of the scene (what was set), measures (what '
                    'was measured) and, if known, MEASURE_sd (its standard deviation). The model '
                    'is run for sets of parameters, and polynomials through them are searched.')
    parser.add_argument('scene', metavar='SCENE.yaml')
    parser.add_argument('measured', metavar='MEASURED.csv')
    parser.add_argument('--vary', metavar='KEY=LOW:HIGH[:log]', action='append', required=True,
                        help='a key to find, and its range; may be given often')
    parser.add_argument('--measure', metavar='NAME,...', required=True,
                        help='measures to compare')
    parser.add_argument('--turns', type=float, default=3.0, help='of each run; default 3')
    parser.add_argument('--settle', type=float, default=1.0,
                        help='turns left out at the start; default 1')
    parser.add_argument('--sample', type=float, default=0.0, metavar='S',
                        help='between samples [s]; default: 0.5 ms, or a step')
    parser.add_argument('--workers', type=int, metavar='N', help='processes; default: the cores')
    parser.add_argument('--output', default='fit', metavar='DIR',
                        help='where fit.json and index.html go; default: fit')
    return parser.parse_args(arguments)


def main(arguments):
    """Run the verb `fit`; return its exit code: 1 where the data cannot tell a parameter."""
    options = _parse(arguments)
    factors = [_factor(rule) for rule in options.vary]
    measures, given = _columns(options, factors)
    study = study_of(load(options.scene), [*given['keys'], *factors], options.turns,
                     options.settle, options.sample)
    folder = Path(options.output).expanduser()
    folder.mkdir(parents=True, exist_ok=True)
    rows = list(zip(*given['set'])) if given['set'] else [()] * len(given['values'][0])
    from .cluster import ClusterLost, open_cluster
    from .fitting import fit
    from .main import cores
    try:
        with open_cluster(None, options.workers or cores()) as client:
            found = fit(factors, residuals(simulated(study, rows, measures, client), given),
                        tell=_tell_round)
    except ClusterLost as error:
        print(f'fit: {error}', file=sys.stderr)
        return 3
    if found is None:
        raise SceneError('most scenes in these ranges cannot be run: give others', key='--vary',
                         value=' '.join(options.vary))
    _tell(found, factors, measures, given, folder)
    return 1 if found.doubts else 0


def study_of(scene, factors, turns, settle, sample=0.0):
    """Return a Study of runs of a scene with values of these factors."""
    if not 0.0 <= sample < 1.0:
        raise SceneError('must be a time from 0 to 1 s', key='--sample', value=sample)
    if not 0.0 <= settle < turns <= MOST_TURNS:
        raise SceneError(f'leaves nothing of {turns:g} turns', key='--settle', value=settle)
    return Study(source='', scene=scene, factors=tuple(factors), design='grid', samples=1, seed=1,
                 duration=None, turns=turns, most_turns=turns, settle=settle, sample=sample,
                 objectives=(), maximise=False, constraints=(), keep=(), fatigue=None)


def _factor(rule):
    name, _, bounds = rule.partition('=')
    ends = bounds.split(':')
    if name not in _KEYS or len(ends) not in (2, 3) or ends[2:] not in ([], ['log']):
        raise SceneError('must be KEY=LOW:HIGH or KEY=LOW:HIGH:log, with a key of a scene',
                         key='--vary', value=rule)
    given = {'from': read_scalar(ends[0]), 'to': read_scalar(ends[1])}
    return read_factor(_KEYS[name], given | ({'scale': 'log'} if ends[2:] else {}), 'fit',
                       '--vary')


def _columns(options, factors):
    """Return (measures, what was set and measured) of the table; raise SceneError."""
    table = read_table(options.measured)
    measures = options.measure.split(',')
    found = {'keys': [], 'set': [], 'values': [], 'deviations': []}
    for name, column in table.items():
        if name in _KEYS:
            if name in [factor.key for factor in factors]:
                raise SceneError('is both measured and to be found', key=name,
                                 source=options.measured)
            for value in column:
                _KEYS[name].check(float(value))
            found['keys'].append(Factor(name, None))
            found['set'].append(column)
        elif name.removesuffix('_sd') not in MEASURES:
            raise SceneError('is no key of a scene, no measure and no MEASURE_sd', key=name,
                             source=options.measured)
    for name in measures:
        if name not in table or name not in MEASURES:
            raise SceneError('has no such measure', key=name, source=options.measured)
        sd = table.get(f'{name}_sd', np.full(len(table[name]),
                                             SHARE * float(np.abs(table[name]).mean())))
        if not (sd > 0.0).all():
            raise SceneError('must be above 0', key=f'{name}_sd', source=options.measured)
        found['values'].append(table[name])
        found['deviations'].append(sd)
    if len(found['values'][0]) * len(measures) <= len(factors):
        raise SceneError(f'has too few numbers to find {len(factors)} parameters',
                         source=options.measured)
    return measures, found


def simulated(study, rows, measures, client):
    """
    Return the function of places (k tuples) that gives measures (k, rows, measures) of all rows.

    rows : what was set of each, tuples that come before a place among the study's values
    """
    from .cluster import in_flight
    tasks = TASKS * sum(client.nthreads().values())

    def submit(part):
        return client.submit(measures_of, *part, study, tuple(measures), pure=False)

    def of(places):
        jobs = [(*row, *place) for place in places for row in rows]
        size = -(-len(jobs) // tasks)
        values = np.empty((len(jobs), len(measures)))
        for first, part in in_flight(client, ((at, jobs[at:at + size]) for at in range(
                0, len(jobs), size)), submit, lambda: False):
            values[first:first + len(part)] = part
        return values.reshape(len(places), len(rows), len(measures))
    return of


def residuals(of, given):
    """Return the function that `fitting.fit` takes, of what `simulated` gives and the table."""
    measured, deviations = np.array(given['values']).T, np.array(given['deviations']).T
    return lambda places: ((of(places) - measured) / deviations).reshape(len(places), -1)


def measures_of(first, rows, study, names):
    """Return `first`, and measures of each of these rows; NaN where one cannot be run."""
    from bristle_ros.simulation import StepFailure

    from .batch import run_scene
    found = []
    for values in rows:
        try:
            row = run_scene(study, study.scene_of(values))[0]
        except (SceneError, StepFailure, MemoryError, FloatingPointError):
            row = dict.fromkeys(names, float('nan'))
        found.append([row[name] for name in names])
    return first, found


def _tell_round(number, sets, place):
    print(f'fit: round {number}: {sets} parameter sets, residuals are {place.scale:.3g} of the '
          f'deviations, the widest interval is {min(2.0 * place.width.max(), 1.0):.0%} of its '
          'range', file=sys.stderr, flush=True)


def _tell(found, factors, measures, given, folder):
    lines = [f'{factor.key} = {value:.4g}, 95 % from {low:.4g} to {high:.4g}'
             for factor, value, low, high in zip(factors, found.value, found.low, found.high)]
    lines.append(f'residuals are {found.scale:.3g} of the deviations, in which the emulator has '
                 f'{found.error.mean():.3g}; {found.sets} parameter sets were run')
    lines += found.doubts or ['the data tell all of them apart']
    print('\n'.join(lines))
    kept = {'parameters': {factor.key: {'value': v, 'low': low, 'high': high} for
                           factor, v, low, high in zip(factors, found.value.tolist(),
                                                       found.low.tolist(), found.high.tolist())},
            'correlation': found.correlation.tolist(), 'residuals': found.residuals.tolist(),
            'emulator_error': found.error.tolist(), 'measures': measures, 'scale': found.scale,
            'sets': found.sets, 'doubts': found.doubts}
    with WholeFile(folder / 'fit.json', text=True, overwrite=True) as file:
        json.dump(kept, file, indent=1)
    with WholeFile(folder / 'index.html', text=True, overwrite=True) as file:
        file.write(_page(found, factors, measures, given, lines))
    sys.stdout.flush()
    print(f'written: {folder / "index.html"}')


def _page(found, factors, measures, given, lines):
    from plotly import graph_objects as go
    residuals = go.Figure(layout={
        'title': 'residuals, in deviations; bars: error of the emulator',
        'xaxis': {'title': 'measured, of the largest'}})
    for name, values, one, error in zip(measures, given['values'],
                                        found.residuals.reshape(-1, len(measures)).T,
                                        found.error.reshape(-1, len(measures)).T):
        residuals.add_scatter(x=values / np.abs(values).max(), y=one, mode='markers', name=name,
                              error_y={'array': error}, showlegend=True)
    names = [factor.key for factor in factors]
    correlation = go.Figure(go.Heatmap(
        z=found.correlation, x=names, y=names, zmin=-1, zmax=1, colorscale='RdBu',
        texttemplate='%{z:.2f}'), {'title': 'correlation', 'yaxis': {'autorange': 'reversed',
                                                                     'automargin': True}})
    return page_of('fit', lines, [residuals, correlation])


__all__ = ['main', 'residuals', 'simulated', 'study_of']
