"""
The contact problem of a step with certainty: brackets around brackets, where Newton has to pass.

What `newton.py` finds in two or three iterations in nearly every step is tried first.
Where that fails, the friction force's bound and the normal force are each bracketed.
"""
from math import sqrt

from bristle_ros.physics.compiler import jit

from .law import friction_coefficient, holding_force, normal_force, OPEN, SLIP, STICK, UNSOLVED
from .newton import slip_by_newton, stick

BRACKETINGS = 100


@jit
def _bounded(w11, w12, w21, w22, s1, s2, bound):
    """
    Return the friction force of magnitude `bound` that opposes its own slip.

    (W + sigma I) f = -s with sigma >= 0 and |f| = bound: the trust-region problem; Newton's method
    on 1/|f| - 1/bound converges from sigma = 0 without safeguards (More, Sorensen 1983).
    """
    sigma = 0.0
    f1 = 0.0
    f2 = 0.0
    if bound < 1e-60:  # no friction; its square would underflow
        return f1, f2
    for _ in range(BRACKETINGS):
        a = w11 + sigma
        d = w22 + sigma
        inverse = 1.0 / (a * d - w12 * w21)
        f1 = (-s1 * d + s2 * w12) * inverse
        f2 = (s1 * w21 - s2 * a) * inverse
        size = sqrt(f1 * f1 + f2 * f2)
        if size <= bound * (1.0 + 1e-14):
            break
        g1 = (f1 * d - f2 * w12) * inverse
        g2 = (f2 * a - f1 * w21) * inverse
        sigma += size * size / (f1 * g1 + f2 * g2) * (size - bound) / bound
    size = sqrt(f1 * f1 + f2 * f2)
    if size > 0.0:
        f1 *= bound / size
        f2 *= bound / size
    return f1, f2


@jit
def _friction(law, h, w, base1, base2, normal):
    """Return f_t (two components), and STICK or SLIP, at this normal force."""
    s1 = base1 + w[0, 2] * normal
    s2 = base2 + w[1, 2] * normal
    f1, f2 = holding_force(w, base1, base2, normal)
    if f1 * f1 + f2 * f2 <= (law.static * normal) ** 2:
        return f1, f2, STICK
    high = law.static * normal
    f1, f2 = _bounded(w[0, 0], w[0, 1], w[1, 0], w[1, 1], s1, s2, high)
    if law.static == law.kinetic or law.decay == 0.0:
        return f1, f2, SLIP
    # the bound depends on the slip speed: bracket, then regula falsi (Illinois)
    low = law.kinetic * normal
    at_high = high - _bound_at(law, h, w, s1, s2, f1, f2, normal)
    f1, f2 = _bounded(w[0, 0], w[0, 1], w[1, 0], w[1, 1], s1, s2, low)
    at_low = low - _bound_at(law, h, w, s1, s2, f1, f2, normal)
    side = 0
    for _ in range(BRACKETINGS):
        if at_low >= 0.0 or high - low <= 1e-14 * high:
            break
        bound = high - at_high * (high - low) / (at_high - at_low)
        f1, f2 = _bounded(w[0, 0], w[0, 1], w[1, 0], w[1, 1], s1, s2, bound)
        here = bound - _bound_at(law, h, w, s1, s2, f1, f2, normal)
        if abs(here) <= 1e-15 * high:
            break
        if here > 0.0:
            high, at_high = bound, here
            if side < 0:
                at_low *= 0.5
            side = -1
        else:
            low, at_low = bound, here
            if side > 0:
                at_high *= 0.5
            side = 1
    return f1, f2, SLIP


@jit
def _bound_at(law, h, w, s1, s2, f1, f2, normal):
    """Return mu f_n at the slip that this friction force leaves."""
    d1 = s1 + w[0, 0] * f1 + w[0, 1] * f2
    d2 = s2 + w[1, 0] * f1 + w[1, 1] * f2
    speed = sqrt(d1 * d1 + d2 * d2) / h
    return friction_coefficient(law, speed)[0] * normal


@jit
def _mismatch(law, h, w, gap0, base, normal, force):
    """Fill `force` at this normal force; return how much more of it the normal law wants."""
    if law.static > 0.0:
        force[0], force[1], state = _friction(law, h, w, base[0], base[1], normal)
    else:
        force[0] = 0.0
        force[1] = 0.0
        state = SLIP
    force[2] = normal
    gap1 = base[2] + w[2, 0] * force[0] + w[2, 1] * force[1] + w[2, 2] * normal
    if law.stiffness == 0.0:
        return -gap1, state
    return normal_force(law, h, gap0, gap1) - normal, state


@jit
def _checked(law, w, base, force, state):
    """Return the state of a solution, UNSOLVED where its friction does not oppose its slip."""
    if state == STICK or law.static == 0.0:
        return state
    slip1 = base[0] + w[0, 0] * force[0] + w[0, 1] * force[1] + w[0, 2] * force[2]
    slip2 = base[1] + w[1, 0] * force[0] + w[1, 1] * force[1] + w[1, 2] * force[2]
    along = slip1 * force[0] + slip2 * force[1]
    across = slip1 * force[1] - slip2 * force[0]
    if along > 0.0 or abs(across) > -1e-3 * along:
        scale = abs(base[0]) + abs(base[1]) + 1e-15
        if max(abs(slip1), abs(slip2)) > 1e-9 * scale:  # else it all but sticks: round-off
            return UNSOLVED
    return state


@jit
def _by_newton(law, h, w, gap0, base, state, force):
    """
    Fill `force` by Newton's method from what it is; return STICK, SLIP, or UNSOLVED and leave it.

    What the state on entry was is tried first.
    """
    sticking = state == STICK
    for _ in range(1 if law.older else 2):
        if sticking:
            state = stick(law, h, w, gap0, base, force)
        else:
            state = slip_by_newton(law, h, w, gap0, base, force)
        if state != UNSOLVED:
            break
        sticking = not sticking
    return state


@jit
def solve_contact(law, h, w, gap0, base, state, force):
    """
    Solve the one-point contact problem of a step: fill `force` [N] (3,), return its state.

    On entry `state` and `force` are what to start from: those of the last iteration or step. Of
    several solutions (friction can jam a steep tip) one that continues them is found, where a
    touch begins one near the normal force without friction.

    The state is OPEN, SLIP, STICK, or UNSOLVED where no force satisfies the laws.

    w [m/N] : (3, 3)      compliance of the tip: displacement over the step per unit of force
    gap0 [m] : float      gap at the start of the step
    base [m] : (3,)       slip over the step and gap at its end if there were no contact force
    The mismatch of the normal law has one sign at zero and the other for large forces, since w is
    positive definite; between them regula falsi (Illinois) always ends.
    """
    # what the mismatch may be per unit of force: N, or m of gap
    enough = 1e-13 if law.stiffness > 0.0 else 1e-15 * w[2, 2]
    guess = force[2]
    pressed = base[2] < 0.0 or (gap0 < 0.0 and law.stiffness > 0.0 and not law.older)
    if pressed and guess > 0.0 and law.static > 0.0:
        state = _by_newton(law, h, w, gap0, base, state, force)
        if state != UNSOLVED:
            return state
    force[0] = 0.0
    force[1] = 0.0
    force[2] = 0.0
    if base[2] >= 0.0 and (gap0 >= 0.0 or law.stiffness == 0.0):
        return OPEN
    low = 0.0
    if law.stiffness == 0.0:
        at_low = -base[2]
    else:
        at_low = normal_force(law, h, gap0, base[2])
    if at_low <= 0.0:
        return OPEN
    high = guess
    if high <= 0.0:
        high = at_low / w[2, 2] if law.stiffness == 0.0 else at_low / (
            1.0 + law.stiffness * w[2, 2])
        if law.static > 0.0 and not law.older:
            force[2] = high
            state = _by_newton(law, h, w, gap0, base, SLIP, force)
            if state != UNSOLVED:
                return state
    at_high, state = _mismatch(law, h, w, gap0, base, high, force)
    for _ in range(BRACKETINGS):
        if at_high <= 0.0:
            break
        low = high
        at_low = at_high
        high *= 2.0
        at_high, state = _mismatch(law, h, w, gap0, base, high, force)
    if at_high > 0.0:
        return UNSOLVED
    side = 0
    here = at_high
    normal = high
    for iteration in range(BRACKETINGS):
        if abs(here) <= enough * normal:
            return _checked(law, w, base, force, state)
        if high - low <= 4e-16 * high:
            break
        normal = high - at_high * (high - low) / (at_high - at_low)
        if iteration % 4 == 3 or not low < normal < high:
            normal = 0.5 * (low + high)
        here, state = _mismatch(law, h, w, gap0, base, normal, force)
        if here < 0.0:
            high, at_high = normal, here
            if side < 0:
                at_low *= 0.5
            side = -1
        else:
            low, at_low = normal, here
            if side > 0:
                at_high *= 0.5
            side = 1
    if abs(here) <= 1e6 * enough * normal:  # round-off of a steep law
        return _checked(law, w, base, force, state)
    return UNSOLVED
