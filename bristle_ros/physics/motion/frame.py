"""
Motion of the brush frame: what the bristle feels of the brush, the sweeper and the road.

Whatever moves the brush, the bristle sees six 3-vectors in its own axes, the orientation of those
axes and the height of the mount above the road (a frame record). Orientation, brush to road:

    R = Rz(heading) Rz(tilt azimuth) Ry(attack angle) Rz(-tilt azimuth) Rz(theta)

`motion` holds the ramps that commands change; `Drive` what stays.
"""
from math import cos, sin

from bristle_ros.physics.compiler import jit
import numpy as np
from numpy.typing import NDArray

from .carried import (AT_ACCELERATION, AT_PLACE, AT_RATE, AT_RATE_RATE, AT_ROTATION, AT_VELOCITY,
                      CARRIED, carried_at)
from .loads import clamp_turn, loads_at
from .records import (CARRY, CLAMP, DRAG_RATE, DRAG_SPIN, FRAME, GRAVITY, HEIGHT, HEIGHT_RATE,
                      MOTION, PATH_SPIN, ROTATION, SPIN, SPIN_RATE, THETA, VELOCITY)


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
    With load steps (time_step > 0) the loads are linear between multiples of time_step; THETA and
    OMEGA stay exact.
    """
    turning, yawing, rising = loads_at(t, drive, motion, basics, frame)
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
    ch, sh = 1.0, 0.0
    if heading != 0.0:
        ch, sh = cos(heading), sin(heading)
    front = heading + drive.tilt_azimuth
    cf, sf = ch, sh
    if drive.tilt_azimuth != 0.0:
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
    """
    theta, c, s = clamp_turn(t, drive, motion, basics, frame[THETA])
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
