"""`simulate`: arrays of the contract, tables, logs, commands, and every way to get it wrong."""
import csv
from pathlib import Path
import subprocess
import sys

import bristle_ros
from bristle_ros.log.command_file import read_commands, step_at
from bristle_ros.realtime.driver import Event
from bristle_ros.scene.error import SceneError
from bristle_ros.simulation.simulation import Simulation, StepFailure
from bristle_ros.simulation.snapshot import ACCOUNTED, NPZ_ARRAYS
from bristle_ros.verbs import simulate as simulate_verb
import numpy as np
import pytest

ROOT = Path(__file__).resolve().parents[2]
SCENE = (ROOT / 'test/small_brush.yaml').read_text()
ITS = 5e-4
COMMANDS = '0.011,cmd_brush_speed,7\n0.013,cmd_vel,0.4,0,0\n0.016,cmd_penetration,0.004\n'
# Ten metres of foil as soft as jelly at 3000 rpm: no sub-step is short enough.
HOPELESS = {'bristle.youngs_modulus': 1e3, 'bristle.length': 10.0, 'bristle.width': 1e-6,
            'bristle.density': 1e5, 'brush.mount_radius': 1.0, 'drive.mean_speed': 320.0,
            'solver.integration_time_step': 5e-3, 'run.sample': 5e-3}


@pytest.fixture
def commands(tmp_path):
    path = tmp_path / 'commands.csv'
    path.write_text('t,topic,values\n# a comment\n\n' + COMMANDS)
    return path


def run(*arguments):
    return subprocess.run([sys.executable, '-m', 'bristle_ros', 'simulate', *map(str, arguments)],
                          cwd=ROOT, capture_output=True, text=True, timeout=600)


def same(first, second):
    """Whether two results are equal to the bit, but for how long they took."""
    return all(np.array_equal(first[name], second[name], equal_nan=True) for name in NPZ_ARRAYS)


def test_arrays_are_those_of_the_contract(scene, tmp_path):
    output = tmp_path / 'out.npz'
    done = run(scene, '--duration', 0.02, '--sample', 0.002, '--output', output)
    assert done.returncode == 0, done.stderr
    assert 'times real time' in done.stdout
    assert str(output) in done.stdout
    shapes = {'t': (10,), 'theta': (10,), 'omega': (10,), 'tip_orientation': (10, 2, 4),
              'brush_force': (10, 3), 'brush_torque': (10, 3), 'energy_kinetic': (10,),
              'energy_elastic': (10,), 'energy_dissipated': (10,), 'work_external': (10,),
              'newton_iterations': (10,), 'substeps': (10,), 'base_pose': (10, 3),
              'clamp_stress': (10, 2, 4), 'wire_gap': (10, 2), 'contact_length': (10, 2),
              'clamp_stress_min': (10, 2, 4), 'clamp_stress_max': (10, 2, 4), 'wall_time': (),
              'compile_time': ()}
    with np.load(output) as found:
        assert set(found.files) == {*NPZ_ARRAYS, 'wall_time', 'compile_time'}
        for name in found.files:
            assert found[name].shape == shapes.get(name, (10, 2, 3)), name
            assert np.all(np.isfinite(found[name])), name
        np.testing.assert_array_equal(found['t'], 4 * np.arange(1, 11) * ITS)
        np.testing.assert_allclose(found['theta'], 5.0 * found['t'], rtol=1e-12)
        assert found['newton_iterations'].dtype.kind == 'i'
        assert same(found, bristle_ros.simulate(scene, 0.02, sample=0.002))


def test_the_last_sample_is_at_the_duration(scene):
    found = bristle_ros.simulate(scene, 0.0105, sample=0.004)
    np.testing.assert_allclose(found['t'], [0.004, 0.008, 0.0105], rtol=1e-15)


def test_bits_depend_on_neither_chunk_nor_sample(scene, commands):
    first = bristle_ros.simulate(scene, 0.04, sample=0.002, commands=commands)
    finer = bristle_ros.simulate(scene, 0.04, sample=0.0005, commands=commands,
                                 overrides={'run.chunk': 0.0035})
    assert np.ptp(first['omega']) > 0.1, 'the commands did something'
    for name, extreme in (('clamp_stress_min', np.min), ('clamp_stress_max', np.max)):
        of_four = extreme(finer.pop(name).reshape(-1, 4, 2, 4), axis=1)
        # a sample's own value is worked out once more, to round-off
        np.testing.assert_allclose(first.pop(name), of_four, rtol=1e-12, err_msg=name)
    for name in set(NPZ_ARRAYS) & set(first):
        np.testing.assert_array_equal(first[name], finer[name][3::4], err_msg=name)


def test_scene_objects_and_command_lists(scene, commands):
    loaded = bristle_ros.load(scene)
    listed = [(0.011, 'cmd_brush_speed', (7.0,)), (0.013, 'cmd_vel', (0.4, 0, 0)),
              (0.016, 'cmd_penetration', [0.004])]
    assert same(bristle_ros.simulate(loaded, 0.03, commands=listed),
                bristle_ros.simulate(scene, 0.03, commands=commands))
    assert same(bristle_ros.simulate(loaded, 0.01, overrides={'gravity': 0.0}),
                bristle_ros.simulate(scene, 0.01, overrides={'gravity': '0'}))


def test_a_reset_starts_the_scene_again(scene):
    found = bristle_ros.simulate(scene, 0.02, commands=[(0.01, 'reset', ())])
    np.testing.assert_array_equal(found['tip_position'][10:], found['tip_position'][:10])
    np.testing.assert_allclose(found['t'], np.arange(1, 21) * 1e-3, rtol=1e-15)


def test_table(scene, tmp_path):
    output = tmp_path / 'out.csv'
    found = bristle_ros.simulate(scene, 0.01, output=output)
    with open(output, newline='') as file:
        rows = list(csv.reader(file))
    assert rows[0][:5] == ['t', 'theta', 'omega', 'tip_position_0_x', 'tip_position_0_y']
    column = rows[0].index('tip_orientation_1_w')
    values = [float(row[column]) for row in rows[1:]]
    assert values == found['tip_orientation'][:, 1, 3].tolist(), 'a table keeps every bit'
    assert {len(row) for row in rows} == {len(rows[0])}


def test_a_log_gives_its_commands_again(scene, commands, tmp_path):
    log = tmp_path / 'out.mcap'
    done = run(scene, '--duration', 0.03, '--commands', commands, '--output', log)
    assert done.returncode == 0, done.stderr
    assert read_commands(log, ITS)
    assert (
        [event for _, event in read_commands(log, ITS)]
        == [event for _, event in read_commands(commands, ITS)])
    halved = [event.step for _, event in read_commands(log, ITS / 2)]
    assert halved == [2 * event.step for _, event in read_commands(log, ITS)]
    assert same(bristle_ros.simulate(scene, 0.03, commands=log),
                bristle_ros.simulate(scene, 0.03, commands=commands))
    again = run(scene, '--duration', 0.03, '--output', log)
    assert again.returncode == 2
    assert 'exists already' in again.stderr


def test_times_become_the_first_step_at_or_after_them():
    assert [step_at(t, 1e-4) for t in (0.0, 1e-4, 0.3, 0.30001, 1e5)] == [0, 1, 3000, 3001, 10**9]


def test_a_command_file_with_what_spreadsheets_add(tmp_path):
    path = tmp_path / 'c.csv'
    path.write_bytes(b'\xef\xbb\xbft,topic,values\r\n'
                     b' 0.1, cmd_vel ,1,2,3\r\n0.2,reset,,,\r\n,,,\r\n')
    assert [event for _, event in read_commands(path, 1e-3)] == [
        Event(100, 'command', 'cmd_vel', (1.0, 2.0, 3.0)), Event(200, 'reset')]


@pytest.mark.parametrize(('line', 'said'), [
    ('x,cmd_vel,1,2,3', 't = "x"'),
    ('-1,cmd_vel,1,2,3', 't = -1.0'),
    ('nan,reset', 't = .nan'),
    ('inf,reset', 't = .inf'),
    ('1', "'1'"),
    ('1,cmd_val,1', 'topic = "cmd_val"'),
    ('1,cmd_vel,1,2', 'cmd_vel with 2 values: takes 3 (vx, vy, yaw rate)'),
    ('1,cmd_vel,1,2,3,4', 'cmd_vel with 4 values'),
    ('1,cmd_penetration,deep', 'm = "deep"'),
    ('1,reset,5', 'reset with 1 values: takes none'),
    ('1,cmd_vel,"1;2",0,0', 'vx = "1;2"')])
def test_bad_command_lines_name_file_and_line(tmp_path, line, said):
    path = tmp_path / 'c.csv'
    path.write_text(f't,topic,values\n{line}\n')
    with pytest.raises(SceneError) as caught:
        read_commands(path, 1e-3)
    assert said in str(caught.value)
    assert str(caught.value).startswith(f'{path}:2: ')
    assert '\n' not in str(caught.value)


@pytest.mark.parametrize(('arguments', 'said'), [
    (['SCENE'], '--duration'),
    (['SCENE', '--duration', 'long'], 'long'),
    (['SCENE', '--duration', '0'], 'duration = 0.0'),
    (['SCENE', '--duration', 'inf'], 'duration = .inf'),
    (['SCENE', '--duration', '0.0101'], 'the nearest is 0.01'),
    (['SCENE', '--duration', '0.01', '--sample', '0.0003'], 'run.sample = 0.0003'),
    (['SCENE', '--duration', '0.01', '-p', 'gravity'], "'gravity' is not an override"),
    (['SCENE', '--duration', '0.01', '-p', 'gravitation:=1'], 'did you mean gravity?'),
    (['SCENE', '--duration', '0.01', '--arrays', 't'], '--arrays'),
    (['SCENE', '--duration', '0.01', '--arrays', 'torque', '--output', 'x.npz'],
     '--arrays = "torque"'),
    (['SCENE', '--duration', '0.01', '--output', 'x.txt'], '.npz, .csv, .mcap'),
    (['SCENE', '--duration', '0.01', '--output', '/no/such/x.npz'], '"/no/such/x.npz"'),
    (['SCENE', '--duration', '0.01', '--output', '/proc/x.csv'], '"/proc/x.csv"'),
    (['SCENE', '--duration', '0.01', '--commands', 'no.csv'], '--commands = "no.csv"'),
    (['SCENE', '--duration', '0.01', '--commands', 'no.txt'], '.csv, an .mcap'),
    (['SCENE', '--duration', '0.01', '--commands', 'BAD'], 'BAD:1: cmd_brush_speed'),
    (['no.yaml', '--duration', '0.01'], 'no.yaml')])
def test_unusable_input_is_one_line(scene, tmp_path, arguments, said):
    bad = tmp_path / 'bad.csv'
    bad.write_text('0,cmd_brush_speed,1e9\n')
    places = {'SCENE': str(scene), 'BAD': str(bad)}
    done = run(*[places.get(argument, argument) for argument in arguments])
    assert done.returncode == 2, done.stderr
    assert said.replace('BAD', str(bad)) in done.stderr
    assert len(done.stderr.strip().splitlines()) == 1, done.stderr


def test_chosen_arrays_alone_are_kept_with_the_same_bits(scene, tmp_path):
    chosen = bristle_ros.simulate(scene, 0.01, arrays=('clamp_stress', 'brush_torque'),
                                  output=tmp_path / 'out.csv')
    assert set(chosen) == {'t', 'clamp_stress', 'brush_torque', 'wall_time', 'compile_time'}
    whole = bristle_ros.simulate(scene, 0.01)
    for name in ('clamp_stress', 'brush_torque'):
        np.testing.assert_array_equal(chosen[name], whole[name])
    header = (tmp_path / 'out.csv').read_text().splitlines()[0].split(',')
    assert header == ['t', *(f'clamp_stress_{i}_{corner}' for i in range(2)
                             for corner in range(4)), *(f'brush_torque_{axis}' for axis in 'xyz')]


def test_what_is_not_chosen_is_not_run(scene):
    run = simulate_verb._Run(scene, 0.01, None, None, None, ('t', 'clamp_stress'))
    assert run.simulation._stepper._features[2] is None
    run.go([])
    assert np.isnan(run.simulation.snapshot().clamp_stress_max).all()


def test_what_came_before_a_failure_is_kept(scene, tmp_path):
    output = tmp_path / 'out.npz'
    overrides = [word for key, value in HOPELESS.items() for word in ('-p', f'{key}:={value}')]
    done = run(scene, '--duration', 1.0, '--output', output, *overrides)
    assert done.returncode == 3, done.stderr
    assert len(done.stderr.strip().splitlines()) == 1
    assert 'step' in done.stderr
    with np.load(output) as found:
        assert 1 <= len(found['t']) < 200
        assert np.all(np.isfinite(found['tip_position']))
    with pytest.raises(StepFailure):
        bristle_ros.simulate(scene, 1.0, overrides=HOPELESS)


def test_the_package_imports_no_compiler(scene):
    code = ('import sys, bristle_ros; from bristle_ros.verbs import simulate; bristle_ros.load; '
            'print([name for name in ("numba", "rclpy", "rich", "mcap") if name in sys.modules])')
    done = subprocess.run([sys.executable, '-c', code], cwd=ROOT, capture_output=True, text=True)
    assert done.stdout.strip() == '[]', done.stdout + done.stderr


def test_energy_accounts_change_no_bits(scene):
    """The node keeps none, `simulate` does: both must step the very same machine code."""
    loaded = bristle_ros.load(scene)
    kept, without = Simulation(loaded, energies=True), Simulation(loaded)
    for simulation in (kept, without):
        simulation.advance(60)
    first, second = kept.snapshot(), without.snapshot()
    for name in set(NPZ_ARRAYS) - set(ACCOUNTED):
        np.testing.assert_array_equal(getattr(first, name), getattr(second, name), err_msg=name)


def test_the_force_of_the_air_is_kept_where_there_is_air(scene):
    still = {'air.density': 1.2, 'contact.enabled': False, 'damping.stiffness': 0.0}
    arrays = bristle_ros.simulate(scene, 0.01, overrides=still)
    assert arrays['air_force'].shape == (10, 2, 3)
    assert arrays['air_force'].any()
    assert 'air_force' not in bristle_ros.simulate(scene, 0.01)
    only = bristle_ros.simulate(scene, 0.01, overrides=still, arrays=['air_force'])
    assert set(only) == {'t', 'air_force', 'wall_time', 'compile_time'}
    with pytest.raises(SceneError, match='^--arrays = "air_force": needs air.density above 0'):
        bristle_ros.simulate(scene, 0.01, arrays=['air_force'])
