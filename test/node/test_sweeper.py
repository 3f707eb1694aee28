"""The sweeper of examples/: MuJoCo and a real node in lockstep, twice the same, in balance."""
from importlib.util import find_spec, module_from_spec, spec_from_file_location
from math import cos, sin

from bristle_ros.log.recording import Recording
from bristle_ros.scene.rows import tip_depth
from bristle_ros.scene.scene import load
from bristle_ros.verbs.verify import verify
from nodes import ROOT
import numpy as np
import pytest

FOLDER = ROOT / 'examples/sweeper'
# kernels that other tests compile too
CHANGES = {'contact__points': 'tip', 'drive__mode': 'speed'}
DURATION = 5.0
pytestmark = pytest.mark.needs('mujoco', lambda: find_spec('mujoco') is not None)


@pytest.fixture(scope='module')
def runs(tmp_path_factory, environment):
    """Return the folder of two logs, and the rows of each."""
    spec = spec_from_file_location('sweep', FOLDER / 'sweep.py')
    sweep = module_from_spec(spec)
    spec.loader.exec_module(sweep)
    folder = tmp_path_factory.mktemp('sweeper')
    return folder, [sweep.sweep(DURATION, str(folder / name), **CHANGES) for name in 'ab'], sweep


def outputs(log):
    return [(entry.name, entry.step, entry.message.data) for entry in Recording(log).entries()
            if entry.name not in ('/diagnostics', '~/scene') and '/events' not in entry.name]


def test_a_second_run_is_equal_bit_for_bit(runs):
    folder, (one, two), _ = runs
    np.testing.assert_array_equal(one, two)
    assert outputs(folder / 'a') == outputs(folder / 'b')
    verdict = verify(folder / 'a')
    assert (verdict.difference, verdict.applied) == ('', 1000)


def test_the_arm_settles_where_spring_and_wires_balance(runs):
    """Moments about the hinge, means over the last 1.5 s, front down positive."""
    _, (rows, _), sweep = runs
    scene = load(FOLDER / 'brush.yaml')
    last = rows[rows[:, 0] > DURATION - 1.5].mean(axis=0)
    q, force, torque = last[1], last[2:5], last[5:8]
    below = tip_depth(scene) - scene.road.penetration - 0.45
    c, s = cos(q), sin(q)
    x, z = 0.7 * c + below * s, below * c - 0.7 * s
    lean = q + scene.road.attack_angle
    fx, fz = force[0] * cos(lean) + force[2] * sin(lean), force[2] * cos(lean) - force[0] * sin(
        lean)
    weight = 9.81 * (6.0 * 0.35 + 8.0 * 0.7) * c
    brush = z * fx - x * fz + torque[1]
    assert fz > 2.0     # it carries part of the arm
    assert weight - sweep.LIFT - 600.0 * q + brush == pytest.approx(0.0, abs=0.02 * weight)
