"""Small vibrations about equilibrium, at rest and spinning, against closed and published ones."""
from bristle_ros.physics.motion.drive import SINE
from bristle_ros.physics.motion import FRAME, SPEED
from bristle_ros.physics.wire import layout
from bristle_ros.physics.wire.beam import internal_forces
from bristle_ros.physics.wire.dynamics import residual
from bristle_ros.scene.scene import Scene
from bristle_ros.scene.sections import Brush, Damping, Drive, Run, Solver
from bristle_ros.simulation.simulation import Simulation
import numpy as np
from physics.beams import Beam, Cantilever, derivative, matrix, scene_along_x
from physics.scenes import NO_CONTACT
import pytest


def frequencies(scene, spin=0.0):
    """
    Return the angular frequencies [rad/s], and for each mode its share of motion along z.

    Stiffness and gyroscopic matrix are finite differences of the out-of-balance forces about the
    equilibrium under `spin` about z: what the steps solve, frame forces included.
    """
    wire = Cantilever(scene)
    wire.settle(np.zeros(6), spin=(0.0, 0.0, spin))
    frame = np.zeros(FRAME)
    frame[:] = wire.frame
    clamp = wire.model.clamp
    beam = Beam([(clamp[:3], clamp[3:])] * (2 * wire.model.elements + 1), wire.model.section)
    beam.s[:] = wire.s
    nodes = [beam.nodes[0]] + [
        (beam.at(n, layout.X, 3).copy(), beam.at(n, layout.Q, 4).copy())
        for n in range(1, 2 * wire.model.elements + 1)]
    beam.nodes = nodes
    beam.rows[:, layout.X0:layout.X0 + 7] = beam.rows[:, layout.X:layout.X + 7]
    beam.rows[:, layout.HA:layout.HV + 6] = 0.0
    internal_forces(beam.s, beam.blocks, clamp, beam.section, 1.0, 0.0)
    axes = [matrix(q) for _, q in nodes[1:]]
    count = len(nodes) - 1

    def out_of_balance():
        residual(beam.s, beam.blocks, 0.0, 0.0, 0.0, frame)
        return np.concatenate([np.concatenate((
            axes[n - 1].T @ matrix(beam.nodes[n][1]) @ beam.at(n, layout.R, 3),
            beam.at(n, layout.R + 3, 3))) for n in range(1, count + 1)])

    stiff = -derivative(beam, out_of_balance, step=1e-7)
    gyroscopic = np.empty_like(stiff)
    still = out_of_balance()
    for n in range(1, count + 1):
        for i in range(6):
            velocity = np.concatenate((axes[n - 1][:, i], np.zeros(3))) if i < 3 else np.eye(6)[i]
            beam.at(n, layout.HV, 6)[:] = velocity
            gyroscopic[:, 6 * (n - 1) + i] = still - out_of_balance()
            beam.at(n, layout.HV, 6)[:] = 0.0
    mass = np.concatenate([np.concatenate((np.repeat(beam.at(n, layout.MASS, 1), 3),
                                           beam.at(n, layout.INERTIA, 3)))
                           for n in range(1, count + 1)])
    first = np.block([[np.zeros_like(stiff), np.eye(len(mass))],
                      [-stiff / mass[:, None], -gyroscopic / mass[:, None]]])
    values, vectors = np.linalg.eig(first)
    found = values.imag > 1e-3
    vectors = vectors[:len(mass), found].reshape(count, 6, -1)
    along = np.array([[axes[n].T[i] for i in range(3)] for n in range(count)])  # (n, i, xyz)
    moves = np.abs(np.einsum('nim,nij->njm', vectors[:, :3], along))
    share = (moves[:, 2] ** 2).sum(axis=0) / (moves ** 2).sum(axis=(0, 1))
    order = np.argsort(values.imag[found])
    return values.imag[found][order], share[order]


@pytest.fixture(scope='module')
def at_rest():
    values, share = frequencies(scene_along_x())
    return values / (2.0 * np.pi), share


# Euler-Bernoulli: (1.87510, 4.69409, 7.85476)^2 sqrt(EI / (rho A L^4)) / 2 pi at density 7800
@pytest.mark.parametrize(('wanted', 'along_z'), [((7.22, 45.27, 126.8), True),
                                                 ((28.90, 181.1, 507.0), False)])
def test_bending(at_rest, wanted, along_z):
    values, share = at_rest
    mine = values[share > 0.5] if along_z else values[share < 0.5]
    np.testing.assert_allclose(mine[:3], wanted, rtol=5e-3)


def test_torsion_and_stretching(at_rest):
    # f = c / 4 L with c^2 = E / rho, and c^2 = GJ / (rho I_p) for torsion
    scene = scene_along_x()
    b, section = scene.bristle, Cantilever(scene).model.section
    polar = b.density * b.breadth * b.width * (b.breadth ** 2 + b.width ** 2) / 12.0
    for stiff, inertia in ((section.axial, b.density * b.breadth * b.width),
                           (section.torsion, polar)):
        wanted = np.sqrt(stiff / inertia) / (4.0 * b.length)
        assert abs(at_rest[0] / wanted - 1.0).min() < 1e-3


# Flapping of a rotating uniform cantilever, hub radius 0: speed, then frequencies, both times
# sqrt(m L^4 / EI). Wright, Smith, Thresher, Wang (1982), J. Appl. Mech. 49, 197, table 1.
WRIGHT = {0: (3.5160, 22.0345, 61.6972), 2: (4.1373, 22.6149, 62.2732),
          4: (5.5850, 24.2734, 63.9668), 6: (7.3604, 26.8091, 66.6840),
          8: (9.2568, 29.9954, 70.2930), 10: (11.2023, 33.6404, 74.6493),
          12: (13.1702, 37.6031, 79.6145)}


@pytest.mark.parametrize('speed', WRIGHT)
def test_flapping_of_a_spinning_wire(speed):
    scene = scene_along_x(elements=8)
    b = scene.bristle
    unit = np.sqrt(b.youngs_modulus * b.width ** 2 / 12.0 / b.density) / b.length ** 2
    values, share = frequencies(scene, spin=speed * unit)
    np.testing.assert_allclose(values[share > 0.5][:3] / unit, WRIGHT[speed], rtol=5e-3)


@pytest.mark.parametrize('speed', [4, 12])
def test_lagging_of_a_spinning_wire(speed):
    # In the plane of rotation: Southwell's frequency softened by the spin, flap^2 - speed^2
    scene = scene_along_x(elements=8, orientation=0.5 * np.pi)  # weak in that plane
    b = scene.bristle
    unit = np.sqrt(b.youngs_modulus * b.width ** 2 / 12.0 / b.density) / b.length ** 2
    values, share = frequencies(scene, spin=speed * unit)
    wanted = np.sqrt(np.array(WRIGHT[speed]) ** 2 - speed ** 2)
    np.testing.assert_allclose(values[share < 0.5][:3] / unit, wanted, rtol=5e-3)


def test_spin_up():
    # Kane, Ryan, Banerjee (1987), J. Guid. Control Dyn. 10, 139; numbers of Simo, Vu-Quoc (1986),
    # J. Appl. Mech. 53, 855: L = 10, EA = 2.8e7, GA = 1e7, EI = 1.4e4, rho A = 1.2, rho I = 6e-4,
    # to 6 rad/s in 15 s. Largest lag of the tip 0.575, steady elongation 5.14e-4.
    width, breadth = np.sqrt(12.0 * 5e-4), 0.1
    scene = Scene(
        bristle=scene_along_x(length=10.0, breadth=breadth, width=width,
                              youngs_modulus=2.8e7 / (breadth * width),
                              density=1.2 / (breadth * width)).bristle,
        brush=Brush(mount_radius=0.0, mount_angle=np.pi / 2.0, mount_orientation=np.pi / 2.0),
        contact=NO_CONTACT, damping=Damping(mass=0.0, stiffness=0.0), gravity=0.0,
        drive=Drive(profile='constant', mean_speed=0.0),
        solver=Solver(elements=8, integration_time_step=5e-3), run=Run(sample=5e-3))
    simulation = Simulation(scene)
    model = simulation.model
    drive = model.drive._replace(profile=SINE, frequency=1.0 / 15.0,
                                 alternating_speed=-6.0 / (2.0 * np.pi))
    simulation.model = model._replace(
        section=model.section._replace(shear_y=1e7, shear_z=1e7), drive=drive, exact=drive)
    simulation.state.motion[SPEED:SPEED + 5] = 0.0, 0.0, 6.0, 15.0, 0.0
    lag = []
    for _ in range(150):
        simulation.advance(20)
        lag.append(simulation.snapshot().tip_position[0, 1])
    assert simulation.snapshot().omega == pytest.approx(6.0)
    assert min(lag) == pytest.approx(-0.575, abs=5e-3)
    # the profile is over, the mean speed goes on
    steady = drive._replace(alternating_speed=0.0)
    simulation.model = simulation.model._replace(drive=steady, exact=steady)
    stretch, sway = [], []
    for _ in range(100):
        simulation.advance(10)
        x, y, _ = simulation.snapshot().tip_position[0]
        stretch.append(x - 10.0)
        sway.append(y)
    assert max(stretch) == pytest.approx(1.2 * 36.0 * 1000.0 / (3.0 * 2.8e7), rel=0.01)
    assert max(np.abs(sway)) < 5e-3
