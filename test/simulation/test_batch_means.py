"""Means with intervals: Student's t against tables, coverage for signals with memory."""
import math

from bristle_ros.simulation.batch_means import BatchMean, LEAST, MOST, students_t
import numpy as np
import pytest


def mean_of(values):
    mean = BatchMean()
    for value in values:
        mean.add(float(value))
    return mean


# Abramowitz, Stegun, table 26.10.
@pytest.mark.parametrize(('freedom', 'wanted', 'within'), [
    (3, 3.182, 0.02), (7, 2.365, 1e-3), (15, 2.131, 1e-3), (30, 2.042, 1e-3)])
def test_students_t(freedom, wanted, within):
    assert students_t(0.95, freedom) == pytest.approx(wanted, abs=within)


@pytest.mark.parametrize('count', [1, 7, MOST - 1, MOST, 1000, 12345])
def test_the_mean_is_that_of_all_samples_and_room_does_not_grow(count):
    values = np.random.default_rng(count).normal(3.0, 1.0, count)
    mean = mean_of(values)
    assert mean.mean == pytest.approx(values.mean(), rel=1e-12)
    assert len(mean._batches) < MOST
    assert math.isfinite(mean.half_width) == (count >= LEAST)


def test_with_a_batch_a_sample_it_is_the_textbook_interval():
    values = np.random.default_rng(1).normal(size=20)
    wanted = 2.093 * values.std(ddof=1) / math.sqrt(20)
    assert mean_of(values).half_width == pytest.approx(wanted, rel=1e-3)


def test_intervals_hold_the_true_mean_in_95_of_100_runs_with_memory():
    """x' = 0.9 x + noise remembers 10 samples: an interval from 1 / sqrt(n) would hold 1 in 3."""
    rng = np.random.default_rng(2)
    x = np.zeros(400)
    means = [BatchMean() for _ in x]
    for noise in rng.normal(size=(3000, 400)):
        x = 0.9 * x + noise
        for mean, value in zip(means, x.tolist()):
            mean.add(value)
    held = sum(abs(mean.mean) < mean.half_width for mean in means)
    assert 0.91 < held / 400 < 0.985
    assert sum(not mean.settled for mean in means) / 400 < 0.09


def test_a_drift_is_not_settled_but_one_below_a_hundredth_is():
    t = np.linspace(0.0, 1.0, 500)
    assert not mean_of(1.0 + 0.1 * t).settled
    assert mean_of(1.0 + 0.01 * t).settled
    assert not mean_of(np.exp(-3.0 * t)).settled
    assert mean_of(np.full(500, 2.0)).settled
