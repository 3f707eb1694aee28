"""
The one place where the report's verdicts are made: from a value, its interval and a threshold.

The words below stand nowhere else in the report; a test searches for them.
"""
from typing import NamedTuple

HOLDS, FAILS, UNDECIDED, UNTESTABLE = ('holds', 'does not hold', 'undecided',
                                       'not testable here')
WORDS = (HOLDS, FAILS, UNDECIDED, UNTESTABLE)


class Measured(NamedTuple):
    """A value and the interval that this run leaves it in."""

    value: float
    low: float
    high: float

    def __str__(self):
        """Write it as `2.1 (1.9 to 2.4)`."""
        value, low, high = (f'{x:.0f}' if 1e3 <= abs(x) < 1e6 else f'{x:.3g}' for x in self)
        return value if self.low == self.high else f'{value} ({low} to {high})'


def exact(value):
    """Return a value whose interval is nothing wide."""
    return Measured(value, value, value)


def spread(values):
    """Return the Measured of a few values: their median, least and largest."""
    ordered = sorted(values)
    middle = len(ordered) // 2
    median = ordered[middle] if len(ordered) % 2 else 0.5 * (ordered[middle - 1]
                                                             + ordered[middle])
    return Measured(median, ordered[0], ordered[-1])


def at_least(measured, threshold):
    """Return the verdict on `value >= threshold`; measured: Measured, or None."""
    if measured is None:
        return UNTESTABLE
    if measured.low >= threshold:
        return HOLDS
    return FAILS if measured.high < threshold else UNDECIDED


def at_most(measured, threshold):
    """Return the verdict on `value <= threshold`; measured: Measured, or None."""
    if measured is None:
        return UNTESTABLE
    if measured.high <= threshold:
        return HOLDS
    return FAILS if measured.low > threshold else UNDECIDED


def between(measured, low, high):
    """Return the verdict on `low <= value <= high`."""
    return every(at_least(measured, low), at_most(measured, high))


def every(*verdicts):
    """Return the verdict on all of some statements together."""
    for word in (FAILS, UNTESTABLE, UNDECIDED):
        if word in verdicts:
            return word
    return HOLDS if verdicts else UNTESTABLE


def contradict(one, other):
    """Whether two verdicts on the same claim exclude each other."""
    return {one, other} == {HOLDS, FAILS}


def widen(measured, factor):
    """Return a Measured whose interval is wider by a factor on both sides; None stays None."""
    return measured and Measured(measured.value, measured.low / factor, measured.high * factor)


def either(*verdicts):
    """Return the verdict on at least one of some statements."""
    for word in (HOLDS, UNDECIDED, FAILS):
        if word in verdicts:
            return word
    return UNTESTABLE
