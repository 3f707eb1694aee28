"""What Newton's method may end in."""
import math

from bristle_ros.physics.step.newton import has_flipped
from bristle_ros.physics.step.scheme import generalized_alpha, hht, newmark, newton_tolerance
from bristle_ros.physics.wire import ELEMENTS, LANES, Q
from bristle_ros.scene.scene import from_parameters
from bristle_ros.simulation.simulation import Simulation
import numpy as np
from physics.scenes import sliding_sweep
import pytest

APART = {'newton': 'tolerance', 'tolerance': 1e-8}      # what held before errors decided


@pytest.mark.parametrize('elements', [1, 7, 12])
@pytest.mark.parametrize('load_case', ['inertia', 'displacement'])
def test_a_node_that_turned_too_far_is_seen(elements, load_case):
    """Whatever node it is; where axes do not turn with the brush they may turn as they like."""
    simulation = Simulation(from_parameters({
        'solver.elements': elements, 'solver.load_case': load_case, 'contact.enabled': False},
        'test'))
    simulation.advance(1)
    nodes, model = simulation.state.nodes[0], simulation.model
    assert not has_flipped(nodes, model)
    for element in range(elements):
        for lane in (element % ELEMENTS, ELEMENTS + element % ELEMENTS):
            row = nodes[element // ELEMENTS]
            before = [row[(Q + i) * LANES + lane] for i in range(4)]
            for angle, far in ((0.9, False), (1.2, True), (-3.0, True), (6.2, False)):
                c, s = math.cos(0.5 * angle), math.sin(0.5 * angle)
                a, b, d, e = before
                turned = (c * a - s * d, c * b + s * e, c * d + s * a, c * e - s * b)
                for i in range(4):
                    row[(Q + i) * LANES + lane] = turned[i]
                assert has_flipped(nodes, model) == (far and load_case == 'inertia')
            for i in range(4):
                row[(Q + i) * LANES + lane] = before[i]


@pytest.mark.parametrize(('error', 'wanted'), [(0.0, 1e-8), (5e-8, 1e-8), (5e-7, 5e-8),
                                               (1.0, 1e-6)])
def test_a_tenth_of_the_local_error_is_enough(error, wanted):
    """Between 1e-8 and the scene's tolerance, which fall with the square of short steps."""
    scheme = generalized_alpha(0.8, 1e-6)
    assert newton_tolerance(scheme, 1e-3, error) == pytest.approx(wanted, rel=1e-12)
    assert newton_tolerance(scheme, 1e-4, error / 4.0) == pytest.approx(wanted / 4.0, rel=1e-12)
    assert newton_tolerance(generalized_alpha(0.8, 1e-9), 1e-3, error) == 1e-9
    assert newton_tolerance(generalized_alpha(0.8, 1e-6, False), 1e-3, error) == 1e-6


@pytest.mark.parametrize('scheme', [generalized_alpha(1.0, 1e-6), hht(0.0, 1e-6),
                                    newmark(0.0, 1e-6)])
def test_what_newton_leaves_does_not_feed_on_itself(scheme):
    """A scheme that keeps what is left of a correction would find it in the next estimate."""
    assert newton_tolerance(scheme, 1e-3, 1.0) == 1e-8


def swept(**solver):
    """Return a sweep's tip path [m] while it hits the road and settles, and iterations a step."""
    simulation = Simulation(sliding_sweep(**solver))
    every, tips = round(2e-3 / simulation.its), []
    for _ in range(150):
        simulation.advance(every)
        tips.append(simulation.snapshot().tip_position[0])
    before = simulation.snapshot().newton_iterations
    simulation.advance(1000)
    return np.array(tips), (simulation.snapshot().newton_iterations - before) / 1000


def test_a_correction_to_each_step_of_a_steady_sweep_and_no_error_for_it():
    """The contact force is expected to turn with the brush; expected to stay it took 1.9."""
    exact, _ = swept(its=2e-5, **APART)
    (tied, few), (fixed, _) = swept(), swept(**APART)
    worst = [np.linalg.norm(tips - exact, axis=1).max() for tips in (tied, fixed)]
    assert worst[0] < 1.5 * worst[1]
    assert few < 1.3
