"""What Newton's method may end in."""
import math

from bristle_ros.physics.step.newton import has_flipped
from bristle_ros.physics.wire import ELEMENTS, LANES, Q
from bristle_ros.scene.scene import from_parameters
from bristle_ros.simulation.simulation import Simulation
import pytest


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
