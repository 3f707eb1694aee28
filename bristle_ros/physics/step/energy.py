"""
Energies, and the accounts of what came in and went out; one definition for tests and output.

All of the whole bristle, in the brush frame. Frame forces on the rotary inertia of the sections
are left out of the work: they are (width / length)^2 of the rest.
"""
from math import asin, cos, sin

from bristle_ros.physics.compiler import jit
from bristle_ros.physics.contact import (ALIVE, BEFORE, FORCE, GAP, OPEN, position, rotate_back,
                                         SLIP_MOVED, spring_energy, STATE, XI)
from bristle_ros.physics.motion import (CLAMP, DRAG_RATE, DRAG_SPIN, GRAVITY, ROTATION, SPIN,
                                        SPIN_RATE, THETA)
from bristle_ros.physics.wire import (clamp_air, clamp_reaction, HV, INERTIA, LANES, MASS,
                                      node_air, Q, Q0, RATE0, RATEACC0, stiffness, STRAIN, STRAIN0,
                                      tip_lane, V0, W0, WEIGHT, X, X0)

DISSIPATED = 0
WORK = DISSIPATED + 1
INJECTED = 2    # the most that contact put into the bristle in a step, beyond the road's work
REACTION = INJECTED + 1    # 6  the clamp's force, moment at the end of the last step, brush axes
STRESS_MIN = REACTION + 6  # 4  stress at the clamp's corners since the last sample: see stress.py
STRESS_MAX = STRESS_MIN + 4  # 4
WRENCH = STRESS_MAX + 4     # 6  force [N s], moment [N m s] on the board since the start: board.py
AUDIT = WRENCH + 6


@jit
def kinetic_energy(s, blocks, drag):
    """
    Return the kinetic energy of the velocities relative to the brush [J].

    drag [rad/s] : float    speed of the brush about z, seen from the frame of the nodes
    """
    total = 0.0
    for j in range(blocks):
        for i in range(LANES):
            q0, q1, q2, q3 = (s[j, Q0 * LANES + i], s[j, (Q0 + 1) * LANES + i],
                              s[j, (Q0 + 2) * LANES + i], s[j, (Q0 + 3) * LANES + i])
            speed = ((s[j, V0 * LANES + i] + drag * s[j, (X0 + 1) * LANES + i]) ** 2
                     + (s[j, (V0 + 1) * LANES + i] - drag * s[j, X0 * LANES + i]) ** 2
                     + s[j, (V0 + 2) * LANES + i] ** 2)
            spin = (s[j, INERTIA * LANES + i]
                    * (s[j, W0 * LANES + i] - drag * 2.0 * (q1 * q3 - q0 * q2)) ** 2
                    + s[j, (INERTIA + 1) * LANES + i]
                    * (s[j, (W0 + 1) * LANES + i] - drag * 2.0 * (q2 * q3 + q0 * q1)) ** 2
                    + s[j, (INERTIA + 2) * LANES + i]
                    * (s[j, (W0 + 2) * LANES + i]
                       - drag * (1.0 - 2.0 * (q1 * q1 + q2 * q2))) ** 2)
            total += 0.5 * (s[j, MASS * LANES + i] * speed + spin)
    return total


@jit
def strain_energy(s, blocks, section):
    """Return the strain energy of the strains last evaluated [J]."""
    c = stiffness(section)
    total = 0.0
    for j in range(blocks):
        for i in range(LANES):
            density = 0.0
            for row in range(6):
                density += c[row] * s[j, (STRAIN + row) * LANES + i] ** 2
            total += 0.5 * s[j, WEIGHT * LANES + i] * density
    return total


@jit
def _turn_with_brush(frame, turned):
    """Fill spin, its rate and gravity of a mount's frame record as the turning brush has them."""
    c, s = cos(frame[THETA]), sin(frame[THETA])
    for vector in (SPIN, SPIN_RATE, GRAVITY):
        turned[vector] = c * frame[vector] + s * frame[vector + 1]
        turned[vector + 1] = c * frame[vector + 1] - s * frame[vector]
        turned[vector + 2] = frame[vector + 2]
    turned[SPIN_RATE] += frame[DRAG_SPIN] * turned[SPIN + 1]
    turned[SPIN_RATE + 1] -= frame[DRAG_SPIN] * turned[SPIN]
    turned[SPIN_RATE + 2] += frame[DRAG_RATE]
    turned[SPIN + 2] += frame[DRAG_SPIN]


@jit
def to_brush(model, frame, x, y, z):
    """Return a vector of the solved axes in the turning brush axes of this moment."""
    if model.displacement:
        c, s = cos(frame[THETA]), sin(frame[THETA])
        return c * x + s * y, c * y - s * x, z
    return x, y, z


@jit
def frame_force(frame, x1, x2, x3):
    """Return gravity and frame forces per mass at a point at rest in the frame [m/s^2]."""
    o1, o2, o3 = frame[SPIN], frame[SPIN + 1], frame[SPIN + 2]
    d1, d2, d3 = frame[SPIN_RATE], frame[SPIN_RATE + 1], frame[SPIN_RATE + 2]
    ox = o1 * x1 + o2 * x2 + o3 * x3
    square = o1 * o1 + o2 * o2 + o3 * o3
    return (frame[GRAVITY] - o1 * ox + square * x1 - d2 * x3 + d3 * x2,
            frame[GRAVITY + 1] - o2 * ox + square * x2 - d3 * x1 + d1 * x3,
            frame[GRAVITY + 2] - o3 * ox + square * x3 - d1 * x2 + d2 * x1)


@jit
def _account_node(model, s, j, i, frames, start, end, cv):
    """Return the frame forces' work on node i of block j over the step, and the mass damping's."""
    x1, x2, x3 = s[j, X0 * LANES + i], s[j, (X0 + 1) * LANES + i], s[j, (X0 + 2) * LANES + i]
    y1, y2, y3 = s[j, X * LANES + i], s[j, (X + 1) * LANES + i], s[j, (X + 2) * LANES + i]
    v1, v2, v3 = s[j, V0 * LANES + i], s[j, (V0 + 1) * LANES + i], s[j, (V0 + 2) * LANES + i]
    w1 = cv * (y1 - x1) + s[j, HV * LANES + i]
    w2 = cv * (y2 - x2) + s[j, (HV + 1) * LANES + i]
    w3 = cv * (y3 - x3) + s[j, (HV + 2) * LANES + i]
    drag0, drag1 = frames[0, DRAG_SPIN], frames[2, DRAG_SPIN]
    v1, v2, v3 = to_brush(model, frames[0], v1 + drag0 * x2, v2 - drag0 * x1, v3)
    w1, w2, w3 = to_brush(model, frames[2], w1 + drag1 * y2, w2 - drag1 * y1, w3)
    x1, x2, x3 = to_brush(model, frames[0], x1, x2, x3)
    y1, y2, y3 = to_brush(model, frames[2], y1, y2, y3)
    f1, f2, f3 = frame_force(start, x1, x2, x3)
    g1, g2, g3 = frame_force(end, y1, y2, y3)
    half = 0.5 * s[j, MASS * LANES + i]
    return (half * ((y1 - x1) * (f1 + g1) + (y2 - x2) * (f2 + g2) + (y3 - x3) * (f3 + g3)),
            half * model.mass_damping * (
                (y1 - x1) * (v1 + w1) + (y2 - x2) * (v2 + w2) + (y3 - x3) * (v3 + w3)))


@jit
def _account_air(model, air, s, frames, step):
    """Return the work that still air does in the brush's axes over the step, and what it takes."""
    if air is None:
        return 0.0, 0.0
    work, power = 0.0, 0.0
    for j in range(model.blocks):
        for i in range(LANES):
            mass = s[j, MASS * LANES + i]
            x = (s[j, X0 * LANES + i], s[j, (X0 + 1) * LANES + i], s[j, (X0 + 2) * LANES + i])
            y = (s[j, X * LANES + i], s[j, (X + 1) * LANES + i], s[j, (X + 2) * LANES + i])
            v = (s[j, V0 * LANES + i], s[j, (V0 + 1) * LANES + i], s[j, (V0 + 2) * LANES + i])
            w = (step.cv * (y[0] - x[0]) + s[j, HV * LANES + i],
                 step.cv * (y[1] - x[1]) + s[j, (HV + 1) * LANES + i],
                 step.cv * (y[2] - x[2]) + s[j, (HV + 2) * LANES + i])
            p = (s[j, Q0 * LANES + i], s[j, (Q0 + 1) * LANES + i], s[j, (Q0 + 2) * LANES + i],
                 s[j, (Q0 + 3) * LANES + i])
            q = (s[j, Q * LANES + i], s[j, (Q + 1) * LANES + i], s[j, (Q + 2) * LANES + i],
                 s[j, (Q + 3) * LANES + i])
            f1, f2, f3, one = node_air(air, mass, x, p, v, frames[0])
            g1, g2, g3, two = node_air(air, mass, y, q, w, frames[2])
            power += one + two
            f1, f2, f3 = to_brush(model, frames[0], f1, f2, f3)
            g1, g2, g3 = to_brush(model, frames[2], g1, g2, g3)
            x1, x2, x3 = to_brush(model, frames[0], x[0], x[1], x[2])
            y1, y2, y3 = to_brush(model, frames[2], y[0], y[1], y[2])
            work += 0.5 * ((y1 - x1) * (f1 + g1) + (y2 - x2) * (f2 + g2) + (y3 - x3) * (f3 + g3))
    _, _, _, one = clamp_air(air, model.clamp_mass, frames[0, DRAG_SPIN], frames[0])
    _, _, _, two = clamp_air(air, model.clamp_mass, frames[2, DRAG_SPIN], frames[2])
    lost = -0.5 * step.h * (power + one + two)
    return work + lost, lost    # what the brush's motion puts in


@jit
def _clamp_work(model, audit, s, frames):
    """
    Return the work of the driven clamp's deviation from its circle over the step.

    On a polygon (load steps) the clamp moves in the axes of the brush that turns exactly, so its
    reaction works there; trapezoidal rule. On the circle it is zero.
    """
    f1, f2, f3, m1, m2, m3 = clamp_reaction(s, frames[2, CLAMP:])
    f1, f2, f3 = to_brush(model, frames[2], f1, f2, f3)
    m1, m2, m3 = to_brush(model, frames[2], m1, m2, m3)
    x1, x2, x3 = to_brush(model, frames[0], frames[0, CLAMP], frames[0, CLAMP + 1],
                           frames[0, CLAMP + 2])
    y1, y2, y3 = to_brush(model, frames[2], frames[2, CLAMP], frames[2, CLAMP + 1],
                           frames[2, CLAMP + 2])
    # z of (orientation at the end) conj(that at the start): the sine of half the clamp's turn
    half = (frames[0, CLAMP + 3] * frames[2, CLAMP + 6] - frames[2, CLAMP + 3]
            * frames[0, CLAMP + 6] + frames[2, CLAMP + 5] * frames[0, CLAMP + 4]
            - frames[2, CLAMP + 4] * frames[0, CLAMP + 5])
    angle = 2.0 * asin(max(-1.0, min(1.0, half))) - (frames[2, THETA] - frames[0, THETA])
    work = -0.5 * ((audit[REACTION] + f1) * (y1 - x1) + (audit[REACTION + 1] + f2) * (y2 - x2)
                   + (audit[REACTION + 2] + f3) * (y3 - x3)
                   + (audit[REACTION + 5] + m3) * angle)
    audit[REACTION], audit[REACTION + 1], audit[REACTION + 2] = f1, f2, f3
    audit[REACTION + 3], audit[REACTION + 4], audit[REACTION + 5] = m1, m2, m3
    return work


@jit
def gap_before(tip, surface):
    """Return the gap at the start of the last step [m]."""
    if surface is None:
        return tip[GAP] - tip[SLIP_MOVED + 2]
    return tip[BEFORE]


@jit
def account_step(model, law, viscosity, audit, bristle, scratch, step):
    """
    Add one converged step, not yet accepted, to the accounts; arguments as in `try_step`.

    step : StepCoefficients
    """
    s, tip, frames, turned = bristle.nodes, bristle.tip, scratch.frames, scratch.turned
    start, end = frames[0], frames[2]
    work = 0.0
    if model.displacement:
        _turn_with_brush(frames[0], turned[0])
        _turn_with_brush(frames[2], turned[1])
        start, end = turned[0], turned[1]
        work = _clamp_work(model, audit, s, frames)
    dissipated = 0.0
    for j in range(model.blocks):
        for i in range(LANES):
            by_frame, by_damping = _account_node(model, s, j, i, frames, start, end, step.cv)
            work += by_frame
            dissipated += by_damping
    by_air, lost = _account_air(model, model.air, s, frames, step)
    work += by_air
    dissipated += lost
    if viscosity is not None:
        c = stiffness(model.section)
        for j in range(model.blocks):
            for i in range(LANES):
                density = 0.0
                for row in range(6):
                    change = s[j, (STRAIN + row) * LANES + i] - s[j, (STRAIN0 + row) * LANES + i]
                    rate = s[j, (RATE0 + row) * LANES + i]
                    density += c[row] * change * (
                        step.cv * change + (1.0 + step.keep) * rate
                        + step.drift * s[j, (RATEACC0 + row) * LANES + i])
                dissipated += 0.5 * viscosity * s[j, WEIGHT * LANES + i] * density
    if law is not None and tip[STATE] != OPEN:
        stored = (spring_energy(law.stiffness, tip[GAP])
                  - spring_energy(law.stiffness, gap_before(tip, law.surface)))
        relative = 0.0
        for i in range(3):
            relative += tip[FORCE + i] * tip[SLIP_MOVED + i]
        j, lane = tip_lane(model.elements)
        f1, f2, f3 = rotate_back(frames[1], ROTATION, tip[FORCE], tip[FORCE + 1], tip[FORCE + 2])
        f1, f2, f3 = to_brush(model, frames[1], f1, f2, f3)
        x1, x2, x3 = to_brush(
            model, frames[0], s[j, X0 * LANES + lane], s[j, (X0 + 1) * LANES + lane],
            s[j, (X0 + 2) * LANES + lane])
        y1, y2, y3 = to_brush(
            model, frames[2], s[j, X * LANES + lane], s[j, (X + 1) * LANES + lane],
            s[j, (X + 2) * LANES + lane])
        on_bristle = f1 * (y1 - x1) + f2 * (y2 - x2) + f3 * (y3 - x3)
        dissipated -= relative + stored
        work += on_bristle - relative       # what the road's own motion puts in
        audit[INJECTED] = max(audit[INJECTED], relative + stored)
    if law is not None:
        by_points, lost = _account_points(model, law, law.wire, audit, bristle, frames)
        work += by_points
        dissipated += lost
    audit[DISSIPATED] += dissipated
    audit[WORK] += work


@jit
def _account_points(model, law, wire, audit, bristle, frames):
    """Return the work that the road's motion does at the points along the wire, and their loss."""
    if wire is None:
        return 0.0, 0.0
    s, points = bristle.nodes, bristle.points
    work = 0.0
    lost = 0.0
    for e in range(points.shape[0]):
        point = points[e]
        if point[ALIVE] == 0.0 or point[STATE] == OPEN:
            continue
        stored = (spring_energy(law.stiffness, point[GAP])
                  - spring_energy(law.stiffness, point[BEFORE]))
        relative = 0.0
        for i in range(3):
            relative += point[FORCE + i] * point[SLIP_MOVED + i]
        f1, f2, f3 = rotate_back(frames[1], ROTATION, point[FORCE], point[FORCE + 1],
                                 point[FORCE + 2])
        f1, f2, f3 = to_brush(model, frames[1], f1, f2, f3)
        x1, x2, x3 = position(s, X0, e, point[XI], frames[0])
        y1, y2, y3 = position(s, X, e, point[XI], frames[2])
        x1, x2, x3 = to_brush(model, frames[0], x1, x2, x3)
        y1, y2, y3 = to_brush(model, frames[2], y1, y2, y3)
        lost -= relative + stored
        work += f1 * (y1 - x1) + f2 * (y2 - x2) + f3 * (y3 - x3) - relative
        audit[INJECTED] = max(audit[INJECTED], relative + stored)
    return work, lost


@jit
def spring_energy_of_points(law, wire, points):
    """Return what the springs of the points along a wire store [J]."""
    total = 0.0
    if wire is None:
        return total
    for e in range(points.shape[0]):
        if points[e, ALIVE] > 0.0:
            total += spring_energy(law.stiffness, points[e, GAP])
    return total
