"""The sweeper of examples/: MuJoCo and a real node in lockstep, twice the same, in balance."""
from importlib.util import find_spec
from math import cos, sin
import sys

from bristle_ros.log.recording import Recording
from bristle_ros.scene.rows import tip_depth
from bristle_ros.scene.scene import load
from bristle_ros.verbs.verify import verify
from nodes import ROOT
import numpy as np
import pytest

FOLDER = ROOT / 'examples/sweeper'
DURATION, CHUNKS = 10.0, 2000
RISE, BEFORE = 0.03, (2.5, 4.0)     # [m] of driveway.csv; where the mount is before its edge
pytestmark = pytest.mark.needs('mujoco', lambda: find_spec('mujoco') is not None)


@pytest.fixture(scope='module')
def runs(tmp_path_factory, environment):
    """Return the folder of two logs, and the Ride of each."""
    sys.path.insert(0, str(FOLDER))
    try:
        import sweep
    finally:
        sys.path.remove(str(FOLDER))
    folder = tmp_path_factory.mktemp('sweeper')
    return folder, [sweep.sweep(DURATION, str(folder / name)) for name in 'ab']


@pytest.fixture
def ride(runs):
    return runs[1][0]


def along(ride, first, last):
    """Return which chunks are between these places of the mount [m]."""
    return (ride.place[:, 0] > first) & (ride.place[:, 0] < last)


def outputs(log):
    return [(entry.name, entry.step, entry.message.data) for entry in Recording(log).entries()
            if entry.name not in ('/diagnostics', '~/scene') and '/events' not in entry.name]


def test_a_second_run_is_equal_bit_for_bit(runs):
    folder, (one, two) = runs
    for name, ours, theirs in zip(one._fields, one, two):
        if name != 'wall':
            np.testing.assert_array_equal(ours, theirs, err_msg=name)
    assert outputs(folder / 'a') == outputs(folder / 'b')
    verdict = verify(folder / 'a')
    assert (verdict.difference, verdict.applied) == ('', CHUNKS)


def test_the_arm_settles_where_spring_and_wires_balance(ride):
    """Moments about the hinge, means over the way before the edge, front down positive."""
    scene = load(FOLDER / 'brush.yaml')
    before = along(ride, *BEFORE)
    q, wrench = ride.hinge[before].mean(), ride.wrench[before].mean(axis=0)
    below = tip_depth(scene) - scene.road.penetration - 0.45
    c, s = cos(q), sin(q)
    x, z = 0.7 * c + below * s, below * c - 0.7 * s
    lean = q + scene.road.attack_angle
    fx = wrench[0] * cos(lean) + wrench[2] * sin(lean)
    fz = wrench[2] * cos(lean) - wrench[0] * sin(lean)
    weight = 9.81 * (6.0 * 0.35 + 8.0 * 0.7) * c
    assert fz > 5.0     # it carries part of the arm
    assert weight - 20.0 - 600.0 * (q - 0.1) + z * fx - x * fz + wrench[4] == pytest.approx(
        0.0, abs=0.01 * weight)


def test_energy_is_where_it_went(ride):
    """What MuJoCo stores, beside the work of drive, cylinder, brush, damping and road."""
    turned_over = np.abs(ride.work[-1]).sum()
    assert np.abs(ride.left_over()).max() < 1e-3 * turned_over      # 3e-4 when it was written
    assert abs(ride.work[-1, 2]) > 0.03 * turned_over   # without the brush it would not balance
    assert abs(ride.added[-1]) < 0.1 * abs(ride.work[-1, 2])


def test_it_runs_along_the_kerb_and_climbs_the_edge(ride):
    before, climbed, after = (along(ride, *way) for way in (BEFORE, (4.8, 5.3), (6.7, 99.0)))
    side, up = -ride.force[:, 1], ride.force[:, 2]
    # more than friction could on what lies below: 0.5 of it
    assert side[before].mean() > 0.52 * up[before].mean()
    assert up[climbed].mean() > 2.0 * up[before].mean()
    assert ride.place[climbed, 2].mean() > ride.place[before, 2].mean() + 0.2 * RISE
    assert ride.place[after, 2].mean() - ride.place[before, 2].mean() == pytest.approx(
        RISE, abs=0.1 * RISE)
    assert up[after].mean() == pytest.approx(up[before].mean(), rel=0.15)
