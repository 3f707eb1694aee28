"""
Where along an element the wire is nearest to the road: local minima of the gap on its curve.

With x(xi) on the curve and N the surface's normal there, d gap / d xi = N . x'(xi). `line` holds
the wire's nodes from the clamp on in the surface's axes, (2 elements + 1, 3): element e's are its
rows 2 e to 2 e + 2.
"""
from bristle_ros.physics.compiler import jit, load8, store8
from bristle_ros.physics.motion import CLAMP, HEIGHT, ROTATION
from bristle_ros.physics.wire import ELEMENTS, LANES, NODE_FORCE, X

from .curved import place_of
from .surface import gap_at, least_gap_at

ROOT_STEPS = 40
PLACED = 1e-9       # xi at which a minimum is found
BY_GAP = 0.7        # way along the wire that is clear for sure, of the gap: less than 1, since the
#                     gap is a distance only to first order where the road has a profile


@jit
def gap_on(surface, x, y, z, sums):
    """Return what `gap_at` does, on the nominal plane too."""
    if surface is None:
        return z, 0.0, 0.0, 1.0, 0
    return gap_at(surface, x, y, z, sums)


@jit
def fill_line(s, rows, elements, frame, line):
    """Fill line from the nodes' rows (X or X0) and a frame record."""
    line[0, 0], line[0, 1], line[0, 2] = place_of(frame, frame[CLAMP], frame[CLAMP + 1],
                                                  frame[CLAMP + 2])
    for e in range(elements):
        j = e // ELEMENTS
        for i in range(2):
            lane = ELEMENTS * i + e % ELEMENTS
            line[2 * e + 1 + i, 0], line[2 * e + 1 + i, 1], line[2 * e + 1 + i, 2] = place_of(
                frame, s[j, rows * LANES + lane], s[j, (rows + 1) * LANES + lane],
                s[j, (rows + 2) * LANES + lane])


@jit
def _place_on(line, e, xi):
    """Return the place xi of element e (3) [m]."""
    n0, n1, n2 = 0.5 * xi * (xi - 1.0), 1.0 - xi * xi, 0.5 * xi * (xi + 1.0)
    at = 2 * e
    return (n0 * line[at, 0] + n1 * line[at + 1, 0] + n2 * line[at + 2, 0],
            n0 * line[at, 1] + n1 * line[at + 1, 1] + n2 * line[at + 2, 1],
            n0 * line[at, 2] + n1 * line[at + 1, 2] + n2 * line[at + 2, 2])


@jit
def gap_along(surface, line, e, xi, sums):
    """Return the gap at a place on element e [m], and its derivative by xi."""
    x, y, z = _place_on(line, e, xi)
    gap, m1, m2, m3, _ = gap_on(surface, x, y, z, sums)
    d0, d1, d2 = xi - 0.5, -2.0 * xi, xi + 0.5
    at = 2 * e
    return gap, (m1 * (d0 * line[at, 0] + d1 * line[at + 1, 0] + d2 * line[at + 2, 0])
                 + m2 * (d0 * line[at, 1] + d1 * line[at + 1, 1] + d2 * line[at + 2, 1])
                 + m3 * (d0 * line[at, 2] + d1 * line[at + 1, 2] + d2 * line[at + 2, 2]))


@jit
def descend(surface, line, e, xi, stride, sums):
    """Return the place of the local minimum of the gap downhill from xi, on the same element."""
    _, slope = gap_along(surface, line, e, xi, sums)
    if slope == 0.0:
        return xi
    way = -1.0 if slope > 0.0 else 1.0
    a, at_a = xi, way * slope       # negative: downhill
    b, at_b = a, at_a
    while at_b < 0.0:
        if b == way:
            return b
        a, at_a = b, at_b
        b = min(max(b + way * stride, -1.0), 1.0)
        at_b = way * gap_along(surface, line, e, b, sums)[1]
    side = 0
    for iteration in range(ROOT_STEPS):     # regula falsi (Illinois), halving now and then
        if abs(b - a) <= PLACED or at_b == 0.0:
            break
        c = a - at_a * (b - a) / (at_b - at_a)
        if iteration % 8 == 7:
            c = 0.5 * (a + b)
        at_c = way * gap_along(surface, line, e, c, sums)[1]
        if abs(at_c) <= 1e-15 * (abs(at_a) + abs(at_b)):
            return c
        if at_c < 0.0:
            a, at_a = c, at_c
            if side < 0:
                at_b *= 0.5
            side = -1
        else:
            b, at_b = c, at_c
            if side > 0:
                at_a *= 0.5
            side = 1
    return b


@jit
def lowest_on(surface, line, e, samples, sums):
    """Return place and gap of the lowest local minimum that `samples` parts of element e show."""
    best, found = -1.0, 1e300
    for i in range(samples + 1):
        xi = 2.0 * i / samples - 1.0
        gap, _ = gap_along(surface, line, e, xi, sums)
        if gap < found:
            best, found = xi, gap
    best = descend(surface, line, e, best, 1.0 / samples, sums)
    return best, gap_along(surface, line, e, best, sums)[0]


@jit
def _rises_from_tip(surface, line, elements, sums):
    return gap_along(surface, line, elements - 1, 1.0, sums)[1] <= 0.0


@jit
def is_clear_of_plane(s, elements, element_length, frame):
    """
    Return whether nothing but the tip can be at the nominal plane, by the heights of the nodes.

    These are put into NODE_FORCE, which is free between evaluations of forces.

    Nodes are half an element apart along the wire, so no place is further than a quarter from one:
    where they are higher than that, so is what lies between. Next to the tip, which touches, the
    wire is clear if it goes up from there.
    """
    n1, n2, n3 = frame[ROTATION + 6], frame[ROTATION + 7], frame[ROTATION + 8]
    reach = 0.26 * element_length - frame[HEIGHT]
    near = 0
    for j in range(s.shape[0]):
        r = s[j]
        store8(r, NODE_FORCE * LANES, n1 * load8(r, X * LANES) + n2 * load8(r, (X + 1) * LANES)
               + n3 * load8(r, (X + 2) * LANES))
        for i in range(LANES):
            near += r[NODE_FORCE * LANES + i] < reach
    last = elements - 1
    j, lane = last // ELEMENTS, NODE_FORCE * LANES + last % ELEMENTS
    tip = s[j, lane + ELEMENTS]
    near -= tip < reach
    if near > 0:
        return False
    if tip >= reach or elements == 1:
        return True
    k, before = (last - 1) // ELEMENTS, NODE_FORCE * LANES + ELEMENTS + (last - 1) % ELEMENTS
    return 0.5 * s[k, before] - 2.0 * s[j, lane] + 1.5 * tip < 0.0


@jit
def mark_near(surface, elements, element_length, room, sums):
    """
    Mark in room.near the elements that the road may reach beside the tip; return whether any.

    Goes along room.line from the tip, a quarter of an element or as far as the gap allows.
    """
    line, near = room.line, room.near
    near[:elements] = 0
    quarter = 0.25 * element_length
    found = False
    if not _rises_from_tip(surface, line, elements, sums):
        near[elements - 1] = 1
        found = True
    k = 1
    while k < 4 * elements:
        e = elements - 1 - k // 4
        x, y, z = _place_on(line, e, 1.0 - 0.5 * (k % 4))
        spare = least_gap_at(surface, x, y, z, room, sums) - 0.55 * quarter
        if spare <= 0.0:
            near[e] = 1
            if k % 4 == 0 and e + 1 < elements:
                near[e + 1] = 1
            found = True
        k += max(1, int(BY_GAP * spare / quarter))
    return found
