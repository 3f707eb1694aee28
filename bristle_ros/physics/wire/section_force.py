"""
Newton's method with the section force as an unknown of its own, so that an old matrix serves long.

A slender element is stiff along itself: EA l^2 / EI is 10^3 to 10^4. When it has turned by delta
since its matrix was factorised, Newton's method in the displacements alone takes EA delta of what
lengthens it for bending, and one correction spoils what the next one mends: its corrections shrink
by EA l^2 delta / EI. With the section force n an unknown, both equations

    f(u) - B(u)^T n = 0,    n - C eps(u) = 0

change by delta only, and so does what a correction leaves. n is eliminated again at each Gauss
point with the frozen B0 (K0 is what the moments, n and inertia make):

    (K0 + B0^T C B0) du = f - B^T n - B0^T (C eps - n),    n <- C (eps + B0 du)

The matrix is that of the displacements, the solution too: at du = 0 nothing is left of n.
Magisano, Leonetti, Garcea (2017), Comput. Methods Appl. Mech. Eng. 313, 986: mixed integration
points. Only the section force needs it; the moments follow the displacements.
"""
from bristle_ros.physics.compiler import halves8, jit, join4, load4, load8, store4, store8

from .beam import stiffness
from .chain import STRAIN_MATRIX
from .layout import ELEMENTS, EXCESS, LANES, LR, R, SECTION_FORCE, SECTION_FORCE0, WEIGHT
from .tangent import add_to


@jit
def begin_section_forces(s, blocks):
    """Start from the section forces at the start of the step."""
    for j in range(blocks):
        for i in range(3 * LANES):
            s[j, SECTION_FORCE * LANES + i] = s[j, SECTION_FORCE0 * LANES + i]


@jit
def accept_section_forces(s, blocks):
    """Carry the section forces over to the next step."""
    for j in range(blocks):
        for i in range(3 * LANES):
            s[j, SECTION_FORCE0 * LANES + i] = s[j, SECTION_FORCE * LANES + i]


@jit
def _transposed(b, at, t1, t2, t3):
    """Return a column of B at both Gauss points times t there, summed."""
    first, second = halves8(load8(b, at) * t1 + load8(b, at + 3 * LANES) * t2
                            + load8(b, at + 6 * LANES) * t3)
    return first + second


@jit
def add_excess(s, mids):
    """Take B0^T (C eps - n) off the residual rows; see `eliminate` for the left corners."""
    for j in range(s.shape[0]):
        rows, b = s[j], mids[j]
        w = load8(rows, WEIGHT * LANES)
        t1, t2, t3 = (w * load8(rows, EXCESS * LANES), w * load8(rows, (EXCESS + 1) * LANES),
                      w * load8(rows, (EXCESS + 2) * LANES))
        for i in range(6):
            # rows of a node's B: 3 x 3 for the displacement, then 3 x 3 for the rotation
            column = STRAIN_MATRIX + (i if i < 3 else 6 + i) * LANES
            store4(rows, (LR + i) * LANES + ELEMENTS, _transposed(b, column, t1, t2, t3))
            add_to(rows, (R + i) * LANES, -_transposed(b, column + 18 * LANES, t1, t2, t3))
            add_to(rows, (R + i) * LANES + ELEMENTS,
                   -_transposed(b, column + 36 * LANES, t1, t2, t3))


@jit
def _row_times(b, at, rows, increment):
    """Return a row of a node's B at both Gauss points times its increment, four lanes each."""
    return ((load8(b, at) * _twice(rows, increment)
             + load8(b, at + LANES) * _twice(rows, increment + LANES)
             + load8(b, at + 2 * LANES) * _twice(rows, increment + 2 * LANES))
            + (load8(b, at + 9 * LANES) * _twice(rows, increment + 3 * LANES)
               + load8(b, at + 10 * LANES) * _twice(rows, increment + 4 * LANES)
               + load8(b, at + 11 * LANES) * _twice(rows, increment + 5 * LANES)))


@jit
def _twice(rows, at):
    lanes = load4(rows, at)
    return join4(lanes, lanes)


@jit
def update_section_forces(s, mids, section, factor):
    """Let n become C (eps + B0 du), the increments du in the rows that `substitute` fills."""
    c = stiffness(section)
    for j in range(s.shape[0]):
        rows, b = s[j], mids[j]
        for i in range(3):
            row = STRAIN_MATRIX + 3 * i * LANES
            change = (_row_times(b, row, rows, LR * LANES)
                      + _row_times(b, row + 18 * LANES, rows, R * LANES)
                      + _row_times(b, row + 36 * LANES, rows, R * LANES + ELEMENTS))
            at = (SECTION_FORCE + i) * LANES
            store8(rows, at, load8(rows, at) + load8(rows, (EXCESS + i) * LANES)
                   + (factor * c[i]) * change)
