"""Large deflections against closed forms and published ones."""
from dataclasses import replace

from bristle_ros.physics.wire import layout
from bristle_ros.physics.wire.beam import internal_forces, stiffness
from bristle_ros.scene.scene import Scene
from bristle_ros.scene.sections import Bristle, Brush, Contact, Drive, Road
from bristle_ros.simulation import static_equilibrium
import numpy as np
from physics.beams import Beam, Cantilever, matrix, product, scene_along_x, turn
from physics.scenes import MOUNT_ANGLE, RPM
import pytest


POINTS, WEIGHTS = np.polynomial.legendre.leggauss(100)


def integral(function, end):
    """Return the integral of a smooth function from 0 to end (Gauss)."""
    x, w = POINTS, WEIGHTS
    return 0.5 * end * (w @ function(0.5 * end * (x + 1.0)))


def elastica(load):
    """
    Return tip deflection, shortening and slope of an inextensible cantilever, relative to length.

    load = P L^2 / EI, across the undeformed wire. Bisshopp, Drucker (1945), Q. Appl. Math. 3, 272:
    with k^2 = (1 + sin t) / 2 and sin(phi) = 1 / (k sqrt 2), sqrt(load) = K(k) - F(phi, k).
    """
    root = np.sqrt(load)

    def parts(k):
        phi = np.arcsin(min(1.0, 1.0 / (k * np.sqrt(2.0))))
        first = [integral(lambda a: 1.0 / np.sqrt(1.0 - (k * np.sin(a)) ** 2), end)
                 for end in (0.5 * np.pi, phi)]
        second = [integral(lambda a: np.sqrt(1.0 - (k * np.sin(a)) ** 2), end)
                  for end in (0.5 * np.pi, phi)]
        return first[0] - first[1], second[0] - second[1]

    low, high = np.sqrt(0.5), 1.0 - 1e-9
    for _ in range(60):
        middle = 0.5 * (low + high)
        low, high = (middle, high) if parts(middle)[0] < root else (low, middle)
    slope = np.arcsin(2.0 * low ** 2 - 1.0)
    return (1.0 - 2.0 / root * parts(low)[1], 1.0 - np.sqrt(2.0 * np.sin(slope)) / root, slope)


# Mattiasson (1981), Int. J. Numer. Meth. Eng. 17, 145, table I: w / L, u / L, slope [rad]
MATTIASSON = {1.0: (0.30172, 0.05643, 0.46135), 2.0: (0.49346, 0.16064, 0.78175),
              5.0: (0.71379, 0.38763, 1.21537), 10.0: (0.81061, 0.55500, 1.43029)}


@pytest.mark.parametrize('load', MATTIASSON)
def test_elastica(load):
    wanted = elastica(load)
    np.testing.assert_allclose(wanted, MATTIASSON[load], atol=6e-6)
    scene = scene_along_x()
    wire = Cantilever(scene)
    length = scene.bristle.length
    stiff = wire.model.section.bending_y
    tip, q = wire.settle([0.0, 0.0, load * stiff / length ** 2, 0.0, 0.0, 0.0])
    along = matrix(q)[:, 0]
    ours = (tip[2] / length, 1.0 - tip[0] / length, np.arctan2(along[2], along[0]))
    np.testing.assert_allclose(ours, wanted, atol=1e-4)
    assert abs(tip[1]) < 1e-12


def test_order_of_the_static_error_in_space():
    # Superconvergent nodes: order 4 where the load is transmitted exactly.
    wanted = elastica(5.0)[0]
    errors = []
    sizes = np.array([4, 6, 8, 12, 16])
    for elements in sizes:
        wire = Cantilever(scene_along_x(elements=int(elements), width=1e-4))
        load = 5.0 * wire.model.section.bending_y / 0.24 ** 2
        errors.append(abs(wire.settle([0.0, 0.0, load, 0.0, 0.0, 0.0])[0][2] / 0.24 - wanted))
    assert min(errors) > 1e-8, 'the finest error is round-off: start coarser'
    order = -np.polyfit(np.log(sizes), np.log(errors), 1)[0]
    assert order == pytest.approx(4.0, abs=0.3)


@pytest.mark.parametrize('axis', [4, 5])
@pytest.mark.parametrize('part', [0.25, 1.0])
def test_end_moment_rolls_the_wire_into_a_circle(axis, part):
    # Euler: curvature M / EI everywhere. The weak and the strong axis.
    scene = scene_along_x()
    wire = Cantilever(scene)
    length = scene.bristle.length
    stiff = stiffness(wire.model.section)[axis]
    load = np.zeros(6)
    load[axis] = part * 2.0 * np.pi * stiff / length
    tip, q = wire.settle(load)
    angle = part * 2.0 * np.pi
    radius = length / angle
    across = radius * (1.0 - np.cos(angle)) * (-1.0 if axis == 4 else 1.0)
    wanted = np.zeros(3)
    wanted[0], wanted[2 if axis == 4 else 1] = radius * np.sin(angle), across
    assert np.linalg.norm(tip - wanted) < 2e-4 * length
    axis_vector = np.eye(3)[axis - 3] * angle
    np.testing.assert_allclose(matrix(q), matrix(turn(axis_vector)), atol=1e-3)


@pytest.mark.parametrize('elements', [1, 2, 12])
@pytest.mark.parametrize('width', [5e-4, 1e-5])
def test_slender_wires_do_not_lock(elements, width):
    # P L^3 / 3 EI + P L / kGA, slenderness 480 and 24000; a locking element errs by its square.
    scene = scene_along_x(elements=elements, width=width)
    wire = Cantilever(scene)
    section, length = wire.model.section, scene.bristle.length
    load = 1e-4 * 3.0 * section.bending_y / length ** 2
    tip, _ = wire.settle([0.0, 0.0, load, 0.0, 0.0, 0.0])
    wanted = load * (length ** 3 / (3.0 * section.bending_y) + length / section.shear_z)
    assert tip[2] == pytest.approx(wanted, rel=1e-6)


def test_torsion_and_tension():
    wire = Cantilever(scene_along_x())
    section = wire.model.section
    tip, q = wire.settle([100.0, 0.0, 0.0, 1e-4, 0.0, 0.0])
    assert tip[0] == pytest.approx(0.24 * (1.0 + 100.0 / section.axial), rel=1e-12)
    # stretched and twisted, each as if alone: the twist is M L / GJ
    assert 2.0 * np.arctan2(q[1], q[0]) == pytest.approx(1e-4 * 0.24 / section.torsion, rel=1e-4)


def rod_tip(curvature, stiff, length, force, steps=40):
    """
    Return the tip of a curved rod under a dead force at its end, by shooting.

    The Simo-Reissner equations x' = R (e_1 + C_n^-1 R^T n), q' = q kappa / 2, m' = -x' x n with
    n = force, m(tip) = 0 are integrated by Runge-Kutta from the clamp; Newton finds m(clamp).
    """
    def slope(y):
        q, m = y[3:7], y[7:]
        axes = matrix(q / np.linalg.norm(q))
        tangent = axes @ (axes.T @ force / stiff[:3] + [1.0, 0.0, 0.0])
        kappa = axes.T @ m / stiff[3:] + curvature
        return np.concatenate((tangent, 0.5 * product(q, np.concatenate(([0.0], kappa))),
                               -np.cross(tangent, force)))

    def shoot(moment):
        y = np.concatenate((np.zeros(3), [1.0, 0.0, 0.0, 0.0], moment))
        h = length / steps
        for _ in range(steps):
            a = slope(y)
            b = slope(y + 0.5 * h * a)
            c = slope(y + 0.5 * h * b)
            y = y + h / 6.0 * (a + 2.0 * b + 2.0 * c + slope(y + h * c))
        return y

    moment = np.zeros(3)
    for part in (0.3, 0.7, 1.0):
        whole = force
        force = part * whole
        for _ in range(6):
            left = shoot(moment)[7:]
            jacobian = np.array([(shoot(moment + 10.0 * e)[7:] - left) / 10.0
                                 for e in np.eye(3)]).T
            moment = moment - np.linalg.solve(jacobian, left)
        force = whole
    y = shoot(moment)
    assert abs(y[7:]).max() < 1e-4
    return y[:3]


def test_45_degree_bend():
    # Bathe, Bolourchi (1979), Int. J. Numer. Meth. Eng. 14, 961: radius 100, unit square section,
    # E = 1e7, G = E / 2, force 600 out of the plane. Torsion constant 1/6 as Simo, Vu-Quoc (1986),
    # Comput. Meth. Appl. Mech. Eng. 58, 79, have it.
    elements, radius, angle = 8, 100.0, np.pi / 4.0
    scene = scene_along_x(elements=elements, length=10.0)
    wire = Cantilever(scene)
    ei = 1e7 / 12.0
    length = radius * angle
    section = wire.model.section._replace(
        axial=1e7, shear_y=5e6, shear_z=5e6, torsion=ei, bending_y=ei, bending_z=ei,
        element_length=length / elements)
    wire.model = wire.model._replace(section=section)
    arc = []
    for n in range(2 * elements + 1):
        turned = angle * n / (2 * elements)
        arc.append((radius * np.array([np.sin(turned), 1.0 - np.cos(turned), 0.0]),
                    turn([0.0, 0.0, turned])))
    bend = Beam(arc, section)
    bend.rows[:, layout.X0:layout.X0 + 7] = bend.rows[:, layout.X:layout.X + 7]
    strain = bend.rows[:, layout.STRAIN:layout.STRAIN + 6].copy()
    bend.rows[:, layout.STRESS0:layout.STRESS0 + 6] = (
        -np.array(stiffness(section))[None, :, None] * strain)
    bend.rows[:, layout.MASS] = 1.0
    wire.s[...] = bend.s
    internal_forces(bend.s, bend.blocks, np.concatenate(arc[0]), section, 1.0, 0.0)
    assert abs(bend.points(layout.STRESS)).max() < 1e-9 * ei
    tip, _ = wire.settle([0.0, 0.0, 600.0, 0.0, 0.0, 0.0])
    # their axes: y along the clamped tangent, x towards the centre
    ours = np.array([tip[1], tip[0], tip[2]])
    # of coarse meshes, to 0.3 % of the length
    np.testing.assert_allclose(ours, [15.9, 47.2, 53.4], atol=0.24)        # Bathe, Bolourchi
    np.testing.assert_allclose(ours, [15.79, 47.23, 53.37], atol=0.24)     # Simo, Vu-Quoc
    exact = rod_tip(np.array([0.0, 0.0, 1.0 / radius]), np.array(stiffness(section)), length,
                    np.array([0.0, 0.0, 600.0]))
    np.testing.assert_allclose(tip, exact, atol=2e-3)


# A chain of 48 rigid links with springs, density 7850, friction and dynamics off: computed apart
# from this project. Attack angle [deg], rpm: normal force [N] at 10, 20, 30, 40, 50 mm.
FORCES = {
    (0, 0): (0.0432, 0.0662, 0.0830, 0.0965, 0.1079),
    (0, 100): (0.0182, 0.0444, 0.0636, 0.0790, 0.0920),
    (0, 150): (0.0, 0.0170, 0.0392, 0.0570, 0.0721),
    (10, 0): (0.0723, 0.0997, 0.1168, 0.1295, 0.1401),
    (10, 100): (0.0405, 0.0744, 0.0955, 0.1112, 0.1239),
    (10, 150): (0.0002, 0.0426, 0.0689, 0.0882, 0.1038)}
# rise of the free tip along the road's normal, and its radius on the level road [mm]
RISES = [(0, 0, -1.36, 214.9), (0, 60, 0.79, 219.3), (0, 100, 4.93, 227.2), (0, 140, 11.77, 238.7),
         (0, 150, 13.96, 242.1), (10, 0, -0.54, None), (10, 100, 3.58, None),
         (10, 150, 9.97, None)]


def brush(attack, rpm, penetration, contact=True):
    return Scene(
        bristle=Bristle(density=7850.0), brush=Brush(mount_angle=MOUNT_ANGLE),
        contact=Contact(enabled=contact, normal_stiffness=1e7),
        road=Road(attack_angle=np.radians(attack), penetration=penetration),
        drive=Drive(profile='constant', mean_speed=rpm * RPM))


@pytest.mark.parametrize(('attack', 'rpm'), FORCES)
def test_quasi_static_normal_force(attack, rpm):
    for depth, wanted in zip((0.01, 0.02, 0.03, 0.04, 0.05), FORCES[attack, rpm]):
        ours = static_equilibrium(brush(attack, rpm, depth)).normal_force[0]
        assert ours == pytest.approx(wanted, rel=0.01, abs=2e-4)


@pytest.mark.parametrize(('attack', 'rpm', 'rise', 'radius'), RISES)
def test_rise_of_the_free_tip(attack, rpm, rise, radius):
    tip = static_equilibrium(brush(attack, rpm, 0.0, contact=False)).tip_position[0]
    length, beta = 0.24, np.radians(attack)
    straight = np.array([0.1125 + length * np.sin(MOUNT_ANGLE), 0.0,
                         -length * np.cos(MOUNT_ANGLE)])
    normal = np.array([-np.sin(beta), 0.0, np.cos(beta)])
    assert 1e3 * (tip - straight) @ normal == pytest.approx(rise, rel=0.01, abs=0.02)
    if radius is not None:
        assert 1e3 * np.hypot(tip[0], tip[1]) == pytest.approx(radius, abs=0.1)


def test_equilibrium_does_not_depend_on_the_road_being_stiff_or_rigid():
    scene = brush(0, 100, 0.03)
    stiff = static_equilibrium(scene)
    road = replace(scene.contact, normal_stiffness=np.inf)
    rigid = static_equilibrium(replace(scene, contact=road))
    assert rigid.normal_force == pytest.approx(stiff.normal_force, rel=1e-6)
    assert rigid.tip_position[0, 2] == pytest.approx(stiff.tip_position[0, 2], abs=1e-8)
