"""
Factorise and solve the iteration matrix of a bristle: a chain of 6 x 6 blocks.

Each element's mid node is eliminated first, four elements at a time, a lane each. What is left
couples each corner to its neighbours and is eliminated from the clamp to the tip, so that the last
block is the tip's own compliance, which the contact problem needs. Corners have a record each:
three matrices of six columns, padded to eight rows so that a column is two vector registers, and
the right-hand side.
"""
from bristle_ros.physics.compiler import (jit, join4, load4, load8, push_first4, push_last4,
                                          splat4, splat_of8, splats6, store4, store8, transpose4)
from bristle_ros.physics.motion import SPIN, SPIN_RATE
import numpy as np
from numpy.typing import NDArray

from .layout import ELEMENTS, INERTIA, LANES, LR, MASS, Q, R, TORQUE
from .tangent import (add_to, block_tangent, keep_strain_matrix, LEFT_LEFT, LEFT_MIDDLE,
                      LEFT_RIGHT, MIDDLE_MIDDLE, MIDDLE_RIGHT, moment_tangent, RIGHT_RIGHT,
                      SIX_BY_SIX, TANGENT_WORK)

# record of a corner
MATRIX = 48
INVERSE = 0                 # of the corner's eliminated diagonal block
LOWER = MATRIX              # what it passes on to the corner behind
UPPER = 2 * MATRIX          # what the corner behind passes back
CORNER = 3 * MATRIX         # right-hand side, then increment
RECORD = CORNER + 8

# mid nodes of a block, matrices row by row, four lanes each
MID_INVERSE = 0
LEFT_MID = SIX_BY_SIX            # K_Lm K_mm^-1, for the corner on the left
RIGHT_MID = 2 * SIX_BY_SIX       # K_Rm K_mm^-1
MID_LEFT = 3 * SIX_BY_SIX        # K_mm^-1 K_mL
MID_RIGHT = 4 * SIX_BY_SIX       # K_mm^-1 K_mR
STRAIN_MATRIX = 5 * SIX_BY_SIX   # of the force strains at the Gauss points, section_force.py
MIDS = STRAIN_MATRIX + 54 * LANES

OK = 0
SINGULAR = 1

_ROW = 6 * ELEMENTS         # of a block's matrix, from one row to the next
_RIGHT_LEFT = TANGENT_WORK  # condensed, not symmetric where the frame turns
# of each element by itself, columns padded as those of a record
_PARTS = _RIGHT_LEFT + SIX_BY_SIX
_PART_LEFT = 0
_PART_UPPER = MATRIX        # left and right
_PART_LOWER = 2 * MATRIX    # right and left
_PART_RIGHT = 3 * MATRIX
_PART = 4 * MATRIX
CHAIN_WORK = _PARTS + ELEMENTS * _PART


def chain_work() -> NDArray[np.float64]:
    """Return the scratch array that `factorise` works in."""
    return np.zeros(CHAIN_WORK)


@jit
def _is_pivot(value):
    return 1e-300 < abs(value) < 1e300


@jit
def _invert_lanes(a, at):
    """Invert the four 6 x 6 matrices at a[at:] in place, without pivoting; OK or SINGULAR."""
    for k in range(6):
        pivot_at = at + k * _ROW + k * ELEMENTS
        for lane in range(ELEMENTS):
            if not _is_pivot(a[pivot_at + lane]):
                return SINGULAR
        inverse = 1.0 / load4(a, pivot_at)
        for j in range(6):
            place = at + k * _ROW + j * ELEMENTS
            store4(a, place, load4(a, place) * inverse)
        store4(a, pivot_at, inverse)
        for i in range(6):
            if i != k:
                factor = load4(a, at + i * _ROW + k * ELEMENTS)
                for j in range(6):
                    if j != k:
                        place = at + i * _ROW + j * ELEMENTS
                        store4(a, place, load4(a, place)
                               - factor * load4(a, at + k * _ROW + j * ELEMENTS))
                store4(a, at + i * _ROW + k * ELEMENTS, -factor * inverse)
    return OK


@jit
def _times(a, x, row_x, col_x, b, y, row_y, col_y, row):
    """Return a row of the product of four 6 x 6 matrices, at a[x:] and b[y:], strides given."""
    at = x + row * row_x
    x0, x1, x2 = load4(a, at), load4(a, at + col_x), load4(a, at + 2 * col_x)
    x3, x4, x5 = (load4(a, at + 3 * col_x), load4(a, at + 4 * col_x), load4(a, at + 5 * col_x))
    return (_dot(b, y, row_y, x0, x1, x2, x3, x4, x5),
            _dot(b, y + col_y, row_y, x0, x1, x2, x3, x4, x5),
            _dot(b, y + 2 * col_y, row_y, x0, x1, x2, x3, x4, x5),
            _dot(b, y + 3 * col_y, row_y, x0, x1, x2, x3, x4, x5),
            _dot(b, y + 4 * col_y, row_y, x0, x1, x2, x3, x4, x5),
            _dot(b, y + 5 * col_y, row_y, x0, x1, x2, x3, x4, x5))


@jit
def _dot(b, y, stride, x0, x1, x2, x3, x4, x5):
    return ((x0 * load4(b, y) + x1 * load4(b, y + stride) + x2 * load4(b, y + 2 * stride))
            + (x3 * load4(b, y + 3 * stride) + x4 * load4(b, y + 4 * stride)
               + x5 * load4(b, y + 5 * stride)))


@jit
def _put_product(a, x, row_x, col_x, b, y, row_y, col_y, out, at):
    """Store the product at out[at:]; arguments as in `_times`."""
    for row in range(6):
        product = _times(a, x, row_x, col_x, b, y, row_y, col_y, row)
        for col in range(6):
            store4(out, at + row * _ROW + col * ELEMENTS, product[col])


@jit
def _take_product(a, x, row_x, col_x, b, y, row_y, col_y, out, at):
    """Take the product off what is at out[at:]; arguments as in `_times`."""
    for row in range(6):
        product = _times(a, x, row_x, col_x, b, y, row_y, col_y, row)
        for col in range(6):
            add_to(out, at + row * _ROW + col * ELEMENTS, -product[col])


@jit
def _add_nodes(s, lane, work, at, step, frame):
    """
    Add inertia, frame forces and the moment's own turning to the blocks at work[at:].

    s : (BLOCK,)                     rows of the four nodes in s[lane:lane + 4] of each row
    step : StepCoefficients, frame : (FRAME,)   of the step's end
    Frame forces' tangent: m (Omega x (Omega x u) + Omega' x u + 2 cv Omega x u).
    """
    mass_factor, cv = step.mass_factor, step.cv
    spin, spin_rate = frame[SPIN:], frame[SPIN_RATE:]
    q0, q1 = load4(s, Q * LANES + lane), load4(s, (Q + 1) * LANES + lane)
    q2, q3 = load4(s, (Q + 2) * LANES + lane), load4(s, (Q + 3) * LANES + lane)
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
    m = load4(s, MASS * LANES + lane)
    rest = mass_factor - (w1 * w1 + w2 * w2 + w3 * w3)
    add_to(work, at, m * (rest + w1 * w1))
    add_to(work, at + ELEMENTS, m * (w1 * w2 - a3))
    add_to(work, at + 2 * ELEMENTS, m * (w1 * w3 + a2))
    add_to(work, at + _ROW, m * (w2 * w1 + a3))
    add_to(work, at + _ROW + ELEMENTS, m * (rest + w2 * w2))
    add_to(work, at + _ROW + 2 * ELEMENTS, m * (w2 * w3 - a1))
    add_to(work, at + 2 * _ROW, m * (w3 * w1 - a2))
    add_to(work, at + 2 * _ROW + ELEMENTS, m * (w3 * w2 + a1))
    add_to(work, at + 2 * _ROW + 2 * ELEMENTS, m * (rest + w3 * w3))
    y0, y1 = load4(s, TORQUE * LANES + lane), load4(s, (TORQUE + 1) * LANES + lane)
    y2, y3 = load4(s, (TORQUE + 2) * LANES + lane), load4(s, (TORQUE + 3) * LANES + lane)
    at += 3 * (_ROW + ELEMENTS)
    moment_tangent(work, at, q0 * y0 + q1 * y1 + q2 * y2 + q3 * y3,
                   q0 * y1 - y0 * q1 - q2 * y3 + q3 * y2, q0 * y2 - y0 * q2 - q3 * y1 + q1 * y3,
                   q0 * y3 - y0 * q3 - q1 * y2 + q2 * y1)
    for i in range(3):
        add_to(work, at + i * (_ROW + ELEMENTS),
               load4(s, (INERTIA + i) * LANES + lane) * mass_factor)


@jit
def _condense(work, mids):
    """Eliminate the mid nodes of a block; fill its mids : (MIDS,). Return OK or SINGULAR."""
    if _invert_lanes(work, MIDDLE_MIDDLE) != OK:
        return SINGULAR
    for i in range(SIX_BY_SIX):
        mids[MID_INVERSE + i] = work[MIDDLE_MIDDLE + i]
    for row in range(6):    # K_RL = K_LR^T still
        for col in range(6):
            store4(work, _RIGHT_LEFT + row * _ROW + col * ELEMENTS,
                   load4(work, LEFT_RIGHT + col * _ROW + row * ELEMENTS))
    _put_product(work, LEFT_MIDDLE, _ROW, ELEMENTS, mids, MID_INVERSE, _ROW, ELEMENTS,
                 mids, LEFT_MID)
    _put_product(work, MIDDLE_RIGHT, ELEMENTS, _ROW, mids, MID_INVERSE, _ROW, ELEMENTS,
                 mids, RIGHT_MID)
    _put_product(mids, MID_INVERSE, _ROW, ELEMENTS, work, LEFT_MIDDLE, ELEMENTS, _ROW,
                 mids, MID_LEFT)
    _put_product(mids, MID_INVERSE, _ROW, ELEMENTS, work, MIDDLE_RIGHT, _ROW, ELEMENTS,
                 mids, MID_RIGHT)
    _take_product(mids, LEFT_MID, _ROW, ELEMENTS, work, LEFT_MIDDLE, ELEMENTS, _ROW,
                  work, LEFT_LEFT)
    _take_product(mids, LEFT_MID, _ROW, ELEMENTS, work, MIDDLE_RIGHT, _ROW, ELEMENTS,
                  work, LEFT_RIGHT)
    _take_product(mids, RIGHT_MID, _ROW, ELEMENTS, work, LEFT_MIDDLE, ELEMENTS, _ROW,
                  work, _RIGHT_LEFT)
    _take_product(mids, RIGHT_MID, _ROW, ELEMENTS, work, MIDDLE_RIGHT, _ROW, ELEMENTS,
                  work, RIGHT_RIGHT)
    return OK


@jit
def _invert_record(record):
    """Invert the 6 x 6 matrix INVERSE of a record in place, without pivoting; OK or SINGULAR."""
    for k in range(6):
        pivot = record[INVERSE + 9 * k]
        if not _is_pivot(pivot):
            return SINGULAR
        inverse = 1.0 / pivot
        column = load8(record, INVERSE + 8 * k) * inverse
        store8(record, INVERSE + 8 * k, column)
        record[INVERSE + 9 * k] = inverse
        for i in range(6):
            if i != k:
                factor = record[INVERSE + 8 * i + k]
                store8(record, INVERSE + 8 * i, load8(record, INVERSE + 8 * i) - factor * column)
                record[INVERSE + 8 * i + k] = -factor * inverse
    return OK


@jit
def _split(work, at, part):
    """Copy the matrices of four lanes at work[at:] to each element's own place `part`."""
    zero = splat4(0.0)
    for col in range(6):
        x = at + col * ELEMENTS
        t0, t1, t2, t3 = transpose4(load4(work, x), load4(work, x + _ROW),
                                    load4(work, x + 2 * _ROW), load4(work, x + 3 * _ROW))
        u0, u1, u2, u3 = transpose4(load4(work, x + 4 * _ROW), load4(work, x + 5 * _ROW),
                                    zero, zero)
        y = _PARTS + part + 8 * col
        store4(work, y, t0)
        store4(work, y + 4, u0)
        store4(work, y + _PART, t1)
        store4(work, y + _PART + 4, u1)
        store4(work, y + 2 * _PART, t2)
        store4(work, y + 2 * _PART + 4, u2)
        store4(work, y + 3 * _PART, t3)
        store4(work, y + 3 * _PART + 4, u3)


@jit
def _combine(a, at, x0, x1, x2, x3, x4, x5):
    return ((load8(a, at) * x0 + load8(a, at + 8) * x1 + load8(a, at + 16) * x2)
            + (load8(a, at + 24) * x3 + load8(a, at + 32) * x4 + load8(a, at + 40) * x5))


@jit
def _columns(a, at, b, first):
    """Return the padded 6 x 6 matrix at a[at:] times the six numbers at b[first:]."""
    return _combine(a, at, splat_of8(b, first), splat_of8(b, first + 1),
                    splat_of8(b, first + 2), splat_of8(b, first + 3), splat_of8(b, first + 4),
                    splat_of8(b, first + 5))


@jit
def _columns_by(a, at, vector):
    """Do the same with the six numbers in a vector: nothing waits for what was just stored."""
    x0, x1, x2, x3, x4, x5 = splats6(vector)
    return _combine(a, at, x0, x1, x2, x3, x4, x5)


@jit
def _link(work, part, before, record):
    """
    Eliminate the corner of the record `before` from the element whose matrices are at `part`.

    Its inverse is filled already; LOWER and UPPER follow, and the matrix of the element's own
    corner goes into INVERSE of `record`, not inverted yet.
    """
    for col in range(0, MATRIX, 8):
        store8(before, UPPER + col, _columns(before, INVERSE, work, part + _PART_UPPER + col))
        store8(before, LOWER + col, _columns(work, part + _PART_LOWER, before, INVERSE + col))
    for col in range(0, MATRIX, 8):
        store8(record, INVERSE + col, load8(work, part + _PART_RIGHT + col)
               - _columns(before, LOWER, work, part + _PART_UPPER + col))


@jit
def factorise(s, elements, section, step, frame, mids, chain, work):
    """
    Factorise the iteration matrix at the present state into `mids` and `chain`; OK or SINGULAR.

    s : (blocks, BLOCK)            the bristle, its internal forces evaluated at the present state
    mids : (blocks, MIDS)          mid nodes, chain : (elements, RECORD) corners
    step : StepCoefficients, frame : (FRAME,)    of the step's end
    work : (CHAIN_WORK,)           scratch
    The matrix is step.factor * material + geometric stiffness + what `_add_nodes` names.
    """
    for e in range(elements):
        j = e // ELEMENTS
        lane = e % ELEMENTS
        if lane == 0:
            block_tangent(s[j], section, step.factor, work)
            keep_strain_matrix(s[j], work, mids[j], STRAIN_MATRIX)
            _add_nodes(s[j], 0, work, MIDDLE_MIDDLE, step, frame)
            _add_nodes(s[j], ELEMENTS, work, RIGHT_RIGHT, step, frame)
            fillers = range(elements - j * ELEMENTS, ELEMENTS)
            for filler in fillers:
                for i in range(6):
                    work[MIDDLE_MIDDLE + i * (_ROW + ELEMENTS) + filler] = 1.0
            if _condense(work, mids[j]) != OK:
                return SINGULAR
            for filler in fillers:      # they never move
                for i in range(36):
                    mids[j, MID_INVERSE + ELEMENTS * i + filler] = 0.0
            _split(work, LEFT_LEFT, _PART_LEFT)
            _split(work, LEFT_RIGHT, _PART_UPPER)
            _split(work, _RIGHT_LEFT, _PART_LOWER)
            _split(work, RIGHT_RIGHT, _PART_RIGHT)
        part = _PARTS + lane * _PART
        record = chain[e]
        if e == 0:
            for col in range(0, MATRIX, 8):
                store8(record, INVERSE + col, load8(work, part + _PART_RIGHT + col))
            continue
        before = chain[e - 1]
        for col in range(0, MATRIX, 8):
            store8(before, INVERSE + col, load8(before, INVERSE + col)
                   + load8(work, part + _PART_LEFT + col))
        if _invert_record(before) != OK:
            return SINGULAR
        _link(work, part, before, record)
    return _invert_record(chain[elements - 1])


@jit
def eliminate(s, elements, mids, chain):
    """
    Forward sweep over the residual rows, mid nodes first, then corners from clamp to tip.

    Lanes 4-7 of LR hold what the left corners' residual is still short of: zero, or see
    section_force.py.

    Afterwards the tip's increment is INVERSE times CORNER of the last record.
    """
    blocks = s.shape[0]
    for j in range(blocks):
        rows, matrices = s[j], mids[j]
        r0, r1 = load4(rows, R * LANES), load4(rows, (R + 1) * LANES)
        r2, r3 = load4(rows, (R + 2) * LANES), load4(rows, (R + 3) * LANES)
        r4, r5 = load4(rows, (R + 4) * LANES), load4(rows, (R + 5) * LANES)
        for row in range(6):
            store4(rows, (LR + row) * LANES,
                   load4(rows, (LR + row) * LANES + ELEMENTS)
                   + _dot(matrices, LEFT_MID + row * _ROW, ELEMENTS, r0, r1, r2, r3, r4, r5))
            add_to(rows, (R + row) * LANES + ELEMENTS,
                   -_dot(matrices, RIGHT_MID + row * _ROW, ELEMENTS, r0, r1, r2, r3, r4, r5))
    _gather_corners(s, elements, chain)
    rest = load8(chain[0], CORNER)
    for e in range(1, elements):
        rest = load8(chain[e], CORNER) - _columns_by(chain[e - 1], LOWER, rest)
        store8(chain[e], CORNER, rest)


@jit
def _gather_corners(s, elements, chain):
    """Put each corner's row, less what the element behind has passed on, into its record."""
    zero = splat4(0.0)
    whole = elements // ELEMENTS
    for j in range(whole):
        rows, behind = s[j], s[min(j + 1, s.shape[0] - 1)]
        last = j + 1 == s.shape[0]
        v0 = _corner_row(rows, behind, last, 0)
        v1 = _corner_row(rows, behind, last, 1)
        v2 = _corner_row(rows, behind, last, 2)
        v3 = _corner_row(rows, behind, last, 3)
        t0, t1, t2, t3 = transpose4(v0, v1, v2, v3)
        u0, u1, u2, u3 = transpose4(_corner_row(rows, behind, last, 4),
                                    _corner_row(rows, behind, last, 5), zero, zero)
        e = j * ELEMENTS
        _put_corner(chain[e], t0, u0)
        _put_corner(chain[e + 1], t1, u1)
        _put_corner(chain[e + 2], t2, u2)
        _put_corner(chain[e + 3], t3, u3)
    for e in range(whole * ELEMENTS, elements):
        rows, lane = s[whole], e - whole * ELEMENTS
        for row in range(6):
            value = rows[(R + row) * LANES + ELEMENTS + lane]
            if e + 1 < elements:
                value -= rows[(LR + row) * LANES + lane + 1]
            chain[e, CORNER + row] = value


@jit
def _corner_row(rows, behind, last, row):
    """Return a row of the corners of a block; behind: the next block, last: there is none."""
    passed = 0.0 if last else behind[(LR + row) * LANES]
    return (load4(rows, (R + row) * LANES + ELEMENTS)
            - push_last4(load4(rows, (LR + row) * LANES), passed))


@jit
def _put_corner(record, low, high):
    store8(record, CORNER, join4(low, high))


@jit
def substitute(s, elements, mids, chain):
    """Backward sweep, tip to clamp: the residual rows become increments; zero for fillers."""
    blocks = s.shape[0]
    record = chain[elements - 1]
    increment = _columns(record, INVERSE, record, CORNER)
    store8(record, CORNER, increment)
    for e in range(elements - 2, -1, -1):
        record = chain[e]
        increment = (_columns(record, INVERSE, record, CORNER)
                     - _columns_by(record, UPPER, increment))
        store8(record, CORNER, increment)
    _scatter_corners(s, elements, chain)
    for j in range(blocks):
        rows, matrices = s[j], mids[j]
        r0, r1 = load4(rows, R * LANES), load4(rows, (R + 1) * LANES)
        r2, r3 = load4(rows, (R + 2) * LANES), load4(rows, (R + 3) * LANES)
        r4, r5 = load4(rows, (R + 4) * LANES), load4(rows, (R + 5) * LANES)
        at = R * LANES + ELEMENTS
        u0, u1, u2 = load4(rows, at), load4(rows, at + LANES), load4(rows, at + 2 * LANES)
        u3, u4, u5 = (load4(rows, at + 3 * LANES), load4(rows, at + 4 * LANES),
                      load4(rows, at + 5 * LANES))
        for row in range(6):
            store4(rows, (R + row) * LANES,
                   _dot(matrices, MID_INVERSE + row * _ROW, ELEMENTS, r0, r1, r2, r3, r4, r5)
                   - _dot(matrices, MID_RIGHT + row * _ROW, ELEMENTS, u0, u1, u2, u3, u4, u5))
        at = LR * LANES
        u0, u1, u2 = load4(rows, at), load4(rows, at + LANES), load4(rows, at + 2 * LANES)
        u3, u4, u5 = (load4(rows, at + 3 * LANES), load4(rows, at + 4 * LANES),
                      load4(rows, at + 5 * LANES))
        for row in range(6):
            add_to(rows, (R + row) * LANES,
                   -_dot(matrices, MID_LEFT + row * _ROW, ELEMENTS, u0, u1, u2, u3, u4, u5))


@jit
def _scatter_corners(s, elements, chain):
    """Put the corners' increments into the rows R, and LR of the elements behind them."""
    whole = elements // ELEMENTS
    for j in range(whole):
        rows, before, e = s[j], s[max(j - 1, 0)], j * ELEMENTS
        one, two, three, four = chain[e], chain[e + 1], chain[e + 2], chain[e + 3]
        v0, v1, v2, v3 = transpose4(load4(one, CORNER), load4(two, CORNER),
                                    load4(three, CORNER), load4(four, CORNER))
        v4, v5, _, _ = transpose4(load4(one, CORNER + 4), load4(two, CORNER + 4),
                                  load4(three, CORNER + 4), load4(four, CORNER + 4))
        _put_corners(rows, before, j == 0, 0, v0)
        _put_corners(rows, before, j == 0, 1, v1)
        _put_corners(rows, before, j == 0, 2, v2)
        _put_corners(rows, before, j == 0, 3, v3)
        _put_corners(rows, before, j == 0, 4, v4)
        _put_corners(rows, before, j == 0, 5, v5)
    for e in range(whole * ELEMENTS, s.shape[0] * ELEMENTS):
        rows, lane = s[whole], e - whole * ELEMENTS
        for row in range(6):
            rows[(R + row) * LANES + ELEMENTS + lane] = (
                chain[e, CORNER + row] if e < elements else 0.0)
            rows[(LR + row) * LANES + lane] = (
                chain[e - 1, CORNER + row] if 0 < e < elements else 0.0)


@jit
def _put_corners(rows, before, first, row, corners):
    """Store a row of the corners of a block; before: the block before, first: there is none."""
    passed = 0.0 if first else before[(R + row) * LANES + LANES - 1]
    store4(rows, (R + row) * LANES + ELEMENTS, corners)
    store4(rows, (LR + row) * LANES, push_first4(corners, passed))
