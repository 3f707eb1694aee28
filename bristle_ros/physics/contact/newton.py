"""
The contact problem of a step by Newton's method, from the last known force.

Unknown is the tip's force f, with slip s = b_t + W_t f over the step and gap g1 = b_n + W_n f:

    stick   s = 0,  |f_t| <= mu_s f_n;            f_n = F(g1)
    slip    f_t |s| + mu(|s| / h) f_n s = 0;      f_n = F(g1)

with F the normal law (rigid: g1 = 0). Where the tip could stick at the normal force of a slip
solution, that is none: stick is taken wherever it is admissible.
"""
from math import sqrt

from bristle_ros.physics.compiler import jit

from .law import friction_coefficient, holding_force, normal_slope, SLIP, STICK, UNSOLVED

SLIP_ITERATIONS = 12
EXACT = 1e-14       # change of the force at which it is found, relative
OUTSIDE = 1e-6      # of the cone that rounding may leave the friction, where it all but sticks


@jit
def stick(law, h, w, gap0, base, force):
    """Fill `force` with what holds the tip in place; return STICK, or UNSOLVED: not admissible."""
    # f_t = c + d f_n, and with it g1 = a + b f_n
    c1, c2 = holding_force(w, base[0], base[1], 0.0)
    d1, d2 = holding_force(w, 0.0, 0.0, 1.0)
    a = base[2] + w[2, 0] * c1 + w[2, 1] * c2
    b = w[2, 2] + w[2, 0] * d1 + w[2, 1] * d2
    if not b > 0.0:
        return UNSOLVED
    normal = force[2]
    if law.stiffness == 0.0:
        normal = -a / b
    else:
        found = False
        for _ in range(SLIP_ITERATIONS):
            wanted, slope = normal_slope(law, h, gap0, a + b * normal)
            change = (wanted - normal) / (1.0 - slope * b)
            normal += change
            if abs(change) <= EXACT * normal:
                found = True
                break
        if not found:
            return UNSOLVED
    f1, f2 = c1 + d1 * normal, c2 + d2 * normal
    if not (normal > 0.0 and f1 * f1 + f2 * f2 <= (law.static * normal) ** 2):
        return UNSOLVED
    force[0], force[1], force[2] = f1, f2, normal
    return STICK


@jit
def _could_stick(law, w, base, normal):
    """Whether friction could hold the tip in place at this normal force."""
    f1, f2 = holding_force(w, base[0], base[1], normal)
    return f1 * f1 + f2 * f2 <= (law.static * normal) ** 2


@jit
def slip_by_newton(law, h, w, gap0, base, force):
    """Fill `force` with what the slipping tip feels; return SLIP, or UNSOLVED and leave it."""
    f1, f2, f3 = force[0], force[1], force[2]
    if f1 == 0.0 and f2 == 0.0:     # no direction yet: against what the slip would be
        s1 = base[0] + w[0, 2] * f3
        s2 = base[1] + w[1, 2] * f3
        size = sqrt(s1 * s1 + s2 * s2)
        if size == 0.0:
            return UNSOLVED
        f1, f2 = -law.static * f3 * s1 / size, -law.static * f3 * s2 / size
    for _ in range(SLIP_ITERATIONS):
        s1 = base[0] + w[0, 0] * f1 + w[0, 1] * f2 + w[0, 2] * f3
        s2 = base[1] + w[1, 0] * f1 + w[1, 1] * f2 + w[1, 2] * f3
        gap1 = base[2] + w[2, 0] * f1 + w[2, 1] * f2 + w[2, 2] * f3
        size = sqrt(s1 * s1 + s2 * s2)
        if not size > 0.0:
            return UNSOLVED
        mu, fall = friction_coefficient(law, size / h)
        e1, e2 = s1 / size, s2 / size
        # d r_i = size df_i + (f_i + fall / h f3 s_i) e . ds + mu f3 ds_i + mu s_i df3
        k1 = f1 + fall / h * f3 * s1
        k2 = f2 + fall / h * f3 * s2
        n1 = e1 * w[0, 0] + e2 * w[1, 0]
        n2 = e1 * w[0, 1] + e2 * w[1, 1]
        n3 = e1 * w[0, 2] + e2 * w[1, 2]
        m = mu * f3
        a11, a12, a13 = size + k1 * n1 + m * w[0, 0], k1 * n2 + m * w[0, 1], (
            k1 * n3 + m * w[0, 2] + mu * s1)
        a21, a22, a23 = k2 * n1 + m * w[1, 0], size + k2 * n2 + m * w[1, 1], (
            k2 * n3 + m * w[1, 2] + mu * s2)
        if law.stiffness == 0.0:
            r3 = gap1
            a31, a32, a33 = w[2, 0], w[2, 1], w[2, 2]
        else:
            wanted, slope = normal_slope(law, h, gap0, gap1)
            r3 = f3 - wanted
            a31, a32, a33 = -slope * w[2, 0], -slope * w[2, 1], 1.0 - slope * w[2, 2]
        r1 = f1 * size + m * s1
        r2 = f2 * size + m * s2
        b1 = a22 * a33 - a23 * a32
        b2 = a23 * a31 - a21 * a33
        b3 = a21 * a32 - a22 * a31
        inverse = -1.0 / (a11 * b1 + a12 * b2 + a13 * b3)
        d1 = inverse * (r1 * b1 + r2 * (a13 * a32 - a12 * a33) + r3 * (a12 * a23 - a13 * a22))
        d2 = inverse * (r1 * b2 + r2 * (a11 * a33 - a13 * a31) + r3 * (a13 * a21 - a11 * a23))
        d3 = inverse * (r1 * b3 + r2 * (a12 * a31 - a11 * a32) + r3 * (a11 * a22 - a12 * a21))
        f1 += d1
        f2 += d2
        f3 += d3
        if not f3 > 0.0:
            return UNSOLVED
        if abs(d1) + abs(d2) + abs(d3) <= EXACT * f3:
            # a root of the equation, but r = 0 holds for slip along the friction as well, and
            # where slip vanishes for any friction
            bound = mu * f3
            size = sqrt(f1 * f1 + f2 * f2)
            if f1 * s1 + f2 * s2 > 0.0 or abs(size - bound) > OUTSIDE * bound + EXACT * f3 or (
                    _could_stick(law, w, base, f3)):
                return UNSOLVED
            # on the cone to the last bit, where rounding left it a little outside
            if size > bound:
                f1 *= bound / size
                f2 *= bound / size
            force[0], force[1], force[2] = f1, f2, f3
            return SLIP
    return UNSOLVED
