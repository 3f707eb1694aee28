"""
Consistent tangent of an element, material and geometric part, in the nodes' section axes.

With increments in the nodes' own axes a rigid motion leaves the matrix as it is, so one
factorisation serves many steps. In the axes of a Gauss point an increment is xi = (e, y, z),

    e = R^T dx',    y = P^-1 dP,    z = P^-1 dP'        (y, z quaternions: y0, yv and z0, zv)

and to second order, with K = P^-1 P' = (k0, k) and c = R^T x',

    strain     c + e + 2 c x yv + 2 e x yv - 2 y0 c x yv + 2 yv x (yv x c) - e_1
    curvature  2 Im(K + (z - y K) - y (z - y K))

The Hessian of the strain energy in xi is E^T C E + S with E the first-order part and S what
section force n and moment m make of the second-order part; the shape functions carry it to nodes.
"""
import numpy as np

from .beam import D_FAR, D_MID, D_NEAR, N_FAR, N_MID, N_NEAR, stiffness
from .jit import jit
from .layout import DP, DX, ELEMENTS, LANES, LQ, P, Q, STRESS, WEIGHT

HESSIAN = 0                     # 11 x 11
FIRST = HESSIAN + 121           # 6 x 11, E
TURN = FIRST + 66               # 3 nodes x (3 x 3): section axes of the node to those of the point
SPIN = TURN + 27                # 3 nodes x (4 x 3): theta of the node to 2 y
PRODUCT = SPIN + 36             # 11 x 6
ELEMENT = PRODUCT + 66          # 18 x 18: left, mid, right node, six increments each
TANGENT_WORK = ELEMENT + 324


def tangent_work():
    """Return the scratch array that `element_tangent` works in; its tail is the matrix."""
    return np.zeros(TANGENT_WORK)


@jit
def _cross_into(a, at, stride, factor, v1, v2, v3):
    """Add factor * [v]x to the 3 x 3 matrix at `at`."""
    a[at + 1] -= factor * v3
    a[at + 2] += factor * v2
    a[at + stride] += factor * v3
    a[at + stride + 2] -= factor * v1
    a[at + 2 * stride] -= factor * v2
    a[at + 2 * stride + 1] += factor * v1


@jit
def _point_hessian(nodes, block, lane, c_material, a):
    """Fill HESSIAN for the Gauss point in `lane` of the block."""
    p0, p1, p2, p3 = (nodes[block, P * LANES + lane], nodes[block, (P + 1) * LANES + lane],
                      nodes[block, (P + 2) * LANES + lane], nodes[block, (P + 3) * LANES + lane])
    d0, d1, d2, d3 = (nodes[block, DP * LANES + lane], nodes[block, (DP + 1) * LANES + lane],
                      nodes[block, (DP + 2) * LANES + lane], nodes[block, (DP + 3) * LANES + lane])
    inverse = 1.0 / (p0 * p0 + p1 * p1 + p2 * p2 + p3 * p3)
    k0 = (p0 * d0 + p1 * d1 + p2 * d2 + p3 * d3) * inverse
    k1 = (p0 * d1 - d0 * p1 - p2 * d3 + p3 * d2) * inverse
    k2 = (p0 * d2 - d0 * p2 - p3 * d1 + p1 * d3) * inverse
    k3 = (p0 * d3 - d0 * p3 - p1 * d2 + p2 * d1) * inverse
    x1 = nodes[block, DX * LANES + lane]
    x2 = nodes[block, (DX + 1) * LANES + lane]
    x3 = nodes[block, (DX + 2) * LANES + lane]
    two = 2.0 * inverse
    c1 = (x1 * (1.0 - two * (p2 * p2 + p3 * p3)) + x2 * two * (p1 * p2 + p0 * p3)
          + x3 * two * (p1 * p3 - p0 * p2))
    c2 = (x1 * two * (p1 * p2 - p0 * p3) + x2 * (1.0 - two * (p1 * p1 + p3 * p3))
          + x3 * two * (p2 * p3 + p0 * p1))
    c3 = (x1 * two * (p1 * p3 + p0 * p2) + x2 * two * (p2 * p3 - p0 * p1)
          + x3 * (1.0 - two * (p1 * p1 + p2 * p2)))
    n1, n2, n3 = (nodes[block, STRESS * LANES + lane], nodes[block, (STRESS + 1) * LANES + lane],
                  nodes[block, (STRESS + 2) * LANES + lane])
    m1 = nodes[block, (STRESS + 3) * LANES + lane]
    m2 = nodes[block, (STRESS + 4) * LANES + lane]
    m3 = nodes[block, (STRESS + 5) * LANES + lane]
    for i in range(66):
        a[FIRST + i] = 0.0
    for i in range(3):
        a[FIRST + i * 11 + i] = 1.0                         # e
        a[FIRST + (3 + i) * 11 + 4 + i] = -2.0 * k0         # yv
        a[FIRST + (3 + i) * 11 + 8 + i] = 2.0               # zv
    _cross_into(a, FIRST + 4, 11, 2.0, c1, c2, c3)
    _cross_into(a, FIRST + 3 * 11 + 4, 11, 2.0, k1, k2, k3)
    a[FIRST + 3 * 11 + 3] = -2.0 * k1                       # y0
    a[FIRST + 4 * 11 + 3] = -2.0 * k2
    a[FIRST + 5 * 11 + 3] = -2.0 * k3
    for i in range(11):
        for j in range(i, 11):
            total = 0.0
            for row in range(6):
                total += a[FIRST + row * 11 + i] * c_material[row] * a[FIRST + row * 11 + j]
            a[HESSIAN + i * 11 + j] = total
    nc = n1 * c1 + n2 * c2 + n3 * c3
    mk = m1 * k1 + m2 * k2 + m3 * k3
    _cross_into(a, HESSIAN + 4, 11, -2.0, n1, n2, n3)               # e, yv
    a[HESSIAN + 3 * 11 + 3] += 4.0 * mk                             # y0, y0
    y1 = -2.0 * (n2 * c3 - n3 * c2) + 4.0 * (k0 * m1 + k2 * m3 - k3 * m2)
    y2 = -2.0 * (n3 * c1 - n1 * c3) + 4.0 * (k0 * m2 + k3 * m1 - k1 * m3)
    y3 = -2.0 * (n1 * c2 - n2 * c1) + 4.0 * (k0 * m3 + k1 * m2 - k2 * m1)
    a[HESSIAN + 3 * 11 + 4] += y1                                   # y0, yv
    a[HESSIAN + 3 * 11 + 5] += y2
    a[HESSIAN + 3 * 11 + 6] += y3
    a[HESSIAN + 3 * 11 + 8] -= 2.0 * m1                             # y0, zv
    a[HESSIAN + 3 * 11 + 9] -= 2.0 * m2
    a[HESSIAN + 3 * 11 + 10] -= 2.0 * m3
    a[HESSIAN + 4 * 11 + 7] -= 2.0 * m1                             # yv, z0
    a[HESSIAN + 5 * 11 + 7] -= 2.0 * m2
    a[HESSIAN + 6 * 11 + 7] -= 2.0 * m3
    diagonal = -4.0 * (nc + mk)                                     # yv, yv
    a[HESSIAN + 4 * 11 + 4] += diagonal + 4.0 * n1 * c1
    a[HESSIAN + 5 * 11 + 5] += diagonal + 4.0 * n2 * c2
    a[HESSIAN + 6 * 11 + 6] += diagonal + 4.0 * n3 * c3
    a[HESSIAN + 4 * 11 + 5] += 2.0 * (n1 * c2 + n2 * c1)
    a[HESSIAN + 4 * 11 + 6] += 2.0 * (n1 * c3 + n3 * c1)
    a[HESSIAN + 5 * 11 + 6] += 2.0 * (n2 * c3 + n3 * c2)
    _cross_into(a, HESSIAN + 4 * 11 + 8, 11, 2.0, m1, m2, m3)       # yv, zv
    for i in range(11):
        for j in range(i):
            a[HESSIAN + i * 11 + j] = a[HESSIAN + j * 11 + i]


@jit
def _relative_rotation(nodes, block, lane, inverse, q0, q1, q2, q3, a, node):
    """Fill TURN and SPIN of `node`, whose quaternion is q, seen from the Gauss point in `lane`."""
    p0, p1, p2, p3 = (nodes[block, P * LANES + lane], nodes[block, (P + 1) * LANES + lane],
                      nodes[block, (P + 2) * LANES + lane], nodes[block, (P + 3) * LANES + lane])
    s = (p0 * q0 + p1 * q1 + p2 * q2 + p3 * q3) * inverse
    v1 = (p0 * q1 - q0 * p1 - p2 * q3 + p3 * q2) * inverse
    v2 = (p0 * q2 - q0 * p2 - p3 * q1 + p1 * q3) * inverse
    v3 = (p0 * q3 - q0 * p3 - p1 * q2 + p2 * q1) * inverse
    two = 2.0 / (s * s + v1 * v1 + v2 * v2 + v3 * v3)
    t = TURN + 9 * node
    a[t] = 1.0 - two * (v2 * v2 + v3 * v3)
    a[t + 1] = two * (v1 * v2 - s * v3)
    a[t + 2] = two * (v1 * v3 + s * v2)
    a[t + 3] = two * (v1 * v2 + s * v3)
    a[t + 4] = 1.0 - two * (v1 * v1 + v3 * v3)
    a[t + 5] = two * (v2 * v3 - s * v1)
    a[t + 6] = two * (v1 * v3 - s * v2)
    a[t + 7] = two * (v2 * v3 + s * v1)
    a[t + 8] = 1.0 - two * (v1 * v1 + v2 * v2)
    m = SPIN + 12 * node
    a[m], a[m + 1], a[m + 2] = -v1, -v2, -v3
    a[m + 3], a[m + 4], a[m + 5] = s, -v3, v2
    a[m + 6], a[m + 7], a[m + 8] = v3, s, -v1
    a[m + 9], a[m + 10], a[m + 11] = -v2, v1, s


@jit
def _add_pairs(a, weight, shapes, slopes):
    """Add this Gauss point's share to ELEMENT: shape functions and slopes of the three nodes."""
    for j in range(3):
        for row in range(11):
            h = HESSIAN + 11 * row
            t = TURN + 9 * j
            m = SPIN + 12 * j
            for col in range(3):
                a[PRODUCT + 6 * row + col] = slopes[j] * (
                    a[h] * a[t + col] + a[h + 1] * a[t + 3 + col] + a[h + 2] * a[t + 6 + col])
                total = 0.0
                for i in range(4):
                    total += (shapes[j] * a[h + 3 + i] + slopes[j] * a[h + 7 + i]
                              ) * a[m + 3 * i + col]
                a[PRODUCT + 6 * row + 3 + col] = 0.5 * total
        for i in range(3):
            t = TURN + 9 * i
            m = SPIN + 12 * i
            for row in range(3):
                at = ELEMENT + 18 * (6 * i + row) + 6 * j
                at_turn = at + 18 * 3
                for col in range(6):
                    a[at + col] += weight * slopes[i] * (
                        a[t + row] * a[PRODUCT + col] + a[t + 3 + row] * a[PRODUCT + 6 + col]
                        + a[t + 6 + row] * a[PRODUCT + 12 + col])
                    total = 0.0
                    for k in range(4):
                        total += a[m + 3 * k + row] * (
                            shapes[i] * a[PRODUCT + 6 * (3 + k) + col]
                            + slopes[i] * a[PRODUCT + 6 * (7 + k) + col])
                    a[at_turn + col] += 0.5 * weight * total


@jit
def element_tangent(nodes, block, element, section, factor, a):
    """
    Fill ELEMENT of the scratch array `a` with the tangent of `element` (0-3) of the block.

    Rows and columns: (displacement, rotation) of left, mid and right node, section axes each. It
    is the derivative of FORCE turned into the nodes' axes and of the moment at fixed TORQUE frame;
    what the turning of the moment's own axes adds is `moment_tangent`, for each node once.
    The strains, stresses and P, DP, DX of the block must be those of the present state.
    factor : float    as in `section_forces`, times which damping stiffens the material part
    """
    for i in range(324):
        a[ELEMENT + i] = 0.0
    c = stiffness(section)
    material = (factor * c[0], factor * c[1], factor * c[2],
                factor * c[3], factor * c[4], factor * c[5])
    scale = 2.0 / section.element_length
    for point in range(2):
        lane = element + ELEMENTS * point
        _point_hessian(nodes, block, lane, material, a)
        inverse = 0.0
        for row in range(4):
            inverse += nodes[block, (P + row) * LANES + lane] ** 2
        inverse = 1.0 / inverse
        at = (LQ * LANES + element, Q * LANES + element, Q * LANES + ELEMENTS + element)
        for node in range(3):
            _relative_rotation(nodes, block, lane, inverse, nodes[block, at[node]],
                               nodes[block, at[node] + LANES], nodes[block, at[node] + 2 * LANES],
                               nodes[block, at[node] + 3 * LANES], a, node)
        if point == 0:
            shapes = (N_NEAR, N_MID, N_FAR)
            slopes = (scale * D_NEAR, scale * D_MID, scale * D_FAR)
        else:
            shapes = (N_FAR, N_MID, N_NEAR)
            slopes = (-scale * D_FAR, -scale * D_MID, -scale * D_NEAR)
        _add_pairs(a, nodes[block, WEIGHT * LANES + lane], shapes, slopes)


@jit
def moment_tangent(torque_scalar, m1, m2, m3, out):
    """
    Add to the 3 x 3 `out` what turning a node adds to its internal moment m, in its own axes.

    From moment = Im(conj(q) Y), q -> q (1, theta / 2): -Y.q theta / 2 + m x theta / 2.
    """
    for i in range(3):
        out[i, i] -= 0.5 * torque_scalar
    out[0, 1] -= 0.5 * m3
    out[0, 2] += 0.5 * m2
    out[1, 0] += 0.5 * m3
    out[1, 2] -= 0.5 * m1
    out[2, 0] -= 0.5 * m2
    out[2, 1] += 0.5 * m1

