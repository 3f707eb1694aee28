"""Outputs of the present state: tip, contact, mount reactions, brush totals, energies."""
from itertools import accumulate
from math import cos, inf, sin
from typing import NamedTuple

from bristle_ros.physics.compiler import inlined, jit
from bristle_ros.physics.contact import (ALIVE, ESTIMATE, FORCE, GAP, IMPULSE, position, rotate,
                                         rotate_back, spring_energy, whole_force, XI)
from bristle_ros.physics.motion import (CLAMP, DRAG_SPIN, frame_at, GRAVITY, is_polygon, MOVED,
                                        OMEGA, PLACE, ROTATION, SPIN, SPIN_RATE, THETA, turn_frame)
from bristle_ros.physics.wire import (clamp_reaction, internal_forces, LANES, MASS, node_air, Q,
                                      Q0, RATE0, STRAIN0, tip_lane, V0, X, X0)

from .board import add_turned, put_damping
from .clearance import lowest_node, nearest_point, touching_length
from .energy import (DISSIPATED, kinetic_energy, spring_energy_of_points, strain_energy,
                     STRESS_MAX, STRESS_MIN, WORK)
from .stepping import own_frame
from .stress import air_on_clamp, corner_stress

# What a bristle's row holds: names of a Snapshot's fields and how many numbers each has.
BRISTLE = {
    'tip_position': 3, 'tip_position_road': 3, 'tip_position_mount': 3,
    'tip_orientation': 4, 'tip_orientation_mount': 4,   # x, y, z, w
    'contact_force': 3, 'contact_impulse': 3, 'mount_force': 3, 'mount_moment': 3,
    'mount_damping_force': 3,                           # bristle's own axes
    'air_force': 3,
    'error_estimate': 1,                                # [m]
    'clamp_stress': 4, 'clamp_stress_min': 4, 'clamp_stress_max': 4,
    'worst': 3,     # largest of these, depth of the wire below road and tip, of the tip
    'tip_force': 3, 'wire_gap': 1, 'contact_length': 1}     # [N], [m], [m]
(POSITION, POSITION_ROAD, POSITION_MOUNT, ORIENTATION, ORIENTATION_MOUNT, CONTACT, CONTACT_IMPULSE,
 MOUNT_FORCE, MOUNT_MOMENT, DAMPING_FORCE, AIR_FORCE, ERROR, CORNER_STRESS, LEAST_STRESS,
 LARGEST_STRESS, WORST, TIP_FORCE, WIRE_GAP, CONTACT_LENGTH, BRISTLE_COLUMNS) = accumulate(
     BRISTLE.values(), initial=0)
# The same of the whole brush.
BRUSH = {
    'brush_force': 3, 'brush_torque': 3, 'contact_force_mount': 3, 'contact_torque_mount': 3,
    'energy_kinetic': 1, 'energy_elastic': 1, 'energy_dissipated': 1, 'work_external': 1,
    'theta': 1, 'omega': 1}
(BRUSH_FORCE, BRUSH_TORQUE, CONTACT_FORCE, CONTACT_TORQUE, KINETIC, ELASTIC, LOST, DONE, ANGLE,
 BRUSH_SPEED, TOTALS) = accumulate(BRUSH.values(), initial=0)


def columns(fields: dict[str, int]) -> dict[str, int | slice]:
    """Return where each field stands: its column, or the slice of its columns."""
    starts = accumulate(fields.values(), initial=0)
    return {name: slice(start, start + size) if size > 1 else start
            for (name, size), start in zip(fields.items(), starts)}


class _Turns(NamedTuple):
    """Cosines and sines of the angles about z that all bristles share."""

    c_theta: float      # of the brush in the mount
    s_theta: float
    c_back: float       # from the solved axes to the bristle's own
    s_back: float
    c_half: float       # of half of that
    s_half: float


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
def _put_stress(row, corners, audit, f1, f2, f3, m1, m2, m3):
    """Store the stress at the clamp's corners, its extremes, and the largest of them."""
    row[WORST] = 0.0
    for i in range(4):
        stress = corner_stress(corners[i], f1, f2, f3, m1, m2, m3)
        row[CORNER_STRESS + i] = stress
        row[LEAST_STRESS + i] = min(stress, audit[STRESS_MIN + i])
        row[LARGEST_STRESS + i] = max(stress, audit[STRESS_MAX + i])
        row[WORST] = max(row[WORST], -row[LEAST_STRESS + i], row[LARGEST_STRESS + i])


@inlined
def _put_tip(model, bristle, s, tip, points, own, turns, row):
    """Store where the tip is and what the road does to it; return its position, own axes."""
    block, lane = tip_lane(model.elements)
    azimuth = model.azimuth[bristle]
    x1, x2, x3 = turned(
        turns.c_back, turns.s_back, s[block, X * LANES + lane], s[block, (X + 1) * LANES + lane],
        s[block, (X + 2) * LANES + lane])
    _put_turned(row, POSITION, azimuth[0], azimuth[1], x1, x2, x3)
    row[POSITION_ROAD], row[POSITION_ROAD + 1], row[POSITION_ROAD + 2] = rotate(
        own, ROTATION, x1, x2, x3)
    _put_turned(row, POSITION_MOUNT, turns.c_theta, turns.s_theta, row[POSITION],
                row[POSITION + 1], x3)
    _put_turned_quaternion(
        row, ORIENTATION, turns.c_half, turns.s_half, s[block, Q * LANES + lane],
        s[block, (Q + 1) * LANES + lane], s[block, (Q + 2) * LANES + lane],
        s[block, (Q + 3) * LANES + lane])
    _put_turned_quaternion(row, ORIENTATION, azimuth[2], azimuth[3], row[ORIENTATION + 3],
                           row[ORIENTATION], row[ORIENTATION + 1], row[ORIENTATION + 2])
    theta = own[THETA]
    _put_turned_quaternion(row, ORIENTATION_MOUNT, cos(0.5 * theta), sin(0.5 * theta),
                           row[ORIENTATION + 3], row[ORIENTATION], row[ORIENTATION + 1],
                           row[ORIENTATION + 2])
    row[CONTACT], row[CONTACT + 1], row[CONTACT + 2] = whole_force(points, tip)
    for i in range(3):
        row[TIP_FORCE + i] = tip[FORCE + i]
        row[CONTACT_IMPULSE + i] = tip[IMPULSE + i]
    row[ERROR] = tip[ESTIMATE]
    return x1, x2, x3


@inlined
def _put_damping_force(model, viscosity, s, clamp, turns, row):
    """Store the damping force at the clamp; leave in STRESS0 the damping of mount_force."""
    row[DAMPING_FORCE:DAMPING_FORCE + 3] = 0.0
    if viscosity is not None:
        put_damping(s, model, viscosity, RATE0, 0.0)
        internal_forces(s, model.blocks, clamp, model.section, 0.0, 0.0)
        f1, f2, f3, _, _, _ = clamp_reaction(s, clamp)
        _put_turned(row, DAMPING_FORCE, turns.c_back, turns.s_back, f1, f2, f3)
        if is_polygon(model):
            # the rates ring from step to step there, unless the scheme damps that; their mean
            # over the step is what the strains have changed by
            put_damping(s, model, viscosity, STRAIN0, 1.0 / model.its)


@jit
def _put_air(model, air, s, driven, row):
    """Store the air's force on the whole wire, road axes; driven: the frame of the nodes."""
    row[AIR_FORCE:AIR_FORCE + 3] = 0.0
    if air is None:
        return
    f1, f2, f3 = air_on_clamp(model, air, driven)
    for j in range(model.blocks):
        for i in range(LANES):
            x = (s[j, X0 * LANES + i], s[j, (X0 + 1) * LANES + i], s[j, (X0 + 2) * LANES + i])
            q = (s[j, Q0 * LANES + i], s[j, (Q0 + 1) * LANES + i], s[j, (Q0 + 2) * LANES + i],
                 s[j, (Q0 + 3) * LANES + i])
            v = (s[j, V0 * LANES + i], s[j, (V0 + 1) * LANES + i], s[j, (V0 + 2) * LANES + i])
            g1, g2, g3, _ = node_air(air, s[j, MASS * LANES + i], x, q, v, driven)
            f1, f2, f3 = f1 + g1, f2 + g2, f3 + g3
    row[AIR_FORCE], row[AIR_FORCE + 1], row[AIR_FORCE + 2] = rotate(driven, ROTATION, f1, f2, f3)


@inlined
def _put_mount(model, bristle, s, driven, own, turns, row):
    """Store what the wire does to the board; return force and moment, bristle's own axes."""
    clamp = driven[CLAMP:]
    internal_forces(s, model.blocks, clamp, model.section, 1.0, 0.0)
    f1, f2, f3, m1, m2, m3 = clamp_reaction(s, clamp)
    a1, a2, a3 = air_on_clamp(model, model.air, driven)
    f1, f2, f3 = turned(turns.c_back, turns.s_back, f1 + a1, f2 + a2, f3 + a3)
    m1, m2, m3 = turned(turns.c_back, turns.s_back, m1, m2, m3)
    o1, o2, o3 = own[SPIN], own[SPIN + 1], own[SPIN + 2]
    d1, d2, d3 = own[SPIN_RATE], own[SPIN_RATE + 1], own[SPIN_RATE + 2]
    p1, p2, p3 = model.clamp[0], model.clamp[1], model.clamp[2]
    op = o1 * p1 + o2 * p2 + o3 * p3
    square = o1 * o1 + o2 * o2 + o3 * o3
    f1 += model.clamp_mass * (own[GRAVITY] - o1 * op + square * p1 - d2 * p3 + d3 * p2)
    f2 += model.clamp_mass * (own[GRAVITY + 1] - o2 * op + square * p2 - d3 * p1 + d1 * p3)
    f3 += model.clamp_mass * (own[GRAVITY + 2] - o3 * op + square * p3 - d1 * p2 + d2 * p1)
    c, s_ = model.azimuth[bristle, 0], model.azimuth[bristle, 1]
    _put_turned(row, MOUNT_FORCE, c, s_, f1, f2, f3)
    _put_turned(row, MOUNT_MOMENT, c, s_, m1, m2, m3)
    return f1, f2, f3, m1, m2, m3


@jit
def _put_depths(model, surface, s, tip, points, driven, sums, row):
    """Store the depths of tip and wire in the road, its least gap, and how much of it touches."""
    row[WORST + 2] = -tip[GAP]
    row[WORST + 1] = -max(tip[GAP], 0.0) - lowest_node(s, model.elements, surface, driven, sums)
    row[WIRE_GAP] = nearest_point(points, tip)
    row[CONTACT_LENGTH] = touching_length(points, model.section.element_length)


@inlined
def _put_no_depths(row):
    """Store that there is no road."""
    row[WORST + 1] = row[WORST + 2] = -1e300
    row[WIRE_GAP] = inf
    row[CONTACT_LENGTH] = 0.0


@jit
def _add_wrench(totals, at, wires, c, s, place, force, moment):
    """
    Add a bristle's wrench to the brush's, about the mount centre, turned into mount axes.

    place, force, moment : (3,) tuples    own axes; the moment is about the place
    """
    x1, x2, x3 = place
    f1, f2, f3 = force
    m1, m2, m3 = moment
    about_mount = m1 + x2 * f3 - x3 * f2, m2 + x3 * f1 - x1 * f3, m3 + x1 * f2 - x2 * f1
    add_turned(totals, at, wires, c, s, force, about_mount)


@jit
def _add_energies(model, law, s, gap, points, audit, drag, totals):
    """Add a bristle's energies and accounts."""
    totals[KINETIC] += model.wires * kinetic_energy(s, model.blocks, drag)
    totals[ELASTIC] += model.wires * strain_energy(s, model.blocks, model.section)
    if law is not None:
        totals[ELASTIC] += model.wires * (spring_energy(law.stiffness, gap)
                                          + spring_energy_of_points(law, law.wire, points))
    totals[LOST] += model.wires * audit[DISSIPATED]
    totals[DONE] += model.wires * audit[WORK]


@jit
def observe(model, law, viscosity, state, scratch, rows, totals):
    """
    Fill the outputs of the present state.

    rows : (B, BRISTLE_COLUMNS), totals : (TOTALS,)   SI units, axes as the columns say
    The internal forces are evaluated anew: the step's last ones are those before its last
    correction. All axes are the exact ones, also where the loads are ramped.
    """
    t = state.step[0] * model.its
    own, driven, frame = scratch.frames     # not scratch.frame: `own_frame` works in that
    frame_at(t, model.exact, False, state.motion, scratch.basics, frame)
    theta = frame[THETA]
    totals[:] = 0.0
    back = -theta if model.displacement else 0.0
    turns = _Turns(cos(theta), sin(theta), cos(back), sin(back), cos(0.5 * back), sin(0.5 * back))
    for bristle in range(model.bristles):
        s, tip, points, row = (state.nodes[bristle], state.tip[bristle], state.points[bristle],
                               rows[bristle])
        ca, sa = model.azimuth[bristle, 0], model.azimuth[bristle, 1]
        turn_frame(frame, ca, sa, own)
        own_frame(model, state.motion, model.azimuth[bristle], t, scratch, driven)
        clamp = driven[CLAMP:]
        place = _put_tip(model, bristle, s, tip, points, own, turns, row)
        _put_damping_force(model, viscosity, s, clamp, turns, row)
        f1, f2, f3, m1, m2, m3 = _put_mount(model, bristle, s, driven, own, turns, row)
        _put_air(model, model.air, s, driven, row)
        _put_stress(row, model.corners, state.audit[bristle], f1, f2, f3, m1, m2, m3)
        if law is None:
            _put_no_depths(row)
        else:
            driven[PLACE], driven[PLACE + 1] = state.motion[MOVED], state.motion[MOVED + 1]
            _put_depths(model, law.surface, s, tip, points, driven, scratch.contact[8], row)
        c = turns.c_theta * ca - turns.s_theta * sa
        s_all = turns.s_theta * ca + turns.c_theta * sa
        _add_wrench(totals, BRUSH_FORCE, model.wires, c, s_all,
                    (model.clamp[0], model.clamp[1], model.clamp[2]), (f1, f2, f3), (m1, m2, m3))
        contact = rotate_back(own, ROTATION, tip[FORCE], tip[FORCE + 1], tip[FORCE + 2])
        _add_wrench(totals, CONTACT_FORCE, model.wires, c, s_all, place, contact, (0.0, 0.0, 0.0))
        for e in range(points.shape[0]):
            if points[e, ALIVE] > 0.0:
                x1, x2, x3 = position(s, X, e, points[e, XI], driven)
                x1, x2, x3 = turned(turns.c_back, turns.s_back, x1, x2, x3)
                contact = rotate_back(own, ROTATION, points[e, FORCE], points[e, FORCE + 1],
                                      points[e, FORCE + 2])
                _add_wrench(totals, CONTACT_FORCE, model.wires, c, s_all, (x1, x2, x3), contact,
                            (0.0, 0.0, 0.0))
        _add_energies(model, law, s, tip[GAP], points, state.audit[bristle], driven[DRAG_SPIN],
                      totals)
    totals[ANGLE], totals[BRUSH_SPEED] = theta, frame[OMEGA]
