"""A mount that is carried: its way, frame forces against an inertial frame, what is refused."""
from math import cos, pi, sin

import bristle_ros
from bristle_ros.log.writer import Log
from bristle_ros.physics.motion import CARRY, CLAMP, FRAME, GRAVITY, HEIGHT, ROTATION, SEGMENT
from bristle_ros.physics.step import advance
from bristle_ros.realtime.driver import Driver, Event
from bristle_ros.scene.error import SceneError
from bristle_ros.scene.scene import from_parameters
from bristle_ros.simulation.carried import (_look, check_way, MountState, quaternion_of,
                                            rotation_vector, state_at, target_of, way_to)
from bristle_ros.simulation.commands import check_command, CommandRefused
from bristle_ros.simulation.mount_path import MountPath
from bristle_ros.simulation.simulation import Simulation, StepFailure
from bristle_ros.verbs.verify import verify
import numpy as np
from physics.mechanics import product
import pytest

CHUNK, ITS = 0.005, 1e-4
# a metre in the air; features are those of SWEEP, so that all tests here share its kernels
FREE = {'contact.points': 'tip', 'contact.normal_stiffness': 1e4, 'road.penetration': -1.0,
        'road.approach_time': 0.0, 'brush.bristle_count': 2, 'drive.profile': 'constant',
        'drive.mean_speed': 0.0, 'solver.elements': 4, 'mount.enabled': True,
        'damping.mass': 0.0, 'damping.stiffness': 1e-7, 'run.chunk': CHUNK,
        'solver.integration_time_step': ITS, 'run.sample': 0.001}
SWEEP = {'contact.points': 'tip', 'contact.normal_stiffness': 1e4, 'road.penetration': 0.02,
         'brush.bristle_count': 2, 'damping.stiffness': 1e-3, 'sweeper.velocity': [0.6, -0.2],
         'road.attack_angle': 0.15, 'road.tilt_azimuth': 0.4, 'drive.profile': 'constant',
         'solver.elements': 4, 'mount.enabled': True, 'run.chunk': CHUNK,
         'solver.integration_time_step': 5e-4, 'run.sample': 0.001}


def scene(base, **changes):
    return from_parameters({**base, **{key.replace('__', '.'): value
                                       for key, value in changes.items()}}, 'test')


def skew(vector):
    x, y, z = vector
    return np.array(((0.0, -z, y), (z, 0.0, -x), (-y, x, 0.0)))


def turn(vector):
    angle = np.linalg.norm(vector)
    cross = skew(vector)
    a = sin(angle) / angle if angle else 1.0
    b = (1.0 - cos(angle)) / angle ** 2 if angle else 0.5
    return np.eye(3) + a * cross + b * cross @ cross


# Heave, surge, sway, and pitch, roll and yaw at once, from rest; analytic in t.
def place(t):
    return np.array((0.02 * (1.0 - np.cos(31.0 * t)), -0.03 * (1.0 - np.cos(23.0 * t)),
                     0.3 + 0.015 * (1.0 - np.cos(47.0 * t))))


def rotation(t):
    return (turn((0.0, 0.0, 0.3 * (1.0 - np.cos(19.0 * t))))
            @ turn((0.0, 0.15 * (1.0 - np.cos(29.0 * t)), 0.0))
            @ turn((0.12 * (1.0 - np.cos(37.0 * t)), 0.0, 0.0)))


def odometry(t, h=1e-6):
    """Return the values of a cmd_mount on that way."""
    now, change = rotation(t), (rotation(t + h) - rotation(t - h)) / (2.0 * h)
    spin = now.T @ change
    velocity = now.T @ (place(t + h) - place(t - h)) / (2.0 * h)
    return (*place(t), *quaternion_of(now), *velocity, spin[2, 1], spin[0, 2], spin[1, 0])


def carry(simulation, duration, offset=(0.0, 0.0, 0.0), look=None):
    """Carry a simulation along the way, chunk by chunk; `look` sees each of its steps."""
    steps = round(CHUNK / simulation.its)
    for chunk in range(round(duration / CHUNK)):
        values = odometry((chunk + 1) * CHUNK)
        simulation.command('cmd_mount', (*(np.array(values[:3]) + offset), *values[3:]))
        if look is None:
            simulation.advance(steps)
            continue
        for _ in range(steps):
            simulation.advance(1)
            look(simulation)


def above(simulation):
    """Return what lets the way begin where the mount of a simulation is."""
    return simulation.mount_state().position - place(0.0)


@pytest.mark.parametrize('angle', [0.0, 1e-9, 1e-3, 0.2, 0.23, 1.5, 3.1])
def test_a_way_joins_its_ends(angle):
    """Place, velocity, rotation and rate at both ends; rates and accelerations by differences."""
    rng = np.random.default_rng(3)
    axis = rng.normal(size=3)
    begin = turn(rng.normal(size=3))
    end = begin @ turn(angle * axis / np.linalg.norm(axis))
    start = MountState(rng.normal(size=3), rng.normal(size=3), begin, rng.normal(size=3))
    target = MountState(rng.normal(size=3), rng.normal(size=3), end, rng.normal(size=3))
    motion = way_to(0.3, start, target, 0.5)
    for t, wanted in ((0.3, start), (0.8, target)):
        found = _look(t, motion)
        np.testing.assert_allclose(found[:3], wanted.position, atol=1e-13)
        np.testing.assert_allclose(found[3:6], wanted.velocity, atol=1e-13)
        np.testing.assert_allclose(found[9:18], wanted.rotation.ravel(), atol=1e-13)
        np.testing.assert_allclose(found[18:21], wanted.rate, atol=1e-12)
    h = 1e-5
    for t in (0.41, 0.66, 0.93):     # the last beyond its end
        now, after, before = _look(t, motion), _look(t + h, motion), _look(t - h, motion)
        change = (after - before) / (2.0 * h)
        spin = now[9:18].reshape(3, 3).T @ change[9:18].reshape(3, 3)
        np.testing.assert_allclose(spin, skew(now[18:21]), atol=1e-7)
        np.testing.assert_allclose(change[18:21], now[21:24], atol=1e-7)
        np.testing.assert_allclose(change[:3], now[3:6], atol=1e-7)
        np.testing.assert_allclose(change[3:6], now[6:9], atol=1e-7)


def test_rotations_and_quaternions():
    for vector in ((0.0, 0.0, 0.0), (pi - 1e-4, 0.0, 0.0), (0.0, 2.0, 2.0), (-1.0, 0.3, 0.2)):
        matrix = turn(np.array(vector))
        values = (0.0, 0.0, 0.0, *quaternion_of(matrix), *[0.0] * 6)
        np.testing.assert_allclose(target_of(values).rotation, matrix, atol=1e-14)
        np.testing.assert_allclose(rotation_vector(matrix), vector, atol=1e-11)


@pytest.fixture(scope='module')
def carried():
    """Return tips in the road's axes after each step, and the simulation, over 60 ms."""
    simulation, tips = Simulation(scene(FREE)), []
    offset = above(simulation)
    first = simulation.mount_state().position

    def look(simulation):
        state, tip = simulation.mount_state(), simulation.snapshot().tip_position_mount[0]
        tips.append(state.position - first + state.rotation @ tip)

    carry(simulation, 0.06, offset, look)
    return np.array(tips), simulation


def test_wires_feel_what_they_feel_in_an_inertial_frame(carried):
    """The same way as a motion of the clamp, no frame forces anywhere: 0.1 % at 0.1 ms."""
    tips, _ = carried
    simulation = Simulation(scene(FREE))
    model, state, scratch = simulation.model, simulation.state, simulation._scratch
    motion = state.motion.copy()
    reference = Simulation(scene(FREE))     # its way alone is asked for
    offset, queue, found = above(reference), np.zeros(1, np.int64), []
    first = reference.mount_state().position
    frame = np.zeros(FRAME)
    frame[ROTATION:ROTATION + 9] = np.eye(3).ravel()
    frame[GRAVITY:GRAVITY + 3], frame[HEIGHT] = (0.0, 0.0, -9.81), 1.0
    law, viscosity, _ = simulation._stepper._features
    for step in range(len(tips)):
        if step % 50 == 0:
            values = odometry((step // 50 + 1) * CHUNK)
            reference.state.step[0] = step
            reference._carry((*(np.array(values[:3]) + offset), *values[3:]), step * ITS)
        for i, t in enumerate((step * ITS, (step + 0.5) * ITS, (step + 1) * ITS)):
            at = state_at(t, reference.state.motion)
            frame[CLAMP:CLAMP + 3] = at.position - first + at.rotation @ model.clamp[:3]
            x, y, z, w = quaternion_of(at.rotation)
            frame[CLAMP + 3:CLAMP + 7] = product(np.array((w, x, y, z)), model.clamp[3:])
            scratch.table[i] = frame
        queue[0] = 0
        assert advance(model, law, viscosity, None, state, scratch, queue, 1, False) == 0
        state.step[0] += 1
        found.append(simulation.centreline_own()[0, -1].copy())
    np.testing.assert_array_equal(motion, state.motion)
    found = np.array(found)
    clamp = found - tips
    bent = np.linalg.norm(tips - tips[0], axis=1).max()
    worst = np.linalg.norm(clamp, axis=1).max()
    assert worst < 1e-3 * bent


def test_a_rigid_wire_is_a_rigid_body():
    """Force of a stiff wire on the board: mass times (g - acceleration of its centre)."""
    simulation = Simulation(scene(FREE, bristle__youngs_modulus=1e14, bristle__length=0.05,
                                  solver__spectral_radius=0.0))
    offset, b = above(simulation), simulation.scene.bristle
    mass, phi = b.density * b.breadth * b.width * b.length, simulation.scene.brush.mount_angle
    middle = (simulation.model.clamp[:3]
              + 0.5 * b.length * np.array((sin(phi), 0.0, -cos(phi))))
    worst, largest = 0.0, 0.0

    def look(simulation):
        nonlocal worst, largest
        now = simulation.step * simulation.its
        at = _look(now, simulation.state.motion[CARRY:CARRY + SEGMENT])
        turned, rate, rise = at[9:18].reshape(3, 3), skew(at[18:21]), skew(at[21:24])
        acceleration = at[6:9] + turned @ (rise + rate @ rate) @ middle
        expected = turned.T @ (mass * (np.array((0.0, 0.0, -9.81)) - acceleration))
        force = simulation.snapshot().mount_force[0]
        if now > 0.004:     # the wire has taken up its weight, and stopped ringing from that
            worst = max(worst, np.linalg.norm(force - expected))
        largest = max(largest, np.linalg.norm(expected))

    carry(simulation, 0.03, offset, look)
    assert largest > 1.2 * 9.81 * mass
    assert worst < 1e-3 * largest


def test_the_mean_wrench_is_the_mean_of_the_wrench():
    simulation = Simulation(scene(FREE))
    forces = []

    def look(simulation):
        sample = simulation.snapshot()
        forces.append([*sample.brush_force, *sample.brush_torque])

    carry(simulation, 0.01, above(simulation), look)
    np.testing.assert_allclose(simulation.wrench_impulse() / 0.01, np.mean(forces, axis=0),
                               rtol=1e-9, atol=1e-12)


def uniform(simulation, way):
    """Return the cmd_mount that keeps a simulation's mount on a uniform way for `way` [s]."""
    state = simulation.mount_state()
    return (*(state.position + way * state.velocity), *quaternion_of(state.rotation),
            *(state.rotation.T @ state.velocity), 0.0, 0.0, 0.0)


def test_a_file_of_commands_that_carry_the_mount_is_enough():
    """The key need not be set where commands say it, and costs nothing where none does."""
    told = uniform(Simulation(scene(SWEEP)), CHUNK)
    runs = [bristle_ros.simulate(scene(SWEEP, mount__enabled=enabled), 0.02, commands=[
        (0.0, 'cmd_mount', told)], arrays=['tip_position']) for enabled in (True, False)]
    np.testing.assert_array_equal(runs[0]['tip_position'], runs[1]['tip_position'])
    with pytest.raises(SceneError, match='mount.enabled = true: a mount that is carried needs'):
        bristle_ros.simulate(scene(SWEEP, mount__enabled=False, solver__load_case='displacement'),
                             0.02, commands=[(0.0, 'cmd_mount', told)])


def test_the_first_command_has_what_it_needs_compiled():
    """A node that was not told beforehand is carried alike, bit for bit, and its log again."""
    runs = []
    for enabled in (True, False):
        simulation = Simulation(scene(SWEEP, mount__enabled=enabled))
        simulation.advance(60)
        assert simulation.ready_to_carry == enabled
        for _ in range(20):
            simulation.command('cmd_mount', uniform(simulation, CHUNK))
            simulation.advance(10)
        assert simulation.carried
        assert simulation.ready_to_carry
        runs.append(simulation.snapshot())
    for name in ('tip_position', 'contact_impulse', 'brush_force', 'base_pose'):
        np.testing.assert_array_equal(getattr(runs[0], name), getattr(runs[1], name))


def test_carried_along_its_own_way_it_is_the_same_run():
    own, carried = Simulation(scene(SWEEP)), Simulation(scene(SWEEP))
    for chunk in range(40):
        if chunk > 8:       # the approach is over
            carried.command('cmd_mount', uniform(carried, CHUNK))
        for simulation in (own, carried):
            simulation.advance(10)
    assert carried.carried
    ours, theirs = carried.snapshot(), own.snapshot()
    assert np.abs(theirs.contact_impulse).max() > 1e-3
    for name in ('tip_position', 'contact_impulse', 'brush_force', 'base_pose'):
        np.testing.assert_allclose(getattr(ours, name), getattr(theirs, name), rtol=1e-5,
                                   atol=1e-8, err_msg=name)


def test_bits_of_a_carried_run_and_of_its_log(tmp_path):
    """Threads, calls, reset and log; a command that comes to a log is followed again."""
    made = scene(SWEEP)
    start = Simulation(made, threads=1)
    start.advance(60)
    begin, later = uniform(start, CHUNK), uniform(start, 2.0 * CHUNK)
    higher = (later[0], later[1] + 1e-4, later[2] + 5e-5, *later[3:])
    events = [Event(60, 'command', 'cmd_mount', begin), Event(70, 'command', 'cmd_mount', higher),
              Event(120, 'timeout', 'cmd_mount', (0.0,) * 6), Event(200, 'reset'),
              Event(230, 'command', 'cmd_vel', (0.2, 0.0, 0.1)),
              Event(280, 'command', 'cmd_mount', begin)]

    def run(threads, chunk, path):
        simulation = Simulation(made, threads=threads)
        driver = Driver(simulation, sample=2, paced=False)
        driver.schedule(events)
        driver.mount = MountPath(made)
        with Log(path, made) as log:
            while driver.total_step < 300:
                log.write(driver.run_chunk(min(chunk, 300 - driver.total_step)))
        assert driver.refused == 1      # the last one: the brush is elsewhere by then
        return simulation

    one, two = run(1, 10, tmp_path / 'one'), run(2, 37, tmp_path / 'two')
    for ours, theirs in zip(one.state, two.state):
        np.testing.assert_array_equal(ours, theirs)
    verdict = verify(tmp_path / 'one')
    assert (verdict.difference, verdict.applied) == ('', 5)


def test_without_commands_it_goes_on_and_brakes():
    simulation = Simulation(scene(FREE, sweeper__max_acceleration=4.0))
    carry(simulation, 0.02, above(simulation))
    before = simulation.mount_state()
    simulation.advance(200)
    held = simulation.mount_state()
    np.testing.assert_allclose(held.velocity, before.velocity, atol=1e-12)
    np.testing.assert_allclose(held.position, before.position + 0.02 * before.velocity, atol=1e-12)
    np.testing.assert_allclose(held.rotation, before.rotation @ turn(0.02 * before.rate),
                               atol=1e-12)
    simulation.command('cmd_mount', (0.0,) * 6)
    lasts = np.linalg.norm(held.velocity) / 4.0
    simulation.advance(round(0.5 * lasts / ITS))
    speed = np.linalg.norm(simulation.mount_state().velocity)
    assert speed == pytest.approx(2.0 * lasts, rel=1e-2)
    simulation.advance(40000)
    stands = simulation.mount_state()
    assert not stands.velocity.any() or abs(stands.velocity).max() < 1e-12
    assert abs(stands.rate).max() < 1e-12
    simulation.reset()
    assert not simulation.carried


def test_what_is_refused_leaves_the_way_as_it_is():
    simulation = Simulation(scene(SWEEP))
    simulation.advance(60)
    good = uniform(simulation, CHUNK)
    x, y, z, w = good[3:7]
    cases = [
        ((*good[:3], 0.0, 0.0, 0.0, 0.0, *good[7:]), 'a quaternion of length 0'),
        ((float('nan'), *good[1:]), 'is not finite'),
        ((good[0] + 1.0, *good[1:]), r'needs \S+ m/s, beyond mount.max_speed = 20 m/s'),
        ((good[0] + 0.01, *good[1:]), r'beyond mount.max_acceleration = 500 m/s\^2'),
        ((*good[:3], *quaternion_of(turn((0.0, 0.0, 0.1))), *good[7:]), 'beyond mount.max_rate'),
        ((*good[:12], 9.0), 'beyond mount.max_angular_acceleration'),
        (good[:12], '12 values, wants 13')]
    for values, words in cases:
        with pytest.raises(CommandRefused, match=words):
            simulation.command('cmd_mount', values)
    assert not simulation.carried
    simulation.command('cmd_mount', (*good[:3], -x, -y, -z, -w, *good[7:]))   # the same rotation
    for topic, values in (('cmd_vel', (0.0, 0.0, 0.0)), ('cmd_penetration', (0.0,))):
        with pytest.raises(CommandRefused, match='carried by cmd_mount, until a reset'):
            simulation.command(topic, values)
    with pytest.raises(CommandRefused, match='cmd_mount: a mount that is carried moves as it is '):
        check_command(scene({'solver.time_step': 1e-3}), 'cmd_mount', good)


def test_a_clamp_that_is_carried_to_the_road_ends_the_run():
    simulation = Simulation(scene(SWEEP))
    low = uniform(simulation, CHUNK)
    state = simulation.mount_state()
    near = state._replace(position=np.array((0.0, 0.0, 0.015)), velocity=np.zeros(3))
    with pytest.raises(CommandRefused, match='would bring a clamp to the road or below it, by '):
        check_way(simulation.scene, way_to(0.0, near, near, 1.0))
    simulation.command('cmd_mount', (*low[:9], low[9] - 0.4, *low[10:]))    # it is not stopped
    with pytest.raises(StepFailure, match='a clamp has come to the surface'):
        simulation.advance(2000)


@pytest.mark.parametrize(('changes', 'words'), [
    ({'solver.load_case': 'displacement'}, 'mount.enabled = true: a mount that is carried needs'),
    ({'solver.time_step': 1e-3}, 'without load steps'),
    ({'run.carried': True, 'run.real_time_factor': 2.0}, 'cmd_mount sets the pace'),
])
def test_scenes_that_are_refused(changes, words):
    with pytest.raises(SceneError) as error:
        from_parameters({**FREE, **changes}, 'test')
    assert words in str(error.value)
