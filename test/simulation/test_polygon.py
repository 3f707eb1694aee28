"""What velocities ring by behind a polygon's corners, against runs, and the warning of it."""
from dataclasses import replace
import warnings

import bristle_ros
from bristle_ros.physics.step import generalized_alpha, hht, newmark
from bristle_ros.physics.wire import LANES, ROWS, V0
from bristle_ros.scene import Brush, Contact, Damping, Drive, Run, Scene, Solver
from bristle_ros.simulation import load_steps, ring_of, Simulation
import numpy as np
import pytest

OMEGA, RADIUS, ITS = 10.0, 0.1, 1e-4
PLACE = 0.02    # [m] of the first element's middle along the wire
STRAIGHT_OUT = Scene(
    brush=Brush(mount_angle=np.pi / 2.0, mount_radius=RADIUS), contact=Contact(enabled=False),
    damping=Damping(mass=0.0, stiffness=1.0), gravity=0.0,
    drive=Drive(profile='constant', mean_speed=OMEGA), run=Run(chunk=ITS, sample=ITS))


def polygon(integrator, steps, **keys):
    return replace(STRAIGHT_OUT, solver=Solver(
        load_case='displacement', integration_time_step=ITS, time_step=steps * ITS,
        integrator=integrator, elements=6, **keys))


# with Newmark and an even number the error estimate asks for sub-steps after four corners
@pytest.mark.parametrize(('integrator', 'keys', 'steps', 'corners'), [
    ('generalized_alpha', {'spectral_radius': 0.4}, 10, 41), ('newmark', {}, 10, 3),
    ('newmark', {}, 5, 41), ('hht', {'amplitude_decay': 0.1}, 8, 41)])
def test_a_wire_without_give_rings_as_the_equations_say(integrator, keys, steps, corners):
    """A wire along the radius, as stiff in beta_D as a rod, takes the clamp's jumps as a whole."""
    scene = polygon(integrator, steps, **keys)
    simulation = Simulation(scene)
    jump = RADIUS * OMEGA ** 2 * scene.solver.time_step
    ring = ring_of(simulation.model.scheme, steps, corners)
    # the first chord's jump is half of one
    first = ring_of(simulation.model.scheme, corners * steps, 1).at[-steps:]
    simulation.advance((corners - 1) * steps)
    found = []
    for step in range(steps):
        simulation.advance(1)
        nodes = simulation.state.nodes.reshape(1, -1, ROWS, LANES)
        velocity = nodes[0, 0, V0:V0 + 2, 0]    # of the first element's middle
        middle = OMEGA * scene.solver.time_step * (corners - 0.5)
        turned = OMEGA * ITS * (step + 1 - 0.5 * steps)
        found.append(velocity @ (np.cos(middle), np.sin(middle))
                     + OMEGA * PLACE * np.sin(turned))      # the wire turns about the clamp
    # towards the axis; along the chord the clamp itself has no radial velocity
    np.testing.assert_allclose(found, -jump * (ring.at - 0.5 * first), rtol=1e-3,
                               atol=1e-3 * jump)


def test_rings_are_those_of_the_schemes_at_infinite_frequency():
    for radius in (0.3, 0.8):
        at = ring_of(generalized_alpha(radius, 1e-8), 100, 1).at
        assert abs(at[59] / at[58]) == pytest.approx(radius, rel=0.03)
    nothing = ring_of(generalized_alpha(0.0, 1e-8), 10, 5)
    assert nothing.lasts == 1
    assert np.abs(nothing.at[1:]).max() < 1e-12
    # an even number of steps rings, an odd one hardly does (the paper's integrator)
    even, odd = (abs(ring_of(newmark(0.005, 1e-8), steps, 1000).at[-1]) for steps in (10, 11))
    assert even > 10.0
    assert odd < 0.51
    assert ring_of(hht(0.05, 1e-8), 100, 100).lasts < 100


def test_corners_are_those_of_load_steps_longer_than_its():
    assert load_steps(polygon('newmark', 10)) == 10
    assert load_steps(polygon('newmark', 1)) == 0
    assert load_steps(STRAIGHT_OUT) == 0
    scene = polygon('newmark', 10)
    assert load_steps(replace(scene, solver=replace(scene.solver, load_case='inertia'))) == 0


@pytest.mark.parametrize(('keys', 'said', 'acts'), [
    ({'spectral_radius': 0.0}, 'after 1 of 10 steps less than 1 % is left', False),
    ({'integrator': 'newmark'}, '% of a jump are left at the next corner', True)])
def test_a_run_on_a_polygon_warns(keys, said, acts):
    scene = polygon(**{'integrator': 'generalized_alpha', 'steps': 10, **keys})
    with warnings.catch_warnings(record=True) as caught:
        warnings.simplefilter('always')
        bristle_ros.simulate(scene, 0.05)
    [told] = [one.message for one in caught if one.message.kind == 'polygon corners']
    assert 'the speed of the clamp jumps by up to 0.01 m/s' in str(told)
    assert said in str(told)
    assert told.acts == acts
