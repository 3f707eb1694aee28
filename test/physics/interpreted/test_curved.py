"""The tip on surfaces that are planes, against the same planes without a surface."""
import math

from bristle_ros.scene.scene import from_parameters, tip_depth
from bristle_ros.simulation.simulation import Simulation
import numpy as np
import pytest

SLOPE = 0.15
STEPS = 40
BASE = {
    'friction.static': 0.5, 'friction.kinetic': 0.3, 'friction.decay': 0.4,
    'damping.stiffness': 1e-3, 'drive.profile': 'constant', 'drive.mean_speed': 10.47,
    'solver.elements': 2, 'solver.integration_time_step': 5e-4, 'run.chunk': 5e-4,
    'road.approach_time': 0.0, 'gravity': 0.0, 'brush.start_angle': 4.75,
    'solver.largest_error': 2e-4}     # the default depends on the road


def end_of(given, **more):
    simulation = Simulation(from_parameters(
        BASE | given | {key.replace('__', '.'): value for key, value in more.items()}, 'test'),
        energies=True)
    simulation.advance(STEPS)
    return simulation.snapshot()


@pytest.mark.parametrize('stiffness', [2e3, math.inf], ids=['spring', 'rigid'])
@pytest.mark.parametrize('friction', [0.3, 3.0], ids=['slip', 'stick'])
def test_an_inclined_plane_is_a_level_one_seen_from_a_tilted_brush(tmp_path, stiffness, friction):
    file = tmp_path / 'plane.csv'
    file.write_text('\n'.join(f'{x},{x * math.tan(SLOPE)!r}' for x in (-20.0, 20.0)))
    given = {'contact.normal_stiffness': stiffness, 'friction.kinetic': friction,
             'friction.static': max(0.5, friction)}
    level = BASE | {'road.attack_angle': SLOPE, 'road.penetration': 0.03}
    distance = tip_depth(from_parameters(level, 'test')) - 0.03
    deep = tip_depth(from_parameters(BASE, 'test')) - distance / math.cos(SLOPE)
    one = end_of(level | given)
    other = end_of(given, road__penetration=deep, profile__kind='file', profile__file=str(file))
    assert np.abs(one.contact_impulse).max() > 1e-4, 'it has touched'
    np.testing.assert_allclose(one.tip_position, other.tip_position, rtol=0.0, atol=1e-11)
    c, s = math.cos(SLOPE), math.sin(SLOPE)
    turned = one.contact_impulse[0] @ np.array(((c, 0.0, s), (0.0, 1.0, 0.0), (-s, 0.0, c)))
    np.testing.assert_allclose(other.contact_impulse[0], turned, rtol=0.0,
                               atol=1e-9 * np.abs(turned).max())
    assert other.energy_dissipated == pytest.approx(one.energy_dissipated, rel=1e-9)
