"""
A step of a brush whose drive feels its load: hub and wires together.

The hub is one more degree of freedom of the same integrator (scheme.py), so its balance

    J (a1 + mount) = T(omega1) + tau(a1) + owed

holds at the step's end, and the whole has the scheme's order. tau is known only by stepping the
wires with the motion that a1 gives. The first a1 of a step is the one that balances a straight
line: tau and a extrapolated from the last two steps, and a slope. The wires' mass is in that
slope: without it the exchange diverges as soon as the wires are heavier than the hub (added mass:
Causin, Gerbeau, Nobile 2005, doi 10.1016/j.cma.2004.12.005). Wires that are stiff within a step
follow like a rigid body, so it begins as their inertia; attempts at one step correct it (secant).

Where what is left of the balance would change the angle by no more than Newton's tolerance, by
the hub's own local error, the step stands, and the next one's balance owes the rest: no impulse is
lost, and a smooth motion takes one attempt a step. Else all wires go back and step again, at most
MOST_ATTEMPTS times.
"""
from bristle_ros.physics.compiler import inlined, jit, take
from bristle_ros.physics.contact import CONTRACTION, EXTRA, MATRIX_STEP, USUAL
from bristle_ros.physics.motion import (ACCELERATION, ADDED, asked_speed, ASKED, ATTEMPTS, OWED,
                                        COMMAND, DRIVE_WORK, drive_torque, END, frame_at,
                                        HUB, keep_place, LASTS, MOUNT_RATE, PSEUDO, REACTION,
                                        SPIN_RATE, START, STARTED, TORQUE, turn_frame, TURNING)
from bristle_ros.physics.wire import error_constant, OK

from .board import board_wrench
from .energy import AUDIT
from .records import AT_FINEST, SPLIT
from .scheme import newton_tolerance
from .stepping import fill_frames, keep_copy, make_steps, PARTS

MOST_ATTEMPTS = 8
BRANCHES = 4        # corrections of a balance that is straight in pieces: one a piece, and one
STIFFEST = 4.0      # the slope is at most this times the wires' inertia


@jit
def _move_end(scheme, hub, acceleration):
    """Let the step end with this acceleration; hub : (HUB,)."""
    h, a0 = hub[LASTS], hub[START + PSEUDO]
    a1 = ((1.0 - scheme.alpha_f) * acceleration + scheme.alpha_f * hub[START + ACCELERATION]
          - scheme.alpha_m * a0) / (1.0 - scheme.alpha_m)
    hub[END] = hub[START] + h * hub[START + 1] + h * h * (
        (0.5 - scheme.beta) * a0 + scheme.beta * a1)
    hub[END + 1] = hub[START + 1] + h * ((1.0 - scheme.gamma) * a0 + scheme.gamma * a1)
    hub[END + ACCELERATION], hub[END + PSEUDO] = acceleration, a1


@jit
def _relation(scheme):
    """Return what the integrator's own acceleration changes by with the true one."""
    return (1.0 - scheme.alpha_f) / (1.0 - scheme.alpha_m)


@jit
def _excess(drive, scheme, hub, reaction):
    """Return what is left of the balance [N m], and what that falls by with a1, wires apart."""
    torque, slope = drive_torque(drive, hub[ASKED], hub[COMMAND], hub[END + 1])
    left = (torque + reaction + hub[OWED]
            - drive.inertia * (hub[END + ACCELERATION] + hub[MOUNT_RATE]))
    return left, drive.inertia - slope * scheme.gamma * hub[LASTS] * _relation(scheme)


@jit
def _balance(drive, scheme, hub, reaction, at):
    """End the step where the line of the reaction balances it; the line is `reaction` at `at`."""
    for _ in range(BRANCHES):
        now = hub[END + ACCELERATION]
        left, slope = _excess(drive, scheme, hub, reaction - hub[ADDED] * (now - at))
        _move_end(scheme, hub, now + left / (slope + hub[ADDED]))


@jit
def begin_turn(model, drive, motion, kept, step, scratch):
    """
    Predict the hub's motion over the step of that number.

    drive : Hub     model.drive.hub;  kept : (HUB,)    filled with the record as it was
    """
    hub = motion[TURNING:]
    for i in range(HUB):
        kept[i] = hub[i]
    t = (step + 1.0) * model.its
    frame_at(t, model.drive, False, motion, scratch.basics, scratch.frame)
    hub[MOUNT_RATE] = scratch.frame[SPIN_RATE + 2] - hub[END + ACCELERATION]
    hub[ASKED] = asked_speed(t, model.drive, motion)
    hub[STARTED], hub[LASTS], hub[ATTEMPTS] = step * model.its, model.its, 0.0
    for i in range(4):
        hub[START + i] = hub[END + i]
    _move_end(model.scheme, hub, hub[END + ACCELERATION])
    _balance(drive, model.scheme, hub, 2.0 * hub[REACTION + 2] - hub[REACTION],
             2.0 * hub[REACTION + 3] - hub[REACTION + 1])


@jit
def end_turn(model, drive, motion, torques):
    """
    Return whether the step stands; else the hub's motion is another one for the next attempt.

    torques [N m] : (B,)    of the wires of each bristle on the board
    """
    hub, scheme = motion[TURNING:], model.scheme
    reaction = 0.0
    for i in range(torques.size):
        reaction += torques[i]
    at, h = hub[END + ACCELERATION], hub[LASTS]
    left, slope = _excess(drive, scheme, hub, reaction)
    apart = at - hub[REACTION + 5]
    if hub[ATTEMPTS] > 0.0 and apart != 0.0:
        found = (hub[REACTION + 4] - reaction) / apart
        hub[ADDED] = min(max(found, 0.0), STIFFEST * drive.wires)
    hub[ATTEMPTS] += 1.0
    hub[REACTION + 4], hub[REACTION + 5] = reaction, at
    moved = left / (slope + hub[ADDED]) * scheme.beta * h * h * _relation(scheme)
    error = error_constant(scheme) * h * h * abs(at - hub[START + ACCELERATION])
    if abs(moved) > newton_tolerance(scheme, h, error) and hub[ATTEMPTS] < MOST_ATTEMPTS:
        _balance(drive, scheme, hub, reaction, at)
        return False
    for i in range(4):
        hub[REACTION + i] = hub[REACTION + 2 + i]
    hub[OWED] = left
    before = hub[TORQUE]
    hub[TORQUE], _ = drive_torque(drive, hub[ASKED], hub[COMMAND], hub[END + 1])
    hub[DRIVE_WORK] += 0.5 * h * (before * hub[START + 1] + hub[TORQUE] * hub[END + 1])
    return True


@jit
def _keep_or_restore(state, kept, bristle, again):
    """Keep a bristle as it is at the step's start, or put it back there."""
    if again:
        tip = state.tip[bristle]
        # the matrix is what it is, and so is what is known of it
        matrix, contraction, usual, extra = (tip[MATRIX_STEP], tip[CONTRACTION], tip[USUAL],
                                             tip[EXTRA])
        keep_copy(kept.nodes[bristle], kept.tip[bristle], kept.points[bristle],
                  state.nodes[bristle], tip, state.points[bristle])
        tip[MATRIX_STEP], tip[CONTRACTION], tip[USUAL], tip[EXTRA] = (matrix, contraction, usual,
                                                                      extra)
        state.counts[bristle, SPLIT] = kept.counts[bristle, SPLIT]
        state.counts[bristle, AT_FINEST] = kept.counts[bristle, AT_FINEST]
        for i in range(AUDIT):
            state.audit[bristle, i] = kept.audit[bristle, i]
        return
    keep_copy(state.nodes[bristle], state.tip[bristle], state.points[bristle],
              kept.nodes[bristle], kept.tip[bristle], kept.points[bristle])
    kept.counts[bristle, SPLIT] = state.counts[bristle, SPLIT]
    kept.counts[bristle, AT_FINEST] = state.counts[bristle, AT_FINEST]
    for i in range(AUDIT):
        kept.audit[bristle, i] = state.audit[bristle, i]


@inlined
def _attempt(model, law, viscosity, audit, state, scratch, turn, bristle):
    """Make an attempt at a step of one bristle, and fill its torque; return the status."""
    _keep_or_restore(state, turn.kept, bristle, state.motion[TURNING + ATTEMPTS] > 0.0)
    status = make_steps(model, law, viscosity, audit, state, scratch, bristle, 1)
    if status == OK:
        frame, azimuth = scratch.frames[2], model.azimuth[bristle]
        turn_frame(scratch.table[2], azimuth[0], azimuth[1], frame)
        turn.torques[bristle] = board_wrench(model, viscosity, state.nodes[bristle], frame)[5]
    return status


@jit
def attempt_share(model, law, viscosity, audit, state, scratch, turn, queue):
    """
    Make an attempt at one step of the bristles of a queue, as `advance` does with many steps.

    turn : Turn
    """
    scratch.known[:PARTS + 1] = 0
    worst = OK
    bristle = take(queue)
    while bristle < model.bristles:
        status = _attempt(model, law, viscosity, audit, state, scratch, turn, bristle)
        if status != OK and (worst == OK or bristle < scratch.failed[2]):
            worst = status
            scratch.failed[1] = 0
            scratch.failed[2] = bristle
        bristle = take(queue)
    return worst


@jit
def advance_driven(model, law, viscosity, audit, state, scratch, turn, steps):
    """Advance one bristle alone, of a brush whose drive feels its load; turn : Turn."""
    for _ in range(steps):
        begin_turn(model, model.drive.hub, state.motion, turn.hub, state.step[0], scratch)
        status, stands = OK, False
        while status == OK and not stands:
            fill_frames(model, law, state, scratch, 1)
            scratch.known[:PARTS + 1] = 0
            status = _attempt(model, law, viscosity, audit, state, scratch, turn, 0)
            if status == OK:
                stands = end_turn(model, model.drive.hub, state.motion, turn.torques)
        if status != OK:
            for i in range(HUB):
                state.motion[TURNING + i] = turn.hub[i]
            return status
        keep_place(scratch.table, state.motion, 1)
        state.step[0] += 1
    return OK
