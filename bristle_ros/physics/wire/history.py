"""
What a step starts from, and what it is expected to end in.

A step's prediction is extrapolated from the last accelerations; one that has converged leaves its
own behind.
"""
from math import sqrt

from bristle_ros.physics.compiler import jit, load8, store8

from .layout import (A0, ACC0, HA, HV, JUMP, LANES, LAST_JUMP, MASS, NODE_FORCE, Q, Q0, R, ROWS,
                     V0, X, X0)

NOISE = 1e-8        # part of the squares of changes that is none
NOTHING = 1e-200    # of them that is no change


@jit
def begin_step(s, blocks, h, scheme, trend, trend_before):
    """
    Fill the histories HA, HV and put the predicted positions into X, Q.

    The prediction is the increment with A1 = A0 + trend * its last change + trend_before * the one
    before: see `accept_step`.

    With u the increment over the step (for rotations the vector 2 tan(angle / 2) along the axis)
    generalized-alpha gives acceleration = ca u - HA and velocity = cv u + HV; see scheme.py.
    """
    relation = 1.0 / (1.0 - scheme.alpha_f)
    by_velocity = (1.0 - scheme.alpha_m) * relation / (scheme.beta * h)
    by_pseudo = ((1.0 - scheme.alpha_m) * (0.5 / scheme.beta - 1.0) - scheme.alpha_m) * relation
    by_acceleration = scheme.alpha_f * relation
    keep = 1.0 - scheme.gamma / scheme.beta
    drift = h * (1.0 - 0.5 * scheme.gamma / scheme.beta)
    half = 0.5 * h * h
    ahead, further = scheme.beta * h * h * trend, scheme.beta * h * h * trend_before
    for j in range(blocks):
        r = s[j]
        for row in range(6):
            v, a = load8(r, (V0 + row) * LANES), load8(r, (A0 + row) * LANES)
            store8(r, (HA + row) * LANES, by_velocity * v + by_pseudo * a
                   + by_acceleration * load8(r, (ACC0 + row) * LANES))
            store8(r, (HV + row) * LANES, keep * v + drift * a)
        for row in range(3):
            store8(r, (X + row) * LANES, load8(r, (X0 + row) * LANES)
                   + h * load8(r, (V0 + row) * LANES) + half * load8(r, (A0 + row) * LANES)
                   + ahead * load8(r, (JUMP + row) * LANES)
                   + further * load8(r, (LAST_JUMP + row) * LANES))
        for i in range(LANES):
            t1 = 0.5 * (h * s[j, (V0 + 3) * LANES + i] + half * s[j, (A0 + 3) * LANES + i]
                        + ahead * s[j, (JUMP + 3) * LANES + i]
                        + further * s[j, (LAST_JUMP + 3) * LANES + i])
            t2 = 0.5 * (h * s[j, (V0 + 4) * LANES + i] + half * s[j, (A0 + 4) * LANES + i]
                        + ahead * s[j, (JUMP + 4) * LANES + i]
                        + further * s[j, (LAST_JUMP + 4) * LANES + i])
            t3 = 0.5 * (h * s[j, (V0 + 5) * LANES + i] + half * s[j, (A0 + 5) * LANES + i]
                        + ahead * s[j, (JUMP + 5) * LANES + i]
                        + further * s[j, (LAST_JUMP + 5) * LANES + i])
            q0, q1, q2, q3 = (s[j, Q0 * LANES + i], s[j, (Q0 + 1) * LANES + i],
                              s[j, (Q0 + 2) * LANES + i], s[j, (Q0 + 3) * LANES + i])
            n = 1.0 / sqrt(1.0 + t1 * t1 + t2 * t2 + t3 * t3)
            s[j, Q * LANES + i] = n * (q0 - q1 * t1 - q2 * t2 - q3 * t3)
            s[j, (Q + 1) * LANES + i] = n * (q1 + q0 * t1 + q2 * t3 - q3 * t2)
            s[j, (Q + 2) * LANES + i] = n * (q2 + q0 * t2 + q3 * t1 - q1 * t3)
            s[j, (Q + 3) * LANES + i] = n * (q3 + q0 * t3 + q1 * t2 - q2 * t1)


@jit
def sum_lanes(r, lanes):
    """Return the sum of a vector, by way of a row that is free between evaluations of forces."""
    store8(r, NODE_FORCE * LANES, lanes)
    total = 0.0
    for i in range(LANES):
        total += r[NODE_FORCE * LANES + i]
    return total


@jit
def _fill_turns(s, j):
    """Put the rotation increments of a block's nodes into the last three residual rows."""
    # the compiler would write eight lanes out one by one if it could count them
    for i in range(s.shape[1] // ROWS):
        q0, q1, q2, q3 = (s[j, Q * LANES + i], s[j, (Q + 1) * LANES + i],
                          s[j, (Q + 2) * LANES + i], s[j, (Q + 3) * LANES + i])
        s0, s1, s2, s3 = (s[j, Q0 * LANES + i], s[j, (Q0 + 1) * LANES + i],
                          s[j, (Q0 + 2) * LANES + i], s[j, (Q0 + 3) * LANES + i])
        inverse = 2.0 / (s0 * q0 + s1 * q1 + s2 * q2 + s3 * q3)
        s[j, (R + 3) * LANES + i] = inverse * (s0 * q1 - q0 * s1 - s2 * q3 + s3 * q2)
        s[j, (R + 4) * LANES + i] = inverse * (s0 * q2 - q0 * s2 - s3 * q1 + s1 * q3)
        s[j, (R + 5) * LANES + i] = inverse * (s0 * q3 - q0 * s3 - s1 * q2 + s2 * q1)


@jit
def accept_step(s, blocks, h, scheme):
    """
    Carry positions, velocities and accelerations over to the start of the next step.

    Returns which parts of the last change of A and of the one before the next change is expected
    to be: those that would have given the last one, d0, from the two before, d1 and d2, with the
    least squares left. That is 2 and -1 in smooth motion, 2 cos(omega h) and -1 in a harmonic one.
    """
    beta_h2 = 1.0 / (scheme.beta * h * h)
    ca = beta_h2 * (1.0 - scheme.alpha_m) / (1.0 - scheme.alpha_f)
    cv = scheme.gamma / (scheme.beta * h)
    back = 1.0 / (1.0 - scheme.alpha_m)
    by_step, by_old = back * (1.0 - scheme.alpha_f), back * scheme.alpha_f
    by_pseudo = back * scheme.alpha_m
    d01 = load8(s[0], MASS * LANES) * 0.0
    d02, d11, d12, d22 = d01, d01, d01, d01
    for j in range(blocks):
        r = s[j]
        _fill_turns(s, j)
        for row in range(3):
            store8(r, (R + row) * LANES,
                   load8(r, (X + row) * LANES) - load8(r, (X0 + row) * LANES))
        for row in range(6):
            u = load8(r, (R + row) * LANES)
            acceleration = ca * u - load8(r, (HA + row) * LANES)
            old, jump = load8(r, (A0 + row) * LANES), load8(r, (JUMP + row) * LANES)
            new = (by_step * acceleration + by_old * load8(r, (ACC0 + row) * LANES)
                   - by_pseudo * old)
            last = load8(r, (LAST_JUMP + row) * LANES)
            d01 = d01 + jump * (new - old)
            d11 = d11 + jump * jump
            d02 = d02 + last * (new - old)
            d12 = d12 + jump * last
            d22 = d22 + last * last
            store8(r, (V0 + row) * LANES, cv * u + load8(r, (HV + row) * LANES))
            store8(r, (LAST_JUMP + row) * LANES, jump)
            store8(r, (JUMP + row) * LANES, new - old)
            store8(r, (A0 + row) * LANES, new)
            store8(r, (ACC0 + row) * LANES, acceleration)
        for row in range(7):
            store8(r, (X0 + row) * LANES, load8(r, (X + row) * LANES))
    r = s[0]
    return trends(scheme.tied, sum_lanes(r, d01), sum_lanes(r, d11), sum_lanes(r, d02),
                  sum_lanes(r, d12), sum_lanes(r, d22))


@jit
def trends(both, d01, d11, d02, d12, d22):
    """
    Return x, y for which the square of d0 - x d1 - y d2 is least; dij: their products.

    Roots of z^2 = x z + y are kept in the unit circle, so that what is expected does not grow.
    both : bool     False: from d1 alone, as bits of old logs need it
    """
    size = d11 + d22
    if d11 == 0.0 or both and size < NOTHING:
        return 0.0, 0.0
    if not both:
        return min(max(d01 / d11, -1.0), 1.0), 0.0
    d11, d12, d22 = d11 / size + NOISE, d12 / size, d22 / size + NOISE
    d01, d02 = d01 / size, d02 / size
    y = min(max((d02 * d11 - d01 * d12) / (d11 * d22 - d12 * d12), -1.0), 1.0)
    return min(max((d01 - d12 * y) / d11, y - 1.0), 1.0 - y), y


@jit
def rescale_memory(s, blocks, ratio):
    """
    Carry the pseudo-acceleration over to a new step size, `ratio` times the old one.

    It stands for the acceleration at a fixed fraction of the step from the step's end, so its
    distance from the true one goes with the step (Arnold, Bruels 2007, doi
    10.1007/s11044-007-9084-0).
    """
    for j in range(blocks):
        for row in range(6):
            for i in range(LANES):
                true = s[j, (ACC0 + row) * LANES + i]
                s[j, (A0 + row) * LANES + i] = true + ratio * (s[j, (A0 + row) * LANES + i] - true)
                s[j, (JUMP + row) * LANES + i] *= ratio
                s[j, (LAST_JUMP + row) * LANES + i] *= ratio
