"""
Means over time with their confidence intervals, by batch means, in room that does not grow.

Samples of one run depend on those before, so their scatter says little about their mean. Means of
batches much longer than that memory are as good as independent: of n of them with the variance
s^2 between, the mean lies within t s / sqrt(n) of the true one, t Student's with n - 1 degrees of
freedom (Law, Kelton, Simulation Modeling and Analysis, section 9.5.3). There are 16 to 31 batches:
two neighbours become one when there would be more.
"""
from math import inf, sqrt
from statistics import fmean, NormalDist
from typing import NamedTuple

MOST = 32           # batches
LEAST = 8           # with which an interval is told
CONFIDENCE = 0.95
RELEVANT = 0.01     # of the root mean square: a smaller drift of a mean is none


def students_t(confidence: float, freedom: int) -> float:
    """
    Return the two-sided quantile of Student's t for 3 or more degrees of freedom.

    Abramowitz, Stegun, Handbook of Mathematical Functions, 26.7.5; within 1e-4 from 7 on.
    """
    z = NormalDist().inv_cdf(0.5 + 0.5 * confidence)
    terms = (z, (z**3 + z) / 4.0, (5.0 * z**5 + 16.0 * z**3 + 3.0 * z) / 96.0,
             (3.0 * z**7 + 19.0 * z**5 + 17.0 * z**3 - 15.0 * z) / 384.0,
             (79.0 * z**9 + 776.0 * z**7 + 1482.0 * z**5 - 1920.0 * z**3 - 945.0 * z) / 92160.0)
    return float(sum(term / freedom**power for power, term in enumerate(terms)))


def _variance(values: list[float]) -> float:
    # what statistics.variance gives to round-off, at a fiftieth of its time
    mean = fmean(values)
    return sum((value - mean) ** 2 for value in values) / (len(values) - 1)


class Halves(NamedTuple):
    """The means of the first and the second half, and by how much chance lets them differ."""

    first: float
    second: float
    chance: float


class BatchMean:
    """The mean of a quantity whose samples are equally far apart in time."""

    def __init__(self) -> None:
        """Begin without a sample."""
        self.count = 0
        self._sum = self._squares = 0.0
        self._batches: list[float] = []
        self._size = 1              # samples of a batch
        self._open, self._held = 0.0, 0     # sum and number of those that fill none yet

    def add(self, value: float) -> None:
        """Take a sample."""
        self.count += 1
        self._sum += value
        self._squares += value * value
        self._open += value
        self._held += 1
        if self._held == self._size:
            self._batches.append(self._open / self._size)
            self._open, self._held = 0.0, 0
            if len(self._batches) == MOST:
                self._batches = [0.5 * (one + two) for one, two in
                                 zip(self._batches[::2], self._batches[1::2])]
                self._size *= 2

    @property
    def mean(self) -> float:
        """Return the mean of all samples; 0 without any."""
        return self._sum / self.count if self.count else 0.0

    @property
    def half_width(self) -> float:
        """Return half the width of the mean's 95 % interval; inf with too few samples."""
        n = len(self._batches)
        if n < LEAST:
            return inf
        return students_t(CONFIDENCE, n - 1) * sqrt(_variance(self._batches) / n)

    @property
    def halves(self) -> Halves | None:
        """
        Compare the first with the second half of the batches; None with too few samples.

        What chance leaves between two means of n batches each: t sqrt((s1^2 + s2^2) / n), t with
        2 (n - 1) degrees of freedom.
        """
        n = len(self._batches) // 2
        if 2 * n < LEAST:
            return None
        first, second = self._batches[:n], self._batches[-n:]
        spread = (_variance(first) + _variance(second)) / n
        return Halves(fmean(first), fmean(second),
                      students_t(CONFIDENCE, 2 * (n - 1)) * sqrt(spread))

    @property
    def settled(self) -> bool:
        """Whether the halves differ by no more than chance, or than 1 % of the RMS, lets them."""
        halves = self.halves
        if halves is None:
            return True
        drift = abs(halves.first - halves.second)
        return drift <= max(halves.chance, RELEVANT * sqrt(self._squares / self.count))
