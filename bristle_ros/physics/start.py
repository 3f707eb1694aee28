"""Consistent accelerations at the start: without them every second-order scheme is first order."""
from .beam import internal_forces
from .frame import CLAMP, DRAG_RATE, DRAG_SPIN
from .jit import jit
from .layout import (A0, ACC0, ELEMENTS, HA, HV, INERTIA, LANES, MASS, Q, R, RATEACC0, STRAIN,
                     STRAIN0, V0, X)
from .loads import residual
from .stepping import own_frame

PROBE = 1e-7    # relative size of the displacement that shows the strains' acceleration


@jit
def _nudge(s, j, half, spin, rate):
    """Move the nodes by half times their accelerations relative to the turning brush."""
    for i in range(LANES):
        x1, x2 = s[j, X * LANES + i], s[j, (X + 1) * LANES + i]
        s[j, X * LANES + i] += half * (s[j, ACC0 * LANES + i] + spin * spin * x1 + rate * x2)
        s[j, (X + 1) * LANES + i] += half * (
            s[j, (ACC0 + 1) * LANES + i] + spin * spin * x2 - rate * x1)
        s[j, (X + 2) * LANES + i] += half * s[j, (ACC0 + 2) * LANES + i]
        q0, q1, q2, q3 = (s[j, Q * LANES + i], s[j, (Q + 1) * LANES + i],
                          s[j, (Q + 2) * LANES + i], s[j, (Q + 3) * LANES + i])
        t1 = 0.5 * half * (s[j, (ACC0 + 3) * LANES + i] - rate * 2.0 * (q1 * q3 - q0 * q2))
        t2 = 0.5 * half * (s[j, (ACC0 + 4) * LANES + i] - rate * 2.0 * (q2 * q3 + q0 * q1))
        t3 = 0.5 * half * (s[j, (ACC0 + 5) * LANES + i]
                           - rate * (1.0 - 2.0 * (q1 * q1 + q2 * q2)))
        s[j, Q * LANES + i] = q0 - q1 * t1 - q2 * t2 - q3 * t3
        s[j, (Q + 1) * LANES + i] = q1 + q0 * t1 + q2 * t3 - q3 * t2
        s[j, (Q + 2) * LANES + i] = q2 + q0 * t2 + q3 * t1 - q1 * t3
        s[j, (Q + 3) * LANES + i] = q3 + q0 * t3 + q1 * t2 - q2 * t1


@jit
def _turn_rigidly(s, j, spin):
    """Give the nodes of a block the velocities of a rigid turn about the brush axis."""
    for i in range(LANES):
        q0, q1, q2, q3 = (s[j, Q * LANES + i], s[j, (Q + 1) * LANES + i],
                          s[j, (Q + 2) * LANES + i], s[j, (Q + 3) * LANES + i])
        s[j, V0 * LANES + i] = -spin * s[j, (X + 1) * LANES + i]
        s[j, (V0 + 1) * LANES + i] = spin * s[j, X * LANES + i]
        s[j, (V0 + 3) * LANES + i] = spin * 2.0 * (q1 * q3 - q0 * q2)
        s[j, (V0 + 4) * LANES + i] = spin * 2.0 * (q2 * q3 + q0 * q1)
        s[j, (V0 + 5) * LANES + i] = spin * (1.0 - 2.0 * (q1 * q1 + q2 * q2))


@jit
def initialise(model, viscosity, state, scratch):
    """
    Fill the accelerations that the equation of motion gives for the present positions, velocities.

    X, Q, X0, Q0 are given; V0, W0 become those of a rigid turn with the brush. ACC0 and A0 follow,
    and with damping the strains and their second derivative.
    """
    frame = scratch.frames[0]
    for bristle in range(model.bristles):
        s = state.nodes[bristle]
        own_frame(model, state.motion, model.azimuth[bristle], state.step[0] * model.its, scratch,
                  frame)
        internal_forces(s, model.blocks, frame[CLAMP:], model.section, 1.0)
        for j in range(model.blocks):
            if frame[DRAG_SPIN] != 0.0:
                _turn_rigidly(s, j, frame[DRAG_SPIN])
            for row in range(6):
                for i in range(LANES):
                    s[j, (HA + row) * LANES + i] = 0.0
                    s[j, (HV + row) * LANES + i] = s[j, (V0 + row) * LANES + i]
        residual(s, model.blocks, 0.0, 0.0, model.mass_damping, frame)
        largest = 0.0
        for j in range(model.blocks):
            for i in range(LANES):
                q0, q1, q2, q3 = (s[j, Q * LANES + i], s[j, (Q + 1) * LANES + i],
                                  s[j, (Q + 2) * LANES + i], s[j, (Q + 3) * LANES + i])
                m = 1.0 / s[j, MASS * LANES + i]
                r1 = m * s[j, R * LANES + i]
                r2 = m * s[j, (R + 1) * LANES + i]
                r3 = m * s[j, (R + 2) * LANES + i]
                s[j, ACC0 * LANES + i] = ((1.0 - 2.0 * (q2 * q2 + q3 * q3)) * r1
                                       + 2.0 * (q1 * q2 - q0 * q3) * r2
                                       + 2.0 * (q1 * q3 + q0 * q2) * r3)
                s[j, (ACC0 + 1) * LANES + i] = (2.0 * (q1 * q2 + q0 * q3) * r1
                                             + (1.0 - 2.0 * (q1 * q1 + q3 * q3)) * r2
                                             + 2.0 * (q2 * q3 - q0 * q1) * r3)
                s[j, (ACC0 + 2) * LANES + i] = (2.0 * (q1 * q3 - q0 * q2) * r1
                                             + 2.0 * (q2 * q3 + q0 * q1) * r2
                                             + (1.0 - 2.0 * (q1 * q1 + q2 * q2)) * r3)
                for row in range(3):
                    s[j, (ACC0 + 3 + row) * LANES + i] = (
                        s[j, (R + 3 + row) * LANES + i] / s[j, (INERTIA + row) * LANES + i])
            for i in range(LANES):
                if j * ELEMENTS + i % ELEMENTS >= model.elements:  # fillers never move
                    for row in range(6):
                        s[j, (ACC0 + row) * LANES + i] = 0.0
            for row in range(6):
                for i in range(LANES):
                    s[j, (A0 + row) * LANES + i] = s[j, (ACC0 + row) * LANES + i]
                    scale = model.section.element_length if row < 3 else 1.0
                    largest = max(largest, abs(s[j, (ACC0 + row) * LANES + i]) / scale)
        if viscosity is not None:
            half = PROBE / (largest + 1e-300)
            for j in range(model.blocks):
                for row in range(6):
                    for i in range(LANES):
                        s[j, (STRAIN0 + row) * LANES + i] = s[j, (STRAIN + row) * LANES + i]
                _nudge(s, j, half, frame[DRAG_SPIN], frame[DRAG_RATE])
            internal_forces(s, model.blocks, frame[CLAMP:], model.section, 1.0)
            for j in range(model.blocks):
                for row in range(6):
                    for i in range(LANES):
                        s[j, (RATEACC0 + row) * LANES + i] = (
                            s[j, (STRAIN + row) * LANES + i]
                            - s[j, (STRAIN0 + row) * LANES + i]) / half
                for row in range(7):
                    for i in range(LANES):
                        s[j, (X + row) * LANES + i] = s[j, (X + 7 + row) * LANES + i]
