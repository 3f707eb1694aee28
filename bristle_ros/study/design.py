"""
The rows of a design, any stretch of them at a time: none is ever held as a whole.

A row is a tuple of values, one for each factor. Which row has which values follows from the study
alone, so that whoever is to run a batch makes its rows itself.
"""
from functools import lru_cache

import numpy as np


def rows(study, first, end):
    """Return rows `first` to `end` - 1 of a design other than `optimise`, as a list of tuples."""
    if study.design == 'grid':
        return [_grid_row(study.factors, number) for number in range(first, end)]
    places = {'sobol': _sobol, 'latin_hypercube': _latin_hypercube,
              'saltelli': _saltelli}[study.design](study, first, end)
    return [tuple(factor.at(float(place)) for factor, place in zip(study.factors, row))
            for row in places]


def _grid_row(factors, number):
    values = []
    for factor in reversed(factors):    # the last key varies fastest
        number, place = divmod(number, factor.size)
        values.append(factor.in_grid(place))
    return tuple(reversed(values))


def _points(dimensions, seed, first, end):
    """Return points of a scrambled Sobol sequence: Owen's, by SciPy."""
    from scipy.stats import qmc
    sequence = qmc.Sobol(dimensions, scramble=True, rng=np.random.default_rng(seed))
    if first:
        sequence.fast_forward(first)
    # random() warns of counts that are no power of 2; a stretch is part of a whole that is
    return np.vstack([sequence.random(1) for _ in range(end - first)])


def _sobol(study, first, end):
    return _points(len(study.factors), study.seed, first, end)


def _latin_hypercube(study, first, end):
    return _hypercube(len(study.factors), study.samples, study.seed)[first:end]


@lru_cache(maxsize=1)
def _hypercube(dimensions, samples, seed):
    """Return all of it, in single precision: permutations cannot be had in parts."""
    from scipy.stats import qmc
    sampler = qmc.LatinHypercube(dimensions, rng=np.random.default_rng(seed))
    return sampler.random(samples).astype(np.float32)


def _saltelli(study, first, end):
    """
    Return rows of Saltelli's scheme, in the order that SALib analyses.

    Base points (A, B) of 2 k numbers make 2 k + 2 rows each: A, A with the i-th number of B for
    each i, B with the i-th number of A for each i, B. Source: Saltelli (2002), Comput. Phys.
    Commun. 145, 280-297.
    """
    k = len(study.factors)
    block = 2 * k + 2
    low, high = first // block, -(-end // block)
    base = _points(2 * k, study.seed, low, high)
    a, b = base[:, None, :k], base[:, None, k:]
    here = np.eye(k, dtype=bool)[None]
    found = np.concatenate(
        (a, np.where(here, b, a), np.where(here, a, b), b), axis=1).reshape(-1, k)
    return found[first - low * block:end - low * block]
