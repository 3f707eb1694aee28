"""
Parameters from measurements by least squares, with what the data can and cannot tell.

Each parameter is a place u from 0 to 1 in its range, linear or logarithmic. Parameter sets are
drawn to fill a box, the model is run for each, and an `Emulator` of the residuals r = (simulated -
measured) / deviation is searched in its place; sets are drawn anew in a box around what was found,
as wide as its uncertainty, until the place found moves by less than that. With J the emulator's
slopes at the place found, e its errors, n residuals and p parameters,

    W = diag(1 / (1 + e^2)),  covariance = max(1, s^2) (J^T W J)^-1,  s^2 = r^T W r / (n - p),
    interval = u +- t sqrt(diag),  t = t(0.975, n - p),

or as far as r^T W r stays within max(1, s^2) t^2 of its least, whichever is wider: slopes at the
place found need not be those around it.
Sources: Seber and Wild, Nonlinear Regression (1989), sec. 2.1.2 and 5.4 (profile likelihood);
Vernon, Goldstein and Bower (2010), Bayesian Analysis 5(4), 619-669, for the error of an emulator
in a comparison, and rounds.
"""
import math
from typing import NamedTuple

import numpy as np
from scipy.optimize import least_squares, minimize
from scipy.special import stdtrit
from scipy.stats import qmc

from .emulator import Emulator, powers

ROUNDS = 8              # at most
FIRST, LATER = 4, 2     # sets drawn, for each coefficient of a quadratic polynomial
REACH = 3.0             # half a box, in deviations of the place found
ROOM = 1.2              # half a box, of how far likely places lie
STARTS = 8              # places from which an emulator is searched
STAYS = 0.5             # of the half width of an interval: a move that is none
SHRUNK = 0.8            # of the last round's intervals: what is no longer worth a round
UNKNOWN = 0.5           # half width, as a share of the range, from which one is not known
INVOLVED = 0.3          # of a unit vector: parameters that take part in a direction
NOISY = 1.5             # residuals, in deviations, from which a fit is none
_PRIOR = 12.0           # of a place from 0 to 1: 1 / variance
_WALL = 1e3             # residual of a place outside the range by its whole width


class Fit(NamedTuple):
    """What a fit found; arrays in the order of the parameters."""

    value: np.ndarray
    low: np.ndarray         # 95 % interval
    high: np.ndarray
    correlation: np.ndarray
    residuals: np.ndarray   # in deviations assumed, (n,)
    error: np.ndarray       # of the emulator, in the same, (n,)
    scale: float            # s: 1 where the given deviations are right
    doubts: list            # what the data cannot tell, in words
    sets: int               # that were run


class Place(NamedTuple):
    """What one emulator says of the best place."""

    u: np.ndarray
    size: np.ndarray        # singular values of the weighted slopes, over max(1, scale)
    turned: np.ndarray      # (p, p): the directions that they belong to, a column each
    below: np.ndarray       # (p,) from the place to the ends of the 95 % intervals
    above: np.ndarray
    along: np.ndarray       # (p,) how far the likely places lie along each of `turned`
    residuals: np.ndarray
    error: np.ndarray
    scale: float

    @property
    def width(self):
        """Mean half widths of the intervals, (p,)."""
        return 0.5 * (self.below + self.above)

    @property
    def axes(self):
        """The box to draw from next; the range is known beforehand, so it has an end."""
        return self.turned * np.maximum(REACH / np.sqrt(self.size ** 2 + _PRIOR),
                                        ROOM * self.along)


def fit(factors, residuals_of, seed=1, tell=None):
    """
    Fit parameters.

    factors : list of Factor with a range
    residuals_of : list of tuples of values -> list of (n,) residuals, NaN where it cannot be run
    tell(number of round, number of sets, Place) : is called after each round
    Returns None where too few sets can be run.
    """
    p = len(factors)
    coefficients = len(powers(p, 2))
    center, axes = np.full(p, 0.5), 0.5 * np.eye(p)
    places, residuals = np.empty((0, p)), None
    place, moved = None, True
    for turn in range(ROUNDS):
        new = draw(center, axes, (LATER if turn else FIRST) * coefficients, seed + turn)
        found = np.array(residuals_of([_values(factors, u) for u in new]))
        places = np.vstack((places, new))
        residuals = found if residuals is None else np.vstack((residuals, found))
        inside = np.abs((places - center) @ np.linalg.inv(axes).T).max(axis=1) <= 1.0 + 1e-9
        inside &= np.isfinite(residuals).all(axis=1)
        if inside.sum() <= coefficients:
            return None
        before = place
        place = search(Emulator(center, axes, places[inside], residuals[inside]),
                       places[inside])
        if tell:
            tell(turn + 1, len(places), place)
        if before is not None:
            moved = not _stays(before, place)
            if not moved:
                break
        center, axes = place.u, place.axes
    failed = int((~np.isfinite(residuals)).any(axis=1).sum())
    return _judged(factors, place, len(places), failed, moved)


def draw(center, axes, count, seed):
    """Return `count` places (count, p) that fill the part of a box which is in the range."""
    sampler = qmc.Sobol(len(center), rng=np.random.default_rng(seed))
    found = np.empty((0, len(center)))
    while len(found) < count:
        more = center + (2.0 * sampler.random(256) - 1.0) @ axes.T
        found = np.vstack((found, more[((more >= 0.0) & (more <= 1.0)).all(axis=1)]))
    return found[:count]


def search(emulator, starts):
    """Return the Place of the least residuals in an emulator's box, from the best of `starts`."""
    weight = 1.0 / np.sqrt(1.0 + emulator.error ** 2)

    def of(s):
        u = emulator.center + emulator.axes @ s
        return np.concatenate((weight * emulator.at(u), _WALL * (u - np.clip(u, 0.0, 1.0))))

    def slopes(s):
        u = emulator.center + emulator.axes @ s
        wall = np.diag(_WALL * ((u < 0.0) | (u > 1.0)))
        return np.vstack((weight[:, None] * emulator.slopes(u), wall)) @ emulator.axes

    costs = np.sum((weight * emulator.at(starts)) ** 2, axis=1)
    inside = np.linalg.solve(emulator.axes, (starts - emulator.center).T).T
    found = [least_squares(of, np.clip(inside[i], -1.0, 1.0), slopes, bounds=(-1.0, 1.0))
             for i in np.argsort(costs)[:STARTS]]
    best = min(found, key=lambda solution: solution.cost)
    u = np.clip(emulator.center + emulator.axes @ best.x, 0.0, 1.0)
    residuals = emulator.at(u)
    n, p = len(residuals), len(u)
    scale = math.sqrt(np.sum((weight * residuals) ** 2) / (n - p))
    _, size, directions = np.linalg.svd(weight[:, None] * emulator.slopes(u) / max(1.0, scale),
                                        full_matrices=False)
    student = float(stdtrit(n - p, 0.975))
    width = student * np.linalg.norm(directions.T / np.maximum(size, _least(size)), axis=1)
    limit = np.sum(best.fun ** 2) + (max(1.0, scale) * student) ** 2
    below, above = (np.maximum(width, [extent(of, slopes, best.x, sign * row, limit)
                                       for row in emulator.axes]) for sign in (-1.0, 1.0))
    along = np.array([max(extent(of, slopes, best.x, sign * row, limit) for sign in (-1.0, 1.0))
                      for row in directions @ emulator.axes])
    return Place(u, size, directions.T, below, above, along, residuals, emulator.error, scale)


def extent(of, slopes, start, direction, limit):
    """
    Return how far along a direction the sum of squares stays below a limit, in the box -1 to 1.

    of(s) : residuals (n,);  slopes(s) : (n, p);  start : (p,) where the sum is least
    """
    size = float(np.linalg.norm(direction))
    found = minimize(
        lambda s: -(direction @ (s - start)) / size, start, jac=lambda s: -direction / size,
        method='SLSQP', bounds=[(-1.0, 1.0)] * len(start), constraints={
            'type': 'ineq', 'fun': lambda s: 1.0 - np.sum(of(s) ** 2) / limit,
            'jac': lambda s: -2.0 * (of(s) @ slopes(s)) / limit},
        options={'maxiter': 60, 'ftol': 1e-5})
    within = np.sum(of(found.x) ** 2) <= 1.01 * limit
    return max(-size * float(found.fun), 0.0) if within else 0.0


def _least(size):
    return 1e-9 * max(float(size[0]), 1e-300)


def _stays(before, now):
    """Whether a round moved the place by less than its interval, which no longer shrinks."""
    return bool((np.abs(now.u - before.u) <= STAYS * now.width).all()
                and (now.width >= SHRUNK * before.width).all())


def _values(factors, u):
    return tuple(factor.at(float(np.clip(x, 0.0, 1.0))) for factor, x in zip(factors, u))


def _judged(factors, place, sets, failed, moved):
    half = place.turned / np.maximum(place.size, _least(place.size))
    covariance = half @ half.T
    spread = np.sqrt(np.diag(covariance))
    low, value, high = (np.array(_values(factors, u)) for u in (
        place.u - place.below, place.u, place.u + place.above))
    return Fit(value, low, high, covariance / np.outer(spread, spread), place.residuals,
               place.error, place.scale, _doubts(factors, place, sets, failed, moved), sets)


def _doubts(factors, place, sets, failed, moved):
    found = []
    if place.scale > NOISY:
        found.append(f'residuals are {place.scale:.2g} deviations: the model does not come down '
                     'to the noise; the intervals do not hold')
    if moved:
        found.append(f'the place found still moved after {ROUNDS} rounds: the intervals may not '
                     'hold')
    if failed:
        found.append(f'{failed} of {sets} parameter sets could not be run')
    n, p = len(place.residuals), len(factors)
    reach = float(stdtrit(n - p, 0.975)) / np.maximum(place.size, _least(place.size))
    for width, direction in zip(reach, place.turned.T):
        if width < UNKNOWN:
            continue
        names = [factor.key for factor, part in zip(factors, direction) if abs(part) > INVOLVED]
        found.append(f'{names[0]}: the data do not tell it within its range' if len(names) == 1
                     else f'{" and ".join(names)} cannot be told apart')
    for factor, u in zip(factors, place.u):
        if min(u, 1.0 - u) < 1e-3:
            found.append(f'{factor.key}: at the end of its range')
    return list(dict.fromkeys(found))
