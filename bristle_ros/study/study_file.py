"""
Reads and checks study files: what is varied, how, for how long, and what is wanted of it.

A Study that exists has keys, ranges, counts and expressions that can be used; each of its rows is
made a Scene when its turn comes, and that may still refuse it.
"""
from dataclasses import dataclass
import difflib
import json
import math
from pathlib import Path

from bristle_ros.scene import from_parameters, keys, load, Scene, SceneError, to_parameters

from .expression import Expression
from .factor import Factor, read_factor
from .measure import MEASURES
from .plain_yaml import read_mapping

DESIGNS = ('grid', 'latin_hypercube', 'sobol', 'saltelli', 'optimise')
MOST_RUNS = 10_000_000
MOST_TURNS = 10_000
GENERATION = 32         # rows asked for at once by an optimisation, and told at once
CURVES = ('theta', 'omega', 'tip_position', 'tip_position_road', 'contact_force',
          'contact_impulse', 'mount_force', 'mount_moment', 'brush_force', 'brush_torque')
_KEYS = {key.name: key for key in keys()}
_GIVEN = ('scene', 'set', 'vary', 'design', 'samples', 'seed', 'duration', 'turns', 'most_turns',
          'settle', 'sample', 'minimise', 'maximise', 'constraints', 'keep', 'fatigue')
_PLAIN = ('design', 'samples', 'seed', 'duration', 'turns', 'most_turns', 'settle', 'sample',
          'maximise')
SAMPLE = 5e-4           # [s] between samples, or a step: what tells impacts apart


@dataclass(frozen=True, kw_only=True)
class Study:
    """
    A study, checked.

    duration [s] or turns of each run, one of them; turns may be 'auto', up to most_turns
    settle : [s], or turns where `turns` is given;  sample [s], 0: SAMPLE or the next step
    objectives : Expressions, wanted small, or large where `maximise`
    fatigue : (exponent, amplitude [Pa] at 1e6 cycles) or None
    """

    source: str
    scene: Scene
    factors: tuple[Factor, ...]
    design: str
    samples: int
    seed: int
    duration: float | None
    turns: object
    most_turns: float
    settle: float
    sample: float
    objectives: tuple[Expression, ...]
    maximise: bool
    constraints: tuple[Expression, ...]
    keep: tuple[str, ...]
    fatigue: tuple[float, float] | None

    @property
    def runs(self):
        """How many rows the design has."""
        if self.design == 'grid':
            return math.prod(factor.size for factor in self.factors)
        return self.samples * (2 * len(self.factors) + 2 if self.design == 'saltelli' else 1)

    def scene_of(self, values):
        """Return the Scene with these values of the varied keys; raise SceneError."""
        parameters = to_parameters(self.scene)
        parameters.update((factor.key, value) for factor, value in zip(self.factors, values))
        return from_parameters(parameters, '')

    def described(self):
        """Return all that rows depend on, as JSON has it: what --resume compares."""
        found = {f'scene.{key}': value for key, value in to_parameters(self.scene).items()
                 if not key.startswith(('run.', 'log.'))}
        found['vary'] = [list(factor) for factor in self.factors]
        found.update((name, getattr(self, name)) for name in _PLAIN)
        for name in ('objectives', 'constraints'):
            found[name] = [each.text for each in getattr(self, name)]
        found['keep'] = list(self.keep)
        found['fatigue'] = list(self.fatigue) if self.fatigue else None
        return json.loads(json.dumps(found))


def restored(found):
    """Make a Study again of what `described` returned; raise SceneError."""
    scene = from_parameters({key.partition('.')[2]: value for key, value in found.items()
                             if key.startswith('scene.')}, 'study.json')
    factors = tuple(
        Factor(key, values and tuple(map(_KEYS[key].check, values)), *more)
        for key, values, *more in found['vary'])
    names = expression_names()
    return Study(
        source='', scene=scene, factors=factors, keep=tuple(found['keep']),
        objectives=tuple(Expression(text, names) for text in found['objectives']),
        constraints=tuple(Expression(text, names, constraint=True)
                          for text in found['constraints']),
        fatigue=found['fatigue'] and tuple(found['fatigue']),
        **{name: found[name] for name in _PLAIN})


def expression_names():
    """Return what expressions may name: measures, and keys that are numbers."""
    return {*MEASURES, *(name for name, key in _KEYS.items() if key.kind in ('float', 'int'))}


def read_study(path):
    """Read and check a study file; raise SceneError."""
    source = str(path)
    given = read_mapping(path)
    for name in given:
        if name not in _GIVEN:
            near = difflib.get_close_matches(name, _GIVEN, 1)
            raise SceneError(f'unknown key, did you mean {near[0]}?' if near else
                             f'unknown key: a study has {", ".join(_GIVEN)}', key=name,
                             source=source)
    scene = _scene(given, source)
    design = _choice(given, 'design', DESIGNS, 'grid', source)
    factors = _factors(given, design, source)
    if design == 'grid' and 'samples' in given:
        raise SceneError('a grid has as many rows as its values make: leave it out',
                         key='samples', value=given['samples'], source=source)
    names = expression_names()
    objectives, maximise = _objectives(given, design, names, source)
    study = Study(
        source=source, scene=scene, factors=factors, design=design, objectives=objectives,
        maximise=maximise, keep=_keep(given, scene, factors, source),
        samples=_whole(given, 'samples', 256, 1, MOST_RUNS, source),
        seed=_whole(given, 'seed', 1, 0, 2**32 - 1, source),
        sample=_number(given, 'sample', 0.0, 0.0, 1.0, source),
        constraints=tuple(Expression(text, names, constraint=True, source=source,
                                     key='constraints')
                          for text in _list(given, 'constraints', source)),
        fatigue=_fatigue(given, source), **_lengths(given, source))
    if study.runs > MOST_RUNS:
        raise SceneError(f'makes {study.runs} runs: at most {MOST_RUNS}', key='vary',
                         source=source)
    if design in ('sobol', 'saltelli') and study.samples & (study.samples - 1):
        below = 1 << (study.samples.bit_length() - 1)
        raise SceneError(f'a Sobol sequence is balanced at powers of 2 only: {below} or '
                         f'{2 * below}', key='samples', value=study.samples, source=source)
    return study


def _scene(given, source):
    if not isinstance(given.get('scene'), str):
        raise SceneError('must be the path of a scene file', key='scene',
                         value=given.get('scene'), source=source)
    changes = given.get('set', {})
    if not isinstance(changes, dict):
        raise SceneError('must be keys of a scene with values', key='set', source=source)
    return load(Path(source).parent / given['scene'], changes)


def _factors(given, design, source):
    vary = given.get('vary')
    if not isinstance(vary, dict) or not vary:
        raise SceneError('must be keys of a scene, each with the values it takes', key='vary',
                         source=source)
    found = []
    for name, values in vary.items():
        if name not in _KEYS:
            near = difflib.get_close_matches(name, _KEYS, 1)
            raise SceneError('unknown key' + (f', did you mean {near[0]}?' if near else
                                              ': `scene --keys` lists them all'),
                             key=f'vary.{name}', source=source)
        if name.startswith(('log.', 'run.')):
            raise SceneError('has no influence on a run offline', key=f'vary.{name}',
                             source=source)
        if name in given.get('set', {}):
            raise SceneError('is given in set as well: keep one of them', key=f'vary.{name}',
                             source=source)
        found.append(read_factor(_KEYS[name], values, design, source))
    return tuple(found)


def _objectives(given, design, names, source):
    if 'minimise' in given and 'maximise' in given:
        raise SceneError('contradicts minimise: give one, with a minus where needed',
                         key='maximise', source=source)
    key = 'maximise' if 'maximise' in given else 'minimise'
    texts = _list(given, key, source)
    if len(texts) > 2 or (design == 'optimise' and not texts):
        raise SceneError('must be one or two expressions', key=key, value=texts, source=source)
    return (tuple(Expression(text, names, source=source, key=key) for text in texts),
            key == 'maximise')


def _keep(given, scene, factors, source):
    names = _list(given, 'keep', source)
    for name in names:
        if name not in CURVES:
            raise SceneError(f'must be among {", ".join(CURVES)}', key='keep', value=name,
                             source=source)
    shapes = {'brush.bristle_count', 'brush.row_counts', 'solver.integration_time_step'}
    varied = shapes & {factor.key for factor in factors}
    if names and ('turns' in given or varied):
        raise SceneError('curves of all runs must have one length: give duration, and do not vary '
                         + ' or '.join(sorted(shapes)), key='keep', value=names, source=source)
    return tuple(names)


def _lengths(given, source):
    if ('duration' in given) == ('turns' in given):
        raise SceneError('give one of duration [s] and turns', key='duration', source=source)
    auto = given.get('turns') == 'auto'
    if 'most_turns' in given and not auto:
        raise SceneError('is for turns: auto', key='most_turns', source=source)
    found = {'duration': None, 'turns': None, 'settle': _number(
        given, 'settle', 0.0, 0.0, 1e6, source),
        'most_turns': _number(given, 'most_turns', 60.0, 5.0, MOST_TURNS, source)}
    if 'duration' in given:
        found['duration'] = _number(given, 'duration', 0.0, 1e-6, 1e6, source)
    else:
        found['turns'] = 'auto' if auto else _number(given, 'turns', 0.0, 1e-3, MOST_TURNS, source)
    whole = found['most_turns'] if auto else found['turns'] or found['duration']
    if found['settle'] >= whole:
        raise SceneError(f'leaves nothing of a run of {whole:g}', key='settle',
                         value=found['settle'], source=source)
    return found


def _fatigue(given, source):
    if 'fatigue' not in given:
        return None
    section = given['fatigue']
    if not isinstance(section, dict) or set(section) != {'exponent', 'strength_at_1e6'}:
        raise SceneError('must be {exponent: m, strength_at_1e6: Pa}', key='fatigue',
                         source=source)
    return (_number(section, 'exponent', 0.0, 1.0, 100.0, source),
            _number(section, 'strength_at_1e6', 0.0, 1.0, 1e12, source))


def _list(given, key, source):
    found = given.get(key, [])
    if not isinstance(found, list) or not all(isinstance(item, str) for item in found):
        raise SceneError('must be a list of texts', key=key, value=str(found), source=source)
    if len(set(found)) < len(found):
        raise SceneError('has an entry twice', key=key, value=found, source=source)
    return found


def _choice(given, key, choices, default, source):
    value = given.get(key, default)
    if value not in choices:
        raise SceneError(f'must be one of {", ".join(choices)}', key=key, value=value,
                         source=source)
    return value


def _number(given, key, default, low, high, source):
    value = given.get(key, default)
    if isinstance(value, bool) or not isinstance(value, (int, float)) or not (
            low <= value <= high):
        raise SceneError(f'must be a number from {low:g} to {high:g}', key=key, value=value,
                         source=source)
    return float(value)


def _whole(given, key, default, low, high, source):
    value = _number(given, key, default, low, high, source)
    if value != int(value):
        raise SceneError('must be a whole number', key=key, value=value, source=source)
    return int(value)
