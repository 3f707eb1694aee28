"""
A point of contact along the wire: its record, its place on an element, what its force does there.

It lies on the element's quadratic curve at xi, -1 at the left corner and 1 at the right one,

    x = sum N_i x_i,    N = (xi (xi - 1) / 2, 1 - xi^2, xi (xi + 1) / 2)

and xi stays what it is within a step. A force f on it is N_i f at the nodes; with d = sum N_i u_i
their work over the step is f . d, so what is passive at a node (tip.py) is passive here. Each
element has one record: the slot of the one point that it may have.

A point owns what its spring stores, by a gap of its own: the true one plus OFFSET. It is chosen
anew from step to step (carry.py), and the gap that its law sees never falls by that, so no choice
of place makes energy.
"""
from bristle_ros.physics.compiler import jit
from bristle_ros.physics.motion import CLAMP
from bristle_ros.physics.wire import ELEMENTS, LANES, MASS, X

from .tip import CONTACT, FORCE, push, section_axes

# record of a point, after what it shares with the tip's (tip.py)
XI = CONTACT        # 1  place on its element
ALIVE = XI + 1      # 1  0: the slot is free
OFFSET = ALIVE + 1  # 1  of the law's gap over the true one [m]
LOWEST = OFFSET + 1  # 1  place of the minimum that it follows, at the end of the last step
POINT = LOWEST + 1

MOST = 64           # points that one wire may have in use at one time, its tip among them


@jit
def node_of(e, i):
    """Return block and lane of a node of element e: left, mid, right; block -1: the clamp."""
    if i == 1:
        return e // ELEMENTS, e % ELEMENTS
    corner = e if i == 2 else e - 1
    if corner < 0:
        return -1, 0
    return corner // ELEMENTS, ELEMENTS + corner % ELEMENTS


@jit
def weights(xi):
    """Return the shape functions at xi."""
    return 0.5 * xi * (xi - 1.0), 1.0 - xi * xi, 0.5 * xi * (xi + 1.0)


@jit
def position(s, rows, e, xi, frame):
    """Return where a point is, axes of the nodes; rows: X or X0, the clamp: the frame record's."""
    n = weights(xi)
    x1 = x2 = x3 = 0.0
    for i in range(3):
        j, lane = node_of(e, i)
        if j < 0:
            x1 += n[i] * frame[CLAMP]
            x2 += n[i] * frame[CLAMP + 1]
            x3 += n[i] * frame[CLAMP + 2]
        else:
            x1 += n[i] * s[j, rows * LANES + lane]
            x2 += n[i] * s[j, (rows + 1) * LANES + lane]
            x3 += n[i] * s[j, (rows + 2) * LANES + lane]
    return x1, x2, x3


@jit
def increment(s, rows, at, e, xi):
    """
    Return by what nodal increments move a point, axes of the nodes.

    rows : (blocks, ...)    increments in the nodes' own section axes, from row `at` on
    """
    n = weights(xi)
    u1 = u2 = u3 = 0.0
    for i in range(3):
        j, lane = node_of(e, i)
        if j >= 0 and n[i] != 0.0:
            axes = section_axes(s, j, lane)
            v1 = n[i] * rows[j, at * LANES + lane]
            v2 = n[i] * rows[j, (at + 1) * LANES + lane]
            v3 = n[i] * rows[j, (at + 2) * LANES + lane]
            u1 += axes[0][0] * v1 + axes[0][1] * v2 + axes[0][2] * v3
            u2 += axes[1][0] * v1 + axes[1][1] * v2 + axes[1][2] * v3
            u3 += axes[2][0] * v1 + axes[2][1] * v2 + axes[2][2] * v3
    return u1, u2, u3


@jit
def push_point(s, step, e, xi, f1, f2, f3, predict):
    """
    Add the change of a point's force (axes of the nodes) to the histories of its nodes.

    predict : bool      their predicted positions follow it, as at a step's start
    """
    n = weights(xi)
    for i in range(3):
        j, lane = node_of(e, i)
        if j < 0 or n[i] == 0.0:
            continue
        push(s, j, lane, step, n[i] * f1, n[i] * f2, n[i] * f3)
        if predict:
            by_x = 0.5 * step.h * step.h * n[i] / s[j, MASS * LANES + lane]
            s[j, X * LANES + lane] += by_x * f1
            s[j, (X + 1) * LANES + lane] += by_x * f2
            s[j, (X + 2) * LANES + lane] += by_x * f3


@jit
def whole_force(points, tip):
    """Return the road's force on the whole wire [N], road axes."""
    f1, f2, f3 = tip[FORCE], tip[FORCE + 1], tip[FORCE + 2]
    for e in range(points.shape[0]):
        if points[e, ALIVE] > 0.0:
            f1 += points[e, FORCE]
            f2 += points[e, FORCE + 1]
            f3 += points[e, FORCE + 2]
    return f1, f2, f3
