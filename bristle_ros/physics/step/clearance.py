"""How far the wire is from the road: the road touches the tip alone, whatever else reaches it."""
from bristle_ros.physics.compiler import jit
from bristle_ros.physics.wire import ELEMENTS, LANES, X


@jit
def lowest_node(s, elements, n1, n2, n3, height):
    """
    Return the least height above the road [m] of the nodes between clamp and tip.

    n1, n2, n3 : float    road normal in the axes of the nodes
    height [m] : float    of their origin above the road
    """
    lowest = 1e300
    for e in range(elements):
        j = e // ELEMENTS
        for i in (e % ELEMENTS, ELEMENTS + e % ELEMENTS):
            if i < ELEMENTS or e < elements - 1:
                lowest = min(lowest, height + n1 * s[j, X * LANES + i]
                             + n2 * s[j, (X + 1) * LANES + i] + n3 * s[j, (X + 2) * LANES + i])
    return lowest
