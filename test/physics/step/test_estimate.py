"""The local error estimate against the true local error; adaptive steps; steady starts; ramps."""
from dataclasses import replace
import math

from bristle_ros.physics.contact.tip import ESTIMATE, MATRIX_STEP
from bristle_ros.physics.wire.layout import LANES, MASS, ROWS, X
from bristle_ros.scene.sections import Damping, Drive, Solver
from bristle_ros.simulation.simulation import Simulation
import numpy as np
from physics.scenes import free_rotation, RPM, run, sliding_sweep, tilted_sweep
import pytest

FINE = 64


def true_local_error(coarse, fine):
    """Take one step with each, from the state of `coarse`; return the root mean square [m]."""
    for source, into in zip(coarse.state, fine.state):
        into[...] = source
    fine.state.step[0] = coarse.step * FINE
    fine.state.tip[0, MATRIX_STEP] = 0.0
    coarse.advance(1)
    fine.advance(FINE)
    one = coarse.state.nodes[0].reshape(-1, ROWS, LANES)
    two = fine.state.nodes[0].reshape(-1, ROWS, LANES)
    square = ((one[:, X:X + 3] - two[:, X:X + 3]) ** 2).sum(axis=1)
    mass = np.where(square > 0.0, one[:, MASS], 0.0)
    return math.sqrt((mass * square).sum() / mass.sum())


def ratios(make, its, duration, count, seed):
    coarse, fine = Simulation(make(its)), Simulation(make(its / FINE))
    last = round(duration / its)
    for step in np.sort(np.random.default_rng(seed).choice(np.arange(20, last), count, False)):
        coarse.advance(int(step) - coarse.step)
        true = true_local_error(coarse, fine)
        yield coarse.state.tip[0, ESTIMATE] / true


@pytest.mark.parametrize(('make', 'its', 'duration'), [
    pytest.param(free_rotation, 1e-3, 0.3, id='free rotation 1 ms'),
    pytest.param(free_rotation, 2e-4, 0.3, id='free rotation 0.2 ms'),
    pytest.param(lambda its: free_rotation(its, viscosity=0.021), 1e-3, 0.3, id='stiff damping'),
    pytest.param(lambda its: sliding_sweep(its, viscosity=1e-3), 2e-4, 0.4, id='sliding'),
    pytest.param(lambda its: tilted_sweep(its, viscosity=1e-3), 2e-4, 0.3, id='tilted')])
def test_the_estimate_tracks_the_true_local_error(make, its, duration):
    # 12 steps of each of 5 scenes; an impact inside the step may fool it, so one in 12 may miss
    found = np.array(list(ratios(make, its, duration, 12, seed=3)))
    assert np.median(found) == pytest.approx(1.0, abs=0.25)
    assert np.sum((found > 1.0 / 3.0) & (found < 3.0)) >= 11, found


def adaptive(scene, its, tolerance):
    return replace(scene, solver=replace(scene.solver, integration_time_step=its, step='adaptive',
                                         error_tolerance=tolerance))


def test_adaptive_steps_meet_their_marks_and_the_error_follows_the_tolerance():
    exact = run(free_rotation(2e-5), 0.1)
    errors = []
    for tolerance in (1e-6, 1e-8):
        found = run(adaptive(free_rotation(), 1e-3, tolerance), 0.1)
        assert len(found.t) == 100
        assert found.substeps > 0
        errors.append(np.abs(found.tip - exact.tip).max())
    assert errors[1] < 0.2 * errors[0] < 2e-5


def test_adaptive_steps_do_not_depend_on_chunks():
    scene = adaptive(tilted_sweep(viscosity=1e-3), 1e-3, 1e-6)
    one, many = Simulation(scene), Simulation(scene)
    one.advance(150)
    for _ in range(50):
        many.advance(3)
    assert one.state.nodes.tobytes() == many.state.nodes.tobytes()


def test_a_steady_start_stays_where_it_is():
    # from the equilibrium of constant spin without friction nothing moves
    scene = free_rotation(1e-4, start='steady')
    scene = replace(scene, drive=Drive(profile='constant', mean_speed=150.0 * RPM))
    simulation = Simulation(scene)
    before = simulation.snapshot().tip_position
    simulation.advance(500)
    assert np.abs(simulation.snapshot().tip_position - before).max() < 1e-7
    straight = Simulation(replace(scene, solver=replace(scene.solver, start='straight')))
    assert np.abs(straight.snapshot().tip_position - before).max() > 1e-2


def test_a_commanded_jump_within_one_step_turns_the_bristle_as_it_should():
    # a jump of the speed is an impulse: a bristle without stiffness left to itself keeps its
    # inertial velocity, so that relative to the brush it gets -d_omega x r at once
    scene = replace(free_rotation(1e-4), drive=Drive(
        profile='constant', mean_speed=0.0, max_acceleration=1e9), gravity=0.0,
        damping=Damping(mass=0.0, stiffness=0.0), solver=Solver(integration_time_step=1e-4))
    simulation = Simulation(scene)
    simulation.advance(10)
    before = simulation.snapshot().tip_position[0].copy()
    simulation.command('cmd_brush_speed', (20.0,))
    simulation.advance(3)
    assert simulation.snapshot().omega == 20.0
    moved = simulation.snapshot().tip_position[0] - before
    # the tip of a 240 mm wire does not know of the clamp within 0.3 ms
    expected = -20.0 * 2.5e-4 * before[0]
    assert moved[1] == pytest.approx(expected, rel=0.25)
