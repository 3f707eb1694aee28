"""The report's scenes of the road: what is measured, shown, and given to other programs."""
import io
import math

from bristle_ros.report import results as files
from bristle_ros.report.context import Context, Progress
from bristle_ros.report.ground import Ground
from bristle_ros.report.page import Page
from bristle_ros.report.peers import exudyn as peers_exudyn, mujoco as peers_mujoco
from bristle_ros.report.peers.comparison import path_error, Solution
from bristle_ros.report.peers.scenes import peer_scene
from bristle_ros.report.peers.surface import surface_gaps
from bristle_ros.report.road import assumption, measure, show
from bristle_ros.report.road.subjects import NAMES, road_scene, subject_of
from bristle_ros.report.runs import Path, run, whole_impulse_error
from bristle_ros.report.verdict import Measured
import numpy as np
import pytest


def test_a_scene_of_the_road_is_measured_and_shown(tmp_path, alone, monkeypatch):
    monkeypatch.setattr(assumption, 'measure', lambda context: {})     # minutes, in one process
    context = Context(True, 0, 0, 1.0, 0, alone, alone, Progress({}, io.StringIO()))
    subject = subject_of('lying')._replace(duration=0.03)
    data = measure.measure(context, (subject,))
    [entry] = data['subjects']
    assert data['peers'] is None
    assert 0.0 < entry['own']['tip'] < 0.1
    steps = [row['tip'] for row in entry['steps']]
    assert len(steps) == 4
    assert steps[0] > steps[-1] > 0.0
    meshes = [row['tip'] for row in entry['meshes']]
    assert meshes == sorted(meshes, reverse=True)
    page = Page('one scene')
    show.show(page, files.clean(data), {})
    [row] = page.tables['road_cost'][0]
    assert row['tip'] <= subject.tip
    assert isinstance(row['times'], Measured)
    assert page.content().count('<svg') == 6
    page.write(tmp_path)
    assert (tmp_path / 'road_refinement.csv').is_file()


def test_nothing_that_misses_a_limit_is_cheapest():
    def row(tip, wall):
        return {'tip': tip, 'impulse': 1.0, 'label': f'{tip}', 'timing': {
            'walls': [wall], 'disturbed': 0, 'slowest': 1.0}}
    entry = {'limits': {'tip': 1.0, 'impulse': 3.0},
             'rows': [row(2.0, 0.01), row(0.9, 0.04), row(0.1, 0.1)]}
    assert show.cheapest(entry)['tip'] == 0.9
    assert show.times_real_time(show.cheapest(entry)).value == pytest.approx(25.0)
    entry['limits']['impulse'] = 0.5
    assert show.cheapest(entry) is None


def test_the_error_of_an_impulse_is_of_all_its_components():
    t = np.linspace(0.0, 0.02, 21)
    exact = Path(t, np.zeros((21, 3)), t[:, None] * (3.0, 0.0, 4.0), 20, 0, 0.0)
    turned = exact._replace(impulse=t[:, None] * (0.0, 3.0, 4.0))
    assert whole_impulse_error(exact, exact) == 0.0
    assert whole_impulse_error(turned, exact) == pytest.approx(math.sqrt(18.0) / 5.0)


@pytest.mark.parametrize('name', NAMES)
def test_no_wire_starts_inside_and_others_have_the_same_surface(name):
    scene, peer = road_scene(name, 1e-4), peer_scene(name)
    assert peer.ground(0.0)[0] < 0.0
    places = np.random.default_rng(2).uniform((-0.3, -0.3, -0.3), (0.3, 0.3, 0.1), (500, 3))
    if peer.gaps is not None:
        gaps, normals = surface_gaps(scene)(places)
        assert gaps == pytest.approx(Ground(scene).gap(places)[0], abs=1e-13)
        assert peer.gaps(places)[1] == pytest.approx(normals)
    forces, pushes = peer.forces(0.0, places, np.zeros((500, 3)))
    assert forces.shape == (500, 3)
    assert (pushes >= 0.0).all()
    assert pushes.any()


@pytest.mark.parametrize(('module', 'elements', 'step', 'bound'), [
    pytest.param(peers_exudyn, 12, 2e-4, 2.0, id='exudyn',
                 marks=pytest.mark.needs('exudyn', peers_exudyn.version)),
    pytest.param(peers_mujoco, 12, 2e-5, 5.0, id='mujoco',
                 marks=pytest.mark.needs('MuJoCo 4', peers_mujoco.version))])
def test_a_peer_meets_the_same_kerb(module, elements, step, bound):
    """Independent programs agree on the tip's path as far as their coarse settings allow."""
    peer = peer_scene('kerb')._replace(duration=0.1)
    theirs = Solution(*module.solve(peer, elements, step))
    assert path_error(theirs, run(road_scene('kerb', 1e-4), 0.1)) < bound


def test_what_the_tip_alone_costs_is_told_from_both_ways():
    def row(value, wire, tip):
        return {'value': value, 'wire': {'normal': wire, 'side': 0.0, 'torque': 0.1},
                'tip': {'normal': tip, 'side': 0.0, 'torque': 0.05}}
    data = {'penetration': [row(20.0, 0.2, 0.2), row(160.0, 0.4, 0.2)], 'kerb': [
        {'value': 0.0, 'wire': {'failed': 'stopped'}, 'tip': {'normal': 1.0, 'side': 0.0,
                                                            'torque': 0.0}}]}
    rows = assumption.differences(data)
    assert [row['normal_off'] for row in rows] == [pytest.approx(0.0), pytest.approx(-50.0), None]
    assert rows[2]['remark'] == 'stopped'
    page = Page('assumption')
    assumption.show(page, data)
    assert '-50 % at 160, penetration' in page.content()
    assert '1 of 2 differ' in page.content()


@pytest.mark.parametrize(('depth', 'normal', 'torque'), [(0.12, 0.0, 0.0), (0.14, -15.0, -9.0),
                                                         (0.16, -49.0, -34.0)])
def test_the_tip_alone_is_off_by_what_an_independent_model_says(depth, normal, torque):
    """A quadratic beam on penalty springs at 256 points an element, steps of 1 to 5 us."""
    ways = {way: assumption.mean_forces({'road.penetration': depth}, way)
            for way in assumption.WAYS}
    [row] = assumption.differences({'penetration': [{'value': 1e3 * depth, **ways}]})
    assert row['normal_off'] == pytest.approx(normal, abs=1.0)
    assert row['torque_off'] == pytest.approx(torque, abs=1.0)
