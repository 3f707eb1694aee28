"""
The hub of a brush whose drive feels its load: angle and speed are then results of the run.

    J (d omega / dt + the mount's own) = T + tau

J: hub, board and gearbox; T: of the drive; tau: what wires and clamps do to the board, about the
axis. Either of

    motor    T = clamp(stall (omega_0 - omega) / rated, +-stall) - loss omega
    torque   T = command - loss omega

with omega_0 the speed that profile and commands ask for. Within a step the angle is the cubic
through angle and speed at both ends; the acceleration that the wires feel is linear between the
ends' own: a step as short as the integration step sees the ends, and sub-steps a motion that joins
them. How a step's end is found: step/driven.py.
"""
from typing import NamedTuple

from bristle_ros.physics.compiler import jit

# hub record, in the motion: at the start of the present step and at its end
STARTED = 0         # 1  time at the start [s]
LASTS = STARTED + 1  # 1  [s]
START = LASTS + 1   # 4  angle [rad], speed, acceleration, the integrator's own acceleration
END = START + 4     # 4
ACCELERATION = 2    # in these
PSEUDO = 3
COMMAND = END + 4   # 1  [N m] of cmd_drive_torque
TORQUE = COMMAND + 1  # 1  [N m] T at the end of the last step
DRIVE_WORK = TORQUE + 1  # 1  [J] of T since the start
# of the coupling: reactions of the wires [N m] and the accelerations that they came with, at the
# ends of the last two steps, and in the last attempt at the present one
REACTION = DRIVE_WORK + 1  # 6
ADDED = REACTION + 6  # 1  [kg m^2] by how much the reaction falls with the acceleration
OWED = ADDED + 1  # 1  [N m] what the last step left of the balance
ATTEMPTS = OWED + 1  # 1  at the present step
ASKED = ATTEMPTS + 1  # 1  omega_0 at the end of the present step [rad/s]
MOUNT_RATE = ASKED + 1  # 1  of the mount's spin about the brush axis there [rad/s^2]
HUB = MOUNT_RATE + 1

AT_END = 1e-9       # parts of a step: nearer is there


class Hub(NamedTuple):
    """What the drive of a brush is made of, where its speed is not given; SI units."""

    inertia: float      # J [kg m^2]
    loss: float         # [N m s/rad]
    stall: float        # [N m]
    rated: float        # [rad/s]; 0: the torque is commanded
    wires: float        # [kg m^2] of the wires, straight, about the axis


@jit
def drive_torque(hub, asked, command, omega):
    """Return the drive's torque on the brush [N m] and its derivative by omega [N m s/rad]."""
    torque, slope = command, 0.0
    if hub.rated > 0.0:
        torque = hub.stall * (asked - omega) / hub.rated
        slope = -hub.stall / hub.rated
        if abs(torque) > hub.stall:
            torque = hub.stall if torque > 0.0 else -hub.stall
            slope = 0.0
    return torque - hub.loss * omega, slope - hub.loss


@jit
def hub_at(t, motion, at):
    """Return angle, speed and acceleration at time t of the hub record at motion[at:]."""
    part = (t - motion[at + STARTED]) / motion[at + LASTS]
    start, end = at + START, at + END
    if part >= 1.0 - AT_END:
        return motion[end], motion[end + 1], motion[end + ACCELERATION]
    if part <= AT_END:
        return motion[start], motion[start + 1], motion[start + ACCELERATION]
    h = motion[at + LASTS]
    # angle0 + h part (speed0 + part (c + part d)), which ends in angle1 with speed1
    rise = (motion[end] - motion[start]) / h - motion[start + 1]
    change = motion[end + 1] - motion[start + 1]
    c, d = 3.0 * rise - change, change - 2.0 * rise
    return (motion[start] + h * part * (motion[start + 1] + part * (c + part * d)),
            motion[start + 1] + part * (2.0 * c + part * 3.0 * d),
            motion[start + ACCELERATION]
            + part * (motion[end + ACCELERATION] - motion[start + ACCELERATION]))
