"""The surface that the campaign checks against, and that its checks on surfaces see."""
import math

from bristle_ros.physics.contact.surface import gap_at
from bristle_ros.report.stability import campaign, cases as campaign_cases, surfaces
from bristle_ros.report.stability.checks import Watch
from bristle_ros.report.stability.contact_checks import points_between
from bristle_ros.report.ground import Ground, mount_to_road
from bristle_ros.scene.scene import from_parameters
from bristle_ros.simulation.simulation import Simulation
from bristle_ros.simulation.surface import surface_of
import numpy as np
import pytest

GUTTER = {'gutter.enabled': True}
EDGE = {**GUTTER, 'gutter.kerb_height': -0.08, 'gutter.channel_slope': 0.2}
SPLINE = {'profile.kind': 'file', 'profile.file': 'data:-1,0;-0.5,0.01;0,-0.02;0.3,0;1,0.02'}


@pytest.mark.parametrize('keys', [
    pytest.param(GUTTER, id='kerb'), pytest.param(EDGE, id='edge'),
    pytest.param({**GUTTER, 'profile.kind': 'sine'}, id='sum'),
    pytest.param({**EDGE, 'profile.kind': 'iso8608'}, id='rough edge'),
    pytest.param(SPLINE, id='spline')])
def test_two_surfaces_from_the_same_keys_are_one(keys):
    scene = from_parameters(keys, 'test')
    ground, surface, sums = Ground(scene), surface_of(scene), np.zeros(16)
    draw = np.random.default_rng(5)
    points = draw.uniform((-1.2, -0.2, 0.0), (1.2, 0.5, 0.0), (2000, 3))
    apart = draw.choice((-1.0, 1.0), 2000) * 10.0 ** draw.uniform(-9.0, -2.5, 2000)
    points[:, 2] = ground.profile(points[:, 0])[0] + ground.section(points[:, 1])[0] + apart
    gaps, normals = ground.gap(points)
    theirs = np.array([gap_at(surface, *point, sums)[:4] for point in points])
    assert gaps == pytest.approx(theirs[:, 0], abs=1e-14)
    assert normals == pytest.approx(theirs[:, 1:], abs=1e-12)
    assert (np.sign(gaps) == np.sign(apart)).all()
    assert ground.inside(points) == pytest.approx(-apart, abs=1e-15)


def test_a_place_is_the_tilted_one():
    scene = from_parameters({'road.attack_angle': 0.2, 'road.tilt_azimuth': 0.7}, 'test')
    simulation = Simulation(scene)
    simulation.advance(100)
    snapshot = simulation.snapshot()
    turn = mount_to_road(scene.road, 0.0)
    assert simulation.centreline()[0, -1] @ turn.T == pytest.approx(
        snapshot.tip_position_road[0], abs=1e-15)


def test_points_between_lie_on_the_parabola():
    s = np.linspace(0.0, 2.0, 5)
    line = np.stack((s, s ** 2, 0.0 * s), axis=-1)[None]
    points = points_between(line)[0]
    assert len(points) == 2 * 8 + 1
    assert points[:, 1] == pytest.approx(points[:, 0] ** 2, abs=1e-15)
    assert points[-1] == pytest.approx(line[0, -1])


def on_kerb(changes=None):
    """Return the watch of a wire that rubs along a kerb, and outputs before and after a step."""
    case = campaign_cases.make_case('', 'level', {
        'road.penetration': 0.05, 'gutter.enabled': True, 'gutter.kerb_distance': 0.19,
        'brush.start_angle': 0.6, **(changes or {})}, 0.1)
    scene = from_parameters(case.parameters, 'test')
    simulation = Simulation(scene, energies=True)
    watch = Watch(scene, simulation)
    watch.look(simulation.snapshot())
    while simulation.step * simulation.its < 0.2:
        simulation.advance(10)
        before = simulation.snapshot()
        watch.before_step(before)
        simulation.advance(1)
        now = simulation.snapshot()
        if now.substeps == before.substeps and before.tip_position_road[0, 1] > 0.19 and (
                now.contact_force[0, 1] < -0.05):
            return watch, before, now
    raise AssertionError('the wire has not come to the kerb')


def with_forces(snapshot, change):
    """Return outputs whose forces are changed."""
    return snapshot._replace(contact_force=change(snapshot.contact_force),
                             tip_force=change(snapshot.tip_force))


@pytest.mark.parametrize(('spoil', 'word'), [
    (lambda s: with_forces(s, lambda f: f * (1.0, -1.0, 1.0)), 'the road pulls'),
    (lambda s: with_forces(s, lambda f: -f), 'the road pulls'),
    (lambda s: with_forces(s, lambda f: f * 1.1), 'the penetration explains'),
    (lambda s: with_forces(s, lambda f: f + (3.0, 0.0, 0.0)), 'outside its cone'),
    (lambda s: s._replace(tip_position_road=s.tip_position_road + (0.0, 1e-4, 0.0)),
     'the penetration explains')])
def test_a_spoilt_output_on_a_kerb_is_seen(spoil, word):
    watch, _, snapshot = on_kerb()
    watch.look(snapshot, stepped=True)
    assert watch.wrong == []
    watch.look(spoil(snapshot), stepped=True)
    assert word in ' '.join(watch.wrong)


def test_a_wire_inside_is_seen():
    watch, _, snapshot = on_kerb()
    # a road that is a centimetre higher than the one that the wire has met
    watch._contact._depth -= 0.01
    watch.look(snapshot, stepped=True)
    assert 'wire 0 is 0.00' in ' '.join(watch.wrong)


def test_work_from_nowhere_is_seen():
    watch, before, snapshot = on_kerb({'friction.static': 0.0, 'friction.kinetic': 0.0})
    watch.look(snapshot, stepped=True)
    assert watch.wrong == []
    moved = snapshot.tip_position_road - before.tip_position_road
    ahead = 1e-3 * np.linalg.norm(snapshot.contact_force) * moved / np.linalg.norm(moved)
    watch.look(with_forces(snapshot, lambda force: force + ahead), stepped=True)
    assert 'from nowhere' in ' '.join(watch.wrong)


def test_a_clamp_that_is_steered_into_the_kerb_is_a_stop():
    case = campaign_cases.make_case('steered', 'level', {
        'gutter.enabled': True, 'gutter.kerb_distance': 0.3, 'gutter.kerb_height': 0.4,
        'sweeper.velocity': (0.0, 4.0)}, 0.1)
    result = campaign.run_case(case, 60.0)
    assert result.kind == 'stopped'
    assert 'a clamp has come to the surface' in result.reason


def test_drawn_surfaces_are_all_kinds_and_nothing_starts_inside():
    from bristle_ros.report.stability.draws import drawn
    seen, uneven = set(), 0
    for case in drawn(4, 300, 0.1, 3.0):
        scene = from_parameters(case.parameters, case.name)
        kind = scene.profile.kind, scene.gutter.enabled and math.copysign(
            1.0, scene.gutter.kerb_height)
        seen.add(kind)
        if Ground(scene).uneven:
            uneven += 1
            assert surfaces.start_gap(scene) > -1e-12
    assert {('none', 1.0), ('none', -1.0), ('sine', False), ('iso8608', False), ('file', False),
            ('sine', 1.0), ('iso8608', 1.0)} <= seen
    assert uneven > 70


def test_listed_surfaces_start_outside():
    for case in campaign_cases.on_surfaces(0.1):
        assert surfaces.start_gap(from_parameters(case.parameters, case.name)) > -1e-12
