"""What a script has: names, errors, numbers of numpy, and answers to calls that make no sense."""
from pathlib import Path
import subprocess
import sys

import bristle_ros
import numpy as np
import pytest

SCENE = str(Path(__file__).resolve().parent / 'small_brush.yaml')


@pytest.fixture(scope='module')
def simulation():
    return bristle_ros.build(bristle_ros.load(SCENE))


def test_dir_lists_what_there_is_and_loads_nothing(root):
    code = ('import bristle_ros, sys\nprint(*dir(bristle_ros))\n'
            'bristle_ros.SceneError\nprint(*({"numba", "numpy"} & set(sys.modules)))')
    done = subprocess.run([sys.executable, '-c', code], cwd=root, text=True, capture_output=True,
                          timeout=600, check=True)
    names, heavy = done.stdout.split('\n')[:2]
    assert {'load', 'build', 'simulate', 'SceneError', 'StepFailure', 'CommandRefused',
            'CompilerRefused'} <= set(names.split())
    assert heavy == ''


def test_errors_are_those_that_are_raised(simulation):
    with pytest.raises(bristle_ros.SceneError):
        bristle_ros.load('none.yaml')
    with pytest.raises(bristle_ros.CommandRefused):
        simulation.command('cmd_stop', 1.0)
    assert issubclass(bristle_ros.StepFailure, RuntimeError)
    with pytest.raises(AttributeError):
        bristle_ros.simulat  # noqa: B018


@pytest.mark.parametrize('values', [
    8.0, 8, np.float64(8.0), np.float32(8.0), np.int64(8), np.array(8.0), np.array([8.0]), [8]],
    ids=repr)
def test_a_command_of_one_value_takes_any_number(simulation, values):
    simulation.reset()
    simulation.command('cmd_brush_speed', (8.0,))
    wanted = simulation.state.motion.copy()
    simulation.reset()
    simulation.command('cmd_brush_speed', values)
    assert np.array_equal(simulation.state.motion, wanted)
    first, second = (bristle_ros.simulate(SCENE, 0.02, commands=[(t, 'cmd_brush_speed', one)])
                     for t, one in ((0.01, (8.0,)), (np.float64(0.01), values)))
    assert np.array_equal(first['omega'], second['omega'])
    assert first['omega'][-1] != first['omega'][0]


@pytest.mark.parametrize('values', ['8', ['8'], None, [None], [[8.0]], 10**400, {'a'}], ids=repr)
def test_what_is_no_number_is_refused(simulation, values):
    with pytest.raises(bristle_ros.CommandRefused, match='cmd_brush_speed: .*must be numbers'):
        simulation.command('cmd_brush_speed', values)
    with pytest.raises(bristle_ros.SceneError, match='must be numbers'):
        bristle_ros.simulate(SCENE, 0.01, commands=[(0.0, 'cmd_brush_speed', values)])


@pytest.mark.parametrize('steps', [-1, 1.5, 2.0, np.float64(3.0), '4', None, 2**63], ids=repr)
def test_steps_that_are_no_count_are_errors(simulation, steps):
    simulation.reset()
    with pytest.raises((TypeError, ValueError)):
        simulation.advance(steps)
    assert simulation.step == 0


def test_steps_may_be_of_numpy(simulation):
    simulation.reset()
    simulation.advance(np.int32(3))
    simulation.advance(0)
    assert simulation.step == 3


def test_repr_says_scene_time_and_bristles(simulation):
    simulation.reset()
    simulation.advance(100)
    text = repr(simulation)
    assert text.startswith('<Simulation at t = 0.05 s, step 100; 2 bristles; scene: ')
    assert 'solver.elements: 3' in text
    assert 'road.penetration' not in text      # as everywhere


@pytest.mark.parametrize('commands', [
    5, [5], [(0.1, 'cmd_vel')], [('x', 'cmd_vel', (1, 0, 0))], [(1e308, 'cmd_vel', (1, 0, 0))],
    [(0.0, ['cmd_vel'], (1, 0, 0))]], ids=repr)
def test_commands_that_are_none_are_unusable_input(commands):
    with pytest.raises(bristle_ros.SceneError):
        bristle_ros.simulate(SCENE, 0.01, commands=commands)


@pytest.mark.parametrize('duration', [1e30, 10**400, -1.0, float('nan'), '1', None], ids=repr)
def test_durations_that_no_run_can_have_are_unusable_input(duration):
    with pytest.raises(bristle_ros.SceneError, match='duration'):
        bristle_ros.simulate(SCENE, duration)


def test_numbers_of_numpy_are_numbers():
    arrays = bristle_ros.simulate(SCENE, np.float32(0.5), sample=np.float64(0.25))
    assert arrays['t'] == pytest.approx([0.25, 0.5], abs=1e-12)
