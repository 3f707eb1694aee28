"""Each step against the laws of motion, written a second time in ../mechanics.py."""
from dataclasses import replace
from typing import NamedTuple

from bristle_ros.physics.contact.law import OPEN, SLIP, STICK
from bristle_ros.physics.contact.tip import ESTIMATE, TREND
from bristle_ros.physics.wire import layout
from bristle_ros.scene.scene import Scene
from bristle_ros.scene.sections import (Bristle, Brush, Contact, Damping, Drive, Friction, Road,
                                        Solver, Sweeper)
from bristle_ros.simulation.simulation import Simulation
import numpy as np
from physics.mechanics import (about_z, axial, bend, internal_forces, nodes_of, Ride, slope,
                               strains, tip_record, turned)
import pytest

ITS = 5e-4
RADIUS = 0.7        # spectral
# Soft and thick: section stiffness and rotary inertia all matter, round-off does not.
RUBBER = Bristle(length=0.2, breadth=0.02, width=0.012, youngs_modulus=4e6, density=1200.0)
# Everything at once: tilted, turning, yawing and accelerating, at an azimuth, damped both ways.
WHOLE = Scene(
    bristle=RUBBER,
    brush=Brush(mount_angle=0.5, mount_orientation=0.6, mount_radius=0.15, start_angle=0.7,
                bristle_count=2, wires_per_bristle=3),
    road=Road(attack_angle=0.3, tilt_azimuth=-0.9, penetration=0.01, approach_time=0.0,
              max_rate=0.8),
    contact=Contact(enabled=False), damping=Damping(mass=2.0, stiffness=1e-3),
    drive=Drive(profile='sine', mean_speed=9.0, alternating_speed=2.0, frequency=7.0,
                max_acceleration=300.0),
    sweeper=Sweeper(velocity=(1.5, -0.3), mount_position=(0.9, -0.6), max_acceleration=25.0,
                    max_yaw_acceleration=40.0, max_yaw_rate=8.0),
    solver=Solver(elements=5, integration_time_step=ITS, spectral_radius=RADIUS, tolerance=1e-13))
DEEP = replace(WHOLE.road, penetration=0.03)


def case(**changes):
    """Return the scene with other values in its sections."""
    return replace(WHOLE, **{name: replace(getattr(WHOLE, name), **values)
                             for name, values in changes.items()})


def touching(stiffness=2e3, damping=0.5, friction=(0.7, 0.27, 0.4), **solver):
    """Return the scene on a road that comes up to its tips within the first steps."""
    scene = case(solver={'elements': 3, **solver}, road={'penetration': -1e-3},
                 brush={'bristle_count': 1, 'start_angle': WHOLE.road.tilt_azimuth})
    return replace(scene, contact=Contact(normal_stiffness=stiffness, damping=damping),
                   friction=Friction(static=friction[0], kinetic=friction[1], decay=friction[2]))


SCENES = {
    'free': (WHOLE, 4),
    'free undamped': (case(damping={'mass': 0.0, 'stiffness': 0.0}, solver={'elements': 2}), 4),
    'displacement': (case(solver={'elements': 2, 'load_case': 'displacement'}), 4),
    'hht': (case(solver={'elements': 2, 'integrator': 'hht', 'amplitude_decay': 0.1}), 3),
    'slip': (touching(), 40),
    'stick': (touching(stiffness=2e4, friction=(9.0, 9.0, 0.0)), 40),
    'rigid slip': (touching(stiffness=np.inf, damping=0.0, friction=(0.3, 0.1, 2.0)), 40),
    'rigid stick': (touching(stiffness=np.inf, damping=0.0, friction=(1.5, 1.5, 0.0)), 40),
    'displacement stick': (touching(stiffness=2e4, friction=(9.0, 9.0, 0.0),
                                    load_case='displacement'), 30)}


class Moment(NamedTuple):
    """A bristle after a step, nodes without the clamp (N, ...)."""

    x: np.ndarray
    q: np.ndarray
    velocity: np.ndarray        # (N, 6) linear, angular
    pseudo: np.ndarray          # (N, 6) A
    acceleration: np.ndarray    # (N, 6)
    mass: np.ndarray
    inertia: np.ndarray
    strain: np.ndarray          # (2 E, 6) and its rate, the rate's own acceleration
    rate: np.ndarray
    rate_acceleration: np.ndarray
    jump: np.ndarray
    last_jump: np.ndarray
    tip: tuple
    estimate: float
    trends: tuple


def moment(simulation, bristle):
    rows = nodes_of(simulation, bristle)
    tip = simulation.state.tip[bristle]
    return Moment(
        rows(layout.X0, 3), rows(layout.Q0, 4), rows(layout.V0, 6), rows(layout.A0, 6),
        rows(layout.ACC0, 6), rows(layout.MASS, 1), rows(layout.INERTIA, 3),
        rows(layout.STRAIN0, 6), rows(layout.RATE0, 6), rows(layout.RATEACC0, 6),
        rows(layout.JUMP, 6), rows(layout.LAST_JUMP, 6), tip_record(simulation, bristle),
        tip[ESTIMATE], tuple(tip[TREND:TREND + 2]))


class Stepped(NamedTuple):
    """A run: for each bristle its moments, one more than steps; what it looked like after each."""

    scene: Scene
    model: object
    ride: Ride
    moments: list
    seen: list


_runs = {}


def stepped(name):
    """Return the run of a scene, made once."""
    if name not in _runs:
        scene, steps = SCENES[name]
        simulation = Simulation(scene, energies=True)
        simulation.command('cmd_brush_speed', (20.0,))
        simulation.command('cmd_vel', (2.0, 0.4, 1.0))
        simulation.command('cmd_penetration', (DEEP.penetration,))
        motion = simulation.state.motion.reshape(-1)
        ramps = [motion[6 * i:6 * i + 4] for i in range(5)]
        lines = [(ramp[1], (ramp[2] - ramp[1]) / ramp[3]) for ramp in ramps]
        assert min(ramp[3] for ramp in ramps) >= (steps - 1) * ITS, 'ramps end after the run'
        ride = Ride(scene, lines[0], lines[3], lines[4], lines[1], lines[2],
                    simulation.model.drive.tip_depth)
        bristles = range(simulation.model.bristles)
        moments = [[moment(simulation, i) for i in bristles]]
        seen = [simulation.snapshot()]
        for _ in range(steps):
            simulation.advance(1)
            moments.append([moment(simulation, i) for i in bristles])
            seen.append(simulation.snapshot())
        assert simulation.state.counts[:, 1].sum() == 0, 'no sub-steps'
        _runs[name] = Stepped(scene, simulation.model, ride, list(zip(*moments)), seen)
    return _runs[name]


def coefficients(scene):
    """Return alpha_m, alpha_f, beta, gamma; Chung, Hulbert (1993), Hilber et al. (1977)."""
    if scene.solver.integrator == 'hht':
        g = scene.solver.amplitude_decay
        return 0.0, g, 0.25 * (1.0 + g) ** 2, 0.5 + g
    r = scene.solver.spectral_radius
    m, f = (2.0 * r - 1.0) / (r + 1.0), r / (r + 1.0)
    return m, f, 0.25 * (1.0 - m + f) ** 2, 0.5 - m + f


def azimuth(run, bristle):
    return 2.0 * np.pi * bristle / run.model.bristles


def axes(run, bristle):
    return lambda t: run.ride.axes(t, azimuth(run, bristle), run.model.displacement)


def brush_axes(run, bristle):
    """Return the axes that turn with the brush, whatever the load case."""
    return lambda t: run.ride.axes(t, azimuth(run, bristle), False)


def increments(before, after):
    """Return the increment of a step, (N, 6); of rotations 2 tan(angle / 2), section axes."""
    p, q = before.q * [1.0, -1.0, -1.0, -1.0], after.q
    w = p[:, :1] * q[:, :1] - (p[:, 1:] * q[:, 1:]).sum(axis=1, keepdims=True)
    v = p[:, :1] * q[:, 1:] + q[:, :1] * p[:, 1:] + np.cross(p[:, 1:], q[:, 1:])
    return np.hstack((after.x - before.x, 2.0 * v / w))


def impact(run, bristle, step):
    """
    Return the force that positions show, and the velocity that the tip lost at the step's end.

    u gains h^2 f / 2 m and v gains h f / m, f turned by the step's middle; what the recorded
    force has beyond f acted on the velocity alone, at the end.
    """
    before, after = run.moments[bristle][step], run.moments[bristle][step + 1]
    turn = axes(run, bristle)
    _, _, beta, _ = coefficients(run.scene)
    u = increments(before, after)[-1, :3]
    mass = after.mass[-1, 0]
    pushed = u - ITS * before.velocity[-1, :3] - ITS * ITS * (
        (0.5 - beta) * before.pseudo[-1, :3] + beta * after.pseudo[-1, :3])
    force = turn((step + 0.5) * ITS) @ pushed * 2.0 * mass / ITS ** 2
    lost = turn((step + 1) * ITS).T @ (after.tip[1] - force) * ITS / mass
    return force, lost


def close(found, wanted, scale, bound):
    assert abs(np.asarray(found) - wanted).max() <= bound * scale


def each(name):
    run = stepped(name)
    for bristle in range(run.model.bristles):
        for step in range(len(run.seen) - 1):
            yield run, bristle, step, run.moments[bristle][step], run.moments[bristle][step + 1]


@pytest.mark.parametrize('name', SCENES)
def test_positions_and_velocities_follow_the_scheme(name):
    for run, bristle, step, before, after in each(name):
        m, f, beta, gamma = coefficients(run.scene)
        u = increments(before, after)
        free = ITS * before.velocity + ITS ** 2 * (
            (0.5 - beta) * before.pseudo + beta * after.pseudo)
        force, lost = impact(run, bristle, step)
        close(u[:-1], free[:-1], abs(u).max(), 1e-12)
        close(u[-1, 3:], free[-1, 3:], abs(u).max(), 1e-12)
        v = before.velocity + ITS * ((1.0 - gamma) * before.pseudo + gamma * after.pseudo)
        v[-1, :3] += lost + axes(run, bristle)((step + 0.5) * ITS).T @ force * (
            ITS / after.mass[-1, 0])
        close(after.velocity, v, abs(v).max(), 1e-9)
        wanted = ((1.0 - f) * after.acceleration + f * before.acceleration - m * before.pseudo
                  ) / (1.0 - m)
        close(after.pseudo, wanted, abs(wanted).max(), 1e-11)
        close(after.jump, after.pseudo - before.pseudo, abs(after.jump).max(), 1e-9)
        if not after.tip[1].any():
            close(force, 0.0, 1.0, 1e-6)
            close(lost, 0.0, 1.0, 1e-6)


@pytest.mark.parametrize('name', SCENES)
def test_the_strain_rate_follows_the_scheme(name):
    for run, _, _, before, after in each(name):
        if not run.scene.damping.stiffness:
            assert not after.rate.any()
            continue
        _, _, beta, gamma = coefficients(run.scene)
        acceleration = after.rate_acceleration
        u = ITS * before.rate + ITS ** 2 * (
            (0.5 - beta) * before.rate_acceleration + beta * acceleration)
        change = after.strain - before.strain
        close(change, u, abs(change).max(), 1e-11)
        v = before.rate + ITS * ((1.0 - gamma) * before.rate_acceleration + gamma * acceleration)
        close(after.rate, v, abs(v).max(), 1e-11)


def clamp(run, bristle, t):
    """Return position and quaternion of the clamp in the solved axes of its bristle."""
    x, q = run.model.clamp[:3], run.model.clamp[3:]
    if run.model.displacement:
        angle = run.ride.theta(t)
        turn = np.array([np.cos(angle / 2), 0.0, 0.0, np.sin(angle / 2)])
        w, v = turn[0] * q[0] - turn[3] * q[3], turn[0] * q[1:] + q[0] * turn[1:] + np.cross(
            turn[1:], q[1:])
        return about_z(angle) @ x, np.concatenate(([w], v))
    return x, q


def all_nodes(run, bristle, after, t):
    x, q = clamp(run, bristle, t)
    return np.vstack((x, after.x)), np.vstack((q, after.q))


def stiffness(model):
    s = model.section
    return np.array([s.axial, s.shear_y, s.shear_z, s.torsion, s.bending_y, s.bending_z])


@pytest.mark.parametrize('name', SCENES)
def test_forces_and_moments_make_the_acceleration(name):
    for run, bristle, step, _, after in each(name):
        t = (step + 1) * ITS
        scene, model, turn = run.scene, run.model, axes(run, bristle)
        x, q = all_nodes(run, bristle, after, t)
        strain = strains(x, q, model.section.element_length)
        if scene.damping.stiffness:
            close(after.strain, strain, abs(strain).max(), 1e-12)
        stress = stiffness(model) * (strain + scene.damping.stiffness * after.rate)
        force, torque = internal_forces(x, q, model.section.element_length, stress)
        # velocities before the impact: the forces know no other
        velocity = after.velocity.copy()
        velocity[-1, :3] -= impact(run, bristle, step)[1]
        brush = np.array([0.0, 0.0, slope(run.ride.theta, t) * model.displacement])
        # road axes: position = mount + R x
        linear = velocity[:, :3]
        absolute = (slope(run.ride.velocity, t) + x[1:] @ bend(turn, t).T
                    + 2.0 * linear @ slope(turn, t).T + after.acceleration[:, :3] @ turn(t).T)
        per_mass = ([0.0, 0.0, -scene.gravity] - absolute) @ turn(t) - scene.damping.mass * (
            linear - np.cross(brush, x[1:]))
        scale = abs(after.mass * per_mass).max()
        close(after.mass * per_mass, force[1:], scale, 3e-7)
        # section axes: W = w + spin
        back = q[1:] * [1.0, -1.0, -1.0, -1.0]
        spin = turned(back, axial(turn(t).T @ slope(turn, t)) + np.zeros(back[:, 1:].shape))
        rate = (axial(turn(t).T @ bend(turn, t)
                      + slope(turn, t).T @ slope(turn, t)) + np.zeros(back[:, 1:].shape))
        w = velocity[:, 3:]
        change = after.acceleration[:, 3:] + turned(back, rate) - np.cross(w, spin)
        momentum = after.inertia * (w + spin)
        inertial = (after.inertia * change + np.cross(w + spin, momentum)
                    + scene.damping.mass * after.inertia * (w - turned(back, brush + 0.0 * w)))
        close(inertial, -torque[1:], abs(inertial).max(), 3e-6)


@pytest.mark.parametrize('name', SCENES)
def test_the_mount_feels_what_gives_the_momentum(name):
    # All that acts on the nodes and the clamped mass: gravity, the mass damping and the mount's
    # reaction. Contact is left out by the accelerations, which it acts beside.
    for run, bristle, step, _, after in each(name):
        t = (step + 1) * ITS
        scene, model, turn = run.scene, run.model, axes(run, bristle)
        x, q = all_nodes(run, bristle, after, t)
        velocity = after.velocity.copy()
        velocity[-1, :3] -= impact(run, bristle, step)[1]
        brush = np.array([0.0, 0.0, slope(run.ride.theta, t) * model.displacement])
        linear = velocity[:, :3]
        free = ([0.0, 0.0, -scene.gravity] - slope(run.ride.velocity, t)) @ turn(t)
        felt = (free - (x[1:] @ bend(turn, t).T + 2.0 * linear @ slope(turn, t).T) @ turn(t)
                - after.acceleration[:, :3]
                - scene.damping.mass * (linear - np.cross(brush, x[1:])))
        own = brush_axes(run, bristle)
        at_clamp = own(t).T @ ([0.0, 0.0, -scene.gravity] - slope(run.ride.velocity, t)
                               - bend(own, t) @ model.clamp[:3])
        to_brush = about_z(azimuth(run, bristle)) @ own(t).T @ turn(t)
        force = to_brush @ (after.mass * felt).sum(axis=0) + about_z(azimuth(run, bristle)) @ (
            model.clamp_mass * at_clamp)
        seen = run.seen[step + 1]
        close(seen.mount_force[bristle], force, abs(force).max(), 3e-6)
        arms = np.cross(x[1:] - x[0], after.mass * felt).sum(axis=0)
        back = q[1:] * [1.0, -1.0, -1.0, -1.0]
        zero = np.zeros(linear.shape)
        spin = turned(back, axial(turn(t).T @ slope(turn, t)) + zero)
        rate = axial(turn(t).T @ bend(turn, t) + slope(turn, t).T @ slope(turn, t)) + zero
        w = velocity[:, 3:]
        twist = -(after.inertia * (after.acceleration[:, 3:] + turned(back, rate)
                                   - np.cross(w, spin)
                                   + scene.damping.mass * (w - turned(back, brush + zero)))
                  + np.cross(w + spin, after.inertia * (w + spin)))
        moments = to_brush @ (arms + turned(q[1:], twist).sum(axis=0))
        close(seen.mount_moment[bristle], moments, abs(moments).max(), 3e-6)


@pytest.mark.parametrize('name', SCENES)
def test_what_is_seen_is_where_it_is(name):
    run = stepped(name)
    turned_by = run.model.displacement
    for step, seen in enumerate(run.seen):
        t = step * ITS
        theta = run.ride.theta(t)
        assert seen.theta == pytest.approx(theta, abs=1e-13)
        assert seen.omega == pytest.approx(slope(run.ride.theta, t), abs=1e-11)
        force, torque, contact, contact_torque = np.zeros((4, 3))
        kinetic = elastic = 0.0
        for bristle, moments in enumerate(run.moments):
            after, to_mount = moments[step], about_z(theta)
            solved = about_z(azimuth(run, bristle) - turned_by * theta)     # to brush axes
            tip = solved @ after.x[-1]
            close(seen.tip_position[bristle], tip, 1.0, 1e-14)
            close(seen.tip_position_mount[bristle], to_mount @ tip, 1.0, 1e-14)
            close(seen.tip_position_road[bristle], run.ride.mount(t) @ to_mount @ tip, 1.0, 1e-14)
            for quaternion, turn in ((seen.tip_orientation, solved),
                                     (seen.tip_orientation_mount, to_mount @ solved)):
                q = np.roll(quaternion[bristle], 1)[None]
                for axis in np.eye(3)[:, None]:
                    close(turned(q, axis), turn @ turned(after.q[-1:], axis)[0], 1.0, 1e-13)
            close(seen.contact_force[bristle], after.tip[1], 1.0, 0.0)
            # sums over real wires, mount axes, about the mount's centre
            arm = to_mount @ about_z(azimuth(run, bristle)) @ run.model.clamp[:3]
            push = 3.0 * to_mount @ seen.mount_force[bristle]
            force += push
            torque += 3.0 * to_mount @ seen.mount_moment[bristle] + np.cross(arm, push)
            road = 3.0 * run.ride.mount(t).T @ after.tip[1]
            contact += road
            contact_torque += np.cross(to_mount @ tip, road)
            x, q = all_nodes(run, bristle, after, t)
            strain = strains(x, q, run.model.section.element_length)
            elastic += 0.75 * run.model.section.element_length * (
                strain ** 2 @ stiffness(run.model)).sum()
            if step and run.scene.contact.enabled and np.isfinite(
                    run.scene.contact.normal_stiffness):
                elastic += 1.5 * run.scene.contact.normal_stiffness * min(after.tip[2], 0.0) ** 2
            spin = np.array([0.0, 0.0, slope(run.ride.theta, t) * turned_by])
            relative = after.velocity[:, :3] - np.cross(spin, after.x)
            own = after.velocity[:, 3:] - turned(
                after.q * [1.0, -1.0, -1.0, -1.0], spin + np.zeros(after.x.shape))
            kinetic += 1.5 * (after.mass * relative ** 2 + after.inertia * own ** 2).sum()
        for found, wanted in ((seen.brush_force, force), (seen.brush_torque, torque),
                              (seen.contact_force_mount, contact),
                              (seen.contact_torque_mount, contact_torque)):
            close(found, wanted, abs(wanted).max() + 1e-12, 1e-11)
        assert seen.energy_elastic == pytest.approx(elastic, rel=1e-9, abs=1e-15)
        assert seen.energy_kinetic == pytest.approx(kinetic, rel=1e-9, abs=1e-15)
        if step:
            close(seen.contact_impulse, run.seen[step - 1].contact_impulse
                  + ITS * seen.contact_force, abs(seen.contact_impulse).max() + 1e-12, 1e-12)


@pytest.mark.parametrize('name', SCENES)
def test_the_error_estimate_is_the_change_of_a(name):
    for run, bristle, step, before, after in each(name):
        m, f, beta, _ = coefficients(run.scene)
        change = (after.pseudo - before.pseudo)[:, :3]
        force = impact(run, bristle, step)[0]
        old = before.tip[1]
        change[-1] += axes(run, bristle)((step + 0.5) * ITS).T @ (force - old) / after.mass[-1]
        wanted = abs(beta + 0.5 * (m - f) - 1.0 / 6.0) * ITS ** 2 * np.sqrt(
            (after.mass * change ** 2).sum() / after.mass.sum())
        assert after.estimate == pytest.approx(wanted, rel=1e-5)
        np.testing.assert_array_equal(after.last_jump, before.jump)
        if before.jump.any():
            changes = np.stack((before.jump, before.last_jump)).reshape(2, -1)
            noise = 1e-8 * (changes ** 2).sum() * np.eye(2)
            x, y = np.linalg.solve(changes @ changes.T + noise, changes @ after.jump.ravel())
            if abs(y) > 1.0:
                y = np.clip(y, -1.0, 1.0)
                x = (changes[0] @ (after.jump.ravel() - y * changes[1])
                     / (changes[0] @ changes[0] + noise[0, 0]))
            assert after.trends == pytest.approx((np.clip(x, y - 1.0, 1.0 - y), y), abs=1e-9)


def normal_force(contact, gap0, gap1):
    """Return what the spring gives over a step: (Phi(g0) - Phi(g1)) / (g1 - g0), damped."""
    energy = [0.5 * contact.normal_stiffness * min(gap, 0.0) ** 2 for gap in (gap0, gap1)]
    force = (energy[0] - energy[1]) / (gap1 - gap0)
    return max(force * (1.0 + contact.damping * (gap0 - gap1) / ITS), 0.0)


@pytest.mark.parametrize('name', [name for name in SCENES if SCENES[name][0].contact.enabled])
def test_the_road_acts_on_the_tip_as_its_laws_say(name):
    seen = {OPEN: 0, SLIP: 0, STICK: 0}
    for run, bristle, step, before, after in each(name):
        scene, turn = run.scene, axes(run, bristle)
        state, recorded, gap, moved = after.tip
        t0, t1 = step * ITS, (step + 1) * ITS
        start, end = turn(t0) @ before.x[-1], turn(t1) @ after.x[-1]
        gap0, gap1 = start[2] + run.ride.height(t0), end[2] + run.ride.height(t1)
        slip = (end - start + ITS * run.ride.velocity(t0 + 0.5 * ITS))[:2]
        # the tip's record is that of the linearised chain: Newton's tolerance off
        assert gap == pytest.approx(gap1, abs=1e-12)
        close(moved, [*slip, gap1 - gap0], 1.0, 1e-12)
        seen[state] += 1
        force, _ = impact(run, bristle, step)
        friction, normal = force[:2], force[2]
        if state == OPEN:
            assert gap1 >= 0.0
            assert not recorded.any()
            continue
        law = scene.friction
        if np.isfinite(scene.contact.normal_stiffness):
            assert normal == pytest.approx(normal_force(scene.contact, gap0, gap1), rel=1e-6,
                                           abs=1e-7)
        else:
            assert abs(gap1) < 1e-12
        mu = law.kinetic + (law.static - law.kinetic) * np.exp(
            -law.decay * np.linalg.norm(slip) / ITS)
        if state == STICK:
            assert np.linalg.norm(slip) < 1e-12
            assert np.linalg.norm(friction) <= law.static * normal * (1.0 + 1e-9)
        else:
            size = np.linalg.norm(slip)
            close(friction, -mu * normal * slip / size, normal + 1e-3, 1e-5)
        # afterwards: the tip rests where it was held, as far as the cone allows
        impulse = recorded - force
        rests = (turn(t1) @ after.velocity[-1, :3] + slope(turn, t1) @ after.x[-1]
                 + run.ride.velocity(t1))
        rests[2] -= run.ride.depth[1]
        assert recorded[2] >= -1e-9
        inside = law.static * recorded[2] - np.linalg.norm(recorded[:2])
        assert inside >= -1e-6 * normal
        if state == STICK and gap1 <= 0.0:
            assert np.linalg.norm(rests[:2]) < 1e-6 or abs(inside) < 1e-6 * normal
        if np.isinf(scene.contact.normal_stiffness):
            assert abs(rests[2]) < 1e-6 or recorded[2] < 1e-9
            if state == SLIP:
                part = min(recorded[2] / normal, 1.0) - 1.0
                close(impulse[:2], part * friction, normal, 1e-6)
        elif state == SLIP:
            close(impulse, 0.0, normal + 1e-3, 1e-5)
    wanted = STICK if 'stick' in name else SLIP
    assert seen[wanted] > 3
    assert seen[OPEN] > 0


@pytest.mark.parametrize('name', SCENES)
def test_the_accounts_are_the_work_of_each_step(name):
    # trapezoidal rule in the axes of the turning brush; rotary inertia is left out there
    for run, bristle, step, _, _ in each(name):
        if bristle:
            continue
        scene = run.scene
        work = lost = 0.0
        for index, moments in enumerate(run.moments):
            before, after = moments[step], moments[step + 1]
            mean, moves, rests = [], [], []
            force, released = impact(run, index, step)
            whole = brush_axes(run, index)
            for t, one in ((step * ITS, before), ((step + 1) * ITS, after)):
                back = whole(t).T @ axes(run, index)(t)
                spin = np.array([0.0, 0.0, slope(run.ride.theta, t) * run.model.displacement])
                velocity = one.velocity[:, :3].copy()
                if one is after:
                    velocity[-1] -= released
                x = one.x @ back.T
                rests.append((velocity - np.cross(spin, one.x)) @ back.T)
                moves.append(x)
                mean.append(([0.0, 0.0, -scene.gravity] - slope(run.ride.velocity, t)
                             - x @ bend(whole, t).T) @ whole(t))
            change = moves[1] - moves[0]
            work += 1.5 * (after.mass * change * (mean[0] + mean[1])).sum()
            lost += 1.5 * scene.damping.mass * (
                after.mass * change * (rests[0] + rests[1])).sum()
            lost += 0.75 * run.model.section.element_length * scene.damping.stiffness * (
                (after.strain - before.strain) * (before.rate + after.rate)
                @ stiffness(run.model)).sum()
            if after.tip[0] != OPEN:
                stored = 0.0
                if np.isfinite(scene.contact.normal_stiffness):
                    gaps = after.tip[2], after.tip[2] - after.tip[3][2]
                    stored = 0.5 * scene.contact.normal_stiffness * (
                        min(gaps[0], 0.0) ** 2 - min(gaps[1], 0.0) ** 2)
                given = force @ after.tip[3]
                held = whole((step + 0.5) * ITS)
                work += 3.0 * ((held.T @ force) @ change[-1] - given)
                lost -= 3.0 * (given + stored)
                end = after.velocity[-1, :3]
                mass = after.mass[-1, 0]
                frame = np.cross(axial(axes(run, index)((step + 1) * ITS).T @ slope(
                    axes(run, index), (step + 1) * ITS)), after.x[-1])
                road = axes(run, index)((step + 1) * ITS).T @ (
                    run.ride.velocity((step + 1) * ITS) - [0.0, 0.0, run.ride.depth[1]])
                over = end + frame + road
                lost += 1.5 * mass * (((over - released) ** 2).sum() - (over ** 2).sum())
        one, two = run.seen[step:step + 2]
        scale = abs(two.work_external) + 1e-6
        assert two.work_external - one.work_external == pytest.approx(work, abs=1e-6 * scale)
        assert two.energy_dissipated - one.energy_dissipated == pytest.approx(
            lost, abs=1e-6 * scale)


def test_strains_carried_over_are_those_of_the_end_however_loose_the_tolerance():
    # without accounts forces were last evaluated before the last correction
    scene = case(solver={'elements': 2, 'tolerance': 1e-3}, brush={'bristle_count': 1})
    simulation = Simulation(scene)
    simulation.advance(3)
    rows, model = nodes_of(simulation, 0), simulation.model
    x = np.vstack((model.clamp[:3], rows(layout.X0, 3)))
    q = np.vstack((model.clamp[3:], rows(layout.Q0, 4)))
    wanted = strains(x, q, model.section.element_length)
    assert abs(wanted).min(axis=0).max() > 1e-6
    close(rows(layout.STRAIN0, 6), wanted, 1.0, 1e-13)
