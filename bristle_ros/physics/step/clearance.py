"""How far the wire is from the road, and what touches it there."""
from bristle_ros.physics.compiler import jit
from bristle_ros.physics.contact import (ALIVE, GAP, gap_on, OPEN, place_of, STATE)
from bristle_ros.physics.wire import ELEMENTS, LANES, X


@jit
def lowest_node(s, elements, surface, frame, sums):
    """
    Return the least gap [m] of the nodes between clamp and tip.

    surface : Surface, or None for the nominal plane; frame : frame record in the nodes' axes
    """
    lowest = 1e300
    for e in range(elements):
        j = e // ELEMENTS
        for i in (e % ELEMENTS, ELEMENTS + e % ELEMENTS):
            if i < ELEMENTS or e < elements - 1:
                p1, p2, p3 = place_of(frame, s[j, X * LANES + i], s[j, (X + 1) * LANES + i],
                                      s[j, (X + 2) * LANES + i])
                lowest = min(lowest, gap_on(surface, p1, p2, p3, sums)[0])
    return lowest


@jit
def nearest_point(points, tip):
    """Return the least gap of any contact point, its law's [m]."""
    gap = tip[GAP]
    for e in range(points.shape[0]):
        if points[e, ALIVE] > 0.0:
            gap = min(gap, points[e, GAP])
    return gap


@jit
def touching_length(points, element_length):
    """Return the length of wire that the touching points stand for [m]: their elements'."""
    total = 0.0
    for e in range(points.shape[0]):
        if points[e, ALIVE] > 0.0 and points[e, STATE] != OPEN:
            total += element_length
    return total
