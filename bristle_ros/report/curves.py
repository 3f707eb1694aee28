"""
Error against cost: which runs pay, and what a given error costs between them.

Costs come as one wall time for each round of timing, so that each round has curves and a ratio of
its own: what they spread is the interval. Errors are known up to the converged run's own error.
"""
from itertools import pairwise
import math
from typing import NamedTuple

from .verdict import Measured, spread

CLEAR = 2.0     # times the converged run's own error: what an error must have to be compared


class Point(NamedTuple):
    """A setting: its error, and its cost in each round."""

    error: float
    costs: tuple


def front(points, round_):
    """Return (error, cost) of the points that none beats in a round, from good to bad."""
    paying, best = [], math.inf
    for point in sorted(points, key=lambda point: point.error):
        cost = point.costs[round_]
        if point.error > 0.0 and cost < best:
            best = cost
            paying.append((point.error, cost))
    return paying


def cost_at(paying, error):
    """
    Return the cost of an error between the points of a front, or None where none is as good.

    Both axes are logarithmic. Where the cheapest is better than asked its cost is returned.
    """
    if not paying or error < paying[0][0]:
        return None
    for (e0, c0), (e1, c1) in pairwise(paying):
        if error <= e1:
            share = math.log(error / e0) / math.log(e1 / e0)
            return c0 * (c1 / c0) ** share
    return paying[-1][1]


def shifted(points, own):
    """Return points with the converged run's own error taken off, where something is left."""
    return [point._replace(error=max(point.error - own, 0.1 * own)) for point in points]


def raised(points, own):
    """Return points with the converged run's own error added."""
    return [point._replace(error=point.error + own) for point in points]


def cost_of(points, level, own=0.0):
    """Return the Measured cost of an error level, or None where it is not reached or not clear."""
    if not points or level < CLEAR * own:
        return None
    rounds = range(min(len(point.costs) for point in points))
    found = [cost_at(front(variant, i), level) for i in rounds
             for variant in _variants(points, own)]
    if None in found:
        return None
    middle = spread([cost_at(front(points, i), level) for i in rounds])
    return Measured(middle.value, min(found), max(found))


def ratio_at(theirs, ours, level, own=(0.0, 0.0)):
    """
    Return the Measured ratio of costs, theirs over ours, at an error level, or None.

    Rounds are paired: both were timed in turns.  own : own errors of the converged runs
    """
    if not theirs or not ours or level < CLEAR * max(own):
        return None
    rounds = range(min(len(point.costs) for point in (*theirs, *ours)))
    middle, all_of_them = [], []
    for i in rounds:
        a, b = cost_at(front(theirs, i), level), cost_at(front(ours, i), level)
        if a is None or b is None:
            return None
        middle.append(a / b)
        for x in _variants(theirs, own[0]):
            for y in _variants(ours, own[1]):
                a, b = cost_at(front(x, i), level), cost_at(front(y, i), level)
                if a is None or b is None:
                    return None
                all_of_them.append(a / b)
    return Measured(spread(middle).value, min(all_of_them), max(all_of_them))


def _variants(points, own):
    return (points,) if own == 0.0 else (points, shifted(points, own), raised(points, own))


def rises(rows, key, own):
    """
    Return the pairs (coarse, fine) of rows where a smaller step has the larger error.

    rows : dicts of one family, by falling step;  own : the converged run's own error, below which
    nothing is told apart
    """
    return [(coarse, fine) for coarse, fine in pairwise(rows)
            if fine[key] > coarse[key] + own]
