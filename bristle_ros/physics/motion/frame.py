"""
Motion of the brush frame: what the bristle feels of the brush, the sweeper and the road.

Whatever moves the brush, the bristle sees six 3-vectors in its own axes, the orientation of those
axes and the height of the mount above the road (a frame record). Orientation, brush to road:

    R = Rz(heading) Rz(tilt azimuth) Ry(attack angle) Rz(-tilt azimuth) Rz(theta)

`motion` holds the ramps that commands change; `Drive` what stays.
"""
from math import cos, floor, sin

from bristle_ros.physics.compiler import jit
import numpy as np
from numpy.typing import NDArray

from .carried import (AT_ACCELERATION, AT_PLACE, AT_RATE, AT_RATE_RATE, AT_ROTATION, AT_VELOCITY,
                      CARRIED, carried_at)
from .drive import approach_at, profile_at, RAMP, ramp_at, table_at
from .hub import hub_at
from .records import (APPROACHING, CARRY, CLAMP, DRAG_RATE, DRAG_SPIN, FRAME, GRAVITY, HEIGHT,
                      HEIGHT_RATE, LOAD_SPLIT, MOTION, OMEGA, PATH_SPIN, RAMPED, RAMPS, RATES,
                      ROTATION, SPEED, SPIN, SPIN_RATE, SPLIT_BASICS, SPLIT_CLAMP, THETA, TURNING,
                      VELOCITY)


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
def _chord_start(n, drive, motion, basics):
    """Return cosine and sine of the clamp's place where its chord begins; basics: the ends."""
    if motion[LOAD_SPLIT] > (n + 1e-9) * drive.time_step:
        return motion[SPLIT_CLAMP], motion[SPLIT_CLAMP + 1]
    return cos(basics[0, 0]), sin(basics[0, 0])


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
    c, s = _chord_start(n, drive, motion, basics)
    motion[SPLIT_CLAMP] = (1.0 - part) * c + part * cos(basics[1, 0])
    motion[SPLIT_CLAMP + 1] = (1.0 - part) * s + part * sin(basics[1, 0])
    for i in range(RAMPED):
        motion[SPLIT_BASICS + i] = basics[0, i] + part * (basics[1, i] - basics[0, i])
    motion[LOAD_SPLIT] = t


@jit
def renew_rates(t, drive, motion, basics):
    """Let accelerations and the road's speed be those of the new ramps where a step is split."""
    if motion[LOAD_SPLIT] == t:
        _basics_at(t, drive, motion, basics[0])
        for i in RATES:
            motion[SPLIT_BASICS + i] = basics[0, i]


@jit
def _loads_at(t, drive, motion, basics, frame):
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
def kerb_offset(t, drive):
    """Return how much further away the kerb still is [m], and the rate of that [m/s]."""
    if t >= drive.approach_time:
        return 0.0, 0.0
    s = t / drive.approach_time
    return (drive.kerb_approach * (1.0 - s * s * (3.0 - 2.0 * s)),
            -drive.kerb_approach * 6.0 * s * (1.0 - s) / drive.approach_time)


@jit
def frame_at(t, drive, displacement, motion, basics, frame):
    """
    Fill the frame record at time t [s], but for the clamp.

    displacement : bool    the frame is the mount's and does not turn with the brush (the
                           displacement load case moves the clamp instead, `drive_clamp`)

    motion : (MOTION,), basics : (2, BASICS) scratch, frame : (FRAME,)
    With load steps (time_step > 0) the basics are linear between multiples of time_step: OMEGA,
    DOMEGA and the motion of the paper's pilot node, ramped. THETA and OMEGA stay exact.
    """
    turning, yawing, rising = _loads_at(t, drive, motion, basics, frame)
    theta, omega, alpha, heading, yaw, yaw_rate = (
        basics[0, 0], basics[0, 1], basics[0, 2], basics[0, 3], basics[0, 4], basics[0, 5])
    vx, vx_rate, vy, vy_rate = basics[0, 6], basics[0, 7], basics[0, 8], basics[0, 9]

    frame[DRAG_SPIN] = 0.0
    frame[DRAG_RATE] = 0.0
    if displacement:
        frame[DRAG_SPIN] = omega
        frame[DRAG_RATE] = alpha
        theta, omega, alpha, turning = 0.0, 0.0, 0.0, 0.0
    turn = theta - drive.tilt_azimuth
    ct, st = cos(turn), sin(turn)
    front = heading + drive.tilt_azimuth
    cf, sf = cos(front), sin(front)
    ca, sa = drive.cos_attack, drive.sin_attack
    frame[ROTATION] = cf * ca * ct - sf * st
    frame[ROTATION + 1] = -cf * ca * st - sf * ct
    frame[ROTATION + 2] = cf * sa
    frame[ROTATION + 3] = sf * ca * ct + cf * st
    frame[ROTATION + 4] = -sf * ca * st + cf * ct
    frame[ROTATION + 5] = sf * sa
    frame[ROTATION + 6] = -sa * ct
    frame[ROTATION + 7] = sa * st
    frame[ROTATION + 8] = ca
    up1, up2, up3 = -sa * ct, sa * st, ca       # road z in brush axes
    frame[SPIN] = yaw * up1
    frame[SPIN + 1] = yaw * up2
    frame[SPIN + 2] = yaw * up3 + omega
    frame[PATH_SPIN] = yawing * up1
    frame[PATH_SPIN + 1] = yawing * up2
    frame[PATH_SPIN + 2] = yawing * up3 + turning
    # d(up)/dt in brush axes = -Omega x up = -omega z x up
    frame[SPIN_RATE] = yaw_rate * up1 + yaw * omega * up2
    frame[SPIN_RATE + 1] = yaw_rate * up2 - yaw * omega * up1
    frame[SPIN_RATE + 2] = yaw_rate * up3 + alpha

    # mount centre: velocity and acceleration from the sweeper's base, turning axes, then road axes
    ux = vx - yaw * drive.mount_y
    uy = vy + yaw * drive.mount_x
    ax = vx_rate - yaw_rate * drive.mount_y - yaw * uy
    ay = vy_rate + yaw_rate * drive.mount_x + yaw * ux
    ch, sh = cos(heading), sin(heading)
    frame[VELOCITY] = ch * ux - sh * uy
    frame[VELOCITY + 1] = sh * ux + ch * uy
    if drive.kerb_approach != 0.0:
        frame[VELOCITY + 1] -= kerb_offset(t, drive)[1]
    frame[VELOCITY + 2] = 0.0
    gx = drive.down_x - (ch * ax - sh * ay)
    gy = drive.down_y - (sh * ax + ch * ay)
    gz = drive.down_z
    for i in range(3):
        frame[GRAVITY + i] = (frame[ROTATION + i] * gx + frame[ROTATION + 3 + i] * gy
                              + frame[ROTATION + 6 + i] * gz)
    frame[HEIGHT] = basics[0, 10]
    frame[HEIGHT_RATE] = rising
    if is_carried(drive.carrier):
        _carry_frame(drive.carrier, t, drive, motion, (theta, omega, alpha, turning), basics[1],
                     frame)


@jit
def is_carried(carrier):
    """Return whether the mount may be carried."""
    return carrier is not None


@jit
def _carry_frame(carrier, t, drive, motion, turn, at, frame):
    """
    Let a frame record be that of a mount that is carried, from the first command on.

    turn : angle, speed, acceleration of the brush, and speed along its chord
    at : (BASICS,) scratch

    With u the mount's angular velocity in its own axes the brush's is Rz(theta)^T u + omega z, and
    its rate Rz(theta)^T u' - omega z x Rz(theta)^T u + alpha z.
    """
    if carrier is None:
        return
    if motion[CARRY + CARRIED] == 0.0:
        return
    theta, omega, alpha, turning = turn
    carried_at(t, motion, CARRY, at)
    c, s = cos(theta), sin(theta)
    for row in range(0, 9, 3):
        x, y = at[AT_ROTATION + row], at[AT_ROTATION + row + 1]
        frame[ROTATION + row] = c * x + s * y
        frame[ROTATION + row + 1] = c * y - s * x
        frame[ROTATION + row + 2] = at[AT_ROTATION + row + 2]
    u1, u2 = c * at[AT_RATE] + s * at[AT_RATE + 1], c * at[AT_RATE + 1] - s * at[AT_RATE]
    d1 = c * at[AT_RATE_RATE] + s * at[AT_RATE_RATE + 1]
    d2 = c * at[AT_RATE_RATE + 1] - s * at[AT_RATE_RATE]
    frame[SPIN], frame[SPIN + 1], frame[SPIN + 2] = u1, u2, at[AT_RATE + 2] + omega
    frame[PATH_SPIN], frame[PATH_SPIN + 1], frame[PATH_SPIN + 2] = (
        u1, u2, at[AT_RATE + 2] + turning)
    frame[SPIN_RATE] = d1 + omega * u2
    frame[SPIN_RATE + 1] = d2 - omega * u1
    frame[SPIN_RATE + 2] = at[AT_RATE_RATE + 2] + alpha
    frame[VELOCITY], frame[VELOCITY + 1] = at[AT_VELOCITY], at[AT_VELOCITY + 1]
    if drive.kerb_approach != 0.0:
        frame[VELOCITY + 1] -= kerb_offset(t, drive)[1]
    g1, g2, g3 = (drive.down_x - at[AT_ACCELERATION], drive.down_y - at[AT_ACCELERATION + 1],
                  drive.down_z - at[AT_ACCELERATION + 2])
    for i in range(3):
        frame[GRAVITY + i] = (frame[ROTATION + i] * g1 + frame[ROTATION + 3 + i] * g2
                              + frame[ROTATION + 6 + i] * g3)
    frame[HEIGHT] = at[AT_PLACE + 2]
    frame[HEIGHT_RATE] = at[AT_VELOCITY + 2]


@jit
def drive_clamp(t, drive, motion, clamp, basics, frame):
    """
    Move the clamp in the frame record along its circle, or along the polygon of the load steps.

    clamp : (7,)    its position and quaternion at theta = 0
    With load steps the position is linear between points of the circle, and so is the angle of its
    rotation (Fig. 2a of the paper).
    """
    theta = frame[THETA]
    c, s = cos(theta), sin(theta)
    if drive.time_step > 0.0:
        n, part = _load_step_at(t, drive)
        if part > 0.0:
            part, _ = _load_step_ends(t, n, part, drive, motion, basics)
            one, two = basics[0, 0], basics[1, 0]
            theta = one + part * (two - one)
            c, s = _chord_start(n, drive, motion, basics)
            c = (1.0 - part) * c + part * cos(two)
            s = (1.0 - part) * s + part * sin(two)
    frame[CLAMP] = c * clamp[0] - s * clamp[1]
    frame[CLAMP + 1] = s * clamp[0] + c * clamp[1]
    frame[CLAMP + 2] = clamp[2]
    c, s = cos(0.5 * theta), sin(0.5 * theta)
    frame[CLAMP + 3] = c * clamp[3] - s * clamp[6]
    frame[CLAMP + 4] = c * clamp[4] - s * clamp[5]
    frame[CLAMP + 5] = c * clamp[5] + s * clamp[4]
    frame[CLAMP + 6] = c * clamp[6] + s * clamp[3]


@jit
def is_polygon(model):
    """Whether the clamp is driven along the polygon of the load steps; its velocity then jumps."""
    return model.displacement and model.drive.time_step > 0.0


@jit
def turn_frame(frame, cosine, sine, turned):
    """Copy a frame record for the bristle at the azimuth with this cosine and sine: own axes."""
    for row in range(3):
        x, y = frame[ROTATION + 3 * row], frame[ROTATION + 3 * row + 1]
        turned[ROTATION + 3 * row] = cosine * x + sine * y
        turned[ROTATION + 3 * row + 1] = cosine * y - sine * x
        turned[ROTATION + 3 * row + 2] = frame[ROTATION + 3 * row + 2]
    for vector in (SPIN, SPIN_RATE, GRAVITY, PATH_SPIN):
        x, y = frame[vector], frame[vector + 1]
        turned[vector] = cosine * x + sine * y
        turned[vector + 1] = cosine * y - sine * x
        turned[vector + 2] = frame[vector + 2]
    for i in range(VELOCITY, FRAME):
        turned[i] = frame[i]


def new_motion() -> NDArray[np.float64]:
    """Return a motion at rest: every ramp over, at zero."""
    return np.zeros(MOTION)
