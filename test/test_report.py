"""The report: its measures of error, its theory, and one page from the command line."""
import csv
import math
import re
import subprocess
import sys

from bristle_ros.report import claims, modes, paper_claims, peers, peers_exudyn, peers_mujoco
from bristle_ros.report.page import Page
from bristle_ros.report.peer_scenes import our_scene, peer_scene
from bristle_ros.report.runs import impulse_error, Path, run, tip_error, total_impulse
from bristle_ros.simulation import Simulation
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


@pytest.mark.parametrize(('module', 'elements', 'step', 'bound'), [
    (peers_exudyn, 8, 2e-3, 3.0), (peers_mujoco, 8, 2e-4, 6.0)])
def test_a_peer_solves_the_same_scene(module, elements, step, bound):
    """Independent programs agree on free rotation as far as their coarse settings allow."""
    if module.version() is None:
        assert module.__name__.rpartition('.')[2][6:] in peers.programs()[1]
        return
    scene = peer_scene('S2')._replace(duration=0.2)
    t, tip, impulse, wall = module.solve(scene, elements, step)
    ours = run(our_scene('S2', 1e-4), 0.2)
    theirs = peers.Solution(t, tip, impulse, wall)
    assert peers.path_error(theirs, ours) < bound
    assert impulse == 0.0
    assert wall > 0.0


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
         str(tmp_path / 'out')], cwd=root, text=True, capture_output=True, timeout=300)
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
                          cwd=root, text=True, capture_output=True, timeout=60)
    assert done.returncode == 2
    assert done.stderr.count('\n') == 1
