"""The report: its measures of error, its theory, and one page from the command line."""
import csv
import math
import re
import subprocess
import sys

from bristle_ros.report import adaptive, estimate
from bristle_ros.report.page import Page
from bristle_ros.report.paper import claims, experiments as paper_claims, modes
from bristle_ros.report.peers import (comparison as peers, exudyn as peers_exudyn,
                                      mujoco as peers_mujoco)
from bristle_ros.report.peers.scenes import our_scene, peer_scene
from bristle_ros.report.runs import impulse_error, Path, run, tip_error, total_impulse
from bristle_ros.simulation.simulation import Simulation
from matplotlib.text import Text
import numpy as np
import pytest


def made_up(tip=1.0, impulse=1.0, step=1e-3):
    t = step * np.arange(round(0.1 / step) + 1)
    path = np.column_stack([t, np.zeros_like(t), np.zeros_like(t)])
    return Path(t, tip * path, impulse * path[:, ::-1] ** 1, 1.0, len(t) - 1, len(t), 0.0)


def test_errors_are_what_they_say():
    exact = made_up()
    assert tip_error(exact, exact) == 0.0
    assert tip_error(made_up(1.01), exact) == pytest.approx(0.01)
    assert tip_error(made_up(1.01, step=5e-3), exact) == pytest.approx(0.01)
    assert impulse_error(made_up(1.0, 0.97), exact) == pytest.approx(0.03)
    assert impulse_error(made_up(1.0, 0.97, 5e-3), exact) == pytest.approx(0.03)
    assert total_impulse(exact) == pytest.approx(0.1)
    with pytest.raises(ValueError, match='too few times in common'):
        tip_error(made_up(step=0.8e-3), exact)


def test_peers_get_the_scene_that_we_solve():
    """The rigid straight bristle: its tip, depth and motion, from both descriptions."""
    for name in ('S2', 'S4'):
        peer = peer_scene(name)
        simulation = Simulation(our_scene(name, 1e-3))
        tip = np.array(peer.clamp) + 0.24 * np.array(peer.along)
        for step in (0, 37):
            simulation.reset()
            simulation.advance(step)
            now = simulation.snapshot()
            angle, speed, _ = peer.motion(now.t)
            assert (now.theta, now.omega) == pytest.approx((angle, speed), rel=1e-12)
            assert peer.axes(now.t) @ now.tip_position[0] == pytest.approx(
                now.tip_position_road[0], abs=1e-12)
            if step == 0:
                assert now.tip_position[0] == pytest.approx(tip, abs=1e-15)
        lowest = simulation.model.drive.tip_depth - peer.depth
        assert peer.ground(1.0)[0] == pytest.approx(-lowest, abs=1e-15)
    # a rigid motion over the road has this field: omega^2 r outward, omega' r backward
    field, by_x, _ = peer_scene('S2').field(0.05)
    _, w, dw = peer_scene('S2').motion(0.05)
    assert by_x @ (1.0, 0.0, 0.0) == pytest.approx((w * w, -dw, 0.0))
    assert field == pytest.approx((0.0, 0.0, -9.81))


def test_modes_are_those_of_the_literature():
    assert modes.wave_numbers(3) == pytest.approx((1.8751041, 4.6940911, 7.8547574), abs=1e-6)
    # loads r I0 + l sin(phi) I1 with the tabulated integrals of unit shapes; signs: tip upward
    lever = 0.24 * math.sin(0.4537856)
    wanted = [0.1125 * a + lever * b for a, b in (
        (0.7830, 0.5688), (-0.4339, -0.0908), (0.2544, 0.0324))]
    assert modes.modal_loads(3) == pytest.approx(wanted, rel=2e-3)


def test_a_mode_under_a_constant_load_swings_about_its_static_place():
    t = np.linspace(0.0, 1.0, 2001)
    w = 2.0 * math.pi * 5.0
    q, rate = modes._single(5.0, 0.0, t[1], np.full(len(t), w * w))
    assert q == pytest.approx(1.0 - np.cos(w * t), abs=1e-9)
    assert rate == pytest.approx(w * np.sin(w * t), abs=1e-7)


def test_small_vibration_is_that_of_the_normal_modes():
    rows, figure = modes.compare(lambda text: None)
    figure.clear()
    assert {row['plane'] for row in rows} == {'tangential', 'radial'}
    assert max(row['largest_deviation_percent'] for row in rows) < 1.5


def test_the_polygon_rings_in_newmark_and_not_at_spectral_radius_0():
    def peak(integrator, time_step):
        scene = paper_claims._figure4_scene(time_step, 1e-5, 'displacement', integrator)
        return np.abs(paper_claims.damping_history(scene, 0.01)[1]).max()
    assert 50.0 < peak('Newmark 0.005', 1e-3) < 200.0      # the paper: about 140 N
    assert 0.5 < peak('spectral radius 0', 1e-3) < 3.0
    assert peak('Newmark 0.005', 1e-5) < 0.05


def test_every_step_of_the_polygon_has_its_row(monkeypatch):
    made = []

    def history(scene, duration):
        made.append(scene)
        return np.linspace(0.0, duration, 20), np.linspace(0.0, -2.0, 20)
    monkeypatch.setattr(paper_claims, 'damping_history', history)
    rows, figure = paper_claims.damping_force(lambda text: None)
    figure.clear()
    steps = {(row['TS_ms'], row['ITS_us']) for row in rows[:-1]}
    assert steps == {(ts, its) for ts in (1.0, 0.1, 0.05, 0.01) for its in (10.0, 5.0, 1.0)} | {
        (0.001, 1.0)}
    assert len(made) == 3 * 13 + 1
    coarse = next(row for row in rows if row['TS_ms'] == 1.0)
    assert coarse['peak N, HHT 0.005'] == 2.0
    assert coarse['planar model N, Newmark 0.005'] == 114.0
    planar = paper_claims.against_planar([
        {'peak N, Newmark 0.005': ours, 'planar model N, Newmark 0.005': theirs}
        for ours, theirs in ((3.0, 2.0), (1.0, math.nan), (8.0, 4.0))])
    assert planar == 'Ours over theirs: Newmark 0.005 1.5 to 2, median 1.75.'
    rows, figure = paper_claims.damping_force(lambda text: None, quick=True)
    figure.clear()
    assert {row['ITS_us'] for row in rows} == {10.0, 5.0}


def test_single_steps_are_compared_from_the_same_state(monkeypatch):
    found = estimate.look_at('S2', 1e-3, {}, (20, 90))
    for guess, true, touching in found:
        assert 1e-8 < true < 1e-4
        assert 1.0 / estimate.BAND < guess / true < estimate.BAND
        assert not touching
    touching = estimate.look_at('cutting_brush', 5e-4, {}, (160,))
    assert touching[0][2]
    # the same step again differs by what Newton leaves, and by nothing else
    monkeypatch.setattr(estimate, 'PARTS', 1)
    assert all(true < 1e-9 for _, true, _ in estimate.look_at('S2', 1e-3, {}, (20, 90)))


def test_a_step_done_in_parts_is_left_out():
    cases = (('S4', 0.02, (1e-3,)),)
    keys = {'step': 'adaptive', 'error_tolerance': 1e-9}
    found, split = estimate.measure(lambda text: None, cases=cases, schemes={'tight': keys})
    assert not found
    assert split > 1
    assert estimate.summary(found) == []


def test_the_summary_counts_what_is_outside_the_band():
    def step(ratio, touching):
        return estimate.Step('S2', 'rho 0', 1e-3, 0.1, touching, ratio * 1e-7, 1e-7)
    rows = estimate.summary([step(0.3, False), step(1.0, False), step(2.9, True)])
    assert [(row['count'], row['outside_a_factor_3']) for row in rows] == [
        (2, 1), (1, 0), (3, 1), (3, 1)]
    assert rows[-1]['smallest_ratio'] == pytest.approx(0.3)
    assert rows[-1]['largest_ratio'] == pytest.approx(2.9)


def work_rows(family, *points):
    return [{'scene': 'cutting_brush', 'family': family, 'label': label, 'ITS_us': 100.0,
             'wall_per_simulated_s': wall, 'tip_error_percent': error,
             'impulse_error_percent': 3.0 * error} for label, wall, error in points]


def test_adaptive_and_fixed_are_compared_at_equal_error():
    # error 1 / wall^2, and a run that is both slower and worse than another
    fixed = work_rows('step', ('1000 us', 1.0, 1.0), ('500 us', 2.0, 0.25),
                      ('200 us', 4.0, 0.0625), ('bad', 5.0, 0.3))
    assert adaptive.wall_at(fixed, 0.25) == pytest.approx(2.0)
    assert adaptive.wall_at(fixed, 0.125) == pytest.approx(8.0 ** 0.5)
    assert adaptive.wall_at(fixed, 7.0) == pytest.approx(1.0)
    assert math.isnan(adaptive.wall_at(fixed, 0.05))
    runs = work_rows('adaptive', ('tol 0.001', 1.5, 1.0), ('tol 0.0001', 1.2, 1.0),
                     ('tol 1e-05', 1.0, 0.25), ('tol 1e-06', 9.0, 0.01))
    rows = adaptive.compare(fixed + runs)
    assert [row['error_tolerance'] for row in rows] == ['0.001', '0.0001', '1e-05', '1e-06']
    for error in ('tip', 'impulse'):
        ratios = [row[f'fixed_over_adaptive_at_this_{error}_error'] for row in rows]
        assert ratios[:3] == pytest.approx([1.0 / 1.5, 1.0 / 1.2, 2.0])
        assert math.isnan(ratios[3])
    assert 'cutting_brush, tip: adaptive steps cheaper in 1 of 3 runs' in adaptive.verdict(rows)


def test_labels_of_the_adaptive_figure_do_not_touch():
    fixed = work_rows('step', *((f'{i} us', 0.1 + 1e-4 * i, 0.5 + 1e-4 * i) for i in range(6)))
    runs = work_rows('adaptive', ('tol 0.001', 0.1, 0.5), ('tol 0.0001', 0.11, 0.5),
                     ('tol 1e-05', 0.2, 0.01))
    scenes = [{**row, 'scene': scene} for row in fixed + runs for scene in adaptive.SWEPT]
    figure = adaptive.draw(scenes)
    figure.canvas.draw()
    for panel in figure.axes:
        boxes = [Text.get_window_extent(text) for text in panel.texts]     # without the line
        assert len(boxes) == 8      # two tolerances that gave the same run share one
        frame = panel.get_window_extent()
        for i, box in enumerate(boxes):
            assert frame.x0 < box.x0 < box.x1 < frame.x1
            assert frame.y0 < box.y0 < box.y1 < frame.y1
            assert not any(box.overlaps(other) for other in boxes[:i])
    figure.clear()


@pytest.mark.parametrize(('module', 'elements', 'step', 'bound'), [
    pytest.param(peers_exudyn, 8, 2e-3, 3.0, id='exudyn',
                 marks=pytest.mark.needs('exudyn', peers_exudyn.version)),
    pytest.param(peers_mujoco, 8, 2e-4, 6.0, id='mujoco',
                 marks=pytest.mark.needs('MuJoCo 4', peers_mujoco.version))])
def test_a_peer_solves_the_same_scene(module, elements, step, bound):
    """Independent programs agree on free rotation as far as their coarse settings allow."""
    scene = peer_scene('S2')._replace(duration=0.2)
    t, tip, impulse, wall = module.solve(scene, elements, step)
    ours = run(our_scene('S2', 1e-4), 0.2)
    theirs = peers.Solution(t, tip, impulse, wall)
    assert peers.path_error(theirs, ours) < bound
    assert impulse == 0.0
    assert wall > 0.0


def test_absent_programs_are_named(monkeypatch):
    for module in (peers_exudyn, peers_mujoco):
        monkeypatch.setattr(module, 'version', lambda: None)
    found, absent = peers.programs()
    assert not {'exudyn', 'mujoco'} & {name.lower() for name in found}
    assert {'exudyn', 'mujoco'} <= {name.lower() for name in absent}


def test_equal_error_takes_the_fastest_that_is_good_enough():
    def solve(name, elements, step):
        t = np.linspace(0.0, 1.0, 11)
        error = step * 10.0     # 1 ms: 1 %
        return peers.Solution(t, np.column_stack([(1 + error) * t] * 3), 0.0, 1e-3 / step)
    found = {'bristle_ros': (solve, ''), 'exudyn': (solve, '1')}
    best = {('bristle_ros', 1.0): {'wall_per_simulated_s': 0.5, 'elements': 4, 'step_us': 1.0,
                                   'error_percent': 0.9},
            ('exudyn', 1.0): {'wall_per_simulated_s': 5.0, 'elements': 4, 'step_us': 1.0,
                              'error_percent': 0.9}}
    row = peers._equal_row('S2', 1.0, best, found)
    assert row['exudyn_over_ours'] == pytest.approx(10.0)
    assert math.isnan(peers._equal_row('S2', 0.1, best, found)['exudyn_over_ours'])
    exact = solve('S2', 4, 0.0 + 1e-12)
    assert peers.path_error(solve('S2', 4, 1e-3), exact) == pytest.approx(1.0, rel=1e-6)


def test_claims_are_judged_by_the_numbers():
    damping = [{'TS_ms': 1.0, 'ITS_us': 10.0, 'peak N, Newmark 0.005': 120.0,
                'peak N, spectral radius 0': 1.0},
               {'TS_ms': 0.01, 'ITS_us': 10.0, 'peak N, Newmark 0.005': 0.02},
               {'TS_ms': 'inertia load case', 'peak N, Newmark 0.005': 0.6}]
    cases = [{'penetration_mm': depth, 'tip_until_touch_percent': 0.1,
              'impulse_inertia_mNs': impulse, 'impulse_displacement_mNs': impulse}
             for depth, impulse in ((40.0, 12.0), (0.04, 0.0))]
    ratio = {'ratio': 3.0, 'error_percent': 0.1}
    holds = {row['claim']: row['holds'] for row in claims.judge(0.0, damping, cases, [], ratio)}
    assert holds['displacement load case, TS 1 ms: huge damping forces'] == 'yes'
    assert holds['damping force at the clamp is positive and below 0.05 N'] == 'no'
    assert holds['the inertia load case needs much less computing'] == 'yes'
    assert holds['penetration 0.04 mm'] == 'no'


def test_a_page_is_complete_in_one_file(tmp_path):
    page = Page('A <title>')
    page.text('1 < 2')
    page.table('numbers', [{'a': 1.5, 'b': math.nan}, {'a': None, 'c': 'x'}])
    content = page.write(tmp_path).read_text(encoding='utf-8')
    assert '<title>A &lt;title&gt;</title>' in content
    assert '1 &lt; 2' in content
    with open(tmp_path / 'numbers.csv', newline='', encoding='utf-8') as file:
        assert list(csv.DictReader(file)) == [{'a': '1.5', 'b': 'nan', 'c': ''},
                                              {'a': '', 'b': '', 'c': 'x'}]


def test_the_verb_writes_page_and_tables(root, tmp_path):
    done = subprocess.run(
        [sys.executable, '-m', 'bristle_ros', 'report', '--quick', '--only', 'theory', '--output',
         str(tmp_path / 'out')], cwd=root, text=True, capture_output=True, timeout=600)
    assert done.returncode == 0, done.stderr
    content = (tmp_path / 'out' / 'index.html').read_text(encoding='utf-8')
    assert 'python3 -m bristle_ros report --quick --only theory' in content
    assert len(re.findall(r'src="data:image/png;base64,', content)) == 2
    assert not re.findall(r'(?:src|href)="http', content)
    with open(tmp_path / 'out' / 'odd_fraction_resonance.csv', newline='') as file:
        rows = {row['fraction']: row for row in csv.DictReader(file)}
    assert float(rows['1/3']['VAP, on over off']) > 4.0
    assert float(rows['1/3']['sine, on over off']) < 1.5
    assert '[' in done.stderr       # progress was shown


def test_unusable_input_is_one_line(root):
    done = subprocess.run([sys.executable, '-m', 'bristle_ros', 'report', '--only', 'all'],
                          cwd=root, text=True, capture_output=True, timeout=600)
    assert done.returncode == 2
    assert done.stderr.count('\n') == 1
