"""
How points of contact come and go: born where a step ends below the road, carried on, given up.

A point is born where a local minimum of the gap along an element is negative at the end of a step
that has converged without it; the step then goes on with it. From step to step a point in use
follows its minimum; at a corner it goes over to the next element, whose slot is free, or ends
where that has a point next to it already. Else it ends only once it is open.

Who owns the stored energy: the point, whatever its place; its law sees the true gap plus OFFSET.
At a new place the true gap is another, and what the spring stores with it: the difference comes
from a tank, which keeps what contact has taken from the wire in excess: places that are higher,
points that end, the stopping of points and tip (finish_contact), and for one step a part of what
friction took in it. Where the tank is empty the law's gap stays as it was and OFFSET grows; where
it is not, offsets fall to 0 over RELAXATION. Over a run contact and friction so give nothing, and
the road does not yield from step to step: with gaps of the law that never fall, and no tank, a
wire at rest walked down through the road in a second. Rigid roads store nothing, and no price of a
lower place is known beforehand: the law's gap stays.

The place is the minimum's in the middle of the step, by its motion over the last one: its gap is
the same at the end of one step and at the start of the next, to third order.
"""
from math import sqrt

from bristle_ros.physics.compiler import jit
from bristle_ros.physics.wire import X, X0

from .law import OPEN, spring_energy
from .point import ALIVE, LOWEST, MOST, OFFSET, POINT, XI
from .search import descend, fill_line, gap_along, lowest_on, mark_near
from .tip import BEFORE, FORCE, GAP, LIVING, SLIP_MOVED, STATE, TANK

# Points that share most of a node's mass answer almost as one, and sweeps over them leave most of
# what is missing: the squared cosine of the angle between two, 0.92 at the distance at which one
# ends, 0.997 beside the tip. None is born nearer than twice that, so that none comes and goes in
# turn: each time would cost what its spring stores.
BORN_APART = 0.1    # [xi] from a neighbour's point
ENDS_APART = 0.05
BORN_INSIDE = 0.1   # [xi] from tip and clamp
ENDS_INSIDE = 0.05
MISSED = 1e-7       # [element lengths] below the road at which a point is born
RELAXATION = 5e-3   # [s] over which a point's offset falls to 1/e
RUBBED = 0.5        # of the friction's work in a step that may go into offsets
MOST_AHEAD = 0.05   # [xi] by which a minimum is taken to move on in a step
STRIDE = 0.25       # of xi, of the search for a minimum

NONE_BORN = 0
TOO_MANY = -1


@jit
def _is_taken(points, e, elements, xi, apart, inside):
    """Return whether a neighbour's point is nearer than `apart`, or tip or clamp than `inside`."""
    if e == elements - 1:
        if 1.0 - xi < inside:
            return True
    elif points[e + 1, ALIVE] > 0.0 and 2.0 - xi + points[e + 1, XI] < apart:
        return True
    if e == 0:
        return 1.0 + xi < inside
    return points[e - 1, ALIVE] > 0.0 and 2.0 + xi - points[e - 1, XI] < apart


@jit
def _goes_on(surface, line, points, e, elements, xi, sums):
    """Return whether a minimum at an element's end is one that a neighbour has to care for."""
    if xi == 1.0 and e < elements - 1:
        return gap_along(surface, line, e + 1, -1.0, sums)[1] < 0.0 and points[e + 1, ALIVE] == 0.0
    if xi == -1.0 and e > 0:
        return points[e - 1, ALIVE] == 0.0
    return False


@jit
def _new_point(point, xi, gap):
    """Fill the record of a new point; gap [m]: the true one at the start of the step."""
    for i in range(POINT):
        point[i] = 0.0
    point[XI], point[LOWEST], point[ALIVE], point[STATE] = xi, xi, 1.0, OPEN
    point[GAP] = point[BEFORE] = max(gap, 0.0)
    point[OFFSET] = point[GAP] - gap


@jit
def find_points(bristle, law, surface, wire, element_length, frames, scratch):
    """
    Let points be born where the present positions, a step's end, are below the road.

    On the plane it is for those that `is_clear_of_plane` does not leave out.

    Returns how many, or TOO_MANY. scratch : Scratch
    """
    s, points, tip, room = bristle.nodes, bristle.points, bristle.tip, scratch.room
    elements = points.shape[0]
    start, end, sums = frames[0], frames[2], scratch.contact[8]
    line = room.line
    fill_line(s, X, elements, end, line)
    if surface is None:
        room.near[:elements] = 1
    elif not mark_near(surface, elements, element_length, room, sums):
        return NONE_BORN
    born = 0
    for e in range(elements):
        if room.near[e] == 0 or points[e, ALIVE] > 0.0:
            continue
        xi, gap = lowest_on(surface, line, e, wire.samples, sums)
        if gap >= -MISSED * element_length or _is_taken(
                points, e, elements, xi, BORN_APART, BORN_INSIDE) or _goes_on(
                surface, line, points, e, elements, xi, sums):
            continue
        if tip[LIVING] + 2.0 > MOST:
            return TOO_MANY
        if born == 0:
            if tip[LIVING] == 0.0:
                room.count[0] = 0
            fill_line(s, X0, elements, start, room.begun)
        _new_point(points[e], xi, gap_along(surface, room.begun, e, xi, sums)[0])
        tip[LIVING] += 1.0
        born += 1
    return born


@jit
def _follow(surface, line, points, e, elements, sums):
    """
    Return element and place that the point of element e goes to; element -1: it ends.

    Its own slot counts as free.
    """
    xi = descend(surface, line, e, points[e, XI], STRIDE, sums)
    if xi == 1.0 and e < elements - 1:
        if points[e + 1, ALIVE] == 0.0 and gap_along(surface, line, e + 1, -1.0, sums)[1] < 0.0:
            e, xi = e + 1, descend(surface, line, e + 1, -1.0, STRIDE, sums)
    elif xi == -1.0 and e > 0 and points[e - 1, ALIVE] == 0.0:
        e, xi = e - 1, descend(surface, line, e - 1, 1.0, STRIDE, sums)
    if _is_taken(points, e, elements, xi, ENDS_APART, ENDS_INSIDE):
        return -1, 0.0
    return e, xi


@jit
def _deepest(law, gap, tank):
    """Return the least gap that the law may see instead of this one [m], if the tank pays."""
    depth = max(-gap, 0.0)
    return -sqrt(depth * depth + 2.0 * max(tank, 0.0) / law.stiffness)


@jit
def _settle(law, point, gap, h, tank):
    """
    Choose the law's gap where the true one is `gap`; return what that takes from the tank [J].

    The spring's energy is k p^2 / 2, p: how deep the law sees it.
    """
    before = point[GAP]
    if law.stiffness == 0.0:
        point[GAP] = max(before, gap)
    else:
        wanted = gap + point[OFFSET] * max(1.0 - h / RELAXATION, 0.0)
        point[GAP] = max(wanted, gap, _deepest(law, before, tank))
    point[OFFSET] = point[GAP] - gap
    return spring_energy(law.stiffness, point[GAP]) - spring_energy(law.stiffness, before)


@jit
def rubbed(law, points):
    """Return what friction and damping at the points have taken in a converged step [J]."""
    total = 0.0
    for e in range(points.shape[0]):
        point = points[e]
        if point[ALIVE] > 0.0 and point[STATE] != OPEN:
            total += spring_energy(law.stiffness, point[BEFORE])
            total -= spring_energy(law.stiffness, point[GAP])
            for i in range(3):
                total -= point[FORCE + i] * point[SLIP_MOVED + i]
    return max(total, 0.0)


@jit
def carry_points(bristle, law, surface, h, end, taken, scratch):
    """
    Move the points on, at the end of a step of length h; return the energy that this loses [J].

    end : (FRAME,)      frame record of the step's end; the positions are in X0 already
    taken [J] : (2,)    what stopping points and tip has taken in the step, and what was `rubbed`
    """
    s, points, tip = bristle.nodes, bristle.points, bristle.tip
    elements, sums = points.shape[0], scratch.contact[8]
    line = scratch.room.line
    fill_line(s, X0, elements, end, line)
    lost = 0.0
    kept = tip[TANK] + taken[0]
    tank = kept + RUBBED * taken[1]
    done = -1
    for e in range(elements):
        if points[e, ALIVE] == 0.0 or e <= done:
            continue
        points[e, ALIVE] = 0.0
        to, xi = -1, 0.0
        if points[e, STATE] != OPEN:
            to, xi = _follow(surface, line, points, e, elements, sums)
        if to < 0:
            tip[LIVING] -= 1.0
            stored = spring_energy(law.stiffness, points[e, GAP])
            tank += stored
            kept += stored
            lost += stored
            continue
        if to != e:
            for i in range(POINT):
                points[to, i] = points[e, i]
            done = to
        point = points[to]
        point[ALIVE] = 1.0
        lowest = xi
        if abs(xi) < 1.0:       # where it will be in the middle of the next step
            before = point[LOWEST] + 2.0 * (e - to)
            xi = min(max(xi + 0.5 * min(max(xi - before, -MOST_AHEAD), MOST_AHEAD), -1.0), 1.0)
        point[LOWEST] = lowest
        point[XI] = xi
        cost = _settle(law, point, gap_along(surface, line, to, xi, sums)[0], h, tank)
        tank -= cost
        lost -= cost
    tip[TANK] = min(tank, kept)
    return lost


@jit
def restore_points(points, tip, kept, living):
    """Put the points back as they were before a step that failed."""
    if living > 0.0:
        for e in range(points.shape[0]):
            for i in range(POINT):
                points[e, i] = kept[e, i]
    elif tip[LIVING] > 0.0:
        for e in range(points.shape[0]):
            points[e, ALIVE] = 0.0
    tip[LIVING] = living


@jit
def keep_points(points, kept):
    """Copy the points as they are before a step."""
    for e in range(points.shape[0]):
        for i in range(POINT):
            kept[e, i] = points[e, i]
