"""
Factorise and solve the iteration matrix of a bristle: a chain of 6 x 6 blocks.

Each element's mid node is eliminated first; what is left couples each corner to its neighbours and
is eliminated from the clamp to the tip, so that the last block is the tip's own compliance, which
the contact problem needs. Elements have a record each: eight matrices of six columns, padded to
eight rows so that a column is two vector registers, and the two right-hand sides.
"""
import numpy as np

from .jit import jit
from .layout import (ELEMENTS, INERTIA, LANES, MASS, Q, R, TORQUE)
from .tangent import ELEMENT, TANGENT_WORK, element_tangent

MATRIX = 48
MID_INVERSE = 0
LEFT_MID = MATRIX           # K_Lm K_mm^-1, for the corner on the left
RIGHT_MID = 2 * MATRIX      # K_Rm K_mm^-1
MID_LEFT = 3 * MATRIX       # K_mm^-1 K_mL
MID_RIGHT = 4 * MATRIX      # K_mm^-1 K_mR
INVERSE = 5 * MATRIX        # of the corner's eliminated diagonal block
LOWER = 6 * MATRIX          # what the corner before passes on
UPPER = 7 * MATRIX          # what the corner behind passes back
MID = 8 * MATRIX            # right-hand side, then increment, of the mid node
CORNER = MID + 8            # of the right corner
RECORD = CORNER + 8

OK = 0
SINGULAR = 1

_A = TANGENT_WORK           # 6 x 6 scratch behind the tangent's
_B = _A + 36
_D = _B + 36
CHAIN_WORK = _D + 36


def chain_work():
    """Return the scratch array that `factorise` works in."""
    return np.zeros(CHAIN_WORK)


@jit
def invert(a, at):
    """Invert the 6 x 6 matrix at a[at:] in place, without pivoting; return OK or SINGULAR."""
    for k in range(6):
        pivot = a[at + 7 * k]
        if not abs(pivot) > 1e-300 or not abs(pivot) < 1e300:
            return SINGULAR
        a[at + 7 * k] = 1.0
        inverse = 1.0 / pivot
        for j in range(6):
            a[at + 6 * k + j] *= inverse
        for i in range(6):
            if i != k:
                f = a[at + 6 * i + k]
                a[at + 6 * i + k] = 0.0
                for j in range(6):
                    a[at + 6 * i + j] -= f * a[at + 6 * k + j]
    return OK


@jit
def _store(chain, e, at, work, source):
    """Copy a 6 x 6 row-major scratch matrix into a record's padded columns."""
    for col in range(6):
        for row in range(6):
            chain[e, at + 8 * col + row] = work[source + 6 * row + col]


@jit
def _times_scratch(work, row0, col0, scratch, chain, e, at):
    """Store chain[e, at] = (6 x 6 part of ELEMENT at row0, col0) times the scratch matrix."""
    for row in range(6):
        for col in range(6):
            total = 0.0
            for k in range(6):
                total += work[ELEMENT + 18 * (row0 + row) + col0 + k] * work[scratch + 6 * k + col]
            chain[e, at + 8 * col + row] = total


@jit
def _scratch_times(work, scratch, row0, col0, chain, e, at):
    """Store chain[e, at] = scratch matrix times the part of ELEMENT at row0, col0."""
    for row in range(6):
        for col in range(6):
            total = 0.0
            for k in range(6):
                total += work[scratch + 6 * row + k] * work[ELEMENT + 18 * (row0 + k) + col0 + col]
            chain[e, at + 8 * col + row] = total


@jit
def _subtract_condensed(work, row0, col0, chain, e, at):
    """Take chain[e, at] times K_m,col0 off the part of ELEMENT at row0, col0."""
    for row in range(6):
        for col in range(6):
            total = 0.0
            for k in range(6):
                total += chain[e, at + 8 * k + row] * work[ELEMENT + 18 * (6 + k) + col0 + col]
            work[ELEMENT + 18 * (row0 + row) + col0 + col] -= total


@jit
def _add_node(s, j, lane, work, corner, mass_factor, spin, spin_rate, cv):
    """
    Add inertia, frame forces and the moment's own turning to the node's diagonal part of ELEMENT.

    mass_factor [1/s^2] : float      ca + alpha_D cv
    spin [rad/s], spin_rate [rad/s^2] : (3,)   Omega and its rate, brush axes
    Frame forces' tangent: m (Omega x (Omega x u) + Omega' x u + 2 cv Omega x u).
    """
    q0, q1, q2, q3 = (s[j, Q * LANES + lane], s[j, (Q + 1) * LANES + lane],
                      s[j, (Q + 2) * LANES + lane], s[j, (Q + 3) * LANES + lane])
    r11, r12, r13 = (1.0 - 2.0 * (q2 * q2 + q3 * q3), 2.0 * (q1 * q2 - q0 * q3),
                     2.0 * (q1 * q3 + q0 * q2))
    r21, r22, r23 = (2.0 * (q1 * q2 + q0 * q3), 1.0 - 2.0 * (q1 * q1 + q3 * q3),
                     2.0 * (q2 * q3 - q0 * q1))
    r31, r32, r33 = (2.0 * (q1 * q3 - q0 * q2), 2.0 * (q2 * q3 + q0 * q1),
                     1.0 - 2.0 * (q1 * q1 + q2 * q2))
    w1 = r11 * spin[0] + r21 * spin[1] + r31 * spin[2]
    w2 = r12 * spin[0] + r22 * spin[1] + r32 * spin[2]
    w3 = r13 * spin[0] + r23 * spin[1] + r33 * spin[2]
    a1 = r11 * spin_rate[0] + r21 * spin_rate[1] + r31 * spin_rate[2] + 2.0 * cv * w1
    a2 = r12 * spin_rate[0] + r22 * spin_rate[1] + r32 * spin_rate[2] + 2.0 * cv * w2
    a3 = r13 * spin_rate[0] + r23 * spin_rate[1] + r33 * spin_rate[2] + 2.0 * cv * w3
    m = s[j, MASS * LANES + lane]
    square = w1 * w1 + w2 * w2 + w3 * w3
    at = ELEMENT + 18 * corner + corner
    work[at] += m * (mass_factor + w1 * w1 - square)
    work[at + 1] += m * (w1 * w2 - a3)
    work[at + 2] += m * (w1 * w3 + a2)
    work[at + 18] += m * (w2 * w1 + a3)
    work[at + 19] += m * (mass_factor + w2 * w2 - square)
    work[at + 20] += m * (w2 * w3 - a1)
    work[at + 36] += m * (w3 * w1 - a2)
    work[at + 37] += m * (w3 * w2 + a1)
    work[at + 38] += m * (mass_factor + w3 * w3 - square)
    y0, y1, y2, y3 = (s[j, TORQUE * LANES + lane], s[j, (TORQUE + 1) * LANES + lane],
                      s[j, (TORQUE + 2) * LANES + lane], s[j, (TORQUE + 3) * LANES + lane])
    scalar = 0.5 * (q0 * y0 + q1 * y1 + q2 * y2 + q3 * y3)
    m1 = 0.5 * (q0 * y1 - y0 * q1 - q2 * y3 + q3 * y2)
    m2 = 0.5 * (q0 * y2 - y0 * q2 - q3 * y1 + q1 * y3)
    m3 = 0.5 * (q0 * y3 - y0 * q3 - q1 * y2 + q2 * y1)
    at += 18 * 3 + 3
    work[at] += s[j, INERTIA * LANES + lane] * mass_factor - scalar
    work[at + 1] -= m3
    work[at + 2] += m2
    work[at + 18] += m3
    work[at + 19] += s[j, (INERTIA + 1) * LANES + lane] * mass_factor - scalar
    work[at + 20] -= m1
    work[at + 36] -= m2
    work[at + 37] += m1
    work[at + 38] += s[j, (INERTIA + 2) * LANES + lane] * mass_factor - scalar


@jit
def factorise(s, elements, section, factor, mass_factor, spin, spin_rate, cv, chain, work):
    """
    Factorise the iteration matrix at the present state into `chain`; return OK or SINGULAR.

    s : (blocks, BLOCK)            the bristle, its internal forces evaluated at the present state
    chain : (elements, RECORD)     one record per element
    work : (CHAIN_WORK,)           scratch
    The matrix is factor * material + geometric stiffness + what `_add_node` names.
    """
    for e in range(elements):
        j = e // ELEMENTS
        lane = e % ELEMENTS
        element_tangent(s, j, lane, section, factor, work)
        for node in range(2):
            _add_node(s, j, lane + ELEMENTS * node, work, 6 + 6 * node, mass_factor, spin,
                      spin_rate, cv)
        for row in range(6):
            for col in range(6):
                work[_A + 6 * row + col] = work[ELEMENT + 18 * (6 + row) + 6 + col]
        if invert(work, _A) != OK:
            return SINGULAR
        _store(chain, e, MID_INVERSE, work, _A)
        for side in range(2):
            _times_scratch(work, 12 * side, 6, _A, chain, e,
                           LEFT_MID + (RIGHT_MID - LEFT_MID) * side)
            _scratch_times(work, _A, 6, 12 * side, chain, e,
                           MID_LEFT + (MID_RIGHT - MID_LEFT) * side)
        for row_side in range(2):
            for col_side in range(2):
                _subtract_condensed(work, 12 * row_side, 12 * col_side, chain, e,
                                    LEFT_MID + (RIGHT_MID - LEFT_MID) * row_side)
        if e > 0:
            for row in range(6):
                for col in range(6):
                    work[_D + 6 * row + col] += work[ELEMENT + 18 * row + col]
            if invert(work, _D) != OK:
                return SINGULAR
            _store(chain, e - 1, INVERSE, work, _D)
            _scratch_times(work, _D, 0, 12, chain, e - 1, UPPER)
            _times_scratch(work, 12, 0, _D, chain, e, LOWER)
            for row in range(6):
                for col in range(6):
                    total = 0.0
                    for k in range(6):
                        total += (chain[e, LOWER + 8 * k + row]
                                  * work[ELEMENT + 18 * k + 12 + col])
                    work[ELEMENT + 18 * (12 + row) + 12 + col] -= total
        for row in range(6):
            for col in range(6):
                work[_D + 6 * row + col] = work[ELEMENT + 18 * (12 + row) + 12 + col]
    if invert(work, _D) != OK:
        return SINGULAR
    _store(chain, elements - 1, INVERSE, work, _D)
    return OK


def _subtraction(into, matrix, behind=0):
    """
    Make the kernel that takes record e's `matrix` times v off the vector `into`.

    The vector is that of record e - behind. Offsets that the compiler knows let it use whole
    registers: as arguments they would not do, since a callee is optimised before it is inlined.
    """
    @jit
    def subtract(chain, e, v0, v1, v2, v3, v4, v5):
        for i in range(8):
            chain[e - behind, into + i] -= (
                (chain[e, matrix + i] * v0 + chain[e, matrix + 8 + i] * v1
                 + chain[e, matrix + 16 + i] * v2)
                + (chain[e, matrix + 24 + i] * v3 + chain[e, matrix + 32 + i] * v4
                   + chain[e, matrix + 40 + i] * v5))
    return subtract


def _application(vector, matrix):
    """Make the kernel that replaces record e's `vector` by `matrix` times it."""
    @jit
    def apply(chain, e):
        v0, v1, v2 = chain[e, vector], chain[e, vector + 1], chain[e, vector + 2]
        v3, v4, v5 = chain[e, vector + 3], chain[e, vector + 4], chain[e, vector + 5]
        for i in range(8):
            chain[e, vector + i] = (
                (chain[e, matrix + i] * v0 + chain[e, matrix + 8 + i] * v1
                 + chain[e, matrix + 16 + i] * v2)
                + (chain[e, matrix + 24 + i] * v3 + chain[e, matrix + 32 + i] * v4
                   + chain[e, matrix + 40 + i] * v5))
    return apply


_to_right = _subtraction(CORNER, RIGHT_MID)
_to_left = _subtraction(CORNER, LEFT_MID, 1)
_along = _subtraction(CORNER, LOWER)
_back = _subtraction(CORNER, UPPER)
_from_right = _subtraction(MID, MID_RIGHT)
_from_left = _subtraction(MID, MID_LEFT)
_solve_corner = _application(CORNER, INVERSE)
_solve_mid = _application(MID, MID_INVERSE)


@jit
def _vector(chain, e, at):
    """Return the six numbers of record e at `at`."""
    return (chain[e, at], chain[e, at + 1], chain[e, at + 2], chain[e, at + 3], chain[e, at + 4],
            chain[e, at + 5])


@jit
def load_residual(s, elements, chain):
    """Copy the residual rows of the nodes into the records."""
    for e in range(elements):
        j = e // ELEMENTS
        lane = e % ELEMENTS
        for row in range(6):
            chain[e, MID + row] = s[j, (R + row) * LANES + lane]
            chain[e, CORNER + row] = s[j, (R + row) * LANES + ELEMENTS + lane]


@jit
def eliminate(chain, elements):
    """Forward sweep, clamp to tip; afterwards the tip's increment is INVERSE times its CORNER."""
    for e in range(elements):
        m0, m1, m2, m3, m4, m5 = _vector(chain, e, MID)
        _to_right(chain, e, m0, m1, m2, m3, m4, m5)
        if e > 0:
            _to_left(chain, e, m0, m1, m2, m3, m4, m5)
    for e in range(1, elements):
        c0, c1, c2, c3, c4, c5 = _vector(chain, e - 1, CORNER)
        _along(chain, e, c0, c1, c2, c3, c4, c5)


@jit
def substitute(chain, elements):
    """Backward sweep, tip to clamp: MID and CORNER become the nodes' increments."""
    for e in range(elements):
        _solve_corner(chain, e)
        _solve_mid(chain, e)
    for e in range(elements - 2, -1, -1):
        c0, c1, c2, c3, c4, c5 = _vector(chain, e + 1, CORNER)
        _back(chain, e, c0, c1, c2, c3, c4, c5)
    for e in range(elements):
        c0, c1, c2, c3, c4, c5 = _vector(chain, e, CORNER)
        _from_right(chain, e, c0, c1, c2, c3, c4, c5)
        if e > 0:
            c0, c1, c2, c3, c4, c5 = _vector(chain, e - 1, CORNER)
            _from_left(chain, e, c0, c1, c2, c3, c4, c5)


@jit
def store_increments(s, elements, chain):
    """Copy the increments in the records into the residual rows of the nodes; zero for fillers."""
    for e in range(elements):
        j = e // ELEMENTS
        lane = e % ELEMENTS
        for row in range(6):
            s[j, (R + row) * LANES + lane] = chain[e, MID + row]
            s[j, (R + row) * LANES + ELEMENTS + lane] = chain[e, CORNER + row]
    for e in range(elements, s.shape[0] * ELEMENTS):
        for row in range(6):
            s[e // ELEMENTS, (R + row) * LANES + e % ELEMENTS] = 0.0
            s[e // ELEMENTS, (R + row) * LANES + ELEMENTS + e % ELEMENTS] = 0.0
