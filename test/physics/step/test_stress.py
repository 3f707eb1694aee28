"""Stress at the clamp: closed forms, and extremes against a run that is sampled at every step."""
import math

import bristle_ros
from bristle_ros.physics.step.stress import corner_factors, CORNERS
from bristle_ros.scene.scene import Scene
from bristle_ros.scene.sections import Bristle, Brush, Contact, Damping, Drive, Road, Run, Solver
from bristle_ros.simulation.simulation import Simulation
import numpy as np
from physics.scenes import cantilever_drop, NO_CONTACT, sliding_sweep
import pytest

AREA = 0.002 * 0.0005                       # of the default section [m^2]
MODULUS_Y = 0.002 * 0.0005 ** 2 / 6.0       # section moduli [m^3]: about y, the weak axis
MODULUS_Z = 0.0005 * 0.002 ** 2 / 6.0
WEIGHT = 7800.0 * AREA * 9.81               # [N/m]
LENGTH = 0.24
Y, Z = np.array(CORNERS, dtype=float).T     # signs


def test_a_tip_force_bends_by_force_times_length():
    """F along z at the tip: M = l e_x x F e_z = -F l e_y at the clamp; so too along y, and x."""
    factors = corner_factors(0.002, 0.0005, np.eye(3))

    def stress(force):
        return factors @ np.concatenate((force, np.cross([LENGTH, 0.0, 0.0], force)))
    np.testing.assert_allclose(stress([0.0, 0.0, 2.0]), -2.0 * LENGTH / MODULUS_Y * Z, rtol=1e-12)
    np.testing.assert_allclose(stress([0.0, 2.0, 0.0]), -2.0 * LENGTH / MODULUS_Z * Y, rtol=1e-12)
    np.testing.assert_allclose(stress([2.0, 0.0, 0.0]), np.full(4, 2.0 / AREA), rtol=1e-12)


@pytest.mark.parametrize('gamma', [0.0, 0.7])
def test_gravity_bends_a_stiff_cantilever(gamma):
    """
    Weight q: N = 0, M = q l^2 / 2 downward, however the section is turned about the wire by gamma.

    A thousand times stiffer than steel, so that the moment is that of the straight wire.
    """
    scene = Scene(
        bristle=Bristle(youngs_modulus=2.07e14), contact=NO_CONTACT,
        brush=Brush(mount_radius=0.0, mount_angle=math.pi / 2.0, mount_orientation=gamma),
        drive=Drive(profile='constant', mean_speed=0.0),
        solver=Solver(start='steady', elements=4))
    found = Simulation(scene).snapshot().clamp_stress[0]
    moment = 0.5 * WEIGHT * LENGTH ** 2
    # down is -z of the section at gamma 0; tension lies on top
    wanted = moment * (math.cos(gamma) / MODULUS_Y * Z + math.sin(gamma) / MODULUS_Z * Y)
    np.testing.assert_allclose(found, wanted, rtol=2e-5)


def test_spin_pulls_along_a_radial_wire():
    """The wire along the radius R: N = rho A omega^2 (R l + l^2 / 2), the same at all corners."""
    omega, radius = 30.0, 0.1125
    scene = Scene(
        brush=Brush(mount_radius=radius, mount_angle=math.pi / 2.0), contact=NO_CONTACT,
        damping=Damping(mass=0.0, stiffness=0.0), gravity=0.0,
        drive=Drive(profile='constant', mean_speed=omega),
        solver=Solver(start='steady', elements=4))
    found = Simulation(scene).snapshot().clamp_stress[0]
    wanted = 7800.0 * omega ** 2 * (radius * LENGTH + 0.5 * LENGTH ** 2)
    np.testing.assert_allclose(found, np.full(4, wanted), rtol=1e-6)


@pytest.mark.parametrize(('case', 'within'), [('inertia', 1e-9), ('displacement', 1e-6)])
def test_extremes_are_those_of_a_run_sampled_at_every_step(case, within):
    scene = sliding_sweep(load_case=case, elements=6)
    fine = bristle_ros.simulate(scene, 0.24, sample=1e-4)
    coarse = bristle_ros.simulate(scene, 0.24, sample=0.02)
    assert fine['substeps'][-1] == 0
    each = fine['clamp_stress'].reshape(12, 200, 1, 4)
    scale = abs(each).max()
    for name, extreme in (('clamp_stress_min', np.min), ('clamp_stress_max', np.max)):
        np.testing.assert_allclose(coarse[name], extreme(each, axis=1), rtol=0.0,
                                   atol=within * scale)
    # what samples alone would show is less
    assert (coarse['clamp_stress_max'] - coarse['clamp_stress']).max() > 1e-3 * scale


def test_extremes_see_sub_steps():
    """Steps of 2 ms into a hard road are taken in sub-steps, whose ends count too."""
    scene = Scene(
        brush=Brush(mount_angle=0.4537856), road=Road(penetration=0.02, approach_time=0.02),
        contact=Contact(normal_stiffness=1e5), drive=Drive(profile='constant', mean_speed=10.0),
        solver=Solver(integration_time_step=2e-3, elements=6), run=Run(chunk=2e-3, sample=2e-3))
    found = bristle_ros.simulate(scene, 0.04, sample=2e-3)
    assert found['substeps'][-1] > 20
    ends = np.concatenate((np.zeros((1, 1, 4)), found['clamp_stress']))
    highest = np.maximum(ends[1:], ends[:-1])
    assert (found['clamp_stress_max'] >= found['clamp_stress']).all()
    assert (found['clamp_stress_max'] - highest).max() > 0.05 * abs(ends).max()


def test_a_reset_leaves_no_trace():
    simulation = Simulation(cantilever_drop(elements=2), energies=True)
    simulation.advance(50)
    swung = simulation.snapshot()
    simulation.reset()
    start = simulation.snapshot()
    np.testing.assert_array_equal(start.clamp_stress_max, start.clamp_stress)
    simulation.advance(1)
    assert simulation.snapshot().clamp_stress_max.max() < 0.1 * swung.clamp_stress_max.max()
