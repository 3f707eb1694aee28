"""
The contact of several points on one wire: one-point problems, one after the other, to the end.

The linearised chain answers forces f_q at the points q (the tip is one of them) by

    d_p = d_p(free) + sum_q W_pq f_q,       W_pq = P_p^T K^-1 P_q

P: a point's shape functions. Each one-point problem (bracket.py) is solved with certainty in its
own compliance W_pp, the others' forces held: block Gauss-Seidel, as in nonsmooth contact dynamics
(Jean 1999, doi 10.1016/S0045-7825(98)00383-1). Without friction it descends in the energy of the
chain, K being positive definite, and so ends; with friction it is capped. Two points that share a
node's mass answer almost as one, and each sweep leaves the same part of what was missing: the sum
of that geometric series is added now and then (Aitken's extrapolation, by the vectors' Rayleigh
quotient), and sweeps judge what came out. Where the sweeps do not end, or one point has no
solution (friction jams), the forces stay and the step goes the way of all failures: a new matrix,
then half the step, which makes W nearly diagonal (inertia), and at last a status.
"""
from bristle_ros.physics.compiler import jit, load8, store8
from bristle_ros.physics.motion import HEIGHT_RATE, PATH_SPIN, ROTATION, VELOCITY
from bristle_ros.physics.wire import (eliminate, LANES, LR, MASS, R, substitute, V0, X,
                                      X0)

from .curved import across, law_on, place_of, solve_in_plane, step_normal
from .law import OPEN
from .point import (ALIVE, increment, node_of, OFFSET, position, push_point, weights, XI)
from .search import gap_on
from .tip import (BEFORE, CONTACT, expect_force, FORCE, GAP, rotate, rotate_back, section_axes,
                  SLIP_MOVED, STATE, stopping_force)

SWEEPS = 300
HASTENED = 200      # sweeps in which what is left of a series is added, so often:
HASTE_EVERY = 6
SLOWEST = 0.9995    # part that a sweep may leave of what was missing, for that
SWEPT = 1e-12       # change of a force in a sweep at which it is found, of the largest
COLUMN = 12 * LANES     # of a block: the rows R, then LR


@jit
def law_at(law, surface, piece):
    """Return the ContactLaw where a point is."""
    if surface is None:
        return law
    return law_on(law, surface.gutter, piece)


@jit
def _copy_records(points, tip, room, back):
    """Copy the records of all that take part into room.records, or back from there."""
    records = room.records
    for a in range(room.count[0]):
        slot = room.slots[a]
        for i in range(CONTACT):
            if slot == points.shape[0]:
                if back:
                    tip[i] = records[a, i]
                else:
                    records[a, i] = tip[i]
            elif back:
                points[slot, i] = records[a, i]
            else:
                records[a, i] = points[slot, i]


@jit
def _place(points, slot):
    """Return element and place on it of a slot."""
    if slot == points.shape[0]:
        return slot - 1, 1.0
    return slot, points[slot, XI]


@jit
def gather(bristle, start, room):
    """
    List those that take part, the tip and all points in use; return how many.

    room.slots keeps its order: who is in it stays where it is, its columns with it.
    """
    s, points = bristle.nodes, bristle.points
    elements = points.shape[0]
    count = room.count[0]
    for e in range(elements + 1):
        if e < elements and points[e, ALIVE] == 0.0:
            continue
        known = False
        for a in range(count):
            known = known or room.slots[a] == e
        if known:
            continue
        room.slots[count] = e
        room.ready[count] = 0
        element, xi = _place(points, e)
        x1, x2, x3 = position(s, X0, element, xi, start)
        room.begin[count, 0], room.begin[count, 1], room.begin[count, 2] = place_of(
            start, x1, x2, x3)
        count += 1
    room.count[0] = count
    return count


@jit
def _fill_column(bristle, element, xi, force, gain, room, column):
    """Fill column : (blocks, COLUMN), the increments that a force (axes of the nodes) makes."""
    s, work, elements = bristle.nodes, room.nodes, bristle.chain.shape[0]
    for j in range(s.shape[0]):
        for i in range(6 * LANES):
            work[j, R * LANES + i] = 0.0
            work[j, LR * LANES + i] = 0.0
    n = weights(xi)
    for i in range(3):
        j, lane = node_of(element, i)
        if j < 0 or n[i] == 0.0:
            continue
        axes = section_axes(s, j, lane)
        for k in range(3):
            work[j, (R + k) * LANES + lane] += gain * n[i] * (
                axes[0][k] * force[0] + axes[1][k] * force[1] + axes[2][k] * force[2])
    eliminate(work, elements, bristle.mids, bristle.chain)
    substitute(work, elements, bristle.mids, bristle.chain)
    for j in range(s.shape[0]):
        r, c = work[j], column[j]
        for row in range(6):
            store8(c, row * LANES, load8(r, (R + row) * LANES))
            store8(c, (6 + row) * LANES, load8(r, (LR + row) * LANES))


@jit
def fill_columns(bristle, step, frames, room):
    """Fill columns and compliances of those that have none for the present matrix."""
    s, points, middle, end = bristle.nodes, bristle.points, frames[1], frames[2]
    count = room.count[0]
    new = False
    for a in range(count):
        if room.ready[a] == 0:
            new = True
            element, xi = _place(points, room.slots[a])
            for col in range(3):
                _fill_column(bristle, element, xi,
                             (middle[ROTATION + 3 * col], middle[ROTATION + 3 * col + 1],
                              middle[ROTATION + 3 * col + 2]), step.gain, room,
                             room.columns[a, col])
    if not new:
        return
    for a in range(count):
        element, xi = _place(points, room.slots[a])
        for b in range(count):
            if room.ready[a] > 0 and room.ready[b] > 0:
                continue
            for col in range(3):
                u1, u2, u3 = increment(s, room.columns[b, col], 0, element, xi)
                w1, w2, w3 = rotate(end, ROTATION, u1, u2, u3)
                room.w[a, b, col], room.w[a, b, 3 + col], room.w[a, b, 6 + col] = w1, w2, w3
    for a in range(count):
        room.ready[a] = 1


@jit
def _solve_one(law, surface, h, offset, a, room, scratch):
    """
    Solve the problem of one of them where the others' forces have put it; whether that went.

    Only room.records[a] is filled: to move all with its force is left to the caller.
    """
    o, d, record, sums = room.begin[a], room.moved[a], room.records[a], scratch[8]
    start, _, _, _, piece = gap_on(surface, o[0], o[1], o[2], sums)
    gap, e1, e2, e3, _ = gap_on(surface, o[0] + d[0], o[1] + d[1], o[2] + d[2], sums)
    before, after = start + offset, gap + offset
    if record[FORCE] == 0.0 and record[FORCE + 1] == 0.0 and record[FORCE + 2] == 0.0 and (
            before >= 0.0 and after >= 0.0):
        record[STATE] = OPEN
        record[GAP], record[BEFORE] = after, before
        return True
    for i in range(3):
        for k in range(3):
            scratch[i, k] = room.w[a, a, 3 * i + k]
    if surface is None:
        n1, n2, n3 = 0.0, 0.0, 1.0
        basis = ((1.0, 0.0, 0.0), (0.0, 1.0, 0.0), (0.0, 0.0, 1.0))
    else:
        n1, n2, n3 = step_normal(surface, o, d, start, gap, sums)
        a1, a2, a3, b1, b2, b3, _ = across(n1, n2, n3)
        basis = ((a1, a2, a3), (b1, b2, b3), (n1, n2, n3))
    return solve_in_plane(law_at(law, surface, piece), h, record, scratch, basis, (e1, e2, e3),
                           d, (before, after))


@jit
def _move(room, a, f1, f2, f3):
    """Move all points by a force at one of them."""
    for b in range(room.count[0]):
        w = room.w[b, a]
        for i in range(3):
            room.moved[b, i] += w[3 * i] * f1 + w[3 * i + 1] * f2 + w[3 * i + 2] * f3


@jit
def _sweep(bristle, law, surface, h, room, scratch):
    """Solve all one-point problems once; return the largest change [N], or -1 where one fails."""
    points = bristle.points
    change = before = both = 0.0
    for a in range(room.count[0]):
        slot = room.slots[a]
        record = room.records[a]
        offset = points[slot, OFFSET] if slot < points.shape[0] else 0.0
        f1, f2, f3 = record[FORCE], record[FORCE + 1], record[FORCE + 2]
        if not _solve_one(law, surface, h, offset, a, room, scratch):
            return -1.0
        f1, f2, f3 = record[FORCE] - f1, record[FORCE + 1] - f2, record[FORCE + 2] - f3
        last = room.change[a]
        before += last[0] * last[0] + last[1] * last[1] + last[2] * last[2]
        both += last[0] * f1 + last[1] * f2 + last[2] * f3
        last[0], last[1], last[2] = f1, f2, f3
        if f1 == 0.0 and f2 == 0.0 and f3 == 0.0:
            continue
        change = max(change, abs(f1), abs(f2), abs(f3))
        _move(room, a, f1, f2, f3)
    room.left[0] = both / before if before > 0.0 else 0.0
    return change


@jit
def _hasten(room):
    """Add to all forces what sweeps would, if each left the same part as the last one did."""
    left = room.left[0]
    if left < 0.1 or left > SLOWEST:
        return
    by = left / (1.0 - left)
    for a in range(room.count[0]):
        f1, f2, f3 = by * room.change[a, 0], by * room.change[a, 1], by * room.change[a, 2]
        if f1 == 0.0 and f2 == 0.0 and f3 == 0.0:
            continue
        room.records[a, FORCE] += f1
        room.records[a, FORCE + 1] += f2
        room.records[a, FORCE + 2] += f3
        _move(room, a, f1, f2, f3)


@jit
def _largest(room):
    largest = 0.0
    for a in range(room.count[0]):
        for i in range(3):
            largest = max(largest, abs(room.records[a, FORCE + i]))
    return largest


@jit
def _apply(bristle, step, middle, room):
    """Put what the forces have changed by into histories and increments of the nodes."""
    s, points, tip = bristle.nodes, bristle.points, bristle.tip
    for a in range(room.count[0]):
        slot = room.slots[a]
        element, xi = _place(points, slot)
        f1, f2, f3 = (room.records[a, FORCE], room.records[a, FORCE + 1],
                      room.records[a, FORCE + 2])
        if slot == points.shape[0]:
            f1, f2, f3 = f1 - tip[FORCE], f2 - tip[FORCE + 1], f3 - tip[FORCE + 2]
        else:
            f1, f2, f3 = (f1 - points[slot, FORCE], f2 - points[slot, FORCE + 1],
                          f3 - points[slot, FORCE + 2])
        for i in range(3):
            room.records[a, SLIP_MOVED + i] = room.moved[a, i]
        if f1 == 0.0 and f2 == 0.0 and f3 == 0.0:
            continue
        g1, g2, g3 = rotate_back(middle, ROTATION, f1, f2, f3)
        push_point(s, step, element, xi, g1, g2, g3, False)
        for j in range(s.shape[0]):
            r = s[j]
            one, two, three = (room.columns[a, 0, j], room.columns[a, 1, j], room.columns[a, 2, j])
            for row in range(12):
                at = (R + row if row < 6 else LR + row - 6) * LANES
                store8(r, at, load8(r, at) + load8(one, row * LANES) * f1
                       + load8(two, row * LANES) * f2 + load8(three, row * LANES) * f3)


@jit
def correct_together(bristle, law, surface, step, frames, scratch):
    """
    Solve the contact problem of all points and the tip; the increments in R and LR follow it.

    After `substitute`, with columns filled. Returns whether it could be solved; if not, all stay
    as they were.  scratch : Scratch
    """
    s, points, tip, room = bristle.nodes, bristle.points, bristle.tip, scratch.room
    end = frames[2]
    count = room.count[0]
    _copy_records(points, tip, room, False)
    for a in range(count):
        element, xi = _place(points, room.slots[a])
        x1, x2, x3 = position(s, X, element, xi, end)
        u1, u2, u3 = increment(s, s, R, element, xi)
        p = place_of(end, x1 + u1, x2 + u2, x3 + u3)
        for i in range(3):
            room.moved[a, i] = p[i] - room.begin[a, i]
    solved = False
    room.change[:count] = 0.0
    for sweep in range(1, SWEEPS + 1):
        change = _sweep(bristle, law, surface, step.h, room, scratch.contact)
        if change < 0.0:
            break
        if count == 1 or change <= SWEPT * _largest(room):
            solved = True
            break
        if sweep % HASTE_EVERY == 0 and sweep <= HASTENED:
            _hasten(room)
    if solved:
        _apply(bristle, step, frames[1], room)
        _copy_records(points, tip, room, True)
    return solved


@jit
def begin_points(bristle, step, middle, room):
    """Let the forces that are expected act in the prediction; forget the last step's list."""
    points = bristle.points
    room.count[0] = 0
    for e in range(points.shape[0]):
        if points[e, ALIVE] > 0.0:
            expect_force(points[e], step.h)
            f1, f2, f3 = rotate_back(middle, ROTATION, points[e, FORCE], points[e, FORCE + 1],
                                     points[e, FORCE + 2])
            push_point(bristle.nodes, step, e, points[e, XI], f1, f2, f3, True)


@jit
def _velocity(s, e, xi, end):
    """Return the velocity of a point over the surface [m/s], road axes, at the step's end."""
    n = weights(xi)
    x1, x2, x3 = position(s, X0, e, xi, end)
    o1, o2, o3 = end[PATH_SPIN], end[PATH_SPIN + 1], end[PATH_SPIN + 2]
    v1, v2, v3 = o2 * x3 - o3 * x2, o3 * x1 - o1 * x3, o1 * x2 - o2 * x1
    for i in range(3):
        j, lane = node_of(e, i)
        if j >= 0:
            v1 += n[i] * s[j, V0 * LANES + lane]
            v2 += n[i] * s[j, (V0 + 1) * LANES + lane]
            v3 += n[i] * s[j, (V0 + 2) * LANES + lane]
    r1, r2, r3 = rotate(end, ROTATION, v1, v2, v3)
    return r1 + end[VELOCITY], r2 + end[VELOCITY + 1], r3 + end[HEIGHT_RATE]


@jit
def finish_points(bristle, law, surface, h, end, scratch):
    """Do for points in use what `finish_contact` does for the tip; return what it takes [J]."""
    s, points = bristle.nodes, bristle.points
    lost = 0.0
    for e in range(points.shape[0]):
        point = points[e]
        if point[ALIVE] == 0.0 or point[STATE] == OPEN:
            continue
        if point[GAP] > 0.0 and law.stiffness > 0.0:
            continue
        xi = point[XI]
        x1, x2, x3 = position(s, X0, e, xi, end)
        p1, p2, p3 = place_of(end, x1, x2, x3)
        _, n1, n2, n3, piece = gap_on(surface, p1, p2, p3, scratch[8])
        a1, a2, a3, b1, b2, b3, _ = across(n1, n2, n3)
        r1, r2, r3 = _velocity(s, e, xi, end)
        n = weights(xi)
        inverse = 0.0
        for i in range(3):
            j, lane = node_of(e, i)
            if j >= 0:
                inverse += n[i] * n[i] / s[j, MASS * LANES + lane]
        by = 1.0 / (h * inverse)
        f1, f2, f3 = point[FORCE], point[FORCE + 1], point[FORCE + 2]
        c1, c2, c3, taken = stopping_force(
            law_at(law, surface, piece), point[STATE], by, h,
            (a1 * r1 + a2 * r2 + a3 * r3, b1 * r1 + b2 * r2 + b3 * r3,
             n1 * r1 + n2 * r2 + n3 * r3),
            (a1 * f1 + a2 * f2 + a3 * f3, b1 * f1 + b2 * f2 + b3 * f3,
             n1 * f1 + n2 * f2 + n3 * f3))
        if c1 == 0.0 and c2 == 0.0 and c3 == 0.0:
            continue
        lost += taken
        f1, f2, f3 = (a1 * c1 + b1 * c2 + n1 * c3, a2 * c1 + b2 * c2 + n2 * c3,
                      a3 * c1 + b3 * c2 + n3 * c3)
        point[FORCE] += f1
        point[FORCE + 1] += f2
        point[FORCE + 2] += f3
        v1, v2, v3 = rotate_back(end, ROTATION, h * f1, h * f2, h * f3)
        for i in range(3):
            j, lane = node_of(e, i)
            if j >= 0:
                share = n[i] / s[j, MASS * LANES + lane]
                s[j, V0 * LANES + lane] += share * v1
                s[j, (V0 + 1) * LANES + lane] += share * v2
                s[j, (V0 + 2) * LANES + lane] += share * v3
    return lost
