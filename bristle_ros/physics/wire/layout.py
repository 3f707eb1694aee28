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
Q = X + 3       # 4  orientation, unit quaternion w, x, y, z: section axes to brush axes
# node rows, at the start of the step
X0 = Q + 4      # 3
Q0 = X0 + 3     # 4
V0 = Q0 + 4     # 3  velocity relative to the brush frame [m/s], brush axes
W0 = V0 + 3     # 3  angular velocity relative to the brush frame [rad/s], section axes
A0 = W0 + 3     # 6  the integrator's own acceleration (three linear, three angular)
ACC0 = A0 + 6   # 6  the acceleration that the equation of motion gives
# node rows, within the step
HA = ACC0 + 6   # 6  acceleration = ca * increment - HA
HV = HA + 6     # 6  velocity = cv * increment + HV
R = HV + 6      # 6  residual force and moment, section axes
NODE_FORCE = R + 6   # 3  internal force [N], brush axes
TORQUE = NODE_FORCE + 3  # 4  internal moment as a quaternion: moment = Im(conj(Q) TORQUE) [N m]
MASS = TORQUE + 4  # 1  [kg]
INERTIA = MASS + 1  # 3  [kg m^2], section axes
# left rows
LX = INERTIA + 3  # 3
LQ = LX + 3     # 4
LFORCE = LQ + 4  # 3
LTORQUE = LFORCE + 3  # 4
# point rows
P = LTORQUE + 4  # 4  interpolated quaternion, not of unit length
DP = P + 4      # 4  its derivative along the bristle [1/m]
DX = DP + 4     # 3  derivative of the position
WEIGHT = DX + 3  # 1  quadrature weight [m]; 0 for a filler
STRAIN = WEIGHT + 1  # 6  elongation, two shears, twist and two curvatures [1/m]
STRESS = STRAIN + 6  # 6  section force [N] and moment [N m], section axes
STRESS0 = STRESS + 6  # 6  the part of it that is constant within the step
PF = STRESS0 + 6  # 3  weighted section force, brush axes
PG = PF + 3     # 4  weighted rotation terms of the virtual work
PM = PG + 4     # 4
# point rows of the strain-rate recursion (Kelvin-Voigt damping)
STRAIN0 = PM + 4  # 6
RATE0 = STRAIN0 + 6  # 6
RATEACC0 = RATE0 + 6  # 6
# a left row, and a node row at the start of the step
LR = RATEACC0 + 6  # 6  residual passed on to the left corner, then its increment; in lanes 4-7
#                      what the excess of the section force adds to it
JUMP = LR + 6   # 6  change of A0 over the last step,
LAST_JUMP = JUMP + 6  # 6  and over the one before
# point rows of the section force as an unknown of its own (section_force.py)
SECTION_FORCE0 = LAST_JUMP + 6  # 3  [N] at the start of the step, section axes
SECTION_FORCE = SECTION_FORCE0 + 3  # 3  now
EXCESS = SECTION_FORCE + 3  # 3  what the strain would make of it, less what it is
# point rows, where the clamp is driven along a polygon
STRAIN_BEFORE = EXCESS + 3  # 6  at the start of the integration step, sub-steps or not
ROWS = STRAIN_BEFORE + 6
BLOCK = ROWS * LANES


def block_count(elements: int) -> int:
    """Return how many blocks hold `elements` elements."""
    return -(-elements // ELEMENTS)


@jit
def tip_lane(elements):
    """Return block and lane of the tip node."""
    return (elements - 1) // ELEMENTS, ELEMENTS + (elements - 1) % ELEMENTS
