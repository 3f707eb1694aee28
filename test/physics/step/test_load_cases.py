"""The displacement load case against the inertia load case, and the paper's polygon (Fig. 4)."""
from dataclasses import replace
import math

from bristle_ros.physics.contact.law import STICK
from bristle_ros.physics.contact.tip import STATE
from bristle_ros.scene.scene import Scene
from bristle_ros.scene.sections import Damping, Drive, Road, Run, Solver, Sweeper
from bristle_ros.simulation.simulation import Simulation
import numpy as np
from physics.scenes import free_rotation, NO_CONTACT, RPM, sliding_sweep, tilted_sweep
import pytest


def displacement(scene, time_step=0.0):
    return replace(scene, solver=replace(scene.solver, load_case='displacement',
                                         time_step=time_step))


def samples(scene, duration, every=1e-3):
    simulation = Simulation(scene)
    found = []
    for _ in range(round(duration / every)):
        simulation.advance(round(every / simulation.its))
        found.append(simulation.snapshot())
    return found


def path(found):
    return np.array([one.tip_position[0] for one in found])


def difference(one, two):
    """Return the difference of two paths, relative to how far the tip moves."""
    return math.sqrt(np.sum((one - two) ** 2) / np.sum((one - one[0]) ** 2))


def test_both_load_cases_give_one_path_and_the_same_reactions():
    # the two are different code paths of one mechanics: what differs is the integrator's error
    inertia = samples(free_rotation(1e-4), 0.2)
    driven = samples(displacement(free_rotation(1e-4)), 0.2)
    assert difference(path(inertia), path(driven)) < 1e-4
    np.testing.assert_allclose(driven[-1].mount_moment, inertia[-1].mount_moment,
                               atol=1e-3 * np.abs(inertia[-1].mount_moment).max())
    np.testing.assert_allclose(driven[-1].tip_orientation, inertia[-1].tip_orientation, atol=2e-4)
    assert driven[-1].theta == inertia[-1].theta


def test_all_bristles_of_a_driven_brush_are_seen_in_the_exact_axes():
    # outputs of the second bristle on came out in the axes of the first one's ramped loads
    scene = free_rotation(1e-4)
    scene = replace(scene, brush=replace(scene.brush, bristle_count=3),
                    solver=replace(scene.solver, elements=6))
    [inertia], [driven] = (samples(each, 0.05, 0.05) for each in (scene, displacement(scene)))
    for name in ('tip_position', 'tip_position_road', 'mount_force', 'brush_torque'):
        ours, theirs = getattr(inertia, name), getattr(driven, name)
        np.testing.assert_allclose(theirs, ours, atol=1e-3 * np.abs(ours).max(), err_msg=name)
    assert driven.omega == inertia.omega


def test_both_load_cases_agree_in_contact_up_to_the_second_impact():
    inertia = samples(tilted_sweep(1e-4, viscosity=1e-3), 0.14)
    driven = samples(displacement(tilted_sweep(1e-4, viscosity=1e-3)), 0.14)
    assert inertia[-1].contact_impulse[0, 2] > 1e-4, 'it has touched the road'
    assert difference(path(inertia), path(driven)) < 1e-3
    assert driven[-1].contact_impulse[0, 2] == pytest.approx(
        inertia[-1].contact_impulse[0, 2], rel=0.01)


def test_a_damped_displacement_run_refers_mass_damping_to_the_turning_clamp():
    # alpha_D 50 1/s would brake a bristle that it saw turning at 16 rad/s within a few ms
    strong = replace(free_rotation(1e-4), damping=Damping(mass=50.0, stiffness=0.0))
    assert difference(path(samples(strong, 0.1)), path(samples(displacement(strong), 0.1))) < 1e-4


@pytest.mark.parametrize('scene', [
    free_rotation(1e-4), free_rotation(1e-4, elements=6), tilted_sweep(1e-4, viscosity=1e-3),
    sliding_sweep(1e-4)])
def test_the_driven_clamp_has_the_energy_accounts_of_the_turning_brush(scene):
    one, two = (Simulation(case, energies=True) for case in (scene, displacement(scene)))
    one.advance(1500)
    two.advance(1500)
    one, two = one.snapshot(), two.snapshot()
    for name in ('energy_kinetic', 'energy_elastic', 'energy_dissipated', 'work_external'):
        assert getattr(two, name) == pytest.approx(
            getattr(one, name), abs=2e-3 * one.work_external), name
    balance = two.energy_kinetic + two.energy_elastic + two.energy_dissipated - two.work_external
    assert abs(balance) < 1e-3 * two.work_external


def paper_figure_4(time_step, its, **solver):
    return Scene(
        contact=NO_CONTACT, damping=Damping(mass=0.1, stiffness=0.021), road=Road(),
        drive=Drive(profile='vap', mean_speed=100.0 * RPM, alternating_speed=5.0 * RPM,
                    frequency=9.0, shape=0.08), run=Run(chunk=1e-3),
        solver=Solver(integration_time_step=its, time_step=time_step, load_case='displacement',
                      **solver))


def peak_damping_force(scene, duration=8e-3, settled=2e-3):
    simulation = Simulation(scene)
    peak = 0.0
    for step in range(round(duration / simulation.its)):
        simulation.advance(1)
        if step * simulation.its > settled:
            peak = max(peak, abs(simulation.snapshot().mount_damping_force[0, 0]))
    return peak


@pytest.mark.parametrize(('time_step', 'its', 'low', 'high'), [
    # the paper prints about 140 N at TS 1 ms; two linear planar models gave 114 N and 107 N at
    # ITS 10 us, and below 0.02 N where TS <= ITS
    (1e-3, 1e-5, 90.0, 180.0), (1e-4, 1e-5, 80.0, 170.0), (1e-5, 1e-5, 0.005, 0.05)])
def test_the_polygon_makes_a_nearly_undamped_integrator_ring(time_step, its, low, high):
    scene = paper_figure_4(time_step, its, integrator='newmark', amplitude_decay=0.005)
    assert low < peak_damping_force(scene) < high


def test_an_annihilating_integrator_does_not_ring():
    # the velocity jump r w^2 TS at a corner is real; without ringing it stays near 1 N
    assert peak_damping_force(paper_figure_4(1e-3, 1e-5, spectral_radius=0.0)) < 3.0


@pytest.mark.parametrize('scene', [free_rotation, sliding_sweep])
def test_the_accounts_of_a_clamp_on_a_polygon_close_as_the_step_shrinks(scene):
    residual = []
    for its in (4e-5, 2e-5, 1e-5):
        simulation = Simulation(displacement(scene(its), time_step=1e-3), energies=True)
        worst = scale = 0.0
        for _ in range(25):
            simulation.advance(round(1e-3 / its))
            now = simulation.snapshot()
            stored = now.energy_kinetic + now.energy_elastic
            scale = max(scale, stored)
            worst = max(worst, abs(stored + now.energy_dissipated - now.work_external))
        residual.append(worst / scale)
    assert residual[2] < residual[1] < residual[0] < 0.012


def mean_torque(**solver):
    simulation = Simulation(sliding_sweep(**solver))
    simulation.advance(2500)    # the approach and what it set off
    torques = []
    for _ in range(250):
        simulation.advance(10)
        torques.append(-simulation.snapshot().brush_torque[2])
    return np.mean(torques), simulation.snapshot()


@pytest.mark.parametrize('time_step', [0.0, 1e-3, 5e-3])
@pytest.mark.parametrize('integrator', ['generalized_alpha', 'newmark', 'hht'])
def test_the_drive_torque_of_a_ringing_scheme_means_something(integrator, time_step):
    """At the corners of the polygon the strain rates ring: their values there have no mean."""
    wanted = mean_torque()[0]
    found, last = mean_torque(load_case='displacement', integrator=integrator,
                              time_step=time_step)
    assert found == pytest.approx(wanted, rel=1e-2)
    if integrator != 'generalized_alpha' and time_step:
        # the damping force keeps the rates of the step's end: figure 4 of the paper is made of it
        assert abs(last.mount_damping_force[0, 2]) > 50.0


def test_a_tip_that_sticks_takes_no_energy_from_load_steps():
    """Stopped at the speed of the loads and not of the places it took 2e-4 J, 4e-4 at half ITS."""
    scene = tilted_sweep(its=2e-6, friction=(1.0, 0.5), time_step=3.2e-3)
    scene = replace(
        scene, brush=replace(scene.brush, start_angle=0.0),
        road=replace(scene.road, approach_time=0.05), sweeper=Sweeper(velocity=(1.5, 0.0)),
        drive=Drive(profile='vap', mean_speed=150.0 * RPM, alternating_speed=4.0 * RPM,
                    frequency=5.0))
    simulation = Simulation(scene, energies=True)
    simulation.advance(1600)
    one = simulation.snapshot()
    assert simulation.state.tip[0, STATE] == STICK
    assert one.energy_kinetic + one.energy_elastic > 5e-3
    assert abs(one.energy_kinetic + one.energy_elastic + one.energy_dissipated
               - one.work_external) < 2e-6
