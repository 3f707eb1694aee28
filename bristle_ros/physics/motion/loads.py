"""
The loads of an instant: the scalars that a frame is made of, exact or linear within load steps.

With load steps (time_step > 0) the basics are linear between multiples of time_step: OMEGA, DOMEGA
and the motion of the paper's pilot node, ramped.
"""
from math import cos, floor, sin

from bristle_ros.physics.compiler import jit

from .drive import approach_at, profile_at, RAMP, ramp_at, table_at
from .hub import hub_at
from .records import (APPROACHING, LOAD_SPLIT, OMEGA, RAMPED, RAMPS, RATES, SPEED, SPLIT_BASICS,
                      SPLIT_CLAMP, THETA, TURNING)


@jit
def _profile_of(t, drive, table):
    """Return what the speed function adds to angle, speed and acceleration."""
    if table is not None:
        return table_at(t, table)
    return profile_at(t, drive.profile, drive.alternating_speed, drive.frequency, drive.shape)


@jit
def asked_speed(t, drive, motion):
    """Return the speed that profile and commands ask for at time t [rad/s]."""
    return ramp_at(motion, SPEED, t)[0] + _profile_of(t, drive, drive.table)[1]


@jit
def _turn_at(t, drive, motion, out, hub):
    """Return angle, speed and acceleration of the brush; out: the ramps at time t."""
    if hub is not None:
        return hub_at(t, motion, TURNING)
    angle, speed, acceleration = _profile_of(t, drive, drive.table)
    return (drive.start_angle + out[RAMPED + 2] + angle, out[RAMPED] + speed,
            out[RAMPED + 1] + acceleration)


@jit
def _basics_at(t, drive, motion, out):
    """Fill the scalars that the frame is made of, at time t."""
    for i in range(RAMPS):
        out[RAMPED + 3 * i], out[RAMPED + 3 * i + 1], out[RAMPED + 3 * i + 2] = ramp_at(
            motion, RAMP * i, t)
    out[0], out[1], out[2] = _turn_at(t, drive, motion, out, drive.hub)
    out[3] = out[RAMPED + 5]
    out[4] = out[RAMPED + 3]
    out[5] = out[RAMPED + 4]
    out[6], out[7] = out[RAMPED + 9], out[RAMPED + 10]
    out[8], out[9] = out[RAMPED + 12], out[RAMPED + 13]
    if motion[APPROACHING] > 0.0:
        depth, rate = approach_at(t, drive.penetration, drive.approach_time)
    else:
        depth, rate = out[RAMPED + 6], out[RAMPED + 7]
    out[10] = drive.tip_depth - depth
    out[11] = -rate


@jit
def _load_step_at(t, drive):
    """Return the number of the load step that t is in, and how far it is through: [0, 1)."""
    n = floor(t / drive.time_step + 1e-9)
    part = t / drive.time_step - n
    return n, part if part > 1e-9 else 0.0


@jit
def _load_step_ends(t, n, part, drive, motion, basics):
    """
    Fill the loads at the ends of load step n into basics[0], basics[1]; return how far t is in it.

    A command acts from its own time on, so the load step that it comes in is split there: up to
    it, loads go where the old step led; from it to the step's end they are linear again. Returned
    with it: the time between the ends [s].
    """
    end = (n + 1.0) * drive.time_step
    _basics_at(end, drive, motion, basics[1])
    split = motion[LOAD_SPLIT]
    if split > (n + 1e-9) * drive.time_step:
        for i in range(RAMPED):
            basics[0, i] = motion[SPLIT_BASICS + i]
        return (t - split) / (end - split), end - split
    _basics_at(n * drive.time_step, drive, motion, basics[0])
    return part, drive.time_step


@jit
def _on_chord(n, part, drive, motion, basics):
    """Return cosine and sine of the clamp's place, so far along its chord; basics: the ends."""
    c, s = cos(basics[0, 0]), sin(basics[0, 0])
    if motion[LOAD_SPLIT] > (n + 1e-9) * drive.time_step:
        c, s = motion[SPLIT_CLAMP], motion[SPLIT_CLAMP + 1]
    return ((1.0 - part) * c + part * cos(basics[1, 0]),
            (1.0 - part) * s + part * sin(basics[1, 0]))


@jit
def split_load_step(t, drive, motion, basics):
    """
    Keep the loads that the present load step has reached at time t, before a command changes it.

    Values (angles, speeds, height, the clamp's place) go on from what they are: no load jumps. To
    be followed by `renew_rates` once the ramps are changed. On a load step's end there is nothing
    to split.
    """
    n, part = _load_step_at(t, drive)
    if part == 0.0:
        return
    part, _ = _load_step_ends(t, n, part, drive, motion, basics)
    motion[SPLIT_CLAMP], motion[SPLIT_CLAMP + 1] = _on_chord(n, part, drive, motion, basics)
    for i in range(RAMPED):
        motion[SPLIT_BASICS + i] = basics[0, i] + part * (basics[1, i] - basics[0, i])
    motion[LOAD_SPLIT] = t


@jit
def renew_rates(t, drive, motion, basics):
    """Let accelerations be those of the new ramps where a step is split."""
    if motion[LOAD_SPLIT] == t:
        _basics_at(t, drive, motion, basics[0])
        for i in RATES:
            motion[SPLIT_BASICS + i] = basics[0, i]


@jit
def loads_at(t, drive, motion, basics, frame):
    """
    Fill basics[0] with the loads at time t, and THETA and OMEGA; return rates of the places.

    Rates: of angle [rad/s], heading [rad/s] and height [m/s]. Within a load step speeds are linear
    and so are places, which therefore do not go at these speeds but at those of their chords. What
    is to rest on the road has to be stopped against the latter: the difference of the two would be
    put in again at every integration step.
    """
    _basics_at(t, drive, motion, basics[0])
    frame[THETA] = basics[0, 0]
    frame[OMEGA] = basics[0, 1]
    if drive.time_step > 0.0:
        n, part = _load_step_at(t, drive)
        if part > 0.0:
            part, span = _load_step_ends(t, n, part, drive, motion, basics)
            turning = (basics[1, 0] - basics[0, 0]) / span
            yawing = (basics[1, 3] - basics[0, 3]) / span
            rising = (basics[1, 10] - basics[0, 10]) / span
            for i in range(RAMPED):
                basics[0, i] += part * (basics[1, i] - basics[0, i])
            return turning, yawing, rising
    return basics[0, 1], basics[0, 4], basics[0, 11]


@jit
def clamp_turn(t, drive, motion, basics, theta):
    """
    Return how far the clamp has turned at time t, and cosine and sine of its place.

    theta [rad]: where it would be without load steps. With them the place is linear between points
    of the circle, and so is the angle of its rotation (Fig. 2a of the paper).
    """
    c, s = cos(theta), sin(theta)
    if drive.time_step > 0.0:
        n, part = _load_step_at(t, drive)
        if part > 0.0:
            part, _ = _load_step_ends(t, n, part, drive, motion, basics)
            theta = basics[0, 0] + part * (basics[1, 0] - basics[0, 0])
            c, s = _on_chord(n, part, drive, motion, basics)
    return theta, c, s
