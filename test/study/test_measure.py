"""Measures of made-up histories against closed forms."""
import math

from bristle_ros.scene import from_parameters
from bristle_ros.study.history import History
from bristle_ros.study.measure import half_width, measure
from bristle_ros.study.stress import clamp_stress, life
import numpy as np
import pytest
from scipy import stats

SPEED, STEP, WIRES = 2.0 * math.pi, 1e-3, 10    # a turn a second
SCENE = from_parameters({'brush.bristle_count': 2, 'brush.wires_per_bristle': WIRES,
                         'sweeper.velocity': [0.5, 0.0], 'drive.mean_speed': SPEED}, '')


def history(seconds, force, radius=0.2, lying=(0.0, 0.0)):
    """
    Two wires on a circle; `force`(t) is a normal force on each, with friction 0.3 against x.

    lying [m] : what of each touches beside its tip while there is a force
    """
    t = np.arange(round(seconds / STEP) + 1) * STEP
    wires = np.zeros((len(t), 2, 3))
    contact = wires.copy()
    contact[..., 2] = force(t)[:, None]
    contact[..., 0] = -0.3 * contact[..., 2]
    middle = contact.copy()
    middle[..., 2] = force(t - 0.5 * STEP)[:, None]
    middle[..., 0] = -0.3 * middle[..., 2]
    impulse = np.cumsum(middle * STEP, axis=0)
    tip = wires.copy()
    tip[..., 0] = radius
    torque = np.zeros((len(t), 3))
    torque[:, 2] = -0.7
    return History(t, SPEED * t, np.full(len(t), SPEED), wires, tip, contact, impulse, wires,
                   wires, np.zeros((len(t), 3)), torque, np.full(len(t), 1e-6),
                   np.where(force(t)[:, None] > 0.0, lying, 0.0), contact)


def test_a_constant_force_is_its_own_mean():
    row = measure(history(6.5, lambda t: np.full(len(t), 2.0)), SCENE, 0.25)
    assert row['turns'] == 6
    assert row['normal_force_mean'] == pytest.approx(2 * WIRES * 2.0, rel=1e-12)
    assert row['normal_force_rms'] == pytest.approx(2 * WIRES * 2.0, rel=1e-12)
    assert row['normal_force_mean_ci95'] == pytest.approx(0.0, abs=1e-10)
    assert row['friction_force_mean'] == pytest.approx(0.6, rel=1e-12)
    assert row['side_force_mean_x'] == pytest.approx(-2 * WIRES * 0.6, rel=1e-12)
    assert row['drive_torque_mean'] == pytest.approx(0.7, rel=1e-12)
    assert row['drive_power'] == pytest.approx(0.7 * SPEED, rel=1e-12)
    # tips stand still over the mount, so that they slip at the sweeper's 0.5 m/s
    assert row['tip_slip_speed_mean'] == pytest.approx(0.5, rel=1e-12)
    assert row['friction_work_per_metre'] == pytest.approx(2 * WIRES * 0.6, rel=1e-12)
    assert (row['contact_share'], row['impacts_per_turn'], row['settled']) == (1.0, 0.0, 'yes')
    assert row['tip_radius_mean'] == pytest.approx(0.2)
    assert row['contact_length_mean'] == 0.0


def test_friction_work_of_a_wire_that_lies_is_not_told():
    """Its tip's slip is not that of the rest of it."""
    row = measure(history(6.5, lambda t: np.full(len(t), 2.0), lying=(0.01, 0.03)), SCENE, 0.25)
    assert row['contact_length_mean'] == pytest.approx(0.02, rel=1e-12)
    assert math.isnan(row['friction_work_per_metre'])
    assert row['normal_force_mean'] == pytest.approx(2 * WIRES * 2.0, rel=1e-12)


def test_only_whole_turns_count():
    row = measure(history(3.9, lambda t: 1.0 + np.sin(SPEED * t)), SCENE, 0.0)
    assert row['turns'] == 3
    assert row['normal_force_mean'] == pytest.approx(2 * WIRES, rel=1e-6)
    assert math.isnan(row['normal_force_mean_ci95'])    # of fewer than 5


def test_touches_after_half_a_millisecond_in_the_air_are_impacts():
    def force(t):       # four hops a turn
        return np.where((4.0 * t) % 1.0 < 0.25, 0.0, 1.0)
    row = measure(history(6.0, force, lying=(0.01, 0.03)), SCENE, 0.0)
    assert row['impacts_per_turn'] == pytest.approx(4.0, abs=0.2)
    assert row['contact_share'] == pytest.approx(0.75, abs=0.01)
    assert row['contact_length_mean'] == pytest.approx(0.75 * 0.02, abs=2e-4)


def test_intervals_are_those_of_turn_means():
    batches = np.array([1.0, 1.3, 0.8, 1.1, 0.9, 1.2])
    low, high = stats.t.interval(0.95, 5, batches.mean(), stats.sem(batches))
    assert half_width(batches) == pytest.approx(0.5 * (high - low), rel=1e-9)


def test_intervals_hold_what_they_say():
    rng = np.random.default_rng(3)
    held = sum(abs(turns.mean() - 1.0) <= half_width(turns)
               for turns in rng.normal(1.0, 0.3, (2000, 8)))
    assert held / 2000 == pytest.approx(0.95, abs=0.015)


def test_a_mean_that_drifts_has_not_settled():
    assert measure(history(8.5, lambda t: 1.0 + 0.05 * t), SCENE, 0.0)['settled'] == 'no'
    assert measure(history(3.0, lambda t: 1.0 + 0.05 * t), SCENE, 0.0)['settled'] == 'unknown'


def test_a_brush_that_stands_is_measured_all_the_time():
    still = history(2.0, lambda t: np.full(len(t), 2.0))._replace(
        theta=np.zeros(2001), omega=np.zeros(2001))
    row = measure(still, SCENE, 0.5)
    assert (row['turns'], row['settled']) == (0, 'unknown')
    assert row['normal_force_mean'] == pytest.approx(2 * WIRES * 2.0)
    assert math.isnan(row['impacts_per_turn'])


@pytest.mark.parametrize('gamma', [0.0, 0.5 * math.pi])
def test_stress_of_a_bent_wire_is_that_of_the_textbook(gamma):
    """A moment about one axis of the section bends about that side alone: 6 M / (b h^2)."""
    scene = from_parameters({'brush.mount_angle': 0.0, 'brush.mount_orientation': gamma}, '')
    some = history(0.01, np.zeros_like)
    bristle = scene.bristle
    moment, force = np.zeros((11, 1, 3)), np.zeros((11, 1, 3))
    moment[..., 1] = 0.01       # about brush +y: t1 lies along it for gamma 0, t2 for pi / 2
    force[..., 2] = -3.0        # along the wire, which hangs down
    stress = clamp_stress(some._replace(mount_moment=moment, mount_force=force), scene)
    across, along = ((bristle.width, bristle.breadth) if gamma == 0.0
                     else (bristle.breadth, bristle.width))
    bending = 6.0 * 0.01 / (along * across ** 2)
    axial = 3.0 / (bristle.breadth * bristle.width)
    assert np.sort(stress[0, 0]) == pytest.approx(
        [axial - bending] * 2 + [axial + bending] * 2, rel=1e-9)


def test_life_of_a_sine_is_that_of_its_cycles():
    t = np.linspace(0.0, 10.0, 20001)
    stress = (2.0e8 * np.sin(2.0 * math.pi * 5.0 * t))[:, None, None] * np.ones((1, 1, 4))
    # half the strength at 1e6 and exponent 3: 8e6 cycles, 5 a second
    assert life(stress, 10.0, (3.0, 4.0e8)) == pytest.approx(8e6 / 5.0 / 3600.0, rel=0.02)
    assert life(0.0 * stress, 10.0, (3.0, 4.0e8)) == math.inf
