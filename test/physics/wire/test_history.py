"""What the next step is expected to change by."""
import math

from bristle_ros.physics.wire.history import trends
import numpy as np
import pytest


def expected(before, last, now, both=True):
    """Return trends by changes of the last three steps."""
    before, last, now = (np.atleast_1d(one) for one in (before, last, now))
    return trends(both, now @ last, last @ last, now @ before, last @ before, before @ before)


@pytest.mark.parametrize('turn', [0.01, 0.3, 1.5, 3.0])
def test_a_vibration_goes_on(turn):
    """Changes of a harmonic motion obey d0 = 2 cos(omega h) d1 - d2."""
    rng = np.random.default_rng(3)
    shapes = rng.normal(size=(2, 20))
    changes = [math.cos(turn * i) * shapes[0] + math.sin(turn * i) * shapes[1] for i in range(3)]
    x, y = expected(*changes)
    assert (x, y) == pytest.approx((2.0 * math.cos(turn), -1.0), abs=2e-3)


def test_what_is_expected_does_not_grow():
    rng = np.random.default_rng(4)
    for _ in range(300):
        x, y = expected(*(rng.normal(size=2) * 10.0 ** rng.uniform(-3.0, 3.0) for _ in range(3)))
        assert abs(np.roots([1.0, -x, -y])).max() < 1.0 + 1e-7


@pytest.mark.parametrize('size', [0.0, 1e-170, 1e-90, 1e90])
def test_no_change_and_any_other_size(size):
    """Products of tiny changes are zero, and divide nothing."""
    for changes in ((0.0, 0.0, size), (0.0, size, size), (size, size, size), (size, 0.0, size)):
        for both in (True, False):
            found = expected(*changes, both=both)
            assert np.isfinite(found).all()
    assert expected(0.0, size, size, both=False) == ((1.0, 0.0) if size > 1e-170 else (0.0, 0.0))
