"""
Parameters from measurements by least squares, with what the data can and cannot tell.

Each parameter is a place u from 0 to 1 in its range, linear or logarithmic. Residuals are
(simulated - measured) / deviation; derivatives are central differences wide enough that the noise
of simulated impacts does not drown them. With J at the solution, n residuals and p parameters,

    covariance = s^2 (J^T J)^-1,  s^2 = r.r / (n - p),  interval = u +- t(0.975, n - p) sqrt(diag).

Source: Seber and Wild, Nonlinear Regression (1989), sec. 2.1.2 and 5.1.
"""
import math
from typing import NamedTuple

import numpy as np
from scipy.optimize import least_squares
from scipy.special import stdtrit
from scipy.stats import qmc

WIDE = 0.02             # of a parameter's range, each way, of a difference
SCANNED = 10            # starts that are tried before the best is followed, a parameter
APART = 0.98            # correlation from which two parameters cannot be told apart
UNKNOWN = 0.5           # half width, as a share of the range, from which one is not known
NOISY = 1.5             # residuals, in deviations, from which a fit is none
WORST = 1e3             # residual of a row that could not be run


class Fit(NamedTuple):
    """What a fit found; arrays in the order of the parameters."""

    value: np.ndarray
    low: np.ndarray         # 95 % interval
    high: np.ndarray
    correlation: np.ndarray
    residuals: np.ndarray
    scale: float            # s: 1 where the given deviations are right
    doubts: list            # what the data cannot tell, in words
    runs: int


def fit(factors, residuals_of, seed=1):
    """
    Fit parameters.

    factors : list of Factor with a range
    residuals_of : list of tuples of values -> list of (n,) residuals; may work on many at once
    """
    p = len(factors)
    count = 0

    def at(places):
        nonlocal count
        count += len(places)
        found = residuals_of([tuple(factor.at(float(np.clip(u, 0.0, 1.0)))
                                    for factor, u in zip(factors, place)) for place in places])
        return [np.where(np.isfinite(r), r, WORST) for r in found]

    def slopes(u):
        ahead, behind = np.minimum(u + WIDE, 1.0), np.maximum(u - WIDE, 0.0)
        places = []
        for i in range(p):
            for end in (ahead, behind):
                place = u.copy()
                place[i] = end[i]
                places.append(place)
        found = at(places)
        return np.column_stack([(found[2 * i] - found[2 * i + 1]) / (ahead[i] - behind[i])
                                for i in range(p)])

    starts = qmc.LatinHypercube(p, rng=np.random.default_rng(seed)).random(SCANNED * p)
    costs = [float(r @ r) for r in at(list(starts))]
    solution = least_squares(lambda u: at([u])[0], starts[int(np.argmin(costs))], slopes,
                             bounds=(0.0, 1.0), x_scale=0.1, xtol=1e-4, ftol=1e-5, max_nfev=25)
    return _judged(factors, solution.x, solution.fun, slopes(solution.x), count)


def _judged(factors, u, residuals, jacobian, count):
    n, p = jacobian.shape
    scale = math.sqrt(float(residuals @ residuals) / (n - p))
    _, size, axes = np.linalg.svd(jacobian, full_matrices=False)
    floor = 1e-9 * max(float(size[0]), 1e-300)
    half = axes.T / np.maximum(size, floor)
    covariance = scale ** 2 * half @ half.T
    spread = np.sqrt(np.diag(covariance))
    width = float(stdtrit(n - p, 0.975)) * spread
    apart = np.outer(spread, spread)
    correlation = np.divide(covariance, apart, out=np.eye(p), where=apart > 0.0)

    def value(places):
        return np.array([float(factor.at(float(np.clip(place, 0.0, 1.0))))
                         for factor, place in zip(factors, places)])
    return Fit(value(u), value(u - width), value(u + width), correlation, residuals, scale,
               _doubts(factors, u, width, correlation, scale), count)


def _doubts(factors, u, width, correlation, scale):
    found = []
    if scale > NOISY:
        found.append(f'residuals are {scale:.2g} deviations: the model does not come down to the '
                     'noise, or the search stopped early; the intervals do not hold')
    for i, factor in enumerate(factors):
        if width[i] >= UNKNOWN:
            found.append(f'{factor.key}: the data do not tell it within its range')
        elif u[i] in (0.0, 1.0) or min(u[i], 1.0 - u[i]) < 1e-6:
            found.append(f'{factor.key}: at the end of its range')
        for j in range(i):
            if abs(correlation[i, j]) > APART:
                found.append(f'{factors[j].key} and {factor.key} cannot be told apart: '
                             f'correlation {correlation[i, j]:.3f}')
    return found
