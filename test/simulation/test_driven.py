"""Drives that feel their load: the hub's balance, its order, its energy, and the same bits."""
from dataclasses import replace
from math import pi

from bristle_ros.log.writer import Log
from bristle_ros.physics.motion import ATTEMPTS, drive_torque, Hub, TURNING
from bristle_ros.realtime.driver import Driver, Event
from bristle_ros.scene.error import SceneError
from bristle_ros.scene.scene import from_parameters
from bristle_ros.simulation.commands import check_command, CommandRefused
from bristle_ros.simulation.mount_path import MountPath
from bristle_ros.simulation.simulation import Simulation
from bristle_ros.verbs.verify import verify
import numpy as np
import pytest

STALL, RATED, LOSS = 5.0, 20.0, 0.02
# 20 wires of 1e-3 kg m^2 in all, and a hub that weighs a twentieth of them; no road
FREE = {
    'contact.enabled': False, 'damping.stiffness': 1e-3, 'brush.wires_per_bristle': 20,
    'drive.mode': 'motor', 'drive.inertia': 5e-5, 'drive.stall_torque': STALL,
    'drive.rated_speed': RATED, 'drive.alternating_speed': 4.0, 'drive.mean_speed': 10.0,
    'solver.elements': 4, 'solver.tolerance': 1e-9, 'run.sample': 0.005}
# with the tip's contact alone, for a kernel that compiles soon
SWEEP = {
    'contact.points': 'tip', 'contact.normal_stiffness': 1e4, 'damping.stiffness': 1e-3,
    'damping.mass': 2.0, 'brush.bristle_count': 3, 'brush.wires_per_bristle': 20,
    'road.penetration': 0.02, 'road.attack_angle': 0.1, 'drive.mode': 'motor',
    'drive.inertia': 2e-3, 'drive.stall_torque': 20.0, 'drive.rated_speed': RATED,
    'drive.loss': LOSS, 'drive.profile': 'constant', 'drive.mean_speed': 12.0,
    'solver.elements': 4, 'solver.integration_time_step': 5e-4, 'sweeper.velocity': [0.5, 0.0],
    'run.chunk': 0.0035, 'run.sample': 0.001}


def scene(base, **changes):
    return from_parameters({**base, **{key.replace('__', '.'): value
                                       for key, value in changes.items()}}, 'test')


def test_torque_of_the_drive():
    law = getattr(drive_torque, 'py_func', drive_torque)
    motor = Hub(1.0, LOSS, STALL, RATED, 0.0)
    assert law(motor, 12.0, 0.0, 8.0) == pytest.approx((4.0 / RATED * STALL - LOSS * 8.0,
                                                        -STALL / RATED - LOSS))
    assert law(motor, 50.0, 0.0, -3.0) == pytest.approx((STALL + LOSS * 3.0, -LOSS))
    assert law(motor, -50.0, 0.0, 3.0) == pytest.approx((-STALL - LOSS * 3.0, -LOSS))
    assert law(motor._replace(rated=0.0), 12.0, 0.7, 2.0) == pytest.approx(
        (0.7 - LOSS * 2.0, -LOSS))


def free_run(its, duration=0.2, **changes):
    simulation = Simulation(scene(FREE, solver__integration_time_step=its, **changes),
                            energies=True)
    every, found = round(0.005 / its), []
    for _ in range(round(duration / 0.005)):
        simulation.advance(every)
        found.append(simulation.snapshot())
    return found


def test_second_order_in_its():
    """Hub and wires, the hub far lighter: angle, speed, work and torque against short steps."""
    def curves(its):
        return np.array([(sample.theta, sample.omega, sample.drive_work, sample.brush_torque[2])
                         for sample in free_run(its)])
    exact, steps = curves(1e-5), 1e-3 / 2.0 ** np.arange(3)
    errors = np.array([abs(curves(its) - exact).max(axis=0) for its in steps])
    orders = [np.polyfit(np.log(steps), np.log(error), 1)[0] for error in errors.T]
    assert orders == pytest.approx([2.0] * 4, abs=0.15)
    assert (errors[-1] < [1e-5, 2e-4, 1e-5, 1e-4]).all()


def test_energy_is_in_balance():
    """Of the hub: what drive and wires do to it. Of the wires: as with any other motion."""
    its = 2.5e-4
    simulation = Simulation(scene(FREE, solver__integration_time_step=its), energies=True)
    first = simulation.snapshot()
    samples = [first]
    for _ in range(800):
        simulation.advance(1)
        samples.append(simulation.snapshot())
    speed = np.array([sample.omega for sample in samples])
    taken = its * np.trapezoid(speed * [sample.brush_torque[2] for sample in samples])
    given = its * np.trapezoid(speed * [sample.drive_torque for sample in samples])
    last = samples[-1]
    assert last.drive_work == pytest.approx(given, rel=1e-9)
    stored = 0.5 * FREE['drive.inertia'] * (speed[-1] ** 2 - speed[0] ** 2)
    assert given + taken == pytest.approx(stored, abs=5e-5 * abs(taken))
    moved = last.energy_kinetic + last.energy_elastic
    assert moved + last.energy_dissipated - last.work_external == pytest.approx(
        0.0, abs=5e-5 * last.work_external)


def test_steady_speed_in_the_air():
    """stall (omega_0 - omega) / rated = loss omega: the wires ask for no torque in the end."""
    last = free_run(5e-4, 0.8, drive__loss=LOSS, drive__alternating_speed=0.0,
                    damping__mass=30.0)[-1]
    assert last.omega == pytest.approx(10.0 / (1.0 + LOSS * RATED / STALL), rel=1e-4)
    assert last.drive_torque == pytest.approx(0.0, abs=1e-5)


def test_commanded_torque():
    """Free, after the start: the angular momentum of all grows by the torque's impulse."""
    simulation = Simulation(scene(
        FREE, drive__mode='torque', drive__alternating_speed=0.0, drive__mean_speed=-2.0,
        solver__integration_time_step=2.5e-4, damping__mass=30.0, drive__loss=5e-3), energies=True)
    assert simulation.snapshot().omega == -2.0
    simulation.advance(400)
    simulation.command('cmd_drive_torque', (0.01,))
    simulation.advance(12000)
    assert simulation.snapshot().omega == pytest.approx(2.0, rel=1e-3)      # 0.01 = loss omega


@pytest.fixture(scope='module')
def swept():
    """Return samples of all steps of a sweep, after it has settled."""
    simulation = Simulation(scene(SWEEP), threads=1)
    simulation.advance(600)
    samples, attempts = [], []
    for _ in range(2400):
        simulation.advance(1)
        samples.append(simulation.snapshot())
        attempts.append(simulation.state.motion[TURNING + ATTEMPTS])
    return samples, np.array(attempts)


def test_mean_speed_on_the_road(swept):
    """The closed balance of means: stall (omega_0 - omega) / rated - loss omega + road's = 0."""
    samples, _ = swept
    road = np.mean([sample.contact_torque_mount[2] for sample in samples])
    wires = np.mean([sample.brush_torque[2] for sample in samples])
    speed = np.mean([sample.omega for sample in samples])
    gain = SWEEP['drive.stall_torque'] / RATED
    stored = SWEEP['drive.inertia'] * (samples[-1].omega - samples[0].omega) / 1.2
    assert speed == pytest.approx((12.0 * gain + wires - stored) / (gain + LOSS), rel=1e-5)
    assert speed == pytest.approx((12.0 * gain + road) / (gain + LOSS), rel=1e-3)
    assert road < -0.05     # it is a load


def test_the_balance_holds_at_each_step(swept):
    """What is reported: J omega' = T + tau, up to what is carried from step to step."""
    samples, attempts = swept
    torque = np.array([sample.drive_torque + sample.brush_torque[2] for sample in samples[1:]])
    speed = np.array([sample.omega for sample in samples])
    left = SWEEP['drive.inertia'] * (speed[1:] - speed[0]) - 5e-4 * np.cumsum(torque)
    assert abs(left).max() < 5e-4 * np.ptp(torque)
    assert abs(left[-1]) < 1e-2 * abs(left).max() + 1e-5
    assert attempts.mean() < 2.5
    assert attempts.max() < 8.0


def test_bits_do_not_depend_on_threads_or_calls():
    one, three = Simulation(scene(SWEEP), threads=1), Simulation(scene(SWEEP), threads=3)
    three._stepper.threads = 3
    one.advance(300)
    for steps in (1, 129, 64, 106):
        three.advance(steps)
    for ours, theirs in zip(one.state, three.state):
        np.testing.assert_array_equal(ours, theirs)
    before = [array.copy() for array in one.state]
    one.reset()
    one.advance(300)
    for ours, theirs in zip(one.state, before):
        np.testing.assert_array_equal(ours, theirs)


def test_rows_turn_one_hub():
    """Two rows of two are the row of four: only sums differ."""
    base = {key: value for key, value in SWEEP.items() if key != 'brush.bristle_count'}
    one = Simulation(scene(base, brush__bristle_count=4))
    two = Simulation(scene(base, brush__row_counts=[2, 2], brush__row_offsets=[0.0, pi / 2]))
    for simulation in (one, two):
        simulation.advance(100)
    assert one.snapshot().theta == pytest.approx(two.snapshot().theta, rel=1e-9)
    assert one.snapshot().omega == pytest.approx(two.snapshot().omega, rel=1e-6)


def test_after_a_failure_all_are_at_the_step_start():
    simulation = Simulation(scene(SWEEP), threads=1)
    simulation.advance(100)
    before = [array.copy() for array in simulation.state]
    stepper = simulation._stepper
    taken = stepper._take
    stepper._take = lambda scratch: [*taken(scratch), (0, 2, 1)]
    assert stepper.advance(5) == (2, 1)
    assert simulation.step == 100
    stepper._take = taken
    for name, ours, theirs in zip(simulation.state._fields, simulation.state, before):
        if name not in ('nodes', 'mids', 'chain', 'tip', 'counts'):
            np.testing.assert_array_equal(ours, theirs)
    simulation.advance(5)       # and can go on


def test_a_log_of_it_is_verified(tmp_path):
    made = scene(SWEEP)
    driver = Driver(Simulation(made), sample=2, paced=False)
    driver.schedule([Event(50, 'command', 'cmd_brush_speed', (14.0,)), Event(120, 'reset'),
                     Event(150, 'command', 'cmd_vel', (0.2, 0.0, 0.5))])
    driver.mount = MountPath(made)
    with Log(tmp_path / 'run', made) as log:
        while driver.total_step < 250:
            log.write(driver.run_chunk())
    verdict = verify(tmp_path / 'run')
    assert (verdict.difference, verdict.applied) == ('', 3)


@pytest.mark.parametrize(('changes', 'words'), [
    ({'drive.inertia': 0.0}, 'drive.inertia = 0.0: drive.mode: motor needs it above 0'),
    ({'drive.rated_speed': 0.0}, 'drive.rated_speed = 0.0: drive.mode: motor needs'),
    ({'drive.stall_torque': 0.0}, 'drive.stall_torque = 0.0: drive.mode: motor needs'),
    ({'solver.load_case': 'displacement'}, 'drive.mode = "motor": prescribes the angle'),
    ({'solver.time_step': 1e-3}, 'solver.time_step = 0.001: the angle at a load step'),
    ({'drive.mode': 'torque', 'drive.profile': 'vap'}, 'drive.profile = "vap": a torque'),
])
def test_scenes_that_are_refused(changes, words):
    with pytest.raises(SceneError) as error:
        from_parameters({**FREE, **changes}, 'test')
    assert words in str(error.value)


def test_commands_that_are_refused():
    motor, torque = scene(FREE), scene(FREE, drive__mode='torque', drive__alternating_speed=0.0)
    for made, topic, value, words in (
            (motor, 'cmd_drive_torque', 1.0, 'needs drive.mode: torque, this is motor'),
            (torque, 'cmd_brush_speed', 1.0, 'there is cmd_drive_torque'),
            (torque, 'cmd_drive_torque', 5.1, 'beyond drive.stall_torque = 5 N m'),
            (torque, 'cmd_drive_torque', float('nan'), 'not finite')):
        with pytest.raises(CommandRefused, match=words):
            check_command(made, topic, (value,))
    any_torque = replace(torque, drive=replace(torque.drive, stall_torque=0.0))
    assert check_command(any_torque, 'cmd_drive_torque', (-99.0,)) == (-99.0,)
