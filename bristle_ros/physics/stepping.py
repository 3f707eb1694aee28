"""
The guaranteed step: Newton with a frozen matrix, sub-steps where it fails, many steps in one call.

The matrix is factorised in the nodes' own axes and kept as long as Newton's corrections shrink
fast. When Newton fails even with a fresh matrix the step is halved, down to 2^-DEEPEST of the
integration step; when that fails too, `advance` stops with a status and the state at the start of
that integration step. All decisions depend on the state alone, so a run repeats bit for bit.
"""
from math import sqrt

from .beam import internal_forces
from .chain import eliminate, factorise, OK, substitute
from .damping import accept_damping, predict_damping, strains
from .energy import account_step, DISSIPATED
from .frame import CLAMP, drive_clamp, frame_at, ROTATION, SPIN, SPIN_RATE, turn_frame
from .jit import inlined, jit
from .layout import LANES, MASS, Q, R, tip_lane, X, X0
from .loads import accept_step, begin_step, local_error, rescale_memory, residual
from .mixed import (accept_section_forces, add_excess, begin_section_forces,
                    update_section_forces)
from .queue import take
from .scheme import newton_tolerance
from .tip import (begin_contact, contact_correction, CONTRACTION, ESTIMATE, finish_contact, FORCE,
                  GAP, IMPULSE, LEVEL, MATRIX_STEP, rotate_back, STATE, STEP,
                  TREND)

MAX_ITERATIONS = 20     # of Newton in one attempt, matrix refreshed when they shrink slowly
SLOW = 0.4              # contraction above which the matrix is factorised anew
# what the second correction is of the first one, where there is no second one to tell
UNKNOWN = 0.1           # after a new matrix
LEAST = 1e-3
AGEING = 1.5            # growth in each step that does not measure it
EASY = 5                # iterations up to which a sub-step may become longer again
DEEPEST = 14            # halvings of the integration step
FINEST = 10             # halvings that the error estimate may ask for
BATCH = 64              # steps in one call: their frames are worked out beforehand
WHOLE = 1 << DEEPEST
MAX_ATTEMPTS = 2 * WHOLE

# status of a step; 0 is done
SINGULAR_MATRIX = 1
NO_CONVERGENCE = 2
NOT_FINITE = 3
TOO_INACCURATE = 4      # adaptive steps: the local error is above what it may be

# running counts
NEWTON = 0
SUBSTEPS = 1
FACTORISATIONS = 2
FAILURES = 3
COUNTS = 4


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
        if model.local_error > 0.0 and tip[ESTIMATE] > model.local_error and h > shortest:
            status = TOO_INACCURATE
    if status != OK:
        tip[MATRIX_STEP] = 0.0
        tip[FORCE], tip[FORCE + 1], tip[FORCE + 2] = old1, old2, old3
        tip[STATE], tip[GAP] = old_state, old_gap
        if status != TOO_INACCURATE:
            counts[FAILURES] += 1
        return status
    tip[CONTRACTION] = contraction
    if refresh:
        tip[MATRIX_STEP] = 0.0
    tip[STEP] = h
    if audit is not None:
        internal_forces(s, blocks, end[CLAMP:], model.section, factor, 0.0)
        account_step(model, law, viscosity, audit, s, tip, frames, scratch.turned, cv, keep, drift,
                     h)
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


@jit
def mount_frame(model, motion, t, scratch, frame):
    """Fill the frame record of a bristle at azimuth 0 at time t."""
    frame_at(t, model.drive, model.displacement, motion, scratch.basics, frame)
    if model.displacement:
        drive_clamp(t, model.drive, motion, model.clamp, scratch.basics, frame)
    else:
        for i in range(7):
            frame[CLAMP + i] = model.clamp[i]


@jit
def own_frame(model, motion, azimuth, t, scratch, frame):
    """Fill the frame record of a bristle (cosine and sine of its azimuth) at time t."""
    mount_frame(model, motion, t, scratch, scratch.frame)
    turn_frame(scratch.frame, azimuth[0], azimuth[1], frame)


@jit
def keep_copy(s, tip, into, into_tip):
    """Copy a bristle's nodes and tip record."""
    for j in range(s.shape[0]):
        for i in range(s.shape[1]):
            into[j, i] = s[j, i]
    for i in range(tip.size):
        into_tip[i] = tip[i]


@inlined
def whole_step(model, law, viscosity, audit, motion, azimuth, s, mids, chain, tip, counts,
               scratch, step, table):
    """
    Advance one bristle over one integration step, in halves of halves where Newton fails.

    table : (3, FRAME)    frame records at azimuth 0 at the step's start, middle and end
    Returns OK, or the last failure's status with the state as it was at the step's start.
    """
    frames = scratch.frames
    position = 0
    level = int(tip[LEVEL])
    if level > 0:
        keep_copy(s, tip, scratch.saved, scratch.saved_tip)
    for _ in range(MAX_ATTEMPTS):
        size = WHOLE >> level
        for i in range(3):
            if size == WHOLE:
                turn_frame(table[i], azimuth[0], azimuth[1], frames[i])
            else:
                part = (position + 0.5 * i * size) / WHOLE
                own_frame(model, motion, azimuth, (step + part) * model.its, scratch, frames[i])
        counted = counts[NEWTON]
        status = try_step(model, law, viscosity, audit, s, mids, chain, tip, counts, frames,
                          scratch, model.its / (1 << level), model.its / (1 << FINEST))
        if status == OK:
            position += size
            if level > 0:
                counts[SUBSTEPS] += 1
                if counts[NEWTON] - counted <= EASY and position % (2 * size) == 0 and (
                        16.0 * tip[ESTIMATE] <= model.local_error or model.local_error == 0.0):
                    level -= 1
            if position == WHOLE:
                tip[LEVEL] = level
                return OK
        else:
            if position == 0:
                keep_copy(s, tip, scratch.saved, scratch.saved_tip)
            level += 1
            if level > DEEPEST:
                break
    keep_copy(scratch.saved, scratch.saved_tip, s, tip)
    tip[MATRIX_STEP] = 0.0
    for j in range(model.blocks):
        for i in range(7 * LANES):
            s[j, X * LANES + i] = s[j, X0 * LANES + i]
    return status


@jit
def fill_frames(model, law, state, scratch, steps, table):
    """
    Fill the frame records at azimuth 0 of the next `steps` steps: all bristles share them.

    table : (2 BATCH + 1, FRAME)    at the steps' starts and ends and, with contact, middles
    """
    for i in range(2 * steps + 1):
        if law is not None or i % 2 == 0:
            mount_frame(model, state.motion, (state.step[0] + 0.5 * i) * model.its, scratch,
                        table[i])


@inlined
def make_steps(model, law, viscosity, audit, state, scratch, table, bristle, steps):
    """Advance a bristle by `steps` steps; OK, or a status and in scratch.failed the step."""
    account = None if audit is None else audit[bristle]
    status = OK
    for step in range(steps):
        status = whole_step(
            model, law, viscosity, account, state.motion, model.azimuth[bristle],
            state.nodes[bristle], state.mids[bristle], state.chain[bristle], state.tip[bristle],
            state.counts[bristle], scratch, state.step[0] + step, table[2 * step:])
        if status != OK:
            scratch.failed[0] = step
            break
    return status


@jit
def advance(model, law, viscosity, audit, state, scratch, table, queue, steps):
    """
    Advance the bristles of a queue by `steps` steps in place, one after the other.

    They know nothing of each other, so that threads may share a queue. Returns 0, or the status of
    the first failure (in steps, then bristles), whose step, counted from here, and bristle are in
    scratch.failed[1:]; state.step[0] stays for the caller to move.
    """
    worst = OK
    bristle = take(queue)
    while bristle < model.bristles:
        status = make_steps(model, law, viscosity, audit, state, scratch, table, bristle, steps)
        failed = scratch.failed
        if status != OK and (worst == OK or failed[0] < failed[1] or (
                failed[0] == failed[1] and bristle < failed[2])):
            worst = status
            failed[1] = failed[0]
            failed[2] = bristle
        bristle = take(queue)
    return worst


@jit
def advance_alone(model, law, viscosity, audit, state, scratch, table, steps):
    """
    Advance the only bristle by any number of steps, frame records and state.step[0] with it.

    One call: what it takes to hand the records over outweighs a few steps. Returns 0, or the
    status of a failure, with the state at the start of the failed step.
    """
    while steps > 0:
        batch = min(steps, BATCH)
        fill_frames(model, law, state, scratch, batch, table)
        status = make_steps(model, law, viscosity, audit, state, scratch, table, 0, batch)
        if status != OK:
            state.step[0] += scratch.failed[0]
            return status
        state.step[0] += batch
        steps -= batch
    return OK
