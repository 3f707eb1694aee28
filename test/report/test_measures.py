"""What the report decides by: verdicts from intervals, curves of error and cost, timings."""
import math

from bristle_ros.report import curves, timing, verdict
from bristle_ros.report.curves import Point
from bristle_ros.report.stability.show import upper_bound
from bristle_ros.report.verdict import FAILS, HOLDS, Measured, UNDECIDED, UNTESTABLE
import pytest


@pytest.mark.parametrize(('low', 'high', 'word'), [
    (2.0, 3.0, HOLDS), (1.9, 3.0, UNDECIDED), (1.0, 2.0, UNDECIDED), (1.0, 1.9, FAILS)])
def test_an_interval_across_its_threshold_decides_nothing(low, high, word):
    measured = Measured(0.5 * (low + high), low, high)
    assert verdict.at_least(measured, 2.0) == word
    assert verdict.at_most(Measured(-measured.value, -high, -low), -2.0) == word


def test_verdicts_on_several_statements():
    assert verdict.at_least(None, 1.0) == UNTESTABLE
    assert verdict.every(HOLDS, UNDECIDED) == UNDECIDED
    assert verdict.every(HOLDS, UNTESTABLE, FAILS) == FAILS
    assert verdict.every() == UNTESTABLE
    assert verdict.either(FAILS, HOLDS) == HOLDS
    assert verdict.either(FAILS, UNDECIDED) == UNDECIDED
    assert verdict.between(verdict.exact(3.0), 1.0, 2.0) == FAILS
    assert verdict.contradict(HOLDS, FAILS)
    assert not verdict.contradict(HOLDS, UNDECIDED)
    assert verdict.spread([3.0, 1.0, 2.0]) == (2.0, 1.0, 3.0)


def line(factor=1.0, rounds=3):
    """Second order: the error falls with the square of the cost, so cost = factor / sqrt(e)."""
    return [Point(error, tuple(factor * (1.0 + 0.01 * i) / math.sqrt(error)
                               for i in range(rounds))) for error in (1.0, 0.1, 0.01)]


def test_costs_are_interpolated_along_a_power_law():
    paying = curves.front(line(), 0)
    assert curves.cost_at(paying, 0.3) == pytest.approx(0.3 ** -0.5)
    assert curves.cost_at(paying, 0.005) is None
    assert curves.cost_at(paying, 5.0) == pytest.approx(1.0)
    # a run that is both slower and worse than another counts for nothing
    assert curves.front([*line(), Point(0.5, (50.0,) * 3)], 0) == paying


def test_ratios_are_those_of_the_rounds_and_widen_with_the_own_error():
    sharp = curves.ratio_at(line(2.0), line(), 0.1)
    assert sharp == pytest.approx((2.0, 2.0, 2.0))     # slow rounds are slow for both
    blurred = curves.ratio_at(line(2.0), line(), 0.1, (0.01, 0.01))
    assert blurred.low < 2.0 < blurred.high
    assert curves.ratio_at(line(), line(), 0.1, (0.09, 0.0)) is None    # not clear of it
    assert curves.ratio_at(line(), [], 0.1) is None
    assert verdict.widen(None, 2.0) is None


def test_a_rise_of_the_error_is_seen_beyond_the_own_error_only():
    rows = [{'tip': 1.0}, {'tip': 0.5}, {'tip': 0.6}, {'tip': 0.1}]
    assert curves.rises(rows, 'tip', 0.01) == [(rows[1], rows[2])]
    assert curves.rises(rows, 'tip', 0.2) == []


def test_clopper_and_pearson():
    """Zero of n: 1 - 0.05^(1/n), in closed form; 1 of 10: the tabulated 39.4 %."""
    assert upper_bound(0, 1000) == pytest.approx(1.0 - 0.05 ** 1e-3, rel=1e-9)
    assert upper_bound(1, 10) == pytest.approx(0.394, abs=5e-4)
    assert upper_bound(3, 3) == upper_bound(0, 0) == 1.0


def test_quartiles_and_ratios_of_timings():
    assert timing.quartiles([4.0, 1.0, 3.0, 2.0, 5.0]) == (3.0, 2.0, 4.0)
    calm = {'walls': [1.0, 2.0, 1.0], 'disturbed': 0, 'slowest': 1.05}
    other = {'walls': [2.0, 4.2, 1.9], 'disturbed': 0, 'slowest': 1.05}
    assert timing.ratio(other, calm) == pytest.approx((2.0, 1.9, 2.1))
    busy = {**other, 'disturbed': 1, 'slowest': 2.0}
    assert timing.ratio(busy, calm) == pytest.approx((2.0, 0.95, 4.2))


def scripted(samples):
    """Return a Timer whose samples come from a script: {key: [(wall, slow, waited), ...]}."""
    made = timing.Timer(2)
    left = {key: list(values) for key, values in samples.items()}

    def once(timed):
        wall, slow, waited = left[timed.key].pop(0)
        return {'wall': wall, 'slow': slow, 'waited': waited}
    made._once = once
    made._worker = lambda program: type('Worker', (), {'call': staticmethod(lambda *_: 1.0)})
    return made, left


def test_a_disturbed_timing_is_done_again_and_marked_if_that_does_not_help():
    made, left = scripted({
        'calm': [(1.0, 1.0, 0.0), (1.1, 1.02, 0.0)],
        'long': [(9.0, 2.0, 0.0)] * 2,
        'once': [(3.9, 2.0, 0.0), (1.0, 1.0, 0.0), (1.2, 1.0, 0.0)],
        'ever': [(3.9, 2.0, 0.0), (3.5, 1.0, 0.5), (3.0, 1.3, 0.0)] * 2})
    found = made.group([timing.Timed(key, None, ()) for key in left])
    assert found['calm'] == {'walls': [1.0, 1.1], 'disturbed': 0, 'slowest': 1.02}
    assert found['once'] == {'walls': [1.0, 1.2], 'disturbed': 0, 'slowest': 1.0}
    # the least disturbed of three attempts is kept
    assert found['ever'] == {'walls': [3.0, 3.0], 'disturbed': 2, 'slowest': 1.3}
    assert found['long']['disturbed'] == 2      # too long to be done again
    assert not any(left.values())
    assert timing.slowness(found['ever']) == 1.3
    assert timing.slowness(found['calm']) == 1.0
    calm, ever = found['calm'], found['ever']
    assert timing.group_slowness([calm, calm, calm, calm, ever]) == 1.0
    assert timing.group_slowness([calm, ever, ever, None]) == 1.3


def test_on_a_machine_that_is_never_quiet_a_group_takes_half_as_long_again():
    made, left = scripted({key: [(2.0, 2.0, 0.0)] * 6 for key in 'abcdef'})
    found = made.group([timing.Timed(key, None, ()) for key in left])
    assert all(each['disturbed'] == 2 for each in found.values())
    attempts = sum(6 - len(samples) for samples in left.values())
    assert 18 <= attempts <= 19     # 12 and half of that; it is known only afterwards
