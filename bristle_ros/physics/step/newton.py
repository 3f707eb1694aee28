"""
One step by Newton's method with a frozen matrix, which either converges or leaves all as it was.

The matrix is factorised in the nodes' own axes and kept as long as it pays: see `judge_matrix`.
With the section force as an unknown of its own (mixed.py) that is for many steps.
"""
from math import sqrt

from bristle_ros.physics.compiler import inlined, jit
from bristle_ros.physics.contact import (begin_contact, contact_correction, CONTRACTION, ESTIMATE,
                                         EXTRA, finish_contact, FORCE, GAP, IMPULSE, MATRIX_STEP,
                                         rotate_back, STATE, STEP, TREND, USUAL)
from bristle_ros.physics.motion import CLAMP, ROTATION, SPIN, SPIN_RATE
from bristle_ros.physics.wire import (accept_damping, accept_section_forces, accept_step,
                                      add_excess, begin_section_forces, begin_step, eliminate,
                                      factorise, internal_forces, LANES, local_error, MASS, OK,
                                      predict_damping, Q, R, rescale_memory, residual, strains,
                                      substitute, tip_lane, update_section_forces, X)

from .energy import account_step, DISSIPATED
from .scheme import newton_tolerance
from .stress import note_stress

MAX_ITERATIONS = 20     # of Newton in one attempt, matrix refreshed when they shrink slowly
SLOW = 0.4              # contraction above which the matrix is factorised anew at once
WORTH = 3.0             # iterations that cost what a matrix costs, measured
# what the second correction is of the first one, where there is no second one to tell
UNKNOWN = 0.1           # after a new matrix
LEAST = 1e-3
AGEING = 1.5            # growth in each step that does not measure it

# status of a step; 0 is done
SINGULAR_MATRIX = 1
NO_CONVERGENCE = 2
NOT_FINITE = 3
TOO_INACCURATE = 4      # the local error is above what it may be: never the last word, since the
#                         finest sub-steps are taken whatever theirs
UNFINISHED = 5          # attempts ran out

# running counts
NEWTON = 0
SUBSTEPS = 1
FACTORISATIONS = 2
FAILURES = 3
SPLIT = 4       # integration steps taken in sub-steps
AT_FINEST = 5   # of these, in sub-steps as short as the error estimate may ask for
COUNTS = 6


@jit
def move_nodes(s, blocks, element_length):
    """Apply the increments in the residual rows; return the largest (element length, 1 rad)."""
    largest = 0.0
    inverse = 1.0 / element_length
    for j in range(blocks):
        for i in range(LANES):
            u1, u2, u3 = s[j, R * LANES + i], s[j, (R + 1) * LANES + i], s[j, (R + 2) * LANES + i]
            t1 = s[j, (R + 3) * LANES + i]
            t2 = s[j, (R + 4) * LANES + i]
            t3 = s[j, (R + 5) * LANES + i]
            q0 = s[j, Q * LANES + i]
            q1 = s[j, (Q + 1) * LANES + i]
            q2 = s[j, (Q + 2) * LANES + i]
            q3 = s[j, (Q + 3) * LANES + i]
            s[j, R * LANES + i] = inverse * inverse * (u1 * u1 + u2 * u2 + u3 * u3) + (
                t1 * t1 + t2 * t2 + t3 * t3)
            s[j, X * LANES + i] += ((1.0 - 2.0 * (q2 * q2 + q3 * q3)) * u1
                                    + 2.0 * (q1 * q2 - q0 * q3) * u2
                                    + 2.0 * (q1 * q3 + q0 * q2) * u3)
            s[j, (X + 1) * LANES + i] += (2.0 * (q1 * q2 + q0 * q3) * u1
                                          + (1.0 - 2.0 * (q1 * q1 + q3 * q3)) * u2
                                          + 2.0 * (q2 * q3 - q0 * q1) * u3)
            s[j, (X + 2) * LANES + i] += (2.0 * (q1 * q3 - q0 * q2) * u1
                                          + 2.0 * (q2 * q3 + q0 * q1) * u2
                                          + (1.0 - 2.0 * (q1 * q1 + q2 * q2)) * u3)
            t1, t2, t3 = 0.5 * t1, 0.5 * t2, 0.5 * t3
            p0 = q0 - q1 * t1 - q2 * t2 - q3 * t3
            p1 = q1 + q0 * t1 + q2 * t3 - q3 * t2
            p2 = q2 + q0 * t2 + q3 * t1 - q1 * t3
            p3 = q3 + q0 * t3 + q1 * t2 - q2 * t1
            n = 1.0 / sqrt(p0 * p0 + p1 * p1 + p2 * p2 + p3 * p3)
            s[j, Q * LANES + i] = p0 * n
            s[j, (Q + 1) * LANES + i] = p1 * n
            s[j, (Q + 2) * LANES + i] = p2 * n
            s[j, (Q + 3) * LANES + i] = p3 * n
        for i in range(LANES):
            if not s[j, R * LANES + i] < 1e29:
                return 1e30
            largest = max(largest, s[j, R * LANES + i])
    return sqrt(largest)


@jit
def judge_matrix(tip, iterations, renewed, refresh):
    """
    Give the matrix up for the next step where it has cost what a new one costs.

    What an ageing matrix costs are the iterations beyond those of the first step made with it.
    Giving it up when they reach the price of a new one takes at most twice what knowing the future
    would (the ski rental problem).

    iterations : int    of the step, renewed : bool    the matrix was made in it
    refresh : bool      it contracted too slowly in the last iteration
    """
    if renewed:
        tip[USUAL] = 0.0
        tip[EXTRA] = 0.0
    elif tip[USUAL] == 0.0:
        tip[USUAL] = iterations
    else:
        tip[EXTRA] += max(iterations - tip[USUAL], 0.0)
    if refresh or tip[EXTRA] >= WORTH:
        tip[MATRIX_STEP] = 0.0


@inlined
def try_step(model, law, viscosity, audit, s, mids, chain, tip, counts, frames, scratch, h,
             shortest):
    """
    Advance one bristle by one step of length h; return OK, or why it failed and stays as it was.

    model : Model             constants; law : ContactLaw or None; viscosity [s] : float or None
    audit : (AUDIT,)          energy accounts, or None
    s, mids, chain, tip, counts   the bristle's state
    shortest [s] : float      step that is accepted whatever its local error
    frames : (3, FRAME)       frame records at the step's start, middle and end, its own axes
    """
    scheme = model.scheme
    elements = model.elements
    blocks = model.blocks
    block, lane = tip_lane(elements)
    end = frames[2]
    if tip[STEP] != h and tip[STEP] > 0.0:
        rescale_memory(s, blocks, h / tip[STEP])
        tip[STEP] = h
    ca = (1.0 - scheme.alpha_m) / ((1.0 - scheme.alpha_f) * scheme.beta * h * h)
    cv = scheme.gamma / (scheme.beta * h)
    keep = 1.0 - scheme.gamma / scheme.beta
    drift = h * (1.0 - 0.5 * scheme.gamma / scheme.beta)
    begin_step(s, blocks, h, scheme, tip[TREND])
    begin_section_forces(s, blocks)
    factor = 1.0
    if viscosity is not None:
        factor = 1.0 + viscosity * cv
        predict_damping(s, blocks, model.section, viscosity, cv, keep, drift)
    old1, old2, old3 = tip[FORCE], tip[FORCE + 1], tip[FORCE + 2]
    old_state, old_gap = tip[STATE], tip[GAP]
    if law is not None:
        begin_contact(s, block, lane, ca, drift, h, frames[1], tip)

    tolerance = newton_tolerance(scheme.tolerance, h)
    refresh = tip[MATRIX_STEP] != h
    rate = UNKNOWN if refresh else min(AGEING * tip[CONTRACTION], 0.5)
    contraction = rate
    renewed = False
    iterations = 0
    before = 0.0
    solved = True
    status = NO_CONVERGENCE
    for iteration in range(MAX_ITERATIONS):
        internal_forces(s, blocks, end[CLAMP:], model.section, factor, 1.0)
        residual(s, blocks, ca, cv, model.mass_damping, end)
        if refresh:
            tip[MATRIX_STEP] = 0.0
            counts[FACTORISATIONS] += 1
            if factorise(s, elements, model.section, factor, ca + model.mass_damping * cv,
                         end[SPIN:], end[SPIN_RATE:], cv, mids, chain, scratch.work) != OK:
                status = SINGULAR_MATRIX
                break
            tip[MATRIX_STEP] = h
            renewed = True
        fresh = refresh
        refresh = False
        add_excess(s, mids)
        eliminate(s, elements, mids, chain)
        if law is not None:
            solved = contact_correction(
                s, block, lane, chain, elements - 1, law, h, ca, drift,
                0.5 * ca * h * h - model.mass_damping * drift, frames[0], frames[1], end, tip,
                scratch.contact)
            if not solved:
                if fresh:
                    break
                refresh = True
        substitute(s, elements, mids, chain)
        update_section_forces(s, mids, model.section, factor)
        size = move_nodes(s, blocks, model.section.element_length)
        counts[NEWTON] += 1
        iterations += 1
        if not size < 1e29:
            status = NOT_FINITE
            break
        if iteration > 0:
            rate = size / before
            if iteration == 1:
                contraction = UNKNOWN if fresh else min(max(rate, LEAST), 0.5)
            if rate > SLOW:
                if fresh and rate > 2.0 and iteration > 2:
                    break
                refresh = True
        elif size > 1.0:
            refresh = True
        before = size
        if solved and (size <= tolerance and rate < 1.0
                       or size * rate <= tolerance * (1.0 - rate)):
            status = OK
            break
    if status == OK:
        p1, p2, p3 = rotate_back(frames[1], ROTATION, tip[FORCE] - old1, tip[FORCE + 1] - old2,
                                 tip[FORCE + 2] - old3)
        inverse = 1.0 / s[block, MASS * LANES + lane]
        tip[ESTIMATE] = local_error(s, blocks, h, scheme, block, lane, p1 * inverse, p2 * inverse,
                                    p3 * inverse)
        if tip[ESTIMATE] > model.local_error and h > shortest:
            status = TOO_INACCURATE
    if status != OK:
        tip[MATRIX_STEP] = 0.0
        tip[FORCE], tip[FORCE + 1], tip[FORCE + 2] = old1, old2, old3
        tip[STATE], tip[GAP] = old_state, old_gap
        if status != TOO_INACCURATE:
            counts[FAILURES] += 1
        return status
    tip[CONTRACTION] = contraction
    judge_matrix(tip, iterations, renewed, refresh)
    tip[STEP] = h
    if audit is not None:
        internal_forces(s, blocks, end[CLAMP:], model.section, factor, 0.0)
        account_step(model, law, viscosity, audit, s, tip, frames, scratch.turned, cv, keep, drift,
                     h)
        note_stress(model, audit, s, frames, scratch.turned)
    if viscosity is not None:
        strains(s, blocks, end[CLAMP:], model.section.element_length)
        accept_damping(s, blocks, cv, keep, drift, 1.0 / (scheme.beta * h * h),
                       1.0 / (scheme.beta * h), 0.5 / scheme.beta - 1.0)
    accept_section_forces(s, blocks)
    tip[TREND] = accept_step(s, blocks, h, scheme)
    if law is not None:
        lost = finish_contact(s, block, lane, law, h, end, tip)
        for i in range(3):
            tip[IMPULSE + i] += h * tip[FORCE + i]
        if audit is not None:
            audit[DISSIPATED] += lost
    return OK
