"""A brush that is steered to the kerb by commands, as an operator would do it, offline."""
from pathlib import Path
import subprocess
import sys

from bristle_ros.scene.scene import load
from bristle_ros.simulation.simulation import Simulation
import numpy as np
import pytest

ROOT = Path(__file__).resolve().parents[2]
# what README says, with fewer wires
DRIVE = ('config/gutter.yaml', '--commands', 'examples/kerb_drive.csv',
         '-p', 'gutter.kerb_distance:=0.5', '-p', 'gutter.approach:=0.0',
         '-p', 'road.penetration:=-0.02')
FEW = ('-p', 'brush.row_counts:=[2, 2, 2]')


def bristle_ros(*arguments):
    return subprocess.run([sys.executable, '-m', 'bristle_ros', *map(str, arguments)], cwd=ROOT,
                          capture_output=True, text=True, timeout=600)


def test_the_log_of_a_drive_to_the_kerb_is_simulated_again_bit_for_bit(tmp_path):
    log, arrays = tmp_path / 'drive.mcap', tmp_path / 'drive.npz'
    for output, *only in ((log,), (arrays, '--arrays', 'base_pose,contact_impulse')):
        done = bristle_ros('simulate', *DRIVE, *FEW, '--duration', 1.2, '--output', output, *only)
        assert done.returncode == 0, done.stderr
    again = bristle_ros('replay', log, '--verify')
    assert (again.returncode, again.stderr) == (0, '')
    assert 'identical' in again.stdout
    found = np.load(arrays)
    assert found['base_pose'][-1, 1] == pytest.approx(0.3, abs=1e-3)
    # on the level road forces are upright but for friction; from the kerb they come from the left
    level, beside = (np.diff(found['contact_impulse'].sum(axis=1)[part], axis=0).sum(axis=0)
                     for part in (found['t'] < 0.45, found['t'] > 0.9))
    assert level[2] > 0.0
    assert abs(level[1]) < 0.5 * level[2] + 1e-9    # friction 0.5
    assert beside[1] < -0.2 * beside[2] < 0.0


def test_a_clamp_that_is_steered_into_a_wall_ends_the_run(tmp_path):
    drive = tmp_path / 'into.csv'
    drive.write_text('0.0,cmd_penetration,0.06\n0.2,cmd_vel,1.5,0.6,0\n')
    log = tmp_path / 'drive.mcap'
    done = bristle_ros('simulate', DRIVE[0], '--commands', drive, *DRIVE[3:], *FEW, '--duration',
                       2.0, '--output', log, '-p', 'gutter.kerb_height:=0.4',
                       # wires that stand upright yield to the wall, others are crushed before
                       '-p', 'brush.row_angles:=[0.0, 0.0, 0.0]')
    assert done.returncode == 3, done.stderr
    [line] = [line for line in done.stderr.splitlines() if not line.startswith('warning: ')]
    assert 'a clamp has come to the surface of the road: keep the brush higher, or' in line
    assert bristle_ros('replay', log, '--verify').returncode == 0   # up to there


def test_the_broom_of_the_scene_has_its_tips_at_one_depth():
    scene = load(ROOT / 'config/gutter.yaml', {'contact.enabled': False, 'solver.elements': 1})
    simulation = Simulation(scene)
    assert simulation.bristles == 102
    assert np.ptp(simulation.snapshot().tip_position[:, 2]) < 1.5e-3
