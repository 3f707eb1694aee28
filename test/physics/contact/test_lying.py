"""A wire that lies on the road against the closed forms of the elastica."""
import math

import bristle_ros
import numpy as np
import pytest
from scipy.integrate import quad

from bristle_ros.physics.contact.point import ALIVE, XI
from bristle_ros.physics.contact.tip import FORCE

QUIET = {
    # no weight, no friction, no turning: what is left is the elastica, as fast as it may settle
    'gravity': 0.0, 'friction.static': 0.0, 'friction.kinetic': 0.0, 'drive.profile': 'constant',
    'drive.mean_speed': 0.0, 'damping.mass': 150.0, 'damping.stiffness': 0.0,
    'contact.normal_stiffness': math.inf, 'solver.integration_time_step': 1e-4,
    'solver.time_step': 0.0, 'brush.start_angle': 0.0, 'run.chunk': 0.01, 'run.sample': 0.01}


def pressed(elements, mount_angle, penetration, length=0.240):
    """Return force [N], place of its centroid along the wire [m] and EI of a wire at rest."""
    scene = bristle_ros.load('config/cutting_brush.yaml', {
        **QUIET, 'solver.elements': elements, 'brush.mount_angle': mount_angle,
        'bristle.length': length, 'road.penetration': penetration, 'road.approach_time': 0.3})
    simulation = bristle_ros.build(scene)
    simulation.advance(6000)
    points = simulation.state.points[0]
    used = points[:, ALIVE] > 0.0
    force = points[used, FORCE + 2]
    place = (np.flatnonzero(used) + 0.5 * (1.0 + points[used, XI])) * length / elements
    total = simulation.snapshot().contact_force[0, 2]
    tip = simulation.snapshot().tip_force[0, 2]
    assert math.isclose(total, force.sum() + tip, rel_tol=1e-12)
    return total, (place @ force + length * tip) / total, simulation.model.section.bending_y


def deep(mount_angle, penetration, length=0.240):
    """Return the closed form for any deflection: height of the clamp, and P / EI [1/m^2]."""
    alpha = 0.5 * math.pi - mount_angle
    height = length * math.cos(mount_angle) - penetration
    whole = quad(lambda a: math.sqrt(math.sin(a)), 0.0, alpha)[0]
    return height, 0.5 * (whole / height) ** 2


@pytest.mark.parametrize('elements', [12, 24])
def test_the_elastica_pressed_flat(elements):
    """P = EI / (2 H^2) (integral of sqrt(sin) from 0 to alpha)^2, lift-off at 160.0 mm."""
    force, place, bending = pressed(elements, math.radians(26.0), 0.16)
    wanted = bending * deep(math.radians(26.0), 0.16)[1]
    assert math.isclose(wanted, 0.39307, rel_tol=1e-4)
    assert math.isclose(force, wanted, rel_tol=5e-3 * (12 / elements) ** 2)
    assert math.isclose(place, 0.1600, abs_tol=5e-4)


def test_its_error_falls_with_the_square_of_the_element():
    wanted = deep(math.radians(26.0), 0.16)[1]
    errors = []
    for elements in (6, 12, 24):
        force, _, bending = pressed(elements, math.radians(26.0), 0.16)
        errors.append(abs(force / bending / wanted - 1.0))
    order = -np.polyfit(np.log([6, 12, 24]), np.log(errors), 1)[0]
    assert order > 1.5, errors


def test_a_wire_pressed_flat_at_small_deflection():
    """P = 2/9 EI alpha^3 / H^2 with its lift-off at 3 H / alpha, clamp at H, alpha to the road."""
    alpha, height = 0.1, 0.1 * 0.16 / 3.0
    force, place, bending = pressed(12, 0.5 * math.pi - alpha, 0.24 * math.sin(alpha) - height)
    # the closed form is that of small angles: alpha^2 / 10 or so
    assert math.isclose(force, 2.0 / 9.0 * bending * alpha ** 3 / height ** 2, rel_tol=5e-3)
    assert math.isclose(place, 3.0 * height / alpha, rel_tol=2e-2)
