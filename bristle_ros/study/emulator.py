"""
A smooth stand-in for the model: polynomials of its parameters, with the error that they make.

The measures of contact scatter from one parameter set to the next, and a run is dear. Polynomials
of degree 0 to 3 are laid through runs in a box by least squares, each output has the degree that
foretells best the runs left out, one at a time, and the mean square of what it misses is its
error:

    e_i = (y_i - f(x_i)) / (1 - h_ii),  H = A (A^T A)^-1 A^T,  error^2 = mean of e_i^2.

It holds both what the polynomial cannot follow and the scatter of the model itself.
Source: Myers, Montgomery and Anderson-Cook, Response Surface Methodology (2016), sec. 2.7 (PRESS).
"""
from itertools import combinations_with_replacement

import numpy as np

DEGREE = 3              # the highest
SPARE = 1.5             # runs for each coefficient, at least


class Emulator:
    """
    Polynomials through outputs of runs in a box `center` + `axes` s, with s from -1 to 1.

    center : (p,);  axes : (p, p), a column an axis;  places : (n, p);  outputs : (n, m)
    error : (m,) root mean square of what the polynomials miss
    """

    def __init__(self, center, axes, places, outputs):
        self.center, self.axes = center, axes
        self._inverse = np.linalg.inv(axes)
        self._powers = powers(len(center), DEGREE)
        matrix = self._terms(places)
        self._weights = np.zeros((matrix.shape[1], outputs.shape[1]))
        squares = np.full(outputs.shape[1], np.inf)
        for degree in range(DEGREE + 1):
            used = self._powers.sum(axis=1) <= degree
            if degree and SPARE * used.sum() > len(places):
                break
            weights, missed = _least_squares(matrix[:, used], outputs)
            better = missed < squares
            squares[better] = missed[better]
            self._weights[:, better] = 0.0
            self._weights[np.ix_(used, better)] = weights[:, better]
        self.error = np.sqrt(squares)

    def _terms(self, places):
        inside = (np.atleast_2d(places) - self.center) @ self._inverse.T
        return np.prod(inside[:, None, :] ** self._powers, axis=2)

    def at(self, place):
        """Return the outputs (m,) at a place (p,), or (k, m) at places (k, p)."""
        found = self._terms(place) @ self._weights
        return found if np.ndim(place) == 2 else found[0]

    def slopes(self, place):
        """Return the derivatives of the outputs by the place, (m, p)."""
        inside = self._inverse @ (place - self.center)
        by_box = []
        for i, power in enumerate(self._powers.T):
            lower = self._powers.copy()
            lower[:, i] = np.maximum(power - 1, 0)
            by_box.append((power * np.prod(inside ** lower, axis=1)) @ self._weights)
        return np.array(by_box).T @ self._inverse


def powers(parameters, degree):
    """Return the exponents of all terms up to a degree, (terms, parameters)."""
    found = []
    for size in range(degree + 1):
        for chosen in combinations_with_replacement(range(parameters), size):
            found.append(np.bincount(chosen, minlength=parameters) if chosen
                         else np.zeros(parameters, int))
    return np.array(found)


def _least_squares(matrix, outputs):
    """Return coefficients, and the mean square of each output's runs left out."""
    q, r = np.linalg.qr(matrix)
    along = q.T @ outputs
    leverage = np.einsum('ij,ij->i', q, q)
    missed = (outputs - q @ along) / np.maximum(1.0 - leverage, 1e-9)[:, None]
    return np.linalg.solve(r, along), np.mean(missed ** 2, axis=0)
