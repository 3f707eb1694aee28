"""
The tip on a surface that is not the level plane: the contact problem in the step's own plane.

Over a step the tip moves by d = x1 - x0 over the surface, from gap g0 to gap g1. The normal force
f_n acts along the discrete gradient of the gap (Gonzalez 2000, doi 10.1016/S0045-7825(00)00189-4),

    n = N_m + (g1 - g0 - N_m . d) / |d|^2 d,    so that n . d = g1 - g0

with N_m the surface's normal at the middle of the step: its work is f_n (g1 - g0), which by the
normal law of law.py is what the spring gives back, at no step size more. On a plane n = N_m.
Friction acts in the plane across n, so it takes -f_t . d. In that plane's axes the problem is the
one-point problem of bracket.py; the gap is linearised anew in each iteration, about where the tip
would be with the force of the last one:

    g1 = g(p) + N(p) . W (f - f_old)

The correction along d is of second order, (curvature |d|) ^ 2.
"""
from math import sqrt

from bristle_ros.physics.compiler import jit
from bristle_ros.physics.motion import (CLAMP, HEIGHT, HEIGHT_RATE, PATH_SPIN, PLACE, ROTATION,
                                        VELOCITY)
from bristle_ros.physics.wire import CORNER, LANES, MASS, tip_lane, V0, X0

from .bracket import solve_contact
from .law import ContactLaw, OPEN, UNSOLVED
from .surface import gap_at
from .tip import (BEFORE, compliance, contact_correction, finish_contact, FORCE, GAP,
                  free_position, push, rotate, rotate_back, section_axes, SLIP_MOVED, STATE,
                  stopping_force)

SHORT = 1e-20   # [m^2] |d|^2 below which the correction along d is left out


@jit
def law_on(law, gutter, piece):
    """Return the ContactLaw of a piece of the cross-section: the gutter may have its own."""
    if gutter is None:
        return law
    if piece < gutter.first:
        return law
    return ContactLaw(law.stiffness, law.damping, gutter.static, gutter.kinetic, gutter.decay,
                      law.surface, law.wire, law.older)


@jit
def place_of(frame, x1, x2, x3):
    """Return where a point of the brush (its axes) is, in the surface's axes."""
    p1, p2, p3 = rotate(frame, ROTATION, x1, x2, x3)
    return p1 + frame[PLACE], p2 + frame[PLACE + 1], p3 + frame[HEIGHT]


@jit
def is_clear(surface, frame, scratch):
    """Return whether a clamp is above the surface; on the nominal plane the scene sees to it."""
    if surface is None:
        return True
    p1, p2, p3 = place_of(frame, frame[CLAMP], frame[CLAMP + 1], frame[CLAMP + 2])
    return gap_at(surface, p1, p2, p3, scratch[8])[0] > 0.0


@jit
def across(n1, n2, n3):
    """Return two unit vectors across a vector (not of unit length), and its length."""
    length = sqrt(n1 * n1 + n2 * n2 + n3 * n3)
    n1, n2, n3 = n1 / length, n2 / length, n3 / length
    if abs(n1) < 0.9:
        size = 1.0 / sqrt(1.0 - n1 * n1)
        a1, a2, a3 = (1.0 - n1 * n1) * size, -n1 * n2 * size, -n1 * n3 * size
    else:
        size = 1.0 / sqrt(1.0 - n2 * n2)
        a1, a2, a3 = -n2 * n1 * size, (1.0 - n2 * n2) * size, -n2 * n3 * size
    return a1, a2, a3, n2 * a3 - n3 * a2, n3 * a1 - n1 * a3, n1 * a2 - n2 * a1, length


@jit
def step_normal(surface, o, d, gap0, gap1, sums):
    """Return the discrete gradient of the gap over a step by d from o."""
    _, n1, n2, n3, _ = gap_at(surface, o[0] + 0.5 * d[0], o[1] + 0.5 * d[1], o[2] + 0.5 * d[2],
                              sums)
    square = d[0] * d[0] + d[1] * d[1] + d[2] * d[2]
    if square > SHORT:
        by = (gap1 - gap0 - (n1 * d[0] + n2 * d[1] + n3 * d[2])) / square
        n1, n2, n3 = n1 + by * d[0], n2 + by * d[1], n3 + by * d[2]
    return n1, n2, n3


@jit
def _times(w, row, x, y, z):
    return w[row, 0] * x + w[row, 1] * y + w[row, 2] * z


@jit
def solve_in_plane(law, h, tip, scratch, basis, end, d, gaps):
    """
    Solve the contact problem in the axes of the step's plane; fill tip[FORCE:] and its state.

    scratch : (9, 16)   in the first rows the compliance in road axes
    basis : two vectors across the step's normal, and that; end : the normal at the step's end
    d, gaps [m] : (3,), (2,)    displacement over the step; gap at its start and at its end
    Returns whether it could be solved.
    """
    w, local = scratch[:3], scratch[3:8]
    gap0, gap1 = gaps
    for col in range(3):
        b1, b2, b3 = basis[col]
        v1, v2, v3 = _times(w, 0, b1, b2, b3), _times(w, 1, b1, b2, b3), _times(w, 2, b1, b2, b3)
        for row in range(2):
            local[row, col] = basis[row][0] * v1 + basis[row][1] * v2 + basis[row][2] * v3
        local[2, col] = end[0] * v1 + end[1] * v2 + end[2] * v3
    force, base = local[4], local[3]
    for i in range(3):
        b1, b2, b3 = basis[i]
        force[i] = tip[FORCE] * b1 + tip[FORCE + 1] * b2 + tip[FORCE + 2] * b3
        base[i] = d[0] * b1 + d[1] * b2 + d[2] * b3
    n1, n2, n3 = basis[2]
    force[2] /= n1 * n1 + n2 * n2 + n3 * n3
    base[2] = gap1
    for i in range(3):
        base[i] -= _times(local, i, force[0], force[1], force[2])
    state = solve_contact(law, h, local[:3], gap0, base, tip[STATE], force)
    if state == UNSOLVED:
        return False
    tip[STATE] = state
    tip[GAP] = base[2] + _times(local, 2, force[0], force[1], force[2])
    tip[BEFORE] = gap0
    for i in range(3):
        tip[FORCE + i] = (force[0] * basis[0][i] + force[1] * basis[1][i] + force[2] * basis[2][i])
    return True


@jit
def correct_contact(bristle, law, surface, step, frames, scratch):
    """
    Solve the contact problem on whatever surface; returns what `contact_correction` returns.

    surface : Surface or None, of the law;  scratch : (9, 16)
    """
    s, chain, tip = bristle.nodes, bristle.chain, bristle.tip
    elements = chain.shape[0]
    if surface is None:
        return contact_correction(s, chain, tip, elements, law, step, frames, scratch)
    j, lane = tip_lane(elements)
    start, middle, end = frames[0], frames[1], frames[2]
    axes = section_axes(s, j, lane)
    x1, x2, x3 = free_position(s, j, lane, chain[elements - 1], axes)
    o = place_of(start, s[j, X0 * LANES + lane], s[j, (X0 + 1) * LANES + lane],
                 s[j, (X0 + 2) * LANES + lane])
    p = place_of(end, x1, x2, x3)
    d = (p[0] - o[0], p[1] - o[1], p[2] - o[2])
    sums = scratch[8]
    gap0, _, _, _, piece = gap_at(surface, o[0], o[1], o[2], sums)
    gap1, e1, e2, e3, _ = gap_at(surface, p[0], p[1], p[2], sums)
    g1, g2, g3 = tip[FORCE], tip[FORCE + 1], tip[FORCE + 2]
    if g1 == 0.0 and g2 == 0.0 and g3 == 0.0 and gap0 >= 0.0 and gap1 >= 0.0:
        tip[STATE] = OPEN
        tip[GAP], tip[BEFORE] = gap1, gap0
        for i in range(3):
            tip[SLIP_MOVED + i] = d[i]
        return True
    w = scratch[:3]
    compliance(chain[elements - 1], axes, step.gain, middle, end, w)
    n1, n2, n3 = step_normal(surface, o, d, gap0, gap1, sums)
    a1, a2, a3, b1, b2, b3, _ = across(n1, n2, n3)
    if not solve_in_plane(law_on(law, surface.gutter, piece), step.h, tip, scratch,
                           ((a1, a2, a3), (b1, b2, b3), (n1, n2, n3)), (e1, e2, e3), d,
                           (gap0, gap1)):
        return False
    c1, c2, c3 = tip[FORCE] - g1, tip[FORCE + 1] - g2, tip[FORCE + 2] - g3
    for i in range(3):
        tip[SLIP_MOVED + i] = d[i] + _times(w, i, c1, c2, c3)
    f1, f2, f3 = rotate_back(middle, ROTATION, c1, c2, c3)
    push(s, j, lane, step, f1, f2, f3)
    corner = chain[elements - 1]
    for i in range(3):
        corner[CORNER + i] += step.gain * (axes[0][i] * f1 + axes[1][i] * f2 + axes[2][i] * f3)
    return True


@jit
def finish_on_surface(bristle, law, surface, h, end, scratch):
    """Do what `finish_contact` does, in the plane of the surface where the step ended."""
    s, tip = bristle.nodes, bristle.tip
    j, lane = tip_lane(bristle.chain.shape[0])
    if surface is None:
        return finish_contact(s, j, lane, law, h, end, tip)
    if tip[STATE] == OPEN or tip[GAP] > 0.0 and law.stiffness > 0.0:
        return 0.0
    x1 = s[j, X0 * LANES + lane]
    x2 = s[j, (X0 + 1) * LANES + lane]
    x3 = s[j, (X0 + 2) * LANES + lane]
    p1, p2, p3 = place_of(end, x1, x2, x3)
    _, n1, n2, n3, piece = gap_at(surface, p1, p2, p3, scratch[8])
    a1, a2, a3, b1, b2, b3, _ = across(n1, n2, n3)
    o1, o2, o3 = end[PATH_SPIN], end[PATH_SPIN + 1], end[PATH_SPIN + 2]
    r1, r2, r3 = rotate(end, ROTATION, s[j, V0 * LANES + lane] + o2 * x3 - o3 * x2,
                        s[j, (V0 + 1) * LANES + lane] + o3 * x1 - o1 * x3,
                        s[j, (V0 + 2) * LANES + lane] + o1 * x2 - o2 * x1)
    r1, r2, r3 = r1 + end[VELOCITY], r2 + end[VELOCITY + 1], r3 + end[HEIGHT_RATE]
    f1, f2, f3 = tip[FORCE], tip[FORCE + 1], tip[FORCE + 2]
    by = s[j, MASS * LANES + lane] / h
    c1, c2, c3, lost = stopping_force(
        law_on(law, surface.gutter, piece), tip[STATE], by, h,
        (a1 * r1 + a2 * r2 + a3 * r3, b1 * r1 + b2 * r2 + b3 * r3, n1 * r1 + n2 * r2 + n3 * r3),
        (a1 * f1 + a2 * f2 + a3 * f3, b1 * f1 + b2 * f2 + b3 * f3, n1 * f1 + n2 * f2 + n3 * f3))
    if c1 == 0.0 and c2 == 0.0 and c3 == 0.0:
        return 0.0
    f1, f2, f3 = (a1 * c1 + b1 * c2 + n1 * c3, a2 * c1 + b2 * c2 + n2 * c3,
                  a3 * c1 + b3 * c2 + n3 * c3)
    tip[FORCE] += f1
    tip[FORCE + 1] += f2
    tip[FORCE + 2] += f3
    v1, v2, v3 = rotate_back(end, ROTATION, f1 / by, f2 / by, f3 / by)
    s[j, V0 * LANES + lane] += v1
    s[j, (V0 + 1) * LANES + lane] += v2
    s[j, (V0 + 2) * LANES + lane] += v3
    return lost
