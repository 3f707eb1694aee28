"""The tip record of a bristle, and the contact problem seen from the chain's last block."""
from bristle_ros.physics.compiler import jit
from bristle_ros.physics.motion import HEIGHT, HEIGHT_RATE, PATH_SPIN, ROTATION, VELOCITY
from bristle_ros.physics.wire import (CORNER, HA, HV, INVERSE, LANES, MASS, Q, tip_lane, V0, X,
                                      X0)

from .bracket import solve_contact
from .law import OPEN, STICK, UNSOLVED

# record of a contact: what the tip's and that of a point along the wire begin with
FORCE = 0           # 3  on the wire, mean over the last step, road axes [N]
STATE = FORCE + 3   # 1  OPEN, SLIP or STICK
GAP = STATE + 1     # 1  at the end of the last step [m]
SLIP_MOVED = GAP + 1  # 3  over the last step: slip, slip and change of the gap [m]
BEFORE = SLIP_MOVED + 3  # 1  gap at the start of the last step [m]; not of tips on the plane
FORCE_RATE = BEFORE + 1  # 3  what FORCE changed by in the last step, over its length [N/s]
FORCE_TREND = FORCE_RATE + 3  # 1  part of that which it is expected to change by again
CONTACT = FORCE_TREND + 1
# tip record, after that
IMPULSE = CONTACT   # 3  of the road on the whole wire, since the start [N s]
STEP = IMPULSE + 3  # 1  length of the last step [s]; 0 before the first
MATRIX_STEP = STEP + 1  # 1  length of the step that the factorised matrix is for; 0: none
CONTRACTION = MATRIX_STEP + 1  # 1  what Newton's second correction is of the first one, last seen
LEVEL = CONTRACTION + 1  # 1  of subdivision that the next step starts with
ESTIMATE = LEVEL + 1  # 1  local error estimate of the last step [m]
ESTIMATED = ESTIMATE + 1  # 1  length of the step that it is of [s]
TREND = ESTIMATED + 1  # 2  parts of its last two changes that A is expected to change by next
USUAL = TREND + 2   # 1  iterations of the first step with the present matrix; 0: none yet
EXTRA = USUAL + 1   # 1  iterations beyond those in the steps since
LIVING = EXTRA + 1  # 1  points along the wire that are in use
TANK = LIVING + 1   # 1  energy that contact has taken and may give back to points [J]: carry.py
TIP = TANK + 1


@jit
def rotate(a, at, x, y, z):
    """Return the row-major 3 x 3 matrix at a[at:] times (x, y, z)."""
    return (a[at] * x + a[at + 1] * y + a[at + 2] * z,
            a[at + 3] * x + a[at + 4] * y + a[at + 5] * z,
            a[at + 6] * x + a[at + 7] * y + a[at + 8] * z)


@jit
def rotate_back(a, at, x, y, z):
    """Return the transpose of the matrix at a[at:] times (x, y, z)."""
    return (a[at] * x + a[at + 3] * y + a[at + 6] * z,
            a[at + 1] * x + a[at + 4] * y + a[at + 7] * z,
            a[at + 2] * x + a[at + 5] * y + a[at + 8] * z)


@jit
def push(s, j, lane, step, f1, f2, f3):
    """Add the change of the contact force (brush axes) to a node's histories."""
    inverse = 1.0 / s[j, MASS * LANES + lane]
    by_a = 0.5 * step.ca * step.h * step.h * inverse
    by_v = step.drift * inverse
    s[j, HA * LANES + lane] += by_a * f1
    s[j, (HA + 1) * LANES + lane] += by_a * f2
    s[j, (HA + 2) * LANES + lane] += by_a * f3
    s[j, HV * LANES + lane] += by_v * f1
    s[j, (HV + 1) * LANES + lane] += by_v * f2
    s[j, (HV + 2) * LANES + lane] += by_v * f3


@jit
def expect_force(record, h):
    """
    Let a contact's force go on as its trend is: on a smooth road it turns with the brush.

    Only where that does not turn it round: it may have been an impact.
    """
    ahead = h * record[FORCE_TREND]
    f1, f2, f3 = record[FORCE], record[FORCE + 1], record[FORCE + 2]
    e1, e2, e3 = (f1 + ahead * record[FORCE_RATE], f2 + ahead * record[FORCE_RATE + 1],
                  f3 + ahead * record[FORCE_RATE + 2])
    if e1 * f1 + e2 * f2 + e3 * f3 > 0.0:
        record[FORCE], record[FORCE + 1], record[FORCE + 2] = e1, e2, e3


@jit
def keep_rate(record, old1, old2, old3, h):
    """
    Keep how fast a contact's force has changed in a step that is done, and its trend.

    The trend is what the last two changes have in common: 1 in smooth motion, 0 where it rings.
    old [N] :   force before the step
    """
    both = square = 0.0
    for i, old in enumerate((old1, old2, old3)):
        rate, before = (record[FORCE + i] - old) / h, record[FORCE_RATE + i]
        both += before * rate
        square += before * before
        record[FORCE_RATE + i] = rate
    record[FORCE_TREND] = 0.0 if square == 0.0 else min(max(both / square, 0.0), 1.0)


@jit
def begin_contact(s, j, lane, step, middle, tip):
    """Let the contact force that is expected act in the prediction."""
    if tip[STATE] != OPEN:
        expect_force(tip, step.h)
        f1, f2, f3 = rotate_back(middle, ROTATION, tip[FORCE], tip[FORCE + 1], tip[FORCE + 2])
        push(s, j, lane, step, f1, f2, f3)
        scale = 0.5 * step.h * step.h / s[j, MASS * LANES + lane]
        s[j, X * LANES + lane] += scale * f1
        s[j, (X + 1) * LANES + lane] += scale * f2
        s[j, (X + 2) * LANES + lane] += scale * f3


@jit
def section_axes(s, j, lane):
    """Return the matrix of a node, section axes to brush axes, row by row."""
    q0, q1, q2, q3 = (s[j, Q * LANES + lane], s[j, (Q + 1) * LANES + lane],
                      s[j, (Q + 2) * LANES + lane], s[j, (Q + 3) * LANES + lane])
    return ((1.0 - 2.0 * (q2 * q2 + q3 * q3), 2.0 * (q1 * q2 - q0 * q3),
             2.0 * (q1 * q3 + q0 * q2)),
            (2.0 * (q1 * q2 + q0 * q3), 1.0 - 2.0 * (q1 * q1 + q3 * q3),
             2.0 * (q2 * q3 - q0 * q1)),
            (2.0 * (q1 * q3 - q0 * q2), 2.0 * (q2 * q3 + q0 * q1),
             1.0 - 2.0 * (q1 * q1 + q2 * q2)))


@jit
def free_position(s, j, lane, record, axes):
    """Return where the tip would be if the contact force stayed, brush axes, from its record."""
    u1 = u2 = u3 = 0.0
    for k in range(6):
        u1 += record[INVERSE + 8 * k] * record[CORNER + k]
        u2 += record[INVERSE + 8 * k + 1] * record[CORNER + k]
        u3 += record[INVERSE + 8 * k + 2] * record[CORNER + k]
    return (
        s[j, X * LANES + lane] + axes[0][0] * u1 + axes[0][1] * u2 + axes[0][2] * u3,
        s[j, (X + 1) * LANES + lane] + axes[1][0] * u1 + axes[1][1] * u2 + axes[1][2] * u3,
        s[j, (X + 2) * LANES + lane] + axes[2][0] * u1 + axes[2][1] * u2 + axes[2][2] * u3)


@jit
def compliance(record, axes, gain, middle, end, w):
    """Fill w : (3, 3), the tip's displacement per unit of contact force, both in road axes."""
    for col in range(3):
        # unit force along road axis `col` -> section axes -> displacement -> road axes
        f1 = middle[ROTATION + 3 * col]
        f2 = middle[ROTATION + 3 * col + 1]
        f3 = middle[ROTATION + 3 * col + 2]
        s1 = gain * (axes[0][0] * f1 + axes[1][0] * f2 + axes[2][0] * f3)
        s2 = gain * (axes[0][1] * f1 + axes[1][1] * f2 + axes[2][1] * f3)
        s3 = gain * (axes[0][2] * f1 + axes[1][2] * f2 + axes[2][2] * f3)
        d1 = record[INVERSE] * s1 + record[INVERSE + 8] * s2 + record[INVERSE + 16] * s3
        d2 = record[INVERSE + 1] * s1 + record[INVERSE + 9] * s2 + record[INVERSE + 17] * s3
        d3 = record[INVERSE + 2] * s1 + record[INVERSE + 10] * s2 + record[INVERSE + 18] * s3
        w[0, col], w[1, col], w[2, col] = rotate(
            end, ROTATION, axes[0][0] * d1 + axes[0][1] * d2 + axes[0][2] * d3,
            axes[1][0] * d1 + axes[1][1] * d2 + axes[1][2] * d3,
            axes[2][0] * d1 + axes[2][1] * d2 + axes[2][2] * d3)


@jit
def contact_correction(s, chain, tip, elements, law, step, frames, scratch):
    """
    Solve the contact problem in the tip's compliance and add the force's change to the last block.

    Returns whether it could be solved; if not, the force stays as it was.

    chain : (elements, RECORD) after `eliminate`, tip : (TIP,)
    step : StepCoefficients, frames : (3, FRAME)   of the step's start, middle and end
    scratch : (5, 3)           compliance, base and force
    The tip's prediction and compliance are exact for the linearised chain, the rotations those of
    the step's end (for displacements) and middle (for the force).
    """
    j, lane = tip_lane(elements)
    e = elements - 1
    h, gain = step.h, step.gain
    start, middle, end = frames[0], frames[1], frames[2]
    axes = section_axes(s, j, lane)
    x1, x2, x3 = free_position(s, j, lane, chain[e], axes)
    p1, p2, p3 = rotate(end, ROTATION, x1, x2, x3)
    o1, o2, o3 = rotate(start, ROTATION, s[j, X0 * LANES + lane], s[j, (X0 + 1) * LANES + lane],
                        s[j, (X0 + 2) * LANES + lane])
    gap0 = o3 + start[HEIGHT]
    moved1 = p1 - o1 + h * middle[VELOCITY]
    moved2 = p2 - o2 + h * middle[VELOCITY + 1]
    gap1 = p3 + end[HEIGHT]
    g1, g2, g3 = tip[FORCE], tip[FORCE + 1], tip[FORCE + 2]
    if g3 == 0.0 and gap0 >= 0.0 and gap1 >= 0.0:   # the road is out of reach
        tip[STATE] = OPEN
        tip[GAP] = gap1
        tip[SLIP_MOVED], tip[SLIP_MOVED + 1], tip[SLIP_MOVED + 2] = moved1, moved2, gap1 - gap0
        return True
    w = scratch[:3]
    compliance(chain[e], axes, gain, middle, end, w)
    base = scratch[3]
    base[0] = moved1 - (w[0, 0] * g1 + w[0, 1] * g2 + w[0, 2] * g3)
    base[1] = moved2 - (w[1, 0] * g1 + w[1, 1] * g2 + w[1, 2] * g3)
    base[2] = gap1 - (w[2, 0] * g1 + w[2, 1] * g2 + w[2, 2] * g3)
    force = scratch[4]
    force[0], force[1], force[2] = g1, g2, g3
    state = solve_contact(law, h, w, gap0, base, tip[STATE], force)
    if state == UNSOLVED:
        return False
    tip[STATE] = state
    for i in range(3):
        tip[SLIP_MOVED + i] = (base[i] + w[i, 0] * force[0] + w[i, 1] * force[1]
                               + w[i, 2] * force[2])
        tip[FORCE + i] = force[i]
    tip[GAP] = tip[SLIP_MOVED + 2]
    tip[SLIP_MOVED + 2] -= gap0
    f1, f2, f3 = rotate_back(middle, ROTATION, force[0] - g1, force[1] - g2, force[2] - g3)
    push(s, j, lane, step, f1, f2, f3)
    chain[e, CORNER] += gain * (axes[0][0] * f1 + axes[1][0] * f2 + axes[2][0] * f3)
    chain[e, CORNER + 1] += gain * (axes[0][1] * f1 + axes[1][1] * f2 + axes[2][1] * f3)
    chain[e, CORNER + 2] += gain * (axes[0][2] * f1 + axes[1][2] * f2 + axes[2][2] * f3)
    return True


@jit
def stopping_force(law, state, by, h, velocity, force):
    """
    Return the force (3) that stops the tip within its cone, and the kinetic energy that it takes.

    velocity [m/s], force [N] : (3,)    of the tip over the road, on the tip; third along normal
    by [kg/s] : float                   mass of the tip's node over the step's length h
    """
    r1, r2, r3 = velocity
    normal = force[2]
    p1 = p2 = p3 = 0.0
    if law.stiffness == 0.0:
        p3 = max(-by * r3, -normal)
    if state == STICK:
        p1 = -by * r1
        p2 = -by * r2
        bound = law.static * (normal + p3)
        f1, f2 = force[0], force[1]
        if (f1 + p1) ** 2 + (f2 + p2) ** 2 > bound * bound:
            # the largest part of it that keeps the sum in the cone; none if the force fills it
            a = p1 * p1 + p2 * p2
            half = f1 * p1 + f2 * p2
            inside = bound * bound - f1 * f1 - f2 * f2
            part = 0.0
            if inside > 0.0 or half < 0.0:
                root = half * half + a * inside
                part = (root ** 0.5 - half) / a if root > 0.0 else 0.0
            part = min(max(part, 0.0), 1.0)
            p1 *= part
            p2 *= part
    elif p3 != 0.0:
        # slipping: keep the friction force in the cone of the changed normal force
        scale = (normal + p3) / normal
        p1 = (min(scale, 1.0) - 1.0) * force[0]
        p2 = (min(scale, 1.0) - 1.0) * force[1]
    if p1 == 0.0 and p2 == 0.0 and p3 == 0.0:
        return 0.0, 0.0, 0.0, 0.0
    lost = -h * (p1 * (r1 + 0.5 * p1 / by) + p2 * (r2 + 0.5 * p2 / by) + p3 * (r3 + 0.5 * p3 / by))
    return p1, p2, p3, lost


@jit
def finish_contact(s, j, lane, law, h, end, tip):
    """
    Stop the tip where the contact holds it at the step's end: a plastic impact of the tip's mass.

    A contact that holds for the whole step fixes the mean velocity of the tip over the step; what
    its node keeps on top of that would swing for ever. The impulse that takes it away is bounded
    so that force and impulse together stay in the friction cone; it only removes kinetic energy,
    which is returned [J]. Velocities: V0 of the tip, already those of the step's end.
    """
    if tip[STATE] == OPEN or tip[GAP] > 0.0 and law.stiffness > 0.0:
        return 0.0
    if law.stiffness == 0.0 and tip[FORCE + 2] <= 0.0:
        return 0.0
    x1 = s[j, X0 * LANES + lane]
    x2 = s[j, (X0 + 1) * LANES + lane]
    x3 = s[j, (X0 + 2) * LANES + lane]
    o1, o2, o3 = end[PATH_SPIN], end[PATH_SPIN + 1], end[PATH_SPIN + 2]
    r1, r2, r3 = rotate(end, ROTATION, s[j, V0 * LANES + lane] + o2 * x3 - o3 * x2,
                        s[j, (V0 + 1) * LANES + lane] + o3 * x1 - o1 * x3,
                        s[j, (V0 + 2) * LANES + lane] + o1 * x2 - o2 * x1)
    r1 += end[VELOCITY]
    r2 += end[VELOCITY + 1]
    r3 += end[HEIGHT_RATE]
    by = s[j, MASS * LANES + lane] / h
    p1, p2, p3, lost = stopping_force(
        law, tip[STATE], by, h, (r1, r2, r3), (tip[FORCE], tip[FORCE + 1], tip[FORCE + 2]))
    if p1 == 0.0 and p2 == 0.0 and p3 == 0.0:
        return 0.0
    tip[FORCE] += p1
    tip[FORCE + 1] += p2
    tip[FORCE + 2] += p3
    v1, v2, v3 = rotate_back(end, ROTATION, p1 / by, p2 / by, p3 / by)
    s[j, V0 * LANES + lane] += v1
    s[j, (V0 + 1) * LANES + lane] += v2
    s[j, (V0 + 2) * LANES + lane] += v3
    return lost
