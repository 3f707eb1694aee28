"""
Energies, and the accounts of what came in and went out; one definition for tests and output.

All of the whole bristle, in the brush frame. Frame forces on the rotary inertia of the sections
are left out of the work: they are (width / length)^2 of the rest.
"""
from .beam import stiffness
from .contact import OPEN, spring_energy
from .frame import GRAVITY, ROTATION, SPIN, SPIN_RATE
from .jit import jit
from .layout import (ELEMENTS, HV, INERTIA, LANES, MASS, Q0, RATE0, RATEACC0, STRAIN, STRAIN0,
                     V0, W0, WEIGHT, X, X0)
from .tip import FORCE, GAP, rotate_back, SLIP_MOVED, STATE

DISSIPATED = 0
WORK = 1
INJECTED = 2    # the most that contact put into the bristle in a step, beyond the road's work
AUDIT = 3


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
def _frame_work(s, j, i, start, end):
    """Return the work of gravity and frame forces on node i of a block over the step [J]."""
    total = 0.0
    for when in range(2):
        frame = start if when == 0 else end
        row = X0 if when == 0 else X
        x1 = s[j, row * LANES + i]
        x2 = s[j, (row + 1) * LANES + i]
        x3 = s[j, (row + 2) * LANES + i]
        o1, o2, o3 = frame[SPIN], frame[SPIN + 1], frame[SPIN + 2]
        d1, d2, d3 = frame[SPIN_RATE], frame[SPIN_RATE + 1], frame[SPIN_RATE + 2]
        ox = o1 * x1 + o2 * x2 + o3 * x3
        square = o1 * o1 + o2 * o2 + o3 * o3
        total += (
            (s[j, X * LANES + i] - s[j, X0 * LANES + i])
            * (frame[GRAVITY] - o1 * ox + square * x1 - d2 * x3 + d3 * x2)
            + (s[j, (X + 1) * LANES + i] - s[j, (X0 + 1) * LANES + i])
            * (frame[GRAVITY + 1] - o2 * ox + square * x2 - d3 * x1 + d1 * x3)
            + (s[j, (X + 2) * LANES + i] - s[j, (X0 + 2) * LANES + i])
            * (frame[GRAVITY + 2] - o3 * ox + square * x3 - d1 * x2 + d2 * x1))
    return 0.5 * s[j, MASS * LANES + i] * total


@jit
def account_step(model, law, viscosity, audit, s, tip, frames, cv, keep, drift, h):
    """Add one converged step, not yet accepted, to the accounts; arguments as in `try_step`."""
    work = 0.0
    dissipated = 0.0
    for j in range(model.blocks):
        for i in range(LANES):
            work += _frame_work(s, j, i, frames[0], frames[2])
            if model.mass_damping > 0.0:
                drag = 0.0
                for row in range(3):
                    u = s[j, (X + row) * LANES + i] - s[j, (X0 + row) * LANES + i]
                    drag += u * (s[j, (V0 + row) * LANES + i] + cv * u
                                 + s[j, (HV + row) * LANES + i])
                dissipated += 0.5 * model.mass_damping * s[j, MASS * LANES + i] * drag
    if viscosity is not None:
        c = stiffness(model.section)
        for j in range(model.blocks):
            for i in range(LANES):
                density = 0.0
                for row in range(6):
                    change = s[j, (STRAIN + row) * LANES + i] - s[j, (STRAIN0 + row) * LANES + i]
                    rate = s[j, (RATE0 + row) * LANES + i]
                    density += c[row] * change * (
                        cv * change + (1.0 + keep) * rate
                        + drift * s[j, (RATEACC0 + row) * LANES + i])
                dissipated += 0.5 * viscosity * s[j, WEIGHT * LANES + i] * density
    if law is not None and tip[STATE] != OPEN:
        stored = (spring_energy(law.stiffness, tip[GAP])
                  - spring_energy(law.stiffness, tip[GAP] - tip[SLIP_MOVED + 2]))
        relative = 0.0
        for i in range(3):
            relative += tip[FORCE + i] * tip[SLIP_MOVED + i]
        j = (model.elements - 1) // ELEMENTS
        lane = ELEMENTS + (model.elements - 1) % ELEMENTS
        f1, f2, f3 = rotate_back(frames[1], ROTATION, tip[FORCE], tip[FORCE + 1], tip[FORCE + 2])
        on_bristle = (f1 * (s[j, X * LANES + lane] - s[j, X0 * LANES + lane])
                      + f2 * (s[j, (X + 1) * LANES + lane] - s[j, (X0 + 1) * LANES + lane])
                      + f3 * (s[j, (X + 2) * LANES + lane] - s[j, (X0 + 2) * LANES + lane]))
        dissipated -= relative + stored
        work += on_bristle - relative       # what the road's own motion puts in
        audit[INJECTED] = max(audit[INJECTED], relative + stored)
    audit[DISSIPATED] += dissipated
    audit[WORK] += work

