"""Static equilibrium in a steadily turning frame, friction off: pseudo-transient continuation."""
from bristle_ros.physics.compiler import jit
from bristle_ros.physics.contact import FORCE, GAP, rotate, rotate_back
from bristle_ros.physics.motion import CLAMP, HEIGHT, ROTATION
from bristle_ros.physics.wire import (add_air, CORNER, eliminate, factorise, HA, HV,
                                      internal_forces, INVERSE, LANES, move_nodes, OK,
                                      pseudo_step, Q, R, residual, substitute, tip_lane, X, X0)

from .newton import NO_CONVERGENCE
from .records import bristle_of
from .scheme import LOOSEST_STEP, newton_tolerance

PSEUDO_STEPS = 400
ITERATIONS = 25
FIRST = 1e-3        # [s] first pseudo time step
LAST = 1e3          # [s] from here on inertia no longer counts
RISE = 0.2          # of the road in a pseudo step, in element lengths


@jit
def _contact(bristle, elements, law, frame):
    """Put the normal force that the linearised tip finds into the last block; frictionless."""
    s, chain, tip = bristle.nodes, bristle.chain, bristle.tip
    j, lane = tip_lane(elements)
    e = elements - 1
    q0, q1, q2, q3 = (s[j, Q * LANES + lane], s[j, (Q + 1) * LANES + lane],
                      s[j, (Q + 2) * LANES + lane], s[j, (Q + 3) * LANES + lane])
    n1, n2, n3 = frame[ROTATION + 6], frame[ROTATION + 7], frame[ROTATION + 8]
    normal = ((1.0 - 2.0 * (q2 * q2 + q3 * q3)) * n1 + 2.0 * (q1 * q2 + q0 * q3) * n2
              + 2.0 * (q1 * q3 - q0 * q2) * n3,
              2.0 * (q1 * q2 - q0 * q3) * n1 + (1.0 - 2.0 * (q1 * q1 + q3 * q3)) * n2
              + 2.0 * (q2 * q3 + q0 * q1) * n3,
              2.0 * (q1 * q3 + q0 * q2) * n1 + 2.0 * (q2 * q3 - q0 * q1) * n2
              + (1.0 - 2.0 * (q1 * q1 + q2 * q2)) * n3)
    free = 0.0
    compliance = 0.0
    for i in range(3):
        for k in range(6):
            free += normal[i] * chain[e, INVERSE + 8 * k + i] * chain[e, CORNER + k]
        for k in range(3):
            compliance += normal[i] * chain[e, INVERSE + 8 * k + i] * normal[k]
    _, _, height = rotate(frame, ROTATION, s[j, X * LANES + lane], s[j, (X + 1) * LANES + lane],
                          s[j, (X + 2) * LANES + lane])
    base = height + frame[HEIGHT] + free - compliance * tip[FORCE + 2]
    if law.stiffness == 0.0:
        force = max(0.0, -base / compliance)
    else:
        force = max(0.0, -base * law.stiffness / (1.0 + law.stiffness * compliance))
    change = force - tip[FORCE + 2]
    tip[FORCE + 2] = force
    tip[GAP] = base + compliance * force
    for k in range(3):
        chain[e, CORNER + k] += change * normal[k]


@jit
def settle(model, law, state, number, frame, load, scratch):
    """
    Move a bristle to its static equilibrium from where it is; return OK or NO_CONVERGENCE.

    frame : (FRAME,)    frame record; its spin acts, its spin rate should be zero
    load [N, N m] : (6,)    extra force (brush axes) and moment (section axes) at the tip
    Each pseudo step solves mass / tau^2 (x - x0) = force(x) and tau grows, so the way leads
    downhill in energy past limit points, and the last steps are Newton's own. A road that starts
    above the tip rises to its height (in `frame`) meanwhile.
    The tip's FORCE (normal component) and GAP are filled.
    """
    bristle = bristle_of(model, state, number)
    s, mids, chain, tip = bristle.nodes, bristle.mids, bristle.chain, bristle.tip
    elements, blocks = model.elements, model.blocks
    tip_block, lane = tip_lane(elements)
    for j in range(blocks):
        for row in range(6):
            for i in range(LANES):
                s[j, (HA + row) * LANES + i] = 0.0
                s[j, (HV + row) * LANES + i] = 0.0
    _, _, tip_height = rotate(
        frame, ROTATION, s[tip_block, X * LANES + lane], s[tip_block, (X + 1) * LANES + lane],
        s[tip_block, (X + 2) * LANES + lane])
    target = frame[HEIGHT]
    frame[HEIGHT] = max(target, -tip_height)
    tau = FIRST
    tip[FORCE] = 0.0
    tip[FORCE + 1] = 0.0
    tip[FORCE + 2] = 0.0
    for _ in range(PSEUDO_STEPS):
        ca = 0.0 if tau >= LAST else 1.0 / (tau * tau)
        for j in range(blocks):
            for row in range(7):
                for i in range(LANES):
                    s[j, (X0 + row) * LANES + i] = s[j, (X + row) * LANES + i]
        force0 = tip[FORCE + 2]
        converged = False
        size = 0.0
        for _ in range(ITERATIONS):
            internal_forces(s, blocks, frame[CLAMP:], model.section, 1.0, 0.0)
            residual(s, blocks, ca, 0.0, 0.0, frame)
            add_air(s, blocks, 0.0, model.air, frame)
            if factorise(s, elements, model.section, pseudo_step(ca), frame, mids, chain,
                         scratch.work) != OK:
                break
            q0 = s[tip_block, Q * LANES + lane]
            q1 = s[tip_block, (Q + 1) * LANES + lane]
            q2 = s[tip_block, (Q + 2) * LANES + lane]
            q3 = s[tip_block, (Q + 3) * LANES + lane]
            f1, f2, f3 = load[0], load[1], load[2]
            if law is not None:
                n1, n2, n3 = rotate_back(frame, ROTATION, 0.0, 0.0, tip[FORCE + 2])
                f1, f2, f3 = f1 + n1, f2 + n2, f3 + n3
            s[tip_block, R * LANES + lane] += ((1.0 - 2.0 * (q2 * q2 + q3 * q3)) * f1
                                               + 2.0 * (q1 * q2 + q0 * q3) * f2
                                               + 2.0 * (q1 * q3 - q0 * q2) * f3)
            s[tip_block, (R + 1) * LANES + lane] += (2.0 * (q1 * q2 - q0 * q3) * f1
                                                     + (1.0 - 2.0 * (q1 * q1 + q3 * q3)) * f2
                                                     + 2.0 * (q2 * q3 + q0 * q1) * f3)
            s[tip_block, (R + 2) * LANES + lane] += (2.0 * (q1 * q3 + q0 * q2) * f1
                                                     + 2.0 * (q2 * q3 - q0 * q1) * f2
                                                     + (1.0 - 2.0 * (q1 * q1 + q2 * q2)) * f3)
            for i in range(3):
                s[tip_block, (R + 3 + i) * LANES + lane] += load[3 + i]
            eliminate(s, elements, mids, chain)
            if law is not None:
                _contact(bristle, elements, law, frame)
            substitute(s, elements, mids, chain)
            size = move_nodes(s, blocks, model.section.element_length)
            if not size < 2.0:
                break
            if size <= newton_tolerance(model.scheme, LOOSEST_STEP, 0.0):
                converged = True
                break
        if not converged:
            tip[FORCE + 2] = force0
            for j in range(blocks):
                for row in range(7):
                    for i in range(LANES):
                        s[j, (X + row) * LANES + i] = s[j, (X0 + row) * LANES + i]
            tau *= 0.2
            if tau < 1e-3 * FIRST:
                return NO_CONVERGENCE
        elif ca == 0.0 and frame[HEIGHT] == target:
            return OK
        else:
            tau *= 3.0
            frame[HEIGHT] = max(target, frame[HEIGHT] - RISE * model.section.element_length)
    return NO_CONVERGENCE
