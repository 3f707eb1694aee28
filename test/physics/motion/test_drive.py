"""Speed functions against quadrature and published formulas; ramps."""
from itertools import pairwise

from bristle_ros.physics.motion.drive import CONSTANT, profile_at, ramp_at, SINE, VAP
import numpy as np
import pytest

POINTS, WEIGHTS = np.polynomial.legendre.leggauss(120)
SHAPES = [0.001, 0.05, 0.08, 0.3, 0.444, 0.5, 0.952, 0.953, 0.99]  # k = 0.05 lies at b = 0.9524
AMPLITUDE, FREQUENCY = 0.5, 9.0


def paper_speed(t, b):
    """VAP, eqs. (2)-(4) of the paper, without the mean speed: by arcsine and sine, as printed."""
    h1 = np.arcsin(np.sin(2.0 * np.pi * FREQUENCY * t)) / np.pi
    h2 = np.arccos(np.cos(2.0 * np.pi * FREQUENCY * t + 0.5 * np.pi)) / np.pi
    h2 = abs(h2 - 0.5)
    return 2.0 * AMPLITUDE / (1.0 - b) * h1 * (1.0 - b * np.exp((1.0 - b) / b * (2.0 * h2 - 1.0)))


def angle_by_quadrature(t, profile, b):
    """Integrate the speed quarter by quarter of a period: in each it is smooth."""
    quarter = 0.25 / FREQUENCY
    total, start = 0.0, 0.0
    while start < t - 1e-15:
        # panels that crowd at both ends: for small b the speed has a boundary layer there
        end = min(t, start + quarter)
        edges = np.concatenate((
            [0.0], 2.0 ** np.arange(-12, -0.5), 1.0 - 2.0 ** -np.arange(2, 13.0), [1.0]))
        for one, two in pairwise(edges):
            x = start + (end - start) * (one + (two - one) * 0.5 * (POINTS + 1.0))
            speeds = [profile_at(at, profile, AMPLITUDE, FREQUENCY, b)[1] for at in x]
            total += 0.5 * (two - one) * (end - start) * (WEIGHTS @ speeds)
        start = end
    return total


@pytest.mark.parametrize('b', SHAPES)
def test_vap_is_the_papers(b):
    for t in np.linspace(0.0, 0.3, 97):
        assert profile_at(t, VAP, AMPLITUDE, FREQUENCY, b)[1] == pytest.approx(
            paper_speed(t, b), abs=1e-7 * AMPLITUDE)  # arcsine loses half the digits at its ends


@pytest.mark.parametrize(('profile', 'b'), [(VAP, b) for b in SHAPES] + [(SINE, 0.5)])
def test_angle_is_the_integral_of_the_speed(profile, b):
    for phase in (0.1, 0.25, 0.4, 0.5, 0.6, 0.75, 0.9, 1.0, 1.15):
        t = phase / FREQUENCY
        assert profile_at(t, profile, AMPLITUDE, FREQUENCY, b)[0] == pytest.approx(
            angle_by_quadrature(t, profile, b), abs=1e-12 * AMPLITUDE)


@pytest.mark.parametrize(('profile', 'b'), [(VAP, b) for b in SHAPES] + [(SINE, 0.5)])
def test_acceleration_is_the_derivative_of_the_speed(profile, b):
    h = 1e-8
    for phase in (0.03, 0.13, 0.31, 0.44, 0.56, 0.68, 0.81, 0.97, 3.2):
        t = phase / FREQUENCY
        up = profile_at(t + h, profile, AMPLITUDE, FREQUENCY, b)[1]
        down = profile_at(t - h, profile, AMPLITUDE, FREQUENCY, b)[1]
        exact = profile_at(t, profile, AMPLITUDE, FREQUENCY, b)[2]
        assert exact == pytest.approx((up - down) / (2.0 * h), rel=1e-5, abs=1e-5)


@pytest.mark.parametrize('b', SHAPES)
def test_peaks_of_vap(b):
    # Largest acceleration, at h1 = 0: 4 f w_a (1 - b exp(-(1 - b) / b)) / (1 - b); peak speed w_a.
    wanted = 4.0 * FREQUENCY * AMPLITUDE * (1.0 - b * np.exp(-(1.0 - b) / b)) / (1.0 - b)
    assert profile_at(0.0, VAP, AMPLITUDE, FREQUENCY, b)[2] == pytest.approx(wanted, rel=1e-13)
    times = np.linspace(0.0, 1.0 / FREQUENCY, 4001)
    values = np.array([profile_at(t, VAP, AMPLITUDE, FREQUENCY, b) for t in times])
    assert abs(values[:, 2]).max() == pytest.approx(wanted, rel=1e-9)
    assert abs(values[:, 1]).max() == pytest.approx(AMPLITUDE, rel=1e-9)
    speed, slope = profile_at(0.25 / FREQUENCY, VAP, AMPLITUDE, FREQUENCY, b)[1:]
    assert speed == pytest.approx(AMPLITUDE, rel=1e-12)
    assert slope == pytest.approx(0.0, abs=1e-9 * wanted)


def test_numbers_of_the_papers_runs():
    rpm = np.pi / 30.0
    assert profile_at(0.0, VAP, 5.0 * rpm, 9.0, 0.08)[2] == pytest.approx(20.49, abs=5e-3)
    assert profile_at(0.0, SINE, 5.0 * rpm, 9.0, 0.08)[2] == pytest.approx(29.61, abs=5e-3)
    assert profile_at(0.0, SINE, 4.0 * rpm, 5.0, 0.08)[2] == pytest.approx(13.16, abs=5e-3)
    # VAP takes as much as the sine at b = 0.444
    vap, sine = (profile_at(0.0, kind, 1.0, 5.0, 0.444)[2] for kind in (VAP, SINE))
    assert vap == pytest.approx(sine, rel=1e-3)


@pytest.mark.parametrize('profile', [SINE, VAP])
def test_angle_does_not_drift(profile):
    # after a million periods the angle is the one of the first (0.1 of a period is exact to 1e-10)
    first = profile_at(0.1 / 8.0, profile, AMPLITUDE, 8.0, 0.08)
    later = profile_at((0.1 + 1e6) / 8.0, profile, AMPLITUDE, 8.0, 0.08)
    np.testing.assert_allclose(later, first, rtol=1e-8)


def test_constant_adds_nothing():
    assert profile_at(1.23, CONSTANT, AMPLITUDE, FREQUENCY, 0.5) == (0.0, 0.0, 0.0)


def test_ramp():
    # at offset 1: from t = 1 on, 2 to 5 in 0.5 s
    values = np.array([9.0, 1.0, 2.0, 5.0, 0.5, 7.0, 0.0])
    assert ramp_at(values, 1, 1.0) == pytest.approx((2.0, 6.0, 7.0))
    assert ramp_at(values, 1, 1.25) == pytest.approx((3.5, 6.0, 7.0 + 0.25 * 2.75))
    assert ramp_at(values, 1, 1.5) == pytest.approx((5.0, 0.0, 7.0 + 0.5 * 3.5))
    assert ramp_at(values, 1, 2.5) == pytest.approx((5.0, 0.0, 7.0 + 0.5 * 3.5 + 5.0))
    at_once = np.array([1.0, 2.0, 5.0, 0.0, 7.0, 0.0])
    assert ramp_at(at_once, 0, 1.0) == (5.0, 0.0, 7.0)
