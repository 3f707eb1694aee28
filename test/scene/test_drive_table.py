"""Tables of brush speeds: the cubics are scipy's, what cannot be is refused on one line."""
import math

from bristle_ros import simulate
from bristle_ros.log.head import head_of
from bristle_ros.log.recording import scene_of
from bristle_ros.physics.motion.drive import table_at
from bristle_ros.scene.error import SceneError
from bristle_ros.scene.scene import from_parameters, load, to_parameters, to_yaml
from bristle_ros.scene.sections import Drive
from bristle_ros.scene.drive_table import speed_table, start_speed
import numpy as np
import pytest
from scipy.interpolate import PchipInterpolator

TABLE = {'drive.profile': 'table'}
RAMP = 'data:0.0,2.0;0.01,5.0;0.03,4.0;0.05,4.0'


def drawn(rng, count):
    t = np.cumsum(rng.uniform(1e-3, 1.0, count)) - rng.uniform(0.0, count / 3)
    speed = np.round(rng.uniform(-20.0, 20.0, count) * rng.integers(0, 2, count), 1)
    return t, speed


def scipys(t, speed):
    """Return speed, acceleration and angle since t = 0 as functions of time, held at the ends."""
    curve = PchipInterpolator(t, speed)
    whole = curve.antiderivative()

    def angle_from_first(at):
        inside = np.clip(at, t[0], t[-1])
        return (whole(inside) + speed[0] * np.minimum(at - t[0], 0.0)
                + speed[-1] * np.maximum(at - t[-1], 0.0))
    return (lambda at: curve(np.clip(at, t[0], t[-1])),
            lambda at: np.where((at < t[0]) | (at > t[-1] + 1e-9), 0.0,
                                curve.derivative()(np.clip(at, t[0], t[-1]))),
            lambda at: angle_from_first(at) - angle_from_first(np.float64(0.0)))


@pytest.mark.parametrize('count', [2, 3, 4, 40])
def test_table_is_scipys_pchip_and_its_integral(count):
    for seed in range(10):
        t, speed = drawn(np.random.default_rng(100 * count + seed), count)
        text = 'data:' + ';'.join(f'{a!r},{b!r}' for a, b in zip(t.tolist(), speed.tolist()))
        table = speed_table(Drive(profile='table', file=text))
        wanted = scipys(t, speed)
        times = np.concatenate((t, np.linspace(t[0] - 1.0, t[-1] + 1.0, 300), [0.0]))
        found = np.array([table_at(at, table) for at in times])
        for column, function in zip((1, 2, 0), wanted):
            exact = function(times)
            np.testing.assert_allclose(found[:, column], exact, rtol=1e-10,
                                       atol=1e-10 * max(1.0, abs(exact).max()))
        assert found[-1, 0] == pytest.approx(0.0, abs=1e-14)
        assert start_speed(Drive(profile='table', file=text)) == pytest.approx(
            float(wanted[0](0.0)), abs=1e-12)


def test_step_to_the_end_of_a_table_feels_its_acceleration():
    table = speed_table(Drive(profile='table', file='data:0,0;0.3,6'))
    assert table_at(3000 * 1e-4, table)[2] == pytest.approx(20.0)     # 0.30000000000000004
    assert table_at(3001 * 1e-4, table)[1:] == (6.0, 0.0)


@pytest.mark.parametrize(('content', 'words'), [
    ('t,speed\n0,1\n1,2\n1,3\n', 'line 4: t = 1 does not go on from 1: t must increase'),
    ('0,1\n1,2\n0.5,3\n', 'line 3: t = 0.5 does not go on'),
    ('0,1\n1,nan\n', 'line 2: 1,nan: must be finite, within 1e6 s'),
    ('0,1\n', 'holds 1 point: a table needs at least two'),
    ('', '0 points'),
    ('0,1\n1,2,3\n', 'line 2: must be two numbers t,speed'),
    ('0,1\n1,321\n', 'beyond drive.max_speed = 320'),
    ('\xff', 'not a CSV file'),
])
def test_tables_that_cannot_be_used_are_refused(tmp_path, content, words):
    file = tmp_path / 'speeds.csv'
    file.write_bytes(content.encode('latin-1'))
    with pytest.raises(SceneError) as refusal:
        from_parameters(TABLE | {'drive.file': str(file)}, 'here')
    assert refusal.value.key == 'drive.file'
    assert words in str(refusal.value)
    assert '\n' not in str(refusal.value)


@pytest.mark.parametrize(('given', 'key'), [
    ({'drive.mean_speed': 10.472}, 'drive.mean_speed'),     # also the usual one
    ({'drive.mean_speed': 3.0}, 'drive.mean_speed'),
    ({'drive.alternating_speed': 0.5}, 'drive.alternating_speed'),
    ({'drive.file': ''}, 'drive.file'),
    ({'drive.file': '/nowhere.csv'}, 'drive.file'),
])
def test_speeds_beside_a_table_are_refused(given, key):
    with pytest.raises(SceneError) as refusal:
        from_parameters(TABLE | {'drive.file': RAMP} | given, 'here')
    assert refusal.value.key == key


def test_table_comes_back_from_parameters_and_file(tmp_path, monkeypatch):
    (tmp_path / 'speeds.csv').write_text('0,1\n1,2\n')
    path = tmp_path / 'scene.yaml'
    path.write_text('/**:\n  ros__parameters:\n    drive: {profile: table, file: speeds.csv}\n')
    monkeypatch.chdir('/')
    scene = load(path)
    assert scene.drive.file == str(tmp_path / 'speeds.csv')
    assert from_parameters(to_parameters(scene), 'here') == scene
    path.write_text(to_yaml(scene))
    assert load(path) == scene
    yaml = head_of(scene, 0, str).yaml
    (tmp_path / 'speeds.csv').unlink()
    assert np.array_equal(speed_table(scene_of(yaml, 'log').drive),
                          speed_table(Drive(profile='table', file='data:0,1;1,2')))


def test_commanded_speed_comes_on_top_of_the_table():
    """theta and omega of a run, with a command that ramps from 0 to 3 rad/s at 100 rad/s^2."""
    overrides = {  # a road far below: kernels that the campaign's test needs as well
        'gutter.enabled': True, 'road.penetration': -0.1, 'road.approach_time': 0.0,
        'damping.stiffness': 1e-6, 'solver.elements': 2, 'drive.max_acceleration': 100.0}
    scene = from_parameters(TABLE | {'drive.file': RAMP} | overrides, 'here')
    arrays = simulate(scene, 0.08, sample=0.001, commands=[(0.02, 'cmd_brush_speed', [3.0])],
                      arrays=['theta', 'omega', 'energy_kinetic'])
    t, speed = np.array([[0.0, 2.0], [0.01, 5.0], [0.03, 4.0], [0.05, 4.0]]).T
    wanted = scipys(t, speed)
    late = np.clip(arrays['t'] - 0.02, 0.0, None)
    np.testing.assert_allclose(arrays['omega'], wanted[0](arrays['t'])
                               + np.minimum(100.0 * late, 3.0), rtol=1e-12)
    ramp = np.where(late < 0.03, 50.0 * late ** 2, 0.045 + 3.0 * (late - 0.03))
    np.testing.assert_allclose(arrays['theta'], wanted[2](arrays['t']) + ramp, rtol=1e-12)
    assert math.isclose(arrays['omega'][-1], 7.0)
