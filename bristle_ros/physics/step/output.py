"""Outputs of the present state: tip, contact, mount reactions, brush totals, energies."""
from math import cos, sin

from bristle_ros.physics.compiler import jit
from bristle_ros.physics.contact import (ESTIMATE, FORCE, GAP, IMPULSE, rotate, rotate_back,
                                         spring_energy)
from bristle_ros.physics.motion import (CLAMP, DRAG_SPIN, frame_at, GRAVITY, is_polygon, OMEGA,
                                        ROTATION, SPIN, SPIN_RATE, THETA, turn_frame)
from bristle_ros.physics.wire import (clamp_reaction, internal_forces, LANES, Q, RATE0, stiffness,
                                      STRAIN0, STRAIN_BEFORE, STRESS0, tip_lane, X)

from .energy import DISSIPATED, kinetic_energy, strain_energy, WORK
from .stepping import own_frame

# columns of a bristle's row
POSITION = 0            # 3  tip, brush axes
POSITION_ROAD = 3       # 3
POSITION_MOUNT = 6      # 3
ORIENTATION = 9         # 4  x, y, z, w, brush axes
ORIENTATION_MOUNT = 13  # 4
CONTACT = 17            # 3  force, road axes
CONTACT_IMPULSE = 20    # 3
MOUNT_FORCE = 23        # 3  brush axes
MOUNT_MOMENT = 26       # 3
DAMPING_FORCE = 29      # 3  bristle's own axes
ERROR = 32              # 1
BRISTLE_COLUMNS = 33

# columns of the totals
BRUSH_FORCE = 0         # 3  mount axes
BRUSH_TORQUE = 3        # 3
CONTACT_FORCE = 6       # 3
CONTACT_TORQUE = 9      # 3
KINETIC = 12
ELASTIC = 13
LOST = 14
DONE = 15
ANGLE = 16
SPEED = 17
TOTALS = 18


@jit
def turned(c, s, x, y, z):
    """Return (x, y, z) turned about z by the angle with this cosine and sine."""
    return c * x - s * y, s * x + c * y, z


@jit
def _put_turned(row, at, c, s, x, y, z):
    """Store (x, y, z) turned about z by the angle with this cosine and sine."""
    row[at] = c * x - s * y
    row[at + 1] = s * x + c * y
    row[at + 2] = z


@jit
def _put_turned_quaternion(row, at, c, s, w, x, y, z):
    """Store, as x, y, z, w, the quaternion turned about z; c and s of half the angle."""
    row[at] = c * x - s * y
    row[at + 1] = c * y + s * x
    row[at + 2] = c * z + s * w
    row[at + 3] = c * w - s * z


@jit
def _put_damping(s, model, viscosity, rows, by_time):
    """
    Put the stress that damping gives into STRESS0, with the strain rates in the rows from `rows`.

    by_time [1/s] : float   0, or the rates are what these rows have changed by over the step
    """
    c = stiffness(model.section)
    for j in range(model.blocks):
        for component in range(6):
            scale = viscosity * c[component]
            for i in range(LANES):
                rate = s[j, (rows + component) * LANES + i]
                if by_time > 0.0:
                    rate = by_time * (rate - s[j, (STRAIN_BEFORE + component) * LANES + i])
                s[j, (STRESS0 + component) * LANES + i] = scale * rate


@jit
def observe(model, law, viscosity, state, scratch, rows, totals):
    """
    Fill the outputs of the present state.

    rows : (B, BRISTLE_COLUMNS), totals : (TOTALS,)   SI units, axes as the columns say
    The internal forces are evaluated anew: the step's last ones are those before its last
    correction. All axes are the exact ones, also where the loads are ramped.
    """
    t = state.step[0] * model.its
    frame = scratch.frames[2]   # not scratch.frame: `own_frame` works in that
    own = scratch.frames[0]
    frame_at(t, model.exact, False, state.motion, scratch.basics, frame)
    theta = frame[THETA]
    for i in range(TOTALS):
        totals[i] = 0.0
    block, lane = tip_lane(model.elements)
    c_theta, s_theta = cos(theta), sin(theta)
    back = -theta if model.displacement else 0.0   # from the solved axes to the bristle's own
    c_back, s_back = cos(back), sin(back)
    c_half, s_half = cos(0.5 * back), sin(0.5 * back)
    driven = scratch.frames[1]
    for bristle in range(model.bristles):
        s = state.nodes[bristle]
        tip = state.tip[bristle]
        row = rows[bristle]
        ca, sa = model.azimuth[bristle, 0], model.azimuth[bristle, 1]
        half_c, half_s = model.azimuth[bristle, 2], model.azimuth[bristle, 3]
        turn_frame(frame, ca, sa, own)
        own_frame(model, state.motion, model.azimuth[bristle], t, scratch, driven)
        clamp = driven[CLAMP:]
        x1, x2, x3 = turned(
            c_back, s_back, s[block, X * LANES + lane], s[block, (X + 1) * LANES + lane],
            s[block, (X + 2) * LANES + lane])
        _put_turned(row, POSITION, ca, sa, x1, x2, x3)
        row[POSITION_ROAD], row[POSITION_ROAD + 1], row[POSITION_ROAD + 2] = rotate(
            own, ROTATION, x1, x2, x3)
        _put_turned(row, POSITION_MOUNT, c_theta, s_theta, row[POSITION], row[POSITION + 1], x3)
        _put_turned_quaternion(row, ORIENTATION, c_half, s_half, s[block, Q * LANES + lane],
                               s[block, (Q + 1) * LANES + lane], s[block, (Q + 2) * LANES + lane],
                               s[block, (Q + 3) * LANES + lane])
        _put_turned_quaternion(row, ORIENTATION, half_c, half_s, row[ORIENTATION + 3],
                               row[ORIENTATION], row[ORIENTATION + 1], row[ORIENTATION + 2])
        _put_turned_quaternion(row, ORIENTATION_MOUNT, cos(0.5 * theta), sin(0.5 * theta),
                               row[ORIENTATION + 3], row[ORIENTATION], row[ORIENTATION + 1],
                               row[ORIENTATION + 2])
        for i in range(3):
            row[CONTACT + i] = tip[FORCE + i]
            row[CONTACT_IMPULSE + i] = tip[IMPULSE + i]
        row[ERROR] = tip[ESTIMATE]

        if viscosity is not None:
            _put_damping(s, model, viscosity, RATE0, 0.0)
            internal_forces(s, model.blocks, clamp, model.section, 0.0, 0.0)
            f1, f2, f3, _, _, _ = clamp_reaction(s, clamp)
            _put_turned(row, DAMPING_FORCE, c_back, s_back, f1, f2, f3)
            if is_polygon(model):
                # the rates ring from step to step there, unless the scheme damps that; their mean
                # over the step is what the strains have changed by
                _put_damping(s, model, viscosity, STRAIN0, 1.0 / model.its)
        else:
            row[DAMPING_FORCE] = 0.0
            row[DAMPING_FORCE + 1] = 0.0
            row[DAMPING_FORCE + 2] = 0.0
        internal_forces(s, model.blocks, clamp, model.section, 1.0, 0.0)
        f1, f2, f3, m1, m2, m3 = clamp_reaction(s, clamp)
        f1, f2, f3 = turned(c_back, s_back, f1, f2, f3)
        m1, m2, m3 = turned(c_back, s_back, m1, m2, m3)
        o1, o2, o3 = own[SPIN], own[SPIN + 1], own[SPIN + 2]
        d1, d2, d3 = own[SPIN_RATE], own[SPIN_RATE + 1], own[SPIN_RATE + 2]
        p1, p2, p3 = model.clamp[0], model.clamp[1], model.clamp[2]
        op = o1 * p1 + o2 * p2 + o3 * p3
        square = o1 * o1 + o2 * o2 + o3 * o3
        f1 += model.clamp_mass * (own[GRAVITY] - o1 * op + square * p1 - d2 * p3 + d3 * p2)
        f2 += model.clamp_mass * (own[GRAVITY + 1] - o2 * op + square * p2 - d3 * p1 + d1 * p3)
        f3 += model.clamp_mass * (own[GRAVITY + 2] - o3 * op + square * p3 - d1 * p2 + d2 * p1)
        _put_turned(row, MOUNT_FORCE, ca, sa, f1, f2, f3)
        _put_turned(row, MOUNT_MOMENT, ca, sa, m1, m2, m3)

        # brush totals, mount axes, about the mount centre
        n1, n2, n3 = m1 + p2 * f3 - p3 * f2, m2 + p3 * f1 - p1 * f3, m3 + p1 * f2 - p2 * f1
        c_all = c_theta * ca - s_theta * sa
        s_all = s_theta * ca + c_theta * sa
        totals[BRUSH_FORCE] += model.wires * (c_all * f1 - s_all * f2)
        totals[BRUSH_FORCE + 1] += model.wires * (s_all * f1 + c_all * f2)
        totals[BRUSH_FORCE + 2] += model.wires * f3
        totals[BRUSH_TORQUE] += model.wires * (c_all * n1 - s_all * n2)
        totals[BRUSH_TORQUE + 1] += model.wires * (s_all * n1 + c_all * n2)
        totals[BRUSH_TORQUE + 2] += model.wires * n3
        g1, g2, g3 = rotate_back(own, ROTATION, tip[FORCE], tip[FORCE + 1], tip[FORCE + 2])
        t1, t2, t3 = x2 * g3 - x3 * g2, x3 * g1 - x1 * g3, x1 * g2 - x2 * g1
        totals[CONTACT_FORCE] += model.wires * (c_all * g1 - s_all * g2)
        totals[CONTACT_FORCE + 1] += model.wires * (s_all * g1 + c_all * g2)
        totals[CONTACT_FORCE + 2] += model.wires * g3
        totals[CONTACT_TORQUE] += model.wires * (c_all * t1 - s_all * t2)
        totals[CONTACT_TORQUE + 1] += model.wires * (s_all * t1 + c_all * t2)
        totals[CONTACT_TORQUE + 2] += model.wires * t3

        totals[KINETIC] += model.wires * kinetic_energy(s, model.blocks, driven[DRAG_SPIN])
        totals[ELASTIC] += model.wires * strain_energy(s, model.blocks, model.section)
        if law is not None:
            totals[ELASTIC] += model.wires * spring_energy(law.stiffness, tip[GAP])
        totals[LOST] += model.wires * state.audit[bristle, DISSIPATED]
        totals[DONE] += model.wires * state.audit[bristle, WORK]
    totals[ANGLE] = theta
    totals[SPEED] = frame[OMEGA]
