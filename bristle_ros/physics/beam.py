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

import numpy as np

from .jit import jit
from .layout import (BLOCK, DP, DX, ELEMENTS, FORCE, LANES, LFORCE, LQ, LTORQUE, LX, P, PF, PG,
                     PM, Q, RATE0, RATEACC0, STRAIN, STRAIN0, STRESS, STRESS0, TORQUE, WEIGHT, X)

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

    s : (blocks * BLOCK,)     the bristle, laid out as layout.py says
    clamp [m, -] : (7,)       position and quaternion of the clamped node
    """
    for j in range(blocks):
        b = s[j * BLOCK:(j + 1) * BLOCK]
        for row in range(7):
            for lane in range(1, ELEMENTS):
                b[(LX + row) * LANES + lane] = b[(X + row) * LANES + ELEMENTS - 1 + lane]
            if j == 0:
                b[(LX + row) * LANES] = clamp[row]
            else:
                b[(LX + row) * LANES] = s[(j - 1) * BLOCK + (X + row) * LANES + LANES - 1]


@jit
def interpolate(b, element_length):
    """Fill P, DP and DX of block `b` from its nodes."""
    scale = 2.0 / element_length
    for row in range(4):
        for i in range(ELEMENTS):
            left = b[(LQ + row) * LANES + i]
            mid = b[(Q + row) * LANES + i]
            right = b[(Q + row) * LANES + ELEMENTS + i]
            b[(P + row) * LANES + i] = N_NEAR * left + N_MID * mid + N_FAR * right
            b[(P + row) * LANES + ELEMENTS + i] = N_FAR * left + N_MID * mid + N_NEAR * right
            b[(DP + row) * LANES + i] = scale * (D_NEAR * left + D_MID * mid + D_FAR * right)
            b[(DP + row) * LANES + ELEMENTS + i] = -scale * (
                D_FAR * left + D_MID * mid + D_NEAR * right)
    for row in range(3):
        for i in range(ELEMENTS):
            left = b[(LX + row) * LANES + i]
            mid = b[(X + row) * LANES + i]
            right = b[(X + row) * LANES + ELEMENTS + i]
            b[(DX + row) * LANES + i] = scale * (D_NEAR * left + D_MID * mid + D_FAR * right)
            b[(DX + row) * LANES + ELEMENTS + i] = -scale * (
                D_FAR * left + D_MID * mid + D_NEAR * right)


@jit
def section_forces(b, section, factor):
    """
    Fill STRAIN, STRESS and the weighted terms of the virtual work at each Gauss point of block `b`.

    factor : float    stress = factor * stiffness * strain + STRESS0; 1 without damping
    """
    axial = factor * section.axial
    shear_y = factor * section.shear_y
    shear_z = factor * section.shear_z
    torsion = factor * section.torsion
    bending_y = factor * section.bending_y
    bending_z = factor * section.bending_z
    for i in range(LANES):
        p0 = b[P * LANES + i]
        p1 = b[(P + 1) * LANES + i]
        p2 = b[(P + 2) * LANES + i]
        p3 = b[(P + 3) * LANES + i]
        d0 = b[DP * LANES + i]
        d1 = b[(DP + 1) * LANES + i]
        d2 = b[(DP + 2) * LANES + i]
        d3 = b[(DP + 3) * LANES + i]
        x1 = b[DX * LANES + i]
        x2 = b[(DX + 1) * LANES + i]
        x3 = b[(DX + 2) * LANES + i]
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
        e1 = c1 - 1.0
        b[STRAIN * LANES + i] = e1
        b[(STRAIN + 1) * LANES + i] = c2
        b[(STRAIN + 2) * LANES + i] = c3
        b[(STRAIN + 3) * LANES + i] = 2.0 * k1
        b[(STRAIN + 4) * LANES + i] = 2.0 * k2
        b[(STRAIN + 5) * LANES + i] = 2.0 * k3
        n1 = axial * e1 + b[STRESS0 * LANES + i]
        n2 = shear_y * c2 + b[(STRESS0 + 1) * LANES + i]
        n3 = shear_z * c3 + b[(STRESS0 + 2) * LANES + i]
        m1 = torsion * 2.0 * k1 + b[(STRESS0 + 3) * LANES + i]
        m2 = bending_y * 2.0 * k2 + b[(STRESS0 + 4) * LANES + i]
        m3 = bending_z * 2.0 * k3 + b[(STRESS0 + 5) * LANES + i]
        b[STRESS * LANES + i] = n1
        b[(STRESS + 1) * LANES + i] = n2
        b[(STRESS + 2) * LANES + i] = n3
        b[(STRESS + 3) * LANES + i] = m1
        b[(STRESS + 4) * LANES + i] = m2
        b[(STRESS + 5) * LANES + i] = m3
        w = b[WEIGHT * LANES + i]
        b[PF * LANES + i] = w * (r11 * n1 + r12 * n2 + r13 * n3)
        b[(PF + 1) * LANES + i] = w * (r21 * n1 + r22 * n2 + r23 * n3)
        b[(PF + 2) * LANES + i] = w * (r31 * n1 + r32 * n2 + r33 * n3)
        g0 = -(m1 * k1 + m2 * k2 + m3 * k3)
        g1 = n2 * c3 - n3 * c2 - k0 * m1 + m2 * k3 - m3 * k2
        g2 = n3 * c1 - n1 * c3 - k0 * m2 + m3 * k1 - m1 * k3
        g3 = n1 * c2 - n2 * c1 - k0 * m3 + m1 * k2 - m2 * k1
        w = w * inverse
        b[PG * LANES + i] = w * (p0 * g0 - p1 * g1 - p2 * g2 - p3 * g3)
        b[(PG + 1) * LANES + i] = w * (p0 * g1 + p1 * g0 + p2 * g3 - p3 * g2)
        b[(PG + 2) * LANES + i] = w * (p0 * g2 + p2 * g0 + p3 * g1 - p1 * g3)
        b[(PG + 3) * LANES + i] = w * (p0 * g3 + p3 * g0 + p1 * g2 - p2 * g1)
        b[PM * LANES + i] = -w * (p1 * m1 + p2 * m2 + p3 * m3)
        b[(PM + 1) * LANES + i] = w * (p0 * m1 + p2 * m3 - p3 * m2)
        b[(PM + 2) * LANES + i] = w * (p0 * m2 + p3 * m1 - p1 * m3)
        b[(PM + 3) * LANES + i] = w * (p0 * m3 + p1 * m2 - p2 * m1)


@jit
def scatter(b, element_length):
    """Sum the weighted terms of block `b` into FORCE, TORQUE of its nodes and its left rows."""
    scale = 2.0 / element_length
    for row in range(3):
        for i in range(ELEMENTS):
            one = scale * b[(PF + row) * LANES + i]
            two = scale * b[(PF + row) * LANES + ELEMENTS + i]
            b[(LFORCE + row) * LANES + i] = D_NEAR * one - D_FAR * two
            b[(FORCE + row) * LANES + i] = D_MID * (one - two)
            b[(FORCE + row) * LANES + ELEMENTS + i] = D_FAR * one - D_NEAR * two
    for row in range(4):
        for i in range(ELEMENTS):
            one = scale * b[(PM + row) * LANES + i]
            two = scale * b[(PM + row) * LANES + ELEMENTS + i]
            g_one = b[(PG + row) * LANES + i]
            g_two = b[(PG + row) * LANES + ELEMENTS + i]
            b[(LTORQUE + row) * LANES + i] = (
                D_NEAR * one - D_FAR * two + N_NEAR * g_one + N_FAR * g_two)
            b[(TORQUE + row) * LANES + i] = D_MID * (one - two) + N_MID * (g_one + g_two)
            b[(TORQUE + row) * LANES + ELEMENTS + i] = (
                D_FAR * one - D_NEAR * two + N_FAR * g_one + N_NEAR * g_two)


@jit
def internal_forces(s, blocks, clamp, section, factor):
    """
    Fill strains, stresses and the internal force and moment of every node.

    The clamped node's own are left in the left rows of block 0, lane 0. Arguments: see
    `gather_left_nodes` and `section_forces`.
    """
    gather_left_nodes(s, blocks, clamp)
    for j in range(blocks):
        b = s[j * BLOCK:(j + 1) * BLOCK]
        interpolate(b, section.element_length)
        section_forces(b, section, factor)
        scatter(b, section.element_length)
    for j in range(blocks):
        b = s[j * BLOCK:(j + 1) * BLOCK]
        for row in range(7):
            for lane in range(1, ELEMENTS):
                b[(FORCE + row) * LANES + ELEMENTS - 1 + lane] += b[(LFORCE + row) * LANES + lane]
            if j > 0:
                s[(j - 1) * BLOCK + (FORCE + row) * LANES + LANES - 1] += b[(LFORCE + row) * LANES]


@jit
def stiffness(section):
    """Return the six section stiffnesses in the order of the strains."""
    return (section.axial, section.shear_y, section.shear_z,
            section.torsion, section.bending_y, section.bending_z)


@jit
def predict_damping(s, blocks, section, viscosity, cv, keep, drift):
    """
    Put what the strain rate's history gives into STRESS0.

    Kelvin-Voigt: stress = C (strain + viscosity * rate). The rate follows the strain by the
    integrator's own recursion, rate = cv (strain - strain0) + keep * rate0 + drift * rateacc0,
    not through nodal velocities: for small strain that is beta_D K v, a rigid rotation gives
    exactly none at any step size, and contact stays passive (test_passivity.py).

    viscosity [s] : float     beta_D
    cv [1/s], keep, drift [s] : float
    """
    c = stiffness(section)
    for j in range(blocks):
        b = s[j * BLOCK:(j + 1) * BLOCK]
        for row in range(6):
            scale = viscosity * c[row]
            for i in range(LANES):
                b[(STRESS0 + row) * LANES + i] = scale * (
                    keep * b[(RATE0 + row) * LANES + i] + drift * b[(RATEACC0 + row) * LANES + i]
                    - cv * b[(STRAIN0 + row) * LANES + i])


@jit
def accept_damping(s, blocks, cv, keep, drift, ca, keep_acc, drift_acc):
    """Carry strain, its rate and the rate's own acceleration over to the next step."""
    for j in range(blocks):
        b = s[j * BLOCK:(j + 1) * BLOCK]
        for row in range(6):
            for i in range(LANES):
                change = b[(STRAIN + row) * LANES + i] - b[(STRAIN0 + row) * LANES + i]
                rate = b[(RATE0 + row) * LANES + i]
                acceleration = b[(RATEACC0 + row) * LANES + i]
                b[(RATE0 + row) * LANES + i] = cv * change + keep * rate + drift * acceleration
                b[(RATEACC0 + row) * LANES + i] = (
                    ca * change - keep_acc * rate - drift_acc * acceleration)
                b[(STRAIN0 + row) * LANES + i] = b[(STRAIN + row) * LANES + i]
