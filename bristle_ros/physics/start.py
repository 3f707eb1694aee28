"""Consistent accelerations at the start: without them every second-order scheme is first order."""
from .beam import internal_forces
from .frame import CLAMP, DRAG_RATE, DRAG_SPIN
from .jit import jit
from .layout import (A0, ACC0, BLOCK, HA, HV, INERTIA, LANES, MASS, Q, R, RATEACC0, STRAIN,
                     STRAIN0, V0, X)
from .loads import residual
from .stepping import own_frame

PROBE = 1e-7    # relative size of the displacement that shows the strains' acceleration


@jit
def _nudge(b, half, spin, rate):
    """Move the nodes by half times their accelerations relative to the turning brush."""
    for i in range(LANES):
        x1, x2 = b[X * LANES + i], b[(X + 1) * LANES + i]
        b[X * LANES + i] += half * (b[ACC0 * LANES + i] + spin * spin * x1 + rate * x2)
        b[(X + 1) * LANES + i] += half * (b[(ACC0 + 1) * LANES + i] + spin * spin * x2 - rate * x1)
        b[(X + 2) * LANES + i] += half * b[(ACC0 + 2) * LANES + i]
        q0, q1, q2, q3 = (b[Q * LANES + i], b[(Q + 1) * LANES + i], b[(Q + 2) * LANES + i],
                          b[(Q + 3) * LANES + i])
        t1 = 0.5 * half * (b[(ACC0 + 3) * LANES + i] - rate * 2.0 * (q1 * q3 - q0 * q2))
        t2 = 0.5 * half * (b[(ACC0 + 4) * LANES + i] - rate * 2.0 * (q2 * q3 + q0 * q1))
        t3 = 0.5 * half * (b[(ACC0 + 5) * LANES + i]
                           - rate * (1.0 - 2.0 * (q1 * q1 + q2 * q2)))
        b[Q * LANES + i] = q0 - q1 * t1 - q2 * t2 - q3 * t3
        b[(Q + 1) * LANES + i] = q1 + q0 * t1 + q2 * t3 - q3 * t2
        b[(Q + 2) * LANES + i] = q2 + q0 * t2 + q3 * t1 - q1 * t3
        b[(Q + 3) * LANES + i] = q3 + q0 * t3 + q1 * t2 - q2 * t1


@jit
def _turn_rigidly(b, spin):
    """Give the nodes of a block the velocities of a rigid turn about the brush axis."""
    for i in range(LANES):
        q0, q1, q2, q3 = (b[Q * LANES + i], b[(Q + 1) * LANES + i], b[(Q + 2) * LANES + i],
                          b[(Q + 3) * LANES + i])
        b[V0 * LANES + i] = -spin * b[(X + 1) * LANES + i]
        b[(V0 + 1) * LANES + i] = spin * b[X * LANES + i]
        b[(V0 + 3) * LANES + i] = spin * 2.0 * (q1 * q3 - q0 * q2)
        b[(V0 + 4) * LANES + i] = spin * 2.0 * (q2 * q3 + q0 * q1)
        b[(V0 + 5) * LANES + i] = spin * (1.0 - 2.0 * (q1 * q1 + q2 * q2))


@jit
def initialise(model, viscosity, state, scratch):
    """
    Fill the accelerations that the equation of motion gives for the present positions, velocities.

    X, Q, X0, Q0 are given; V0, W0 become those of a rigid turn with the brush. ACC0 and A0 follow, and with damping the strains and their
    second derivative.
    """
    frame = scratch.frames[0]
    for bristle in range(model.bristles):
        s = state.nodes[bristle]
        own_frame(model, state.motion, model.azimuth[bristle], state.step[0] * model.its, scratch,
                  frame)
        internal_forces(s, model.blocks, frame[CLAMP:], model.section, 1.0)
        for j in range(model.blocks):
            b = s[j * BLOCK:(j + 1) * BLOCK]
            if frame[DRAG_SPIN] != 0.0:
                _turn_rigidly(b, frame[DRAG_SPIN])
            for row in range(6):
                for i in range(LANES):
                    b[(HA + row) * LANES + i] = 0.0
                    b[(HV + row) * LANES + i] = b[(V0 + row) * LANES + i]
        residual(s, model.blocks, 0.0, 0.0, model.mass_damping, frame)
        largest = 0.0
        for j in range(model.blocks):
            b = s[j * BLOCK:(j + 1) * BLOCK]
            for i in range(LANES):
                q0, q1, q2, q3 = (b[Q * LANES + i], b[(Q + 1) * LANES + i],
                                  b[(Q + 2) * LANES + i], b[(Q + 3) * LANES + i])
                m = 1.0 / b[MASS * LANES + i]
                r1 = m * b[R * LANES + i]
                r2 = m * b[(R + 1) * LANES + i]
                r3 = m * b[(R + 2) * LANES + i]
                b[ACC0 * LANES + i] = ((1.0 - 2.0 * (q2 * q2 + q3 * q3)) * r1
                                       + 2.0 * (q1 * q2 - q0 * q3) * r2
                                       + 2.0 * (q1 * q3 + q0 * q2) * r3)
                b[(ACC0 + 1) * LANES + i] = (2.0 * (q1 * q2 + q0 * q3) * r1
                                             + (1.0 - 2.0 * (q1 * q1 + q3 * q3)) * r2
                                             + 2.0 * (q2 * q3 - q0 * q1) * r3)
                b[(ACC0 + 2) * LANES + i] = (2.0 * (q1 * q3 - q0 * q2) * r1
                                             + 2.0 * (q2 * q3 + q0 * q1) * r2
                                             + (1.0 - 2.0 * (q1 * q1 + q2 * q2)) * r3)
                for row in range(3):
                    b[(ACC0 + 3 + row) * LANES + i] = (
                        b[(R + 3 + row) * LANES + i] / b[(INERTIA + row) * LANES + i])
            for row in range(6):
                for i in range(LANES):
                    b[(A0 + row) * LANES + i] = b[(ACC0 + row) * LANES + i]
                    scale = model.section.element_length if row < 3 else 1.0
                    largest = max(largest, abs(b[(ACC0 + row) * LANES + i]) / scale)
        if viscosity is not None:
            half = PROBE / (largest + 1e-300)
            for j in range(model.blocks):
                b = s[j * BLOCK:(j + 1) * BLOCK]
                for row in range(6):
                    for i in range(LANES):
                        b[(STRAIN0 + row) * LANES + i] = b[(STRAIN + row) * LANES + i]
                _nudge(b, half, frame[DRAG_SPIN], frame[DRAG_RATE])
            internal_forces(s, model.blocks, frame[CLAMP:], model.section, 1.0)
            for j in range(model.blocks):
                b = s[j * BLOCK:(j + 1) * BLOCK]
                for row in range(6):
                    for i in range(LANES):
                        b[(RATEACC0 + row) * LANES + i] = (
                            b[(STRAIN + row) * LANES + i] - b[(STRAIN0 + row) * LANES + i]) / half
                for row in range(7):
                    for i in range(LANES):
                        b[(X + row) * LANES + i] = b[(X + 7 + row) * LANES + i]
