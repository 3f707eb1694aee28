"""
Where a bristle's numbers lie: blocks of four elements, eight lanes wide.

One block holds four elements in one flat row of numbers, as rows of eight lanes at offsets that
the compiler knows; that is what lets it prove that rows don't overlap, and vectorise every loop
over lanes.

Node rows: lanes 0-3 are the four mid nodes, lanes 4-7 the four right corner nodes.
Point rows: lanes 0-3 are the first Gauss points of the four elements, lanes 4-7 the second ones.
Left rows: lanes 0-3 are the left corner nodes, copies of the right corners before them.

Elements that only fill up the last block have weight zero and never move.
"""
from bristle_ros.physics.compiler import jit

ELEMENTS = 4            # in a block
LANES = 2 * ELEMENTS    # of a row

# node rows, now
X = 0           # 3  position [m], brush axes
Q = 3           # 4  orientation, unit quaternion w, x, y, z: section axes to brush axes
# node rows, at the start of the step
X0 = 7          # 3
Q0 = 10         # 4
V0 = 14         # 3  velocity relative to the brush frame [m/s], brush axes
W0 = 17         # 3  angular velocity relative to the brush frame [rad/s], section axes
A0 = 20         # 6  the integrator's own acceleration (three linear, three angular)
ACC0 = 26       # 6  the acceleration that the equation of motion gives
JUMP = 140      # 6  change of A0 over the last step
# node rows, within the step
HA = 32         # 6  acceleration = ca * increment - HA
HV = 38         # 6  velocity = cv * increment + HV
R = 44          # 6  residual force and moment, section axes
FORCE = 50      # 3  internal force [N], brush axes
TORQUE = 53     # 4  internal moment as a quaternion: moment = Im(conj(Q) TORQUE) [N m]
MASS = 57       # 1  [kg]
INERTIA = 58    # 3  [kg m^2], section axes
# left rows
LX = 61         # 3
LQ = 64         # 4
LFORCE = 68     # 3
LTORQUE = 71    # 4
LR = 134        # 6  residual passed on to the left corner, then its increment; in lanes 4-7 what
#                      the excess of the section force adds to it
# point rows
P = 75          # 4  interpolated quaternion, not of unit length
DP = 79         # 4  its derivative along the bristle [1/m]
DX = 83         # 3  derivative of the position
WEIGHT = 86     # 1  quadrature weight [m]; 0 for a filler
STRAIN = 87     # 6  elongation, two shears, twist and two curvatures [1/m]
STRESS = 93     # 6  section force [N] and moment [N m], section axes
STRESS0 = 99    # 6  the part of it that is constant within the step
PF = 105        # 3  weighted section force, brush axes
PG = 108        # 4  weighted rotation terms of the virtual work
PM = 112        # 4
# point rows of the strain-rate recursion (Kelvin-Voigt damping)
STRAIN0 = 116   # 6
RATE0 = 122     # 6
RATEACC0 = 128  # 6
# point rows of the section force as an unknown of its own (mixed.py)
SECTION_FORCE0 = 146    # 3  [N] at the start of the step, section axes
SECTION_FORCE = 149     # 3  now
EXCESS = 152    # 3  what the strain would make of it, less what it is
# point rows, where the clamp is driven along a polygon
STRAIN_BEFORE = 155     # 6  at the start of the integration step, sub-steps or not
ROWS = 161
BLOCK = ROWS * LANES


def block_count(elements: int) -> int:
    """Return how many blocks hold `elements` elements."""
    return -(-elements // ELEMENTS)


@jit
def tip_lane(elements):
    """Return block and lane of the tip node."""
    return (elements - 1) // ELEMENTS, ELEMENTS + (elements - 1) % ELEMENTS
