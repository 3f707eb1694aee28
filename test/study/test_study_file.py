"""What a study file may say, and the one line for all it may not."""
import math

from bristle_ros.scene import SceneError
from bristle_ros.study.expression import Expression
from bristle_ros.study.study_file import restored
import pytest

NAMES = {'drive_power', 'road.penetration', 'normal_force_mean'}
NUMBERS = {'drive_power': 3.0, 'road.penetration': 0.25, 'normal_force_mean': 2.0}


@pytest.mark.parametrize(('text', 'value'), [
    ('drive_power', 3.0), ('-drive_power ** 2 + 1', -8.0), ('road.penetration * 4', 1.0),
    ('min(drive_power, 2, 5) / max(1, 2)', 1.0), ('sqrt(abs(-drive_power * 3))', 3.0),
    ('exp(log(drive_power))', 3.0)])
def test_expressions_have_their_values(text, value):
    assert Expression(text, NAMES).value(NUMBERS) == pytest.approx(value, rel=1e-15)


@pytest.mark.parametrize('text', ['1 / (drive_power - 3)', 'log(0 - drive_power)', '9.0 ** 9 ** 9',
                                  'exp(1e6)', 'sqrt(-1)', '(-8) ** 0.5'])
def test_what_has_no_value_is_nan(text):
    assert math.isnan(Expression(text, NAMES).value(NUMBERS))


@pytest.mark.parametrize(('text', 'excess'), [
    ('normal_force_mean > 1.5', -0.5), ('normal_force_mean <= 1.5', 0.5),
    ('0.25 >= road.penetration', 0.0)])
def test_constraints_say_by_how_much_they_are_broken(text, excess):
    assert Expression(text, NAMES, constraint=True).excess(NUMBERS) == excess


@pytest.mark.parametrize('text', [
    '__import__("os")', 'drive_power.real', '().__class__', 'lambda: 1', '[1][0]', '"a"', 'True',
    'drive_power if 1 else 2', 'min(1)', 'sqrt(1, 2)', 'abs(x=1)', 'open(drive_power)', '1e999',
    'drive_power > 1', 'f"{1}"', 'drive_power; 1', '', '(' * 300, '-' * 499 + '1' * 2, '1j', None])
def test_all_else_is_no_expression(text):
    with pytest.raises(SceneError) as refused:
        Expression(text, NAMES)
    assert '\n' not in str(refused.value)


@pytest.mark.parametrize('text', ['drive_power', '1 < drive_power < 2', 'drive_power == 1',
                                  'drive_power > 1 and 1 > 0', 'drive > 1'])
def test_all_else_is_no_constraint(text):
    with pytest.raises(SceneError):
        Expression(text, NAMES, constraint=True)


VARY = 'duration: 1.0\nvary: {road.penetration: [0.01, 0.02]}\n'


@pytest.mark.parametrize(('text', 'told'), [
    ('duration: 1\nvary: {road.penetraton: [0.01]}', 'did you mean road.penetration?'),
    ('duration: 1\nvary: {road.penetration: {from: 0.02, to: 0.02, count: 3}}', 'empty range'),
    ('duration: 1\nvary: {road.penetration: []}', 'no values'),
    ('duration: 1\nvary: {road.penetration: [.nan]}', 'must be a number from -10 to 10'),
    ('duration: 1\nvary: {road.penetration: {from: 0, to: .inf, count: 3}}', 'must be a number'),
    ('duration: 1\nvary: {road.penetration: {from: 0, to: 1, count: 3, scale: log}}', 'above 0'),
    ('duration: 1\nvary: {road.penetration: [0.01, 0.01]}', 'has a value twice'),
    ('duration: 1\nvary: {road.penetration: [0.01], road.penetration: [0.02]}', 'given twice'),
    ('duration: 1\nvary: {drive.profile: {from: 1, to: 2, count: 2}}', 'give a list of values'),
    ('duration: 1\nvary: {run.chunk: [0.1]}', 'has no influence'),
    ('duration: 1\nset: {road.penetration: 0.01}\nvary: {road.penetration: [0.02]}', 'as well'),
    ('duration: 1\nvary: {gravity: {from: 0, to: 9, count: 1000000}, '
     'damping.mass: {from: 0, to: 1, count: 1000000}}', 'makes 1000000000000 runs'),
    (VARY + 'constraints: ["force > 1"]', "'force' is no measure"),
    (VARY + 'minimise: ["print(1)"]', 'is not understood'),
    (VARY + 'samples: 8', 'leave it out'),
    (VARY + 'turns: 3', 'give one of duration [s] and turns'),
    (VARY + 'settle: 1.0', 'leaves nothing'),
    (VARY + 'keep: [contact]', 'must be among'),
    (VARY + 'fatigue: {exponent: 3}', 'strength_at_1e6'),
    (VARY + 'seeds: 1', 'did you mean seed?'),
    ('duration: 1\ndesign: sobol\nsamples: 100\nvary: {gravity: {from: 1, to: 2}}', '64 or 128'),
    ('duration: 1\ndesign: sobol\nsamples: 64\nvary: {gravity: {from: 1, to: 2, count: 2}}',
     'count is for a grid'),
    ('duration: 1\ndesign: optimise\nvary: {gravity: {from: 1, to: 2}}', 'one or two expressions'),
    ('vary', 'not YAML')])
def test_what_is_wrong_is_said_on_one_line(study_of, text, told):
    with pytest.raises(SceneError) as refused:
        study_of(text)
    assert told in str(refused.value)
    assert '\n' not in str(refused.value)
    assert 'study.yaml' in str(refused.value)


def test_a_study_comes_back_from_its_description(study_of):
    study = study_of("""
vary:
  drive.profile: [sine, vap]
  sweeper.velocity: [[1.0, 0.0], [1.5, 0.5]]
  brush.bristle_count: {from: 1, to: 3, count: 3}
  contact.normal_stiffness: {from: 1.0e3, to: 1e5, count: 2, scale: log}
turns: auto
fatigue: {exponent: 5, strength_at_1e6: 3.0e8}
constraints: ["drive_power < 1"]
""")
    again = restored(study.described())
    assert again.described() == study.described()
    assert (again.factors, again.scene, again.runs) == (study.factors, study.scene, 24)
