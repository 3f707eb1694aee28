"""
The guaranteed step: sub-steps where Newton's method fails, and many steps in one call.

When it fails even with a fresh matrix the step is halved, down to 2^-DEEPEST of the integration
step; when that fails too, `advance` stops with a status and the state at the start of that
integration step. All decisions depend on the state alone, so a run repeats bit for bit.
"""
from bristle_ros.physics.compiler import inlined, jit, load8, store8, take
from bristle_ros.physics.contact import (ESTIMATE, is_clear, LEVEL, MATRIX_STEP, POINT, rotate)
from bristle_ros.physics.motion import (CLAMP, drive_clamp, follow_path, frame_at, HEIGHT,
                                        is_carried, is_polygon, keep_place, ROTATION, turn_frame,
                                        VELOCITY, way_within)
from bristle_ros.physics.wire import (HA, JUMP, keep_strains, LANES, LR, OK, SECTION_FORCE,
                                      STRAIN0, X, X0)

from .board import add_wrench
from .newton import CLAMP_INSIDE, try_step, UNFINISHED
from .records import AT_FINEST, bristle_of, NEWTON, SPLIT, SUBSTEPS

EASY = 5                # iterations up to which a sub-step may become longer again
DEEPEST = 14            # halvings of the integration step
FINEST = 10             # halvings that the error estimate may ask for
BATCH = 64              # steps in one call: their frames are worked out beforehand
PARTS = 8               # of a step, at whose ends frames are kept for other bristles
WHOLE = 1 << DEEPEST
MAX_ATTEMPTS = 2 * WHOLE
# twice what the local error grows by when the step doubles: a longer step should last
GROWTH = 16.0


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
def _copy_rows(r, first, end, into):
    for row in range(first, end):
        store8(into, row * LANES, load8(r, row * LANES))


@jit
def keep_copy(s, tip, points, into, into_tip, into_points):
    """Copy what a bristle's nodes carry from step to step, and its contact's records."""
    for j in range(s.shape[0]):
        _copy_rows(s[j], X0, HA, into[j])
        _copy_rows(s[j], STRAIN0, LR, into[j])
        _copy_rows(s[j], JUMP, SECTION_FORCE, into[j])
    for i in range(tip.size):
        into_tip[i] = tip[i]
    for e in range(points.shape[0]):
        for i in range(POINT):
            into_points[e, i] = points[e, i]


@jit
def frame_within(model, motion, start, step, part, scratch, frame):
    """Fill the frame record of a bristle at azimuth 0 after start + step + part steps."""
    mount_frame(model, motion, (start + step + part) * model.its, scratch, frame)
    way_within(scratch.table, step, part, model.its, frame)


@inlined
def place_frames(model, state, azimuth, step, position, size, scratch):
    """
    Fill the frames of a sub-step, `size` from `position` on of WHOLE in a step.

    Where the steps of many bristles end, within 1 / PARTS of a step, they are worked out but once.
    What is at hand is turned here: to hand all records to a kernel takes longer than that.
    """
    for i in range(3):
        part = (position + 0.5 * i * size) / WHOLE
        place = step * PARTS + int(part * PARTS)
        frame = scratch.parts[place]
        if size == WHOLE:
            frame = scratch.table[2 * step + i]
        elif part * PARTS != int(part * PARTS):
            frame = scratch.frame
            frame_within(model, state.motion, state.step[0], step, part, scratch, frame)
        elif scratch.known[place] == 0:
            frame_within(model, state.motion, state.step[0], step, part, scratch, frame)
            scratch.known[place] = 1
        turn_frame(frame, azimuth[0], azimuth[1], scratch.frames[i])


@jit
def clamp_is_clear(surface, carrier, azimuth, scratch, step):
    """
    Return whether the clamp is above the surface where the step starts.

    On the plane only a mount that is carried can bring it down: other ways there are refused.
    """
    if surface is None:
        if carrier is None:
            return True
        frame = scratch.frame
        turn_frame(scratch.table[2 * step], azimuth[0], azimuth[1], frame)
        return frame[HEIGHT] + rotate(frame, ROTATION, frame[CLAMP], frame[CLAMP + 1],
                                      frame[CLAMP + 2])[2] > 0.0
    turn_frame(scratch.table[2 * step], azimuth[0], azimuth[1], scratch.frame)
    return is_clear(surface, scratch.frame, scratch.contact)


@inlined
def whole_step(model, law, viscosity, audit, state, bristle, scratch, step):
    """
    Advance one bristle over one integration step, in halves of halves where Newton fails.

    step : int      counted from the start of this call
    Returns OK, or the last failure's status with the state as it was at the step's start.
    """
    if law is not None and not clamp_is_clear(law.surface, model.drive.carrier,
                                              bristle.azimuth, scratch, step):
        return CLAMP_INSIDE
    nodes, tip, points, counts = bristle.nodes, bristle.tip, bristle.points, bristle.counts
    if viscosity is not None and is_polygon(model):
        keep_strains(nodes)
    position = 0
    level = int(tip[LEVEL])
    deepest = 0
    if level > 0:
        keep_copy(nodes, tip, points, scratch.saved, scratch.saved_tip, scratch.saved_points)
    if audit is not None:
        for i in range(audit.size):
            scratch.saved_audit[i] = audit[i]
    for _ in range(MAX_ATTEMPTS):
        size = WHOLE >> level
        place_frames(model, state, bristle.azimuth, step, position, size, scratch)
        counted = counts[NEWTON]
        status = try_step(model, law, viscosity, audit, bristle, scratch,
                          model.its / (1 << level), model.its / (1 << FINEST))
        if status == OK:
            position += size
            deepest = max(deepest, level)
            if level > 0:
                counts[SUBSTEPS] += 1
                if counts[NEWTON] - counted <= EASY and position % (2 * size) == 0 and (
                        GROWTH * tip[ESTIMATE] <= model.local_error):
                    level -= 1
            if position == WHOLE:
                tip[LEVEL] = level
                counts[SPLIT] += deepest > 0
                counts[AT_FINEST] += deepest >= FINEST
                return OK
        else:
            if position == 0:
                keep_copy(nodes, tip, points, scratch.saved, scratch.saved_tip,
                          scratch.saved_points)
            level += 1
            if level > DEEPEST:
                break
    keep_copy(scratch.saved, scratch.saved_tip, scratch.saved_points, nodes, tip, points)
    if audit is not None:
        for i in range(audit.size):
            audit[i] = scratch.saved_audit[i]
    tip[MATRIX_STEP] = 0.0
    for j in range(model.blocks):
        for i in range(7 * LANES):
            nodes[j, X * LANES + i] = nodes[j, X0 * LANES + i]
    return UNFINISHED if status == OK else status


@jit
def fill_frames(model, law, state, scratch, steps):
    """Fill scratch.table for the next `steps` steps; no middles where there is no contact."""
    for i in range(2 * steps + 1):
        if law is not None or i % 2 == 0:
            mount_frame(model, state.motion, (state.step[0] + 0.5 * i) * model.its, scratch,
                        scratch.table[i])
    if law is None:     # nothing asks where the road is within a step
        for i in range(1, 2 * steps, 2):
            for row in range(VELOCITY, VELOCITY + 2):
                scratch.table[i, row] = 0.5 * (
                    scratch.table[i - 1, row] + scratch.table[i + 1, row])
    follow_path(scratch.table, state.motion, model.its, steps)


@inlined
def make_steps(model, law, viscosity, audit, state, scratch, number, steps):
    """Advance a bristle by `steps` steps; OK, or a status and in scratch.failed the step."""
    account = None if audit is None else audit[number]
    bristle = bristle_of(model, state, number)
    status = OK
    for step in range(steps):
        status = whole_step(model, law, viscosity, account, state, bristle, scratch, step)
        if status != OK:
            scratch.failed[0] = step
            break
        if is_carried(model.drive.carrier):
            add_wrench(model.drive.carrier, model, viscosity, state, scratch, number, step)
    return status


@jit
def advance(model, law, viscosity, audit, state, scratch, queue, steps, alone):
    """
    Advance the bristles of a queue by `steps` steps in place, one after the other.

    They know nothing of each other, so that threads may share a queue. Frame records and
    state.step[0] are the caller's, and steps are at most BATCH; but `alone`, the only bristle, has
    them with it and takes any number of steps in one call: what it takes to hand the records over
    outweighs a few. Returns 0, or the status of the first failure (in steps, then bristles), whose
    step, counted from here, and bristle are in scratch.failed[1:].
    """
    worst = OK
    while steps > 0 and worst == OK:
        batch = min(steps, BATCH)
        if alone:
            fill_frames(model, law, state, scratch, batch)
            queue[0] = 0
        scratch.known[:batch * PARTS + 1] = 0
        bristle = take(queue)
        while bristle < model.bristles:
            status = make_steps(model, law, viscosity, audit, state, scratch, bristle, batch)
            failed = scratch.failed
            if status != OK and (worst == OK or failed[0] < failed[1] or (
                    failed[0] == failed[1] and bristle < failed[2])):
                worst = status
                failed[1] = failed[0]
                failed[2] = bristle
            bristle = take(queue)
        if alone:
            done = batch if worst == OK else scratch.failed[1]
            keep_place(scratch.table, state.motion, done)
            state.step[0] += done
        steps -= batch
    return worst
