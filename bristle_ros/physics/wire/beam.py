"""
Geometrically exact beam, 3-node quadratic elements: strains, section forces, internal forces.

The centreline is interpolated by the quadratic shape functions N_i, the rotation by the normalised
sum of the nodal quaternions. With P = sum N_i q_i, P' its derivative along the arc and R = R(P),

    strain     eps   = R^T x' - e_1          (elongation, shear, shear)
    curvature  kappa = 2 Im(P^-1 P')         (twist, bending, bending), exact at any rotation

Both are unchanged when a rigid motion is superposed. Two Gauss points an element: no locking.
Virtual work (Simo 1985, doi 10.1016/0045-7825(85)90050-7), written with quaternions: with
c = R^T x', K = P^-1 P' = (k0, k) and an increment q_i -> q_i (1, theta_i / 2),

    d eps   = R^T dx' + c x dphi,    dphi = sum N_i Im(Q_i theta_i),    Q_i = P^-1 q_i
    d kappa = sum Im((Q_i theta_i)(N_i' - N_i K))

so that section force n and moment m give the nodal force sum w N_i' R n and the nodal moment
Im(conj(q_i) Y_i), Y_i = sum w (N_i' P(0, m) + N_i P(-m.k, n x c - k0 m + m x k)) / |P|^2.
"""
from typing import NamedTuple

from bristle_ros.physics.compiler import inlined, jit, load4, push_first4, store4
import numpy as np

from .layout import (DP, DX, ELEMENTS, EXCESS, LANES, LFORCE, LQ, LTORQUE, LX, NODE_FORCE, P, PF,
                     PG, PM, Q, SECTION_FORCE, STRAIN, STRESS, STRESS0, TORQUE, WEIGHT, X)

GAUSS = 1.0 / np.sqrt(3.0)
# Shape functions at the first Gauss point: left, mid, right; the second one mirrors them.
N_NEAR = 0.5 * GAUSS * (GAUSS + 1.0)
N_MID = 1.0 - GAUSS * GAUSS
N_FAR = 0.5 * GAUSS * (GAUSS - 1.0)
# Their derivatives in the parent coordinate, times 2 / (element length) along the arc.
D_NEAR = -GAUSS - 0.5
D_MID = 2.0 * GAUSS
D_FAR = -GAUSS + 0.5


class Section(NamedTuple):
    """Stiffness of the section in its own axes, and the element length."""

    axial: float        # EA [N]
    shear_y: float      # k G A [N]
    shear_z: float
    torsion: float      # GJ [N m^2]
    bending_y: float    # EI about y: the weak axis at breadth > width
    bending_z: float
    element_length: float   # [m]


@jit
def gather_left_nodes(s, blocks, clamp):
    """
    Copy each element's left corner into its left rows.

    s : (blocks, BLOCK)     the bristle, laid out as layout.py says
    clamp [m, -] : (7,)       position and quaternion of the clamped node
    """
    for j in range(blocks):
        r = s[j]
        for row in range(7):
            before = clamp[row] if j == 0 else s[j - 1, (X + row) * LANES + LANES - 1]
            # the right corners of all but the last element, one lane on
            corners = load4(r, (X + row) * LANES + ELEMENTS)
            store4(r, (LX + row) * LANES, push_first4(corners, before))


@jit
def interpolate(s, j, element_length):
    """Fill P, DP and DX of block j from its nodes."""
    r = s[j]
    scale = 2.0 / element_length
    for row in range(4):
        left, mid, right = (load4(r, (LQ + row) * LANES), load4(r, (Q + row) * LANES),
                            load4(r, (Q + row) * LANES + ELEMENTS))
        store4(r, (P + row) * LANES, N_NEAR * left + N_MID * mid + N_FAR * right)
        store4(r, (P + row) * LANES + ELEMENTS, N_FAR * left + N_MID * mid + N_NEAR * right)
        _put_slopes(r, (DP + row) * LANES, scale, left, mid, right)
    for row in range(3):
        _put_slopes(r, (DX + row) * LANES, scale, load4(r, (LX + row) * LANES),
                    load4(r, (X + row) * LANES), load4(r, (X + row) * LANES + ELEMENTS))


@jit
def _put_slopes(r, at, scale, left, mid, right):
    """Store the derivatives at both Gauss points of what is so much at the nodes."""
    store4(r, at, (scale * D_NEAR) * left + (scale * D_MID) * mid + (scale * D_FAR) * right)
    store4(r, at + ELEMENTS, (-scale * D_FAR) * left - (scale * D_MID) * mid
           - (scale * D_NEAR) * right)


@inlined
def point(s, j, i):
    """
    Return P, 1 / |P|^2, K, R row by row and c = R^T x' at the Gauss point in lane i of block j.

    What the strains are made of: eps = c - e_1, kappa = 2 (k1, k2, k3).
    """
    p0 = s[j, P * LANES + i]
    p1 = s[j, (P + 1) * LANES + i]
    p2 = s[j, (P + 2) * LANES + i]
    p3 = s[j, (P + 3) * LANES + i]
    d0 = s[j, DP * LANES + i]
    d1 = s[j, (DP + 1) * LANES + i]
    d2 = s[j, (DP + 2) * LANES + i]
    d3 = s[j, (DP + 3) * LANES + i]
    x1 = s[j, DX * LANES + i]
    x2 = s[j, (DX + 1) * LANES + i]
    x3 = s[j, (DX + 2) * LANES + i]
    inverse = 1.0 / (p0 * p0 + p1 * p1 + p2 * p2 + p3 * p3)
    k0 = (p0 * d0 + p1 * d1 + p2 * d2 + p3 * d3) * inverse
    k1 = (p0 * d1 - d0 * p1 - p2 * d3 + p3 * d2) * inverse
    k2 = (p0 * d2 - d0 * p2 - p3 * d1 + p1 * d3) * inverse
    k3 = (p0 * d3 - d0 * p3 - p1 * d2 + p2 * d1) * inverse
    two = 2.0 * inverse
    r11 = 1.0 - two * (p2 * p2 + p3 * p3)
    r12 = two * (p1 * p2 - p0 * p3)
    r13 = two * (p1 * p3 + p0 * p2)
    r21 = two * (p1 * p2 + p0 * p3)
    r22 = 1.0 - two * (p1 * p1 + p3 * p3)
    r23 = two * (p2 * p3 - p0 * p1)
    r31 = two * (p1 * p3 - p0 * p2)
    r32 = two * (p2 * p3 + p0 * p1)
    r33 = 1.0 - two * (p1 * p1 + p2 * p2)
    c1 = r11 * x1 + r21 * x2 + r31 * x3
    c2 = r12 * x1 + r22 * x2 + r32 * x3
    c3 = r13 * x1 + r23 * x2 + r33 * x3
    return ((p0, p1, p2, p3), inverse, (k0, k1, k2, k3),
            (r11, r12, r13, r21, r22, r23, r31, r32, r33), (c1, c2, c3))


@jit
def section_forces(s, j, section, factor, mixed):
    """
    Fill STRAIN, STRESS and the weighted terms of the virtual work at each Gauss point of block j.

    factor : float    stress = factor * stiffness * strain + STRESS0; 1 without damping
    mixed : float     1: the section force is SECTION_FORCE, and EXCESS what it would be, less that
    """
    axial = factor * section.axial
    shear_y = factor * section.shear_y
    shear_z = factor * section.shear_z
    torsion = factor * section.torsion
    bending_y = factor * section.bending_y
    bending_z = factor * section.bending_z
    for i in range(LANES):
        (p0, p1, p2, p3), inverse, (k0, k1, k2, k3), r, (c1, c2, c3) = point(s, j, i)
        r11, r12, r13, r21, r22, r23, r31, r32, r33 = r
        e1 = c1 - 1.0
        s[j, STRAIN * LANES + i] = e1
        s[j, (STRAIN + 1) * LANES + i] = c2
        s[j, (STRAIN + 2) * LANES + i] = c3
        s[j, (STRAIN + 3) * LANES + i] = 2.0 * k1
        s[j, (STRAIN + 4) * LANES + i] = 2.0 * k2
        s[j, (STRAIN + 5) * LANES + i] = 2.0 * k3
        n1 = axial * e1 + s[j, STRESS0 * LANES + i]
        n2 = shear_y * c2 + s[j, (STRESS0 + 1) * LANES + i]
        n3 = shear_z * c3 + s[j, (STRESS0 + 2) * LANES + i]
        t1 = mixed * (n1 - s[j, SECTION_FORCE * LANES + i])
        t2 = mixed * (n2 - s[j, (SECTION_FORCE + 1) * LANES + i])
        t3 = mixed * (n3 - s[j, (SECTION_FORCE + 2) * LANES + i])
        s[j, EXCESS * LANES + i] = t1
        s[j, (EXCESS + 1) * LANES + i] = t2
        s[j, (EXCESS + 2) * LANES + i] = t3
        n1 = n1 - t1
        n2 = n2 - t2
        n3 = n3 - t3
        m1 = torsion * 2.0 * k1 + s[j, (STRESS0 + 3) * LANES + i]
        m2 = bending_y * 2.0 * k2 + s[j, (STRESS0 + 4) * LANES + i]
        m3 = bending_z * 2.0 * k3 + s[j, (STRESS0 + 5) * LANES + i]
        s[j, STRESS * LANES + i] = n1
        s[j, (STRESS + 1) * LANES + i] = n2
        s[j, (STRESS + 2) * LANES + i] = n3
        s[j, (STRESS + 3) * LANES + i] = m1
        s[j, (STRESS + 4) * LANES + i] = m2
        s[j, (STRESS + 5) * LANES + i] = m3
        w = s[j, WEIGHT * LANES + i]
        s[j, PF * LANES + i] = w * (r11 * n1 + r12 * n2 + r13 * n3)
        s[j, (PF + 1) * LANES + i] = w * (r21 * n1 + r22 * n2 + r23 * n3)
        s[j, (PF + 2) * LANES + i] = w * (r31 * n1 + r32 * n2 + r33 * n3)
        g0 = -(m1 * k1 + m2 * k2 + m3 * k3)
        g1 = n2 * c3 - n3 * c2 - k0 * m1 + m2 * k3 - m3 * k2
        g2 = n3 * c1 - n1 * c3 - k0 * m2 + m3 * k1 - m1 * k3
        g3 = n1 * c2 - n2 * c1 - k0 * m3 + m1 * k2 - m2 * k1
        w = w * inverse
        s[j, PG * LANES + i] = w * (p0 * g0 - p1 * g1 - p2 * g2 - p3 * g3)
        s[j, (PG + 1) * LANES + i] = w * (p0 * g1 + p1 * g0 + p2 * g3 - p3 * g2)
        s[j, (PG + 2) * LANES + i] = w * (p0 * g2 + p2 * g0 + p3 * g1 - p1 * g3)
        s[j, (PG + 3) * LANES + i] = w * (p0 * g3 + p3 * g0 + p1 * g2 - p2 * g1)
        s[j, PM * LANES + i] = -w * (p1 * m1 + p2 * m2 + p3 * m3)
        s[j, (PM + 1) * LANES + i] = w * (p0 * m1 + p2 * m3 - p3 * m2)
        s[j, (PM + 2) * LANES + i] = w * (p0 * m2 + p3 * m1 - p1 * m3)
        s[j, (PM + 3) * LANES + i] = w * (p0 * m3 + p1 * m2 - p2 * m1)


@jit
def scatter(s, j, element_length):
    """Sum the weighted terms of block j into NODE_FORCE, TORQUE of its nodes and its left rows."""
    r = s[j]
    scale = 2.0 / element_length
    near, mid, far = scale * D_NEAR, scale * D_MID, scale * D_FAR
    for row in range(3):
        one, two = load4(r, (PF + row) * LANES), load4(r, (PF + row) * LANES + ELEMENTS)
        store4(r, (LFORCE + row) * LANES, near * one - far * two)
        store4(r, (NODE_FORCE + row) * LANES, mid * (one - two))
        store4(r, (NODE_FORCE + row) * LANES + ELEMENTS, far * one - near * two)
    for row in range(4):
        one, two = load4(r, (PM + row) * LANES), load4(r, (PM + row) * LANES + ELEMENTS)
        g_one, g_two = load4(r, (PG + row) * LANES), load4(r, (PG + row) * LANES + ELEMENTS)
        store4(r, (LTORQUE + row) * LANES,
               near * one - far * two + N_NEAR * g_one + N_FAR * g_two)
        store4(r, (TORQUE + row) * LANES, mid * (one - two) + N_MID * (g_one + g_two))
        store4(r, (TORQUE + row) * LANES + ELEMENTS,
               far * one - near * two + N_FAR * g_one + N_NEAR * g_two)


@jit
def internal_forces(s, blocks, clamp, section, factor, mixed):
    """
    Fill strains, stresses and the internal force and moment of every node.

    The clamped node's own are left in the left rows of block 0, lane 0. Arguments: see
    `gather_left_nodes` and `section_forces`.
    """
    gather_left_nodes(s, blocks, clamp)
    for j in range(blocks):
        interpolate(s, j, section.element_length)
        section_forces(s, j, section, factor, mixed)
        scatter(s, j, section.element_length)
    for j in range(blocks):
        r = s[j]
        for row in range(7):
            # left corners are right ones one lane back; the lane behind the last is always zero
            right = (NODE_FORCE + row) * LANES + ELEMENTS
            store4(r, right, load4(r, right) + load4(r, (LFORCE + row) * LANES + 1))
            if j > 0:
                s[j - 1, (NODE_FORCE + row) * LANES + LANES - 1] += r[(LFORCE + row) * LANES]


@jit
def clamp_reaction(s, clamp):
    """Return the force and moment that the clamped node takes, brush axes, from the left rows."""
    y0, y1, y2, y3 = (s[0, LTORQUE * LANES], s[0, (LTORQUE + 1) * LANES],
                      s[0, (LTORQUE + 2) * LANES], s[0, (LTORQUE + 3) * LANES])
    q0, q1, q2, q3 = clamp[3], clamp[4], clamp[5], clamp[6]
    # Y conj(q) is the moment in brush axes: q (conj(q) Y) conj(q)
    m1 = -y0 * q1 + y1 * q0 - y2 * q3 + y3 * q2
    m2 = -y0 * q2 + y2 * q0 - y3 * q1 + y1 * q3
    m3 = -y0 * q3 + y3 * q0 - y1 * q2 + y2 * q1
    return (-s[0, LFORCE * LANES], -s[0, (LFORCE + 1) * LANES], -s[0, (LFORCE + 2) * LANES],
            -m1, -m2, -m3)


@jit
def stiffness(section):
    """Return the six section stiffnesses in the order of the strains."""
    return (section.axial, section.shear_y, section.shear_z,
            section.torsion, section.bending_y, section.bending_z)
