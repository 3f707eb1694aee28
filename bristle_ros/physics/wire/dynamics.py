"""
Equation of motion of the nodes in the brush frame: inertia, frame forces, damping; local error.

A node at x with velocity v relative to the brush frame, frame rates Omega and Omega', feels

    m (g - a0 - 2 Omega x v - Omega x (Omega x x) - Omega' x x) - alpha_D m v

(centrifugal, Euler and Coriolis are the paper's OMEGA, DOMEGA and CORIOLIS), and its section, with
W = w + R^T Omega its absolute angular velocity in section axes,

    -J (w' + R^T Omega' - w x R^T Omega) - W x J W - alpha_D J w.

The mass is lumped by the three-point Gauss-Lobatto rule, so all of it is nodal.
"""
from math import sqrt

from bristle_ros.physics.compiler import jit, load8, store8
from bristle_ros.physics.motion import DRAG_SPIN, GRAVITY, SPIN, SPIN_RATE

from .history import sum_lanes
from .layout import (A0, ACC0, HA, HV, INERTIA, LANES, MASS, NODE_FORCE, Q, Q0, R, tip_lane,
                     TORQUE, X, X0)


@jit
def residual(s, blocks, ca, cv, mass_damping, frame):
    """
    Fill the residual rows from the internal forces and the present increment; section axes.

    ca [1/s^2], cv [1/s], mass_damping (alpha_D) [1/s] : float;  frame : (FRAME,), end of the step
    """
    o1, o2, o3 = frame[SPIN], frame[SPIN + 1], frame[SPIN + 2]
    d1, d2, d3 = frame[SPIN_RATE], frame[SPIN_RATE + 1], frame[SPIN_RATE + 2]
    g1, g2, g3 = frame[GRAVITY], frame[GRAVITY + 1], frame[GRAVITY + 2]
    square = o1 * o1 + o2 * o2 + o3 * o3
    drag = frame[DRAG_SPIN]
    for j in range(blocks):
        for i in range(LANES):
            x1 = s[j, X * LANES + i]
            x2 = s[j, (X + 1) * LANES + i]
            x3 = s[j, (X + 2) * LANES + i]
            u1 = x1 - s[j, X0 * LANES + i]
            u2 = x2 - s[j, (X0 + 1) * LANES + i]
            u3 = x3 - s[j, (X0 + 2) * LANES + i]
            v1 = cv * u1 + s[j, HV * LANES + i]
            v2 = cv * u2 + s[j, (HV + 1) * LANES + i]
            v3 = cv * u3 + s[j, (HV + 2) * LANES + i]
            ox = o1 * x1 + o2 * x2 + o3 * x3
            m = s[j, MASS * LANES + i]
            f1 = m * (g1 - 2.0 * (o2 * v3 - o3 * v2) - o1 * ox + square * x1 - (d2 * x3 - d3 * x2)
                      - mass_damping * (v1 + drag * x2) - ca * u1
                      + s[j, HA * LANES + i]) - s[j, NODE_FORCE * LANES + i]
            f2 = m * (g2 - 2.0 * (o3 * v1 - o1 * v3) - o2 * ox + square * x2 - (d3 * x1 - d1 * x3)
                      - mass_damping * (v2 - drag * x1) - ca * u2
                      + s[j, (HA + 1) * LANES + i]) - s[j, (NODE_FORCE + 1) * LANES + i]
            f3 = m * (g3 - 2.0 * (o1 * v2 - o2 * v1) - o3 * ox + square * x3 - (d1 * x2 - d2 * x1)
                      - mass_damping * v3 - ca * u3 + s[j, (HA + 2) * LANES + i]
                      ) - s[j, (NODE_FORCE + 2) * LANES + i]
            q0 = s[j, Q * LANES + i]
            q1 = s[j, (Q + 1) * LANES + i]
            q2 = s[j, (Q + 2) * LANES + i]
            q3 = s[j, (Q + 3) * LANES + i]
            r11 = 1.0 - 2.0 * (q2 * q2 + q3 * q3)
            r12 = 2.0 * (q1 * q2 - q0 * q3)
            r13 = 2.0 * (q1 * q3 + q0 * q2)
            r21 = 2.0 * (q1 * q2 + q0 * q3)
            r22 = 1.0 - 2.0 * (q1 * q1 + q3 * q3)
            r23 = 2.0 * (q2 * q3 - q0 * q1)
            r31 = 2.0 * (q1 * q3 - q0 * q2)
            r32 = 2.0 * (q2 * q3 + q0 * q1)
            r33 = 1.0 - 2.0 * (q1 * q1 + q2 * q2)
            s[j, R * LANES + i] = r11 * f1 + r21 * f2 + r31 * f3
            s[j, (R + 1) * LANES + i] = r12 * f1 + r22 * f2 + r32 * f3
            s[j, (R + 2) * LANES + i] = r13 * f1 + r23 * f2 + r33 * f3
            s0 = s[j, Q0 * LANES + i]
            s1 = s[j, (Q0 + 1) * LANES + i]
            s2 = s[j, (Q0 + 2) * LANES + i]
            s3 = s[j, (Q0 + 3) * LANES + i]
            inverse = 2.0 / (s0 * q0 + s1 * q1 + s2 * q2 + s3 * q3)
            t1 = inverse * (s0 * q1 - q0 * s1 - s2 * q3 + s3 * q2)
            t2 = inverse * (s0 * q2 - q0 * s2 - s3 * q1 + s1 * q3)
            t3 = inverse * (s0 * q3 - q0 * s3 - s1 * q2 + s2 * q1)
            w1 = cv * t1 + s[j, (HV + 3) * LANES + i]
            w2 = cv * t2 + s[j, (HV + 4) * LANES + i]
            w3 = cv * t3 + s[j, (HV + 5) * LANES + i]
            p1 = r11 * o1 + r21 * o2 + r31 * o3
            p2 = r12 * o1 + r22 * o2 + r32 * o3
            p3 = r13 * o1 + r23 * o2 + r33 * o3
            a1 = (ca * t1 - s[j, (HA + 3) * LANES + i] + r11 * d1 + r21 * d2 + r31 * d3
                  - w2 * p3 + w3 * p2)
            a2 = (ca * t2 - s[j, (HA + 4) * LANES + i] + r12 * d1 + r22 * d2 + r32 * d3
                  - w3 * p1 + w1 * p3)
            a3 = (ca * t3 - s[j, (HA + 5) * LANES + i] + r13 * d1 + r23 * d2 + r33 * d3
                  - w1 * p2 + w2 * p1)
            p1 = p1 + w1
            p2 = p2 + w2
            p3 = p3 + w3
            i1 = s[j, INERTIA * LANES + i]
            i2 = s[j, (INERTIA + 1) * LANES + i]
            i3 = s[j, (INERTIA + 2) * LANES + i]
            y0 = s[j, TORQUE * LANES + i]
            y1 = s[j, (TORQUE + 1) * LANES + i]
            y2 = s[j, (TORQUE + 2) * LANES + i]
            y3 = s[j, (TORQUE + 3) * LANES + i]
            s[j, (R + 3) * LANES + i] = (
                -(q0 * y1 - y0 * q1 - q2 * y3 + q3 * y2)
                - i1 * (a1 + mass_damping * (w1 - drag * r31)) - (i3 - i2) * p2 * p3)
            s[j, (R + 4) * LANES + i] = (
                -(q0 * y2 - y0 * q2 - q3 * y1 + q1 * y3)
                - i2 * (a2 + mass_damping * (w2 - drag * r32)) - (i1 - i3) * p3 * p1)
            s[j, (R + 5) * LANES + i] = (
                -(q0 * y3 - y0 * q3 - q1 * y2 + q2 * y1)
                - i3 * (a3 + mass_damping * (w3 - drag * r33)) - (i2 - i1) * p1 * p2)


@jit
def local_error(s, elements, h, scheme, push):
    """
    Return the local error of the step's displacements, root mean square over the mass [m].

    The scheme's leading error is |beta + sigma / 2 - 1/6| h^3 da/dt, sigma = alpha_m - alpha_f,
    since its A stands for the acceleration at t + sigma h; h da/dt is the change of A, at the tip
    with the change `push` [m/s^2] (3) of what contact gives it, which A does not hold.
    """
    ca = (1.0 - scheme.alpha_m) / ((1.0 - scheme.alpha_f) * scheme.beta * h * h)
    back = 1.0 / (1.0 - scheme.alpha_m)
    by_step, by_old = back * (1.0 - scheme.alpha_f), back * scheme.alpha_f
    total = load8(s[0], MASS * LANES) * 0.0
    mass = total
    for j in range(s.shape[0]):
        r = s[j]
        square = total * 0.0
        for row in range(3):
            change = _change_of_a(r, row, ca, by_step, by_old, back)
            square = square + change * change
        total = total + load8(r, MASS * LANES) * square
        mass = mass + load8(r, MASS * LANES)
    block, lane = tip_lane(elements)
    r = s[block]
    tip_change = 0.0
    for row in range(3):
        store8(r, NODE_FORCE * LANES, _change_of_a(r, row, ca, by_step, by_old, back))
        tip_change += (2.0 * r[NODE_FORCE * LANES + lane] + push[row]) * push[row]
    total = max(sum_lanes(r, total) + r[MASS * LANES + lane] * tip_change, 0.0)
    return error_constant(scheme) * h * h * sqrt(total / sum_lanes(r, mass))


@jit
def fill_changes(s, h, scheme):
    """
    Fill NODE_FORCE with what A changes by over the step; return its square times the mass, summed.

    For `local_error` where contact acts on more nodes than the tip: `add_change` adds that, and
    `error_of_changes` is the result.
    """
    ca = (1.0 - scheme.alpha_m) / ((1.0 - scheme.alpha_f) * scheme.beta * h * h)
    back = 1.0 / (1.0 - scheme.alpha_m)
    by_step, by_old = back * (1.0 - scheme.alpha_f), back * scheme.alpha_f
    total = 0.0
    for j in range(s.shape[0]):
        r = s[j]
        for row in range(3):
            store8(r, (NODE_FORCE + row) * LANES,
                   _change_of_a(r, row, ca, by_step, by_old, back))
            for i in range(LANES):
                total += r[MASS * LANES + i] * r[(NODE_FORCE + row) * LANES + i] ** 2
    return total


@jit
def add_change(s, j, lane, p1, p2, p3):
    """Add to a node's change of A [m/s^2]; return by what the sum of `fill_changes` grows."""
    c1, c2, c3 = (s[j, NODE_FORCE * LANES + lane], s[j, (NODE_FORCE + 1) * LANES + lane],
                  s[j, (NODE_FORCE + 2) * LANES + lane])
    s[j, NODE_FORCE * LANES + lane] = c1 + p1
    s[j, (NODE_FORCE + 1) * LANES + lane] = c2 + p2
    s[j, (NODE_FORCE + 2) * LANES + lane] = c3 + p3
    return s[j, MASS * LANES + lane] * (
        (2.0 * c1 + p1) * p1 + (2.0 * c2 + p2) * p2 + (2.0 * c3 + p3) * p3)


@jit
def error_of_changes(s, total, h, scheme):
    """Return the local error of `local_error` from the sum of `fill_changes` and `add_change`."""
    mass = 0.0
    for j in range(s.shape[0]):
        for i in range(LANES):
            mass += s[j, MASS * LANES + i]
    return error_constant(scheme) * h * h * sqrt(max(total, 0.0) / mass)


@jit
def error_constant(scheme):
    """Return the factor of h^3 da/dt in the scheme's local error."""
    return abs(scheme.beta + 0.5 * (scheme.alpha_m - scheme.alpha_f) - 1.0 / 6.0)


@jit
def _change_of_a(r, row, ca, by_step, by_old, back):
    """Return by how much A changes over the step, a row of displacements of a block."""
    u = load8(r, (X + row) * LANES) - load8(r, (X0 + row) * LANES)
    return (by_step * (ca * u - load8(r, (HA + row) * LANES))
            + by_old * load8(r, (ACC0 + row) * LANES) - back * load8(r, (A0 + row) * LANES))
