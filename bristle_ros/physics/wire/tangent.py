"""
Consistent tangent of the elements, material and geometric part, in the nodes' section axes.

With increments in the nodes' own axes a rigid motion leaves the matrix as it is, so one
factorisation serves many steps. In the axes of a Gauss point an increment is xi = (e, y, z),

    e = R^T dx',    y = P^-1 dP,    z = P^-1 dP'        (y, z quaternions: y0, yv and z0, zv)

and to second order, with K = P^-1 P' = (k0, k) and c = R^T x',

    strain     c + e + 2 c x yv + 2 e x yv - 2 y0 c x yv + 2 yv x (yv x c) - e_1
    curvature  2 Im(K + (z - y K) - y (z - y K))

The Hessian of the strain energy in xi is H = E^T C E + S with E the first-order part and S what
section force n and moment m make of the second-order part. The shape functions carry it to the
nodes: with A the turn from a node's section axes to the point's, J the 4 x 3 matrix of
Q = P^-1 q, theta -> Im and Re of Q theta / 2, and N, D shape function and slope of the node,

    e = D A u,    y = N J theta,    z = D J theta.

Four elements at a time, a lane each; the Gauss points one after the other.
"""
from bristle_ros.physics.compiler import jit, load4, splat4, store4

from .beam import D_FAR, D_MID, D_NEAR, N_FAR, N_MID, N_NEAR, stiffness
from .layout import DP, DX, ELEMENTS, LANES, LQ, P, Q, STRAIN, STRESS, WEIGHT

# rows of eight lanes, four for each Gauss point
_E_Y = 0                    # 3 x 3, H of e and yv
_Y_Y = _E_Y + 9             # 4 x 4, H of y and y
_Y_Z = _Y_Y + 16            # 4 x 4, H of y and z
_NODES = _Y_Z + 16
# rows of each node
_A = 0                      # 3 x 3, D A
_CA = 9                     # 3 x 3, w C D A
_HJ = 18                    # 3 x 3, w H_ey N J
_NJ = 27                    # 4 x 3, N J
_DJ = 39                    # 4 x 3, D J
_U = 51                     # 4 x 3, w (H_yy N + H_yz D) J
_V = 63                     # 4 x 3, w (H_zy N + H_zz D) J
_NODE = 75
# rows of four lanes: the six different 6 x 6 blocks of the elements, row by row
SIX_BY_SIX = 36 * ELEMENTS
LEFT_LEFT = (_NODES + 3 * _NODE) * LANES
LEFT_MIDDLE = LEFT_LEFT + SIX_BY_SIX
LEFT_RIGHT = LEFT_MIDDLE + SIX_BY_SIX
MIDDLE_MIDDLE = LEFT_RIGHT + SIX_BY_SIX
MIDDLE_RIGHT = MIDDLE_MIDDLE + SIX_BY_SIX
RIGHT_RIGHT = MIDDLE_RIGHT + SIX_BY_SIX
TANGENT_WORK = RIGHT_RIGHT + SIX_BY_SIX


@jit
def _point_hessian(s, c, a, half):
    """Fill H at the Gauss points in lanes half, half + 1 ... of the block's rows s."""
    p0, p1 = load4(s, P * LANES + half), load4(s, (P + 1) * LANES + half)
    p2, p3 = load4(s, (P + 2) * LANES + half), load4(s, (P + 3) * LANES + half)
    d0, d1 = load4(s, DP * LANES + half), load4(s, (DP + 1) * LANES + half)
    d2, d3 = load4(s, (DP + 2) * LANES + half), load4(s, (DP + 3) * LANES + half)
    inverse = 1.0 / (p0 * p0 + p1 * p1 + p2 * p2 + p3 * p3)
    k0 = (p0 * d0 + p1 * d1 + p2 * d2 + p3 * d3) * inverse
    k1 = (p0 * d1 - d0 * p1 - p2 * d3 + p3 * d2) * inverse
    k2 = (p0 * d2 - d0 * p2 - p3 * d1 + p1 * d3) * inverse
    k3 = (p0 * d3 - d0 * p3 - p1 * d2 + p2 * d1) * inverse
    x1, x2, x3 = (load4(s, DX * LANES + half), load4(s, (DX + 1) * LANES + half),
                  load4(s, (DX + 2) * LANES + half))
    two = 2.0 * inverse
    c1 = (x1 * (1.0 - two * (p2 * p2 + p3 * p3)) + x2 * two * (p1 * p2 + p0 * p3)
          + x3 * two * (p1 * p3 - p0 * p2))
    c2 = (x1 * two * (p1 * p2 - p0 * p3) + x2 * (1.0 - two * (p1 * p1 + p3 * p3))
          + x3 * two * (p2 * p3 + p0 * p1))
    c3 = (x1 * two * (p1 * p3 + p0 * p2) + x2 * two * (p2 * p3 - p0 * p1)
          + x3 * (1.0 - two * (p1 * p1 + p2 * p2)))
    n1, n2, n3 = (load4(s, STRESS * LANES + half), load4(s, (STRESS + 1) * LANES + half),
                  load4(s, (STRESS + 2) * LANES + half))
    m1, m2, m3 = (load4(s, (STRESS + 3) * LANES + half), load4(s, (STRESS + 4) * LANES + half),
                  load4(s, (STRESS + 5) * LANES + half))

    zero = splat4(0.0)
    # strain: de = e + 2 c x yv; n's own part -2 n x
    f1, f2, f3 = 2.0 * (c[0] * c3 - n3), 2.0 * (c[0] * c2 - n2), 2.0 * (c[1] * c3 - n3)
    f4, f5, f6 = 2.0 * (c[1] * c1 - n1), 2.0 * (c[2] * c2 - n2), 2.0 * (c[2] * c1 - n1)
    _put_row(a, _E_Y, half, zero, -f1, f2)
    _put_row(a, _E_Y + 3, half, f3, zero, -f4)
    _put_row(a, _E_Y + 6, half, -f5, f6, zero)
    # curvature: dkappa = 2 zv - 2 k y0 + B yv,  B = -2 k0 + 2 [k]x; t, u, v: C B, row by row
    t1, t2, t3 = -2.0 * c[3] * k0, -2.0 * c[3] * k3, 2.0 * c[3] * k2
    u1, u2, u3 = 2.0 * c[4] * k3, -2.0 * c[4] * k0, -2.0 * c[4] * k1
    v1, v2, v3 = -2.0 * c[5] * k2, 2.0 * c[5] * k1, -2.0 * c[5] * k0
    nc = n1 * c1 + n2 * c2 + n3 * c3
    mk = m1 * k1 + m2 * k2 + m3 * k3
    y1 = (-2.0 * (n2 * c3 - n3 * c2) + 4.0 * (k0 * m1 + k2 * m3 - k3 * m2)
          - 2.0 * (k1 * t1 + k2 * u1 + k3 * v1))
    y2 = (-2.0 * (n3 * c1 - n1 * c3) + 4.0 * (k0 * m2 + k3 * m1 - k1 * m3)
          - 2.0 * (k1 * t2 + k2 * u2 + k3 * v2))
    y3 = (-2.0 * (n1 * c2 - n2 * c1) + 4.0 * (k0 * m3 + k1 * m2 - k2 * m1)
          - 2.0 * (k1 * t3 + k2 * u3 + k3 * v3))
    trace = -4.0 * (nc + mk)
    y11 = (trace + 4.0 * (n1 * c1 + c[1] * c3 * c3 + c[2] * c2 * c2)
           - 2.0 * (k0 * t1 - k3 * u1 + k2 * v1))
    y22 = (trace + 4.0 * (n2 * c2 + c[0] * c3 * c3 + c[2] * c1 * c1)
           - 2.0 * (k3 * t2 + k0 * u2 - k1 * v2))
    y33 = (trace + 4.0 * (n3 * c3 + c[0] * c2 * c2 + c[1] * c1 * c1)
           + 2.0 * (k2 * t3 - k1 * u3 - k0 * v3))
    y12 = 2.0 * (n1 * c2 + n2 * c1 - 2.0 * c[2] * c1 * c2 - k0 * t2 + k3 * u2 - k2 * v2)
    y13 = 2.0 * (n1 * c3 + n3 * c1 - 2.0 * c[1] * c1 * c3 - k0 * t3 + k3 * u3 - k2 * v3)
    y23 = 2.0 * (n2 * c3 + n3 * c2 - 2.0 * c[0] * c2 * c3 - k3 * t3 - k0 * u3 + k1 * v3)
    y00 = 4.0 * (c[3] * k1 * k1 + c[4] * k2 * k2 + c[5] * k3 * k3 + mk)
    _put_four(a, _Y_Y, half, y00, y1, y2, y3)
    _put_four(a, _Y_Y + 4, half, y1, y11, y12, y13)
    _put_four(a, _Y_Y + 8, half, y2, y12, y22, y23)
    _put_four(a, _Y_Y + 12, half, y3, y13, y23, y33)
    _put_four(a, _Y_Z, half, zero, -4.0 * c[3] * k1 - 2.0 * m1, -4.0 * c[4] * k2 - 2.0 * m2,
              -4.0 * c[5] * k3 - 2.0 * m3)
    _put_four(a, _Y_Z + 4, half, -2.0 * m1, 2.0 * t1, 2.0 * (u1 - m3), 2.0 * (v1 + m2))
    _put_four(a, _Y_Z + 8, half, -2.0 * m2, 2.0 * (t2 + m3), 2.0 * u2, 2.0 * (v2 - m1))
    _put_four(a, _Y_Z + 12, half, -2.0 * m3, 2.0 * (t3 - m2), 2.0 * (u3 + m1), 2.0 * v3)


@jit
def _put_row(a, row, half, x, y, z):
    """Store three vectors into rows of the scratch array from `row` on."""
    store4(a, row * LANES + half, x)
    store4(a, (row + 1) * LANES + half, y)
    store4(a, (row + 2) * LANES + half, z)


@jit
def _put_four(a, row, half, w, x, y, z):
    """Store four vectors into rows of the scratch array from `row` on."""
    store4(a, row * LANES + half, w)
    _put_row(a, row + 1, half, x, y, z)


@jit
def _node_terms(s, c, a, half, node, at, shape, slope):
    """Fill the rows of a node, whose quaternions are in lanes s[at:], for one Gauss point."""
    p0, p1 = load4(s, P * LANES + half), load4(s, (P + 1) * LANES + half)
    p2, p3 = load4(s, (P + 2) * LANES + half), load4(s, (P + 3) * LANES + half)
    q0, q1 = load4(s, at), load4(s, at + LANES)
    q2, q3 = load4(s, at + 2 * LANES), load4(s, at + 3 * LANES)
    inverse = 1.0 / (p0 * p0 + p1 * p1 + p2 * p2 + p3 * p3)
    r = (p0 * q0 + p1 * q1 + p2 * q2 + p3 * q3) * inverse
    v1 = (p0 * q1 - q0 * p1 - p2 * q3 + p3 * q2) * inverse
    v2 = (p0 * q2 - q0 * p2 - p3 * q1 + p1 * q3) * inverse
    v3 = (p0 * q3 - q0 * p3 - p1 * q2 + p2 * q1) * inverse
    base = _NODES + _NODE * node
    weight = load4(s, WEIGHT * LANES + half)
    two = (2.0 * slope) / (r * r + v1 * v1 + v2 * v2 + v3 * v3)
    _put_row(a, base + _A, half, slope - two * (v2 * v2 + v3 * v3), two * (v1 * v2 - r * v3),
             two * (v1 * v3 + r * v2))
    _put_row(a, base + _A + 3, half, two * (v1 * v2 + r * v3), slope - two * (v1 * v1 + v3 * v3),
             two * (v2 * v3 - r * v1))
    _put_row(a, base + _A + 6, half, two * (v1 * v3 - r * v2), two * (v2 * v3 + r * v1),
             slope - two * (v1 * v1 + v2 * v2))
    for at, factor in ((base + _NJ, 0.5 * shape), (base + _DJ, 0.5 * slope)):
        _put_row(a, at, half, -factor * v1, -factor * v2, -factor * v3)
        _put_row(a, at + 3, half, factor * r, -factor * v3, factor * v2)
        _put_row(a, at + 6, half, factor * v3, factor * r, -factor * v1)
        _put_row(a, at + 9, half, -factor * v2, factor * v1, factor * r)
    for row in range(3):
        stiff = c[row] * weight
        h1 = weight * load4(a, (_E_Y + 3 * row) * LANES + half)
        h2 = weight * load4(a, (_E_Y + 3 * row + 1) * LANES + half)
        h3 = weight * load4(a, (_E_Y + 3 * row + 2) * LANES + half)
        for col in range(3):
            at = (base + 3 * row + col) * LANES + half
            store4(a, at + _CA * LANES, stiff * load4(a, at + _A * LANES))
            j = (base + _NJ + col) * LANES + half
            store4(a, at + _HJ * LANES, h1 * load4(a, j + 3 * LANES)
                   + h2 * load4(a, j + 6 * LANES) + h3 * load4(a, j + 9 * LANES))
    for row in range(4):
        for col in range(3):
            j = (base + _NJ + col) * LANES + half
            u = splat4(0.0)
            v = splat4(0.0)
            for k in range(4):
                by_shape = load4(a, j + 3 * k * LANES)
                by_slope = load4(a, j + (_DJ - _NJ + 3 * k) * LANES)
                u = (u + load4(a, (_Y_Y + 4 * row + k) * LANES + half) * by_shape
                     + load4(a, (_Y_Z + 4 * row + k) * LANES + half) * by_slope)
                v = v + load4(a, (_Y_Z + 4 * k + row) * LANES + half) * by_shape
            if row > 0:
                v = v + 4.0 * c[2 + row] * load4(a, j + (_DJ - _NJ + 3 * row) * LANES)
            at = (base + 3 * row + col) * LANES + half
            store4(a, at + _U * LANES, weight * u)
            store4(a, at + _V * LANES, weight * v)


@jit
def _pair(a, one, two, out):
    """Store the 6 x 6 block of the nodes `one` and `two` at a[out:], summed over the points."""
    for row in range(3):
        for col in range(3):
            x = (_NODES + _NODE * one + row) * LANES
            y = (_NODES + _NODE * two + col) * LANES
            uu, ut, tu, tt = splat4(0.0), splat4(0.0), splat4(0.0), splat4(0.0)
            for half in (0, ELEMENTS):
                for k in (0, 3 * LANES, 6 * LANES):
                    turn = load4(a, x + _A * LANES + half + k)
                    uu = uu + turn * load4(a, y + _CA * LANES + half + k)
                    ut = ut + turn * load4(a, y + _HJ * LANES + half + k)
                    tu = tu + (load4(a, x + _HJ * LANES + half + k)
                               * load4(a, y + _A * LANES + half + k))
                for k in (0, 3 * LANES, 6 * LANES, 9 * LANES):
                    tt = (tt + load4(a, x + _NJ * LANES + half + k)
                          * load4(a, y + _U * LANES + half + k)
                          + load4(a, x + _DJ * LANES + half + k)
                          * load4(a, y + _V * LANES + half + k))
            at = out + (6 * row + col) * ELEMENTS
            store4(a, at, uu)
            store4(a, at + 3 * ELEMENTS, ut)
            store4(a, at + 18 * ELEMENTS, tu)
            store4(a, at + 21 * ELEMENTS, tt)


@jit
def block_tangent(s, section, factor, a):
    """
    Fill the blocks LEFT_LEFT ... RIGHT_RIGHT of the scratch array `a` for the four elements of s.

    s : (BLOCK,)                 rows of a block; its strains, stresses and P, DP, DX are present
    a : (TANGENT_WORK,)          a[LEFT_RIGHT + 4 (6 row + col) + element], for instance
    factor : float               as in `section_forces`, times which damping stiffens the material
    Rows and columns: (displacement, rotation), section axes of the node. It is the derivative of
    NODE_FORCE turned into the nodes' axes and of the moment at fixed TORQUE frame; what the
    turning of the moment's own axes adds is `moment_tangent`, for each node once. The matrix of an
    element is symmetric, so the blocks above its diagonal say all.
    """
    c = stiffness(section)
    c = (factor * c[0], factor * c[1], factor * c[2],
         factor * c[3], factor * c[4], factor * c[5])
    scale = 2.0 / section.element_length
    for half in (0, ELEMENTS):
        _point_hessian(s, c, a, half)
        # the second point mirrors the first one
        if half == 0:
            near, far, slope_near, slope_far = N_NEAR, N_FAR, scale * D_NEAR, scale * D_FAR
            middle = scale * D_MID
        else:
            near, far, slope_near, slope_far = N_FAR, N_NEAR, -scale * D_FAR, -scale * D_NEAR
            middle = -scale * D_MID
        _node_terms(s, c, a, half, 0, LQ * LANES, near, slope_near)
        _node_terms(s, c, a, half, 1, Q * LANES, N_MID, middle)
        _node_terms(s, c, a, half, 2, Q * LANES + ELEMENTS, far, slope_far)
    out = LEFT_LEFT
    for one in range(3):
        for two in range(one, 3):
            _pair(a, one, two, out)
            out += SIX_BY_SIX


@jit
def keep_strain_matrix(s, a, out, at):
    """
    Store the first-order part B of the force strains at out[at:], after `block_tangent`.

    Rows of eight lanes as of Gauss points; for the left, the mid and the right node 3 x 3 for the
    displacement, D A, and 3 x 3 for the rotation, 2 [c]x N J: d eps = B (u, theta).
    """
    for half in (0, ELEMENTS):
        c1 = 1.0 + load4(s, STRAIN * LANES + half)
        c2, c3 = load4(s, (STRAIN + 1) * LANES + half), load4(s, (STRAIN + 2) * LANES + half)
        for node in range(3):
            terms = (_NODES + _NODE * node) * LANES + half
            rows = at + 18 * node * LANES + half
            for i in range(9):
                store4(out, rows + i * LANES, load4(a, terms + (_A + i) * LANES))
            for col in range(3):
                turn = terms + (_NJ + 3 + col) * LANES
                y1, y2, y3 = (load4(a, turn), load4(a, turn + 3 * LANES),
                              load4(a, turn + 6 * LANES))
                store4(out, rows + (9 + col) * LANES, 2.0 * (c2 * y3 - c3 * y2))
                store4(out, rows + (12 + col) * LANES, 2.0 * (c3 * y1 - c1 * y3))
                store4(out, rows + (15 + col) * LANES, 2.0 * (c1 * y2 - c2 * y1))


@jit
def add_to(a, at, value):
    """Add a vector of four lanes to a[at:at + 4]."""
    store4(a, at, load4(a, at) + value)


@jit
def moment_tangent(a, at, scalar, m1, m2, m3):
    """
    Add to the 3 x 3 at a[at:] of a 6 x 6 block what turning a node adds to its internal moment.

    From moment = Im(conj(q) Y), q -> q (1, theta / 2): -Y.q theta / 2 + m x theta / 2, in the
    node's own axes; scalar = Y.q. Vectors of four lanes.
    """
    row = 6 * ELEMENTS
    add_to(a, at, -0.5 * scalar)
    add_to(a, at + ELEMENTS, -0.5 * m3)
    add_to(a, at + 2 * ELEMENTS, 0.5 * m2)
    add_to(a, at + row, 0.5 * m3)
    add_to(a, at + row + ELEMENTS, -0.5 * scalar)
    add_to(a, at + row + 2 * ELEMENTS, -0.5 * m1)
    add_to(a, at + 2 * row, -0.5 * m2)
    add_to(a, at + 2 * row + ELEMENTS, 0.5 * m1)
    add_to(a, at + 2 * row + 2 * ELEMENTS, -0.5 * scalar)
