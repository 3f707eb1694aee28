"""What a bristle's wires do to the board, at the end of a step and summed over steps."""
from math import cos, sin

from bristle_ros.physics.compiler import jit
from bristle_ros.physics.motion import CLAMP, THETA, turn_frame
from bristle_ros.physics.wire import (clamp_reaction, internal_forces, LANES, RATE0, stiffness,
                                      STRAIN_BEFORE, STRESS0)

from .energy import frame_force, WRENCH
from .stress import air_on_clamp


@jit
def put_damping(s, model, viscosity, rows, by_time):
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
def board_wrench(model, viscosity, s, frame):
    """
    Return a bristle's force [N] and moment about the mount centre [N m], as output.py does.

    s : (blocks, BLOCK)     nodes at the end of a step;  frame : (FRAME,)    then, own axes
    """
    if viscosity is not None:
        put_damping(s, model, viscosity, RATE0, 0.0)
    clamp = frame[CLAMP:]
    internal_forces(s, model.blocks, clamp, model.section, 1.0, 0.0)
    f1, f2, f3, m1, m2, m3 = clamp_reaction(s, clamp)
    a1, a2, a3 = air_on_clamp(model, model.air, frame)
    p1, p2, p3 = model.clamp[0], model.clamp[1], model.clamp[2]
    g1, g2, g3 = frame_force(frame, p1, p2, p3)
    mass = model.clamp_mass
    f1, f2, f3 = f1 + a1 + mass * g1, f2 + a2 + mass * g2, f3 + a3 + mass * g3
    return (model.wires * f1, model.wires * f2, model.wires * f3,
            model.wires * (m1 + p2 * f3 - p3 * f2), model.wires * (m2 + p3 * f1 - p1 * f3),
            model.wires * (m3 + p1 * f2 - p2 * f1))


@jit
def add_turned(totals, at, by, c, s, force, moment):
    """Add `by` times a wrench in a bristle's own axes to totals[at:], turned into mount axes."""
    f1, f2, f3 = force
    m1, m2, m3 = moment
    totals[at] += by * (c * f1 - s * f2)
    totals[at + 1] += by * (s * f1 + c * f2)
    totals[at + 2] += by * f3
    totals[at + 3] += by * (c * m1 - s * m2)
    totals[at + 4] += by * (s * m1 + c * m2)
    totals[at + 5] += by * m3


@jit
def add_wrench(carrier, model, viscosity, state, scratch, number, step):
    """Add a bristle's wrench at the end of a step of this call, times its length; mount axes."""
    if carrier is None:
        return
    frame, azimuth, audit = scratch.frames[2], model.azimuth[number], state.audit[number]
    turn_frame(scratch.table[2 * step + 2], azimuth[0], azimuth[1], frame)
    f1, f2, f3, m1, m2, m3 = board_wrench(model, viscosity, state.nodes[number], frame)
    ct, st = cos(frame[THETA]), sin(frame[THETA])
    c, s = ct * azimuth[0] - st * azimuth[1], st * azimuth[0] + ct * azimuth[1]
    add_turned(audit, WRENCH, model.its, c, s, (f1, f2, f3), (m1, m2, m3))
