"""Still air against integrals along the wire, done by numpy from the definition alone."""
from dataclasses import replace
import math

from bristle_ros.physics.wire.air import Air, node_air
from bristle_ros.physics.wire.layout import (HV, LANES, MASS, Q, R, ROWS, X, X0)
from bristle_ros.scene.scene import from_parameters
from bristle_ros.scene.sections import Air as AirOfScene
from bristle_ros.simulation.equilibrium import static_equilibrium
from bristle_ros.simulation.simulation import Simulation
import numpy as np
from physics.scenes import sliding_sweep
import pytest

DENSITY, COEFFICIENT = 1.2, 1.3
ROAD = {'road.attack_angle': 0.15, 'sweeper.velocity': (3.0, -1.0), 'drive.mean_speed': 12.0,
        'damping.stiffness': 1e-3, 'road.penetration': 0.02, 'road.approach_time': 0.05}


def scene(**given):
    return from_parameters({
        'air.density': DENSITY, 'air.drag_coefficient': COEFFICIENT, **{
            key.replace('__', '.'): value for key, value in given.items()}}, 'test')


def stiff(**given):
    """Return a scene whose wire stays straight, 5,000 times as stiff as steel, and at rest."""
    return scene(bristle__youngs_modulus=1e15, contact__enabled=False, gravity=0.0,
                 damping__mass=0.0, drive__profile='constant',
                 solver__start='steady', solver__tolerance=1e-12, **given)


def drag(scene, spin, wind, nodes=200_001):
    """
    Return force and moment about the mount centre of air on a straight wire at azimuth 0.

    spin [rad/s] : (3,), wind [m/s] : (3,)    of the wire through the air, mount axes
    The width that a rectangle shows is worked out by projecting its corners.
    """
    b = scene.bristle
    phi, gamma = scene.brush.mount_angle, scene.brush.mount_orientation
    along = np.array([math.sin(phi), 0.0, -math.cos(phi)])
    y0, z0 = np.array([0.0, 1.0, 0.0]), np.array([math.cos(phi), 0.0, math.sin(phi)])
    y = math.cos(gamma) * y0 + math.sin(gamma) * z0
    z = math.cos(gamma) * z0 - math.sin(gamma) * y0
    arc = np.linspace(0.0, b.length, nodes)
    place = np.array([scene.brush.mount_radius, 0.0, 0.0]) + arc[:, None] * along
    velocity = wind + np.cross(spin, place)
    across = velocity - (velocity @ along)[:, None] * along
    speed = np.linalg.norm(across, axis=1)
    side = np.cross(along, across / np.maximum(speed, 1e-30)[:, None])
    corners = [side @ (0.5 * (one * b.breadth * y + two * b.width * z))
               for one in (-1, 1) for two in (-1, 1)]
    width = np.max(corners, axis=0) - np.min(corners, axis=0)
    load = -0.5 * DENSITY * COEFFICIENT * (width * speed)[:, None] * across
    return (np.trapezoid(load, arc, axis=0),
            np.trapezoid(np.cross(place, load), arc, axis=0))


@pytest.mark.parametrize('gamma', [0.0, 0.5, math.pi / 2.0, 2.2])
@pytest.mark.parametrize('load_case', ['inertia', 'displacement'])
def test_torque_of_a_stiff_turning_wire_is_the_integral_along_it(gamma, load_case):
    turning = stiff(brush__mount_orientation=gamma, drive__mean_speed=30.0,
                    solver__load_case=load_case)
    simulation = Simulation(turning, energies=True)
    simulation.advance(20)
    snapshot, spin = simulation.snapshot(), np.array([0.0, 0.0, 30.0])
    force, moment = drag(turning, spin, np.zeros(3))
    turn = np.array([[math.cos(snapshot.theta), -math.sin(snapshot.theta), 0.0],
                     [math.sin(snapshot.theta), math.cos(snapshot.theta), 0.0], [0, 0, 1.0]])
    np.testing.assert_allclose(snapshot.air_force[0], turn @ force,
                               atol=2e-4 * np.abs(force).max())
    assert snapshot.work_external == pytest.approx(snapshot.energy_dissipated, rel=1e-6)
    if load_case == 'displacement':     # the driven clamp of a wire as stiff as that trembles
        return
    assert snapshot.brush_torque[2] == pytest.approx(moment[2], rel=2e-4)
    # what the drive puts in goes into the air, all of it
    assert snapshot.energy_dissipated == pytest.approx(
        -30.0 * snapshot.brush_torque[2] * snapshot.t, rel=2e-5)


def test_air_sees_the_sweeper_the_heading_and_the_tilt():
    driven = stiff(brush__mount_orientation=0.4, drive__mean_speed=-8.0, solver__elements=6,
                   sweeper__velocity=(7.0, -3.0), road__attack_angle=0.3, road__tilt_azimuth=0.8,
                   brush__start_angle=1.1)
    simulation = Simulation(driven)
    simulation.command('cmd_vel', [7.0, -3.0, 1.0])
    simulation.advance(300)
    snapshot = simulation.snapshot()
    tilt, turn = 0.3, snapshot.theta + 0.0

    def about_z(angle):
        c, s = math.cos(angle), math.sin(angle)
        return np.array([[c, -s, 0.0], [s, c, 0.0], [0.0, 0.0, 1.0]])

    c, s = math.cos(tilt), math.sin(tilt)
    heading = snapshot.base_pose[2]
    lean = np.array([[c, 0.0, s], [0.0, 1.0, 0.0], [-s, 0.0, c]])
    to_road = about_z(heading) @ about_z(0.8) @ lean @ about_z(-0.8) @ about_z(turn)
    yaw = 2.0 * snapshot.t      # sweeper.max_yaw_acceleration
    spin = np.array([0.0, 0.0, -8.0]) + to_road.T @ [0.0, 0.0, yaw]
    wind = to_road.T @ about_z(heading) @ [7.0, -3.0, 0.0]
    force, _ = drag(driven, spin, wind)
    np.testing.assert_allclose(snapshot.air_force[0], to_road @ force,
                               atol=2e-3 * np.linalg.norm(force))


def test_the_force_is_that_of_the_width_seen_and_its_power_is_taken():
    rng = np.random.default_rng(3)
    frame = np.zeros(64)
    frame[[0, 4, 8]] = 1.0
    for _ in range(50):
        q = rng.normal(size=4)
        q /= np.linalg.norm(q)
        v = rng.normal(size=3)
        *force, power = node_air(Air(3.0, 0.5), 2.0, (0.1, 0.2, 0.3), tuple(q), tuple(v), frame)
        w, a, b, c = q
        axes = np.array([[1 - 2 * (b * b + c * c), 2 * (a * b - w * c), 2 * (a * c + w * b)],
                         [2 * (a * b + w * c), 1 - 2 * (a * a + c * c), 2 * (b * c - w * a)],
                         [2 * (a * c - w * b), 2 * (b * c + w * a), 1 - 2 * (a * a + b * b)]])
        _, y, z = axes.T @ v
        seen = 2.0 * (3.0 * abs(z) + 0.5 * abs(y))
        np.testing.assert_allclose(force, axes @ [0.0, -seen * y, -seen * z], atol=1e-12)
        assert power == pytest.approx(np.dot(force, v), rel=1e-12)
        assert power <= 0.0


@pytest.mark.parametrize('load_case', ['inertia', 'displacement'])
def test_the_energy_balance_closes_with_air(load_case):
    """A hundred times the density: the balance must not leave out what is as large as that."""
    moving = {} if load_case == 'displacement' else {
        'sweeper__velocity': (3.0, -1.0), 'road__attack_angle': 0.15}
    simulation = Simulation(scene(
        air__density=100.0, solver__load_case=load_case, contact__enabled=False,
        damping__stiffness=2e-4, drive__mean_speed=30.0, **moving), energies=True)
    simulation.advance(1000)
    now = simulation.snapshot()
    residual = (now.energy_kinetic + now.energy_elastic + now.energy_dissipated
                - now.work_external)
    assert now.energy_dissipated > 0.1
    assert abs(residual) < 1e-5 * now.energy_dissipated


def test_a_thousandth_of_newtons_corrections_is_left_to_the_air():
    """The frozen matrix knows no air: at a hundred times its density hardly an iteration more."""
    counts = []
    for density in (0.0, 1.2, 100.0):
        still = replace(sliding_sweep(its=1e-3), air=AirOfScene(density=density))
        simulation = Simulation(still)
        simulation.advance(500)
        assert simulation.newton_failures == 0
        counts.append(simulation.snapshot().newton_iterations)
    assert counts[1] < 1.1 * counts[0]
    assert counts[2] < 1.5 * counts[0]


def test_without_density_there_is_no_air():
    default, off = Simulation(sliding_sweep()), Simulation(
        replace(sliding_sweep(), air=AirOfScene(drag_coefficient=5.0)))
    for simulation in (default, off):
        simulation.advance(300)
        assert simulation.model.air is None
        assert not simulation.snapshot().air_force.any()
    np.testing.assert_array_equal(default.state.nodes, off.state.nodes)


def test_air_bends_the_wire_of_a_static_equilibrium():
    """Small deflection of a wire held in a steady wind: p l^4 / 8 EI at its tip."""
    length, wind = 0.1, 5.0
    still = scene(bristle__length=length, brush__mount_radius=0.0, brush__mount_angle=0.0,
                  contact__enabled=False, drive__mean_speed=0.0, gravity=0.0,
                  sweeper__velocity=(wind, 0.0))
    load = 0.5 * DENSITY * COEFFICIENT * still.bristle.breadth * wind ** 2
    stiffness = still.bristle.youngs_modulus * 0.002 * 0.0005 ** 3 / 12.0
    tip = static_equilibrium(still).tip_position[0]
    assert tip[0] == pytest.approx(-load * length ** 4 / (8.0 * stiffness), rel=2e-3)


def test_the_settled_speed_of_air_is_in_the_residual_rows():
    """What the kernel adds to a row of lanes is what it says of a single node."""
    from bristle_ros.physics.wire.air import add_air
    rng = np.random.default_rng(5)
    s = np.zeros((2, ROWS * LANES))
    rows = s.reshape(2, ROWS, LANES)
    rows[:] = rng.normal(size=rows.shape)
    rows[:, MASS] = np.abs(rows[:, MASS])
    rows[:, Q:Q + 4] /= np.linalg.norm(rows[:, Q:Q + 4], axis=1, keepdims=True)
    rows[:, R:R + 6] = 0.0
    frame, air, cv = rng.normal(size=64), Air(3.0, 0.5), 7.0
    add_air(s, 2, cv, air, frame)
    for j in range(2):
        for i in range(LANES):
            x = rows[j, X:X + 3, i]
            v = cv * (x - rows[j, X0:X0 + 3, i]) + rows[j, HV:HV + 3, i]
            q = rows[j, Q:Q + 4, i]
            *force, _ = node_air(air, rows[j, MASS, i], tuple(x), tuple(q), tuple(v), frame)
            w, a = q[0], q[1:]
            turned = force + 2.0 * np.cross(np.cross(force, a) + w * np.array(force), a)
            np.testing.assert_allclose(rows[j, R:R + 3, i], turned, rtol=1e-9, atol=1e-9)
