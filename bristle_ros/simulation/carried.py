"""
A mount that is carried: from a command to the segment of its way, and what is refused of it.

The way is a cubic in position, and in the rotation vector from where it starts, that has the
commanded place and velocity at its end (physics/motion/carried.py). Without a command the velocity
stays, straight and about one axis; braking is a segment of its own.
"""
import math
from typing import NamedTuple

from bristle_ros.physics.motion import (AT_ACCELERATION, AT_PLACE, AT_RATE, AT_RATE_RATE,
                                        AT_ROTATION, AT_VELOCITY, CARRIED, CARRIED_AT,
                                        carried_at as compiled_carried_at, CARRY, CUBIC, FROM,
                                        jacobian_factors as compiled_factors, MOVES, SEGMENT,
                                        SINCE, TURNS, VECTOR)
from bristle_ros.scene import Scene, widest
import numpy as np
from numpy.typing import NDArray

from .commands import CommandRefused

Floats = NDArray[np.float64]

carried_at = getattr(compiled_carried_at, 'py_func', compiled_carried_at)
factors = getattr(compiled_factors, 'py_func', compiled_factors)

PARTS = 16      # of a way, at whose ends it is held against the limits
UNIT = 1e-2     # that a quaternion's length may be off by


class MountState(NamedTuple):
    """Where the mount is and how it moves."""

    position: Floats        # [m] (3,) road axes
    velocity: Floats        # [m/s] (3,) road axes
    rotation: Floats        # (3, 3) mount axes to road axes
    rate: Floats            # [rad/s] (3,) mount axes


def is_carried(motion: Floats) -> bool:
    """Return whether a first command has come."""
    return bool(motion[CARRY + CARRIED])


def state_at(t: float, motion: Floats) -> MountState:
    """Return the MountState at t [s] of a mount that is carried."""
    at = _look(t, motion[CARRY:CARRY + SEGMENT])
    return MountState(at[AT_PLACE:AT_PLACE + 3], at[AT_VELOCITY:AT_VELOCITY + 3],
                      at[AT_ROTATION:AT_ROTATION + 9].reshape(3, 3), at[AT_RATE:AT_RATE + 3])


def _look(t: float, segment: Floats) -> Floats:
    at = np.zeros(CARRIED_AT)
    carried_at(t, segment, 0, at)
    return at


def target_of(values: tuple[float, ...]) -> MountState:
    """
    Return what a cmd_mount asks for; raise CommandRefused.

    values : x, y, z [m], quaternion x, y, z, w, road axes; linear [m/s] and angular velocity
    [rad/s], mount axes
    """
    x, y, z, w = values[3:7]
    length = math.sqrt(x * x + y * y + z * z + w * w)
    if abs(length - 1.0) > UNIT:
        raise CommandRefused(f'cmd_mount: a quaternion of length {length:.6g}: give one of 1')
    x, y, z, w = x / length, y / length, z / length, w / length
    rotation = np.array((
        (1.0 - 2.0 * (y * y + z * z), 2.0 * (x * y - z * w), 2.0 * (x * z + y * w)),
        (2.0 * (x * y + z * w), 1.0 - 2.0 * (x * x + z * z), 2.0 * (y * z - x * w)),
        (2.0 * (x * z - y * w), 2.0 * (y * z + x * w), 1.0 - 2.0 * (x * x + y * y))))
    return MountState(np.array(values[:3]), rotation @ values[7:10], rotation,
                      np.array(values[10:13]))


def quaternion_of(rotation: Floats) -> tuple[float, float, float, float]:
    """Return the quaternion x, y, z, w, w >= 0, of a rotation matrix (3, 3)."""
    m = rotation.tolist()
    # the largest of the four first: no division by a small one (Shepperd 1978)
    squares = (m[0][0] - m[1][1] - m[2][2], m[1][1] - m[0][0] - m[2][2],
               m[2][2] - m[0][0] - m[1][1], m[0][0] + m[1][1] + m[2][2])
    largest = squares.index(max(squares))
    first = 0.5 * math.sqrt(1.0 + squares[largest])
    scale = 0.25 / first
    sums = {(0, 1): m[0][1] + m[1][0], (0, 2): m[0][2] + m[2][0], (1, 2): m[1][2] + m[2][1],
            (0, 3): m[2][1] - m[1][2], (1, 3): m[0][2] - m[2][0], (2, 3): m[1][0] - m[0][1]}
    parts = [first if i == largest else scale * sums[min(i, largest), max(i, largest)]
             for i in range(4)]
    sign = math.copysign(1.0, parts[3])
    x, y, z, w = (sign * part for part in parts)
    return x, y, z, w


def rotation_vector(rotation: Floats) -> Floats:
    """Return the vector (3,) whose exponential is a rotation matrix (3, 3)."""
    x, y, z, w = quaternion_of(rotation)
    half = math.sqrt(x * x + y * y + z * z)
    # angle / sin(angle / 2) by the arc tangent; 2 where both vanish
    scale = 2.0 * math.atan2(half, w) / half if half > 1e-12 else 2.0
    return scale * np.array((x, y, z))


def way_to(now: float, state: MountState, target: MountState, duration: float) -> Floats:
    """Return the segment that begins at `now` in `state` and has `target` `duration` [s] later."""
    segment = np.zeros(SEGMENT)
    segment[CARRIED], segment[SINCE] = 1.0, now
    segment[MOVES] = segment[TURNS] = duration
    rho = rotation_vector(state.rotation.T @ target.rotation)
    # rho' at the end: the inverse of J (as in physics/motion/carried.py) times the rate
    square = float(rho @ rho)
    a, b, _, _, _ = factors(square)
    c = (1.0 - 0.5 * a / b) / square if square > 1e-4 else 1.0 / 12.0 + square / 720.0
    once = np.cross(rho, target.rate)
    growth = target.rate + 0.5 * once + c * np.cross(rho, once)
    cubic = segment[CUBIC:CUBIC + 12].reshape(4, 3)
    cubic[0], cubic[1] = state.position, state.velocity
    cubic[2], cubic[3] = _cubic(target.position - state.position, state.velocity,
                                target.velocity, duration)
    segment[FROM:FROM + 9] = state.rotation.ravel()
    vector = segment[VECTOR:VECTOR + 9].reshape(3, 3)
    vector[0] = state.rate
    vector[1], vector[2] = _cubic(rho, state.rate, growth, duration)
    return segment


def _cubic(way: Floats, first: Floats, last: Floats, duration: float) -> tuple[Floats, Floats]:
    """Return the factors of tau^2 and tau^3 of a cubic with these velocities at its ends."""
    return ((3.0 * way - duration * (2.0 * first + last)) / duration ** 2,
            (duration * (first + last) - 2.0 * way) / duration ** 3)


def brake(now: float, state: MountState, scene: Scene) -> Floats:
    """Return the segment that brakes to a stand, in whole steps."""
    segment = np.zeros(SEGMENT)
    segment[CARRIED], segment[SINCE] = 1.0, now
    segment[CUBIC:CUBIC + 6] = *state.position, *state.velocity
    segment[FROM:FROM + 9] = state.rotation.ravel()
    segment[VECTOR:VECTOR + 3] = state.rate
    its = scene.solver.integration_time_step
    for lasts, at, speed, limit in (
            (MOVES, CUBIC + 3, state.velocity, scene.sweeper.max_acceleration),
            (TURNS, VECTOR, state.rate, scene.sweeper.max_yaw_acceleration)):
        duration = math.ceil(float(np.linalg.norm(speed)) / limit / its - 1e-9) * its
        segment[lasts] = duration
        if duration > 0.0:
            segment[at + 3:at + 6] = -0.5 * speed / duration
    return segment


def check_way(scene: Scene, segment: Floats) -> None:
    """Raise CommandRefused where a way is beyond the limits, or brings a clamp to the road."""
    mount, deepest = scene.mount, widest(scene)
    rows = np.array([_look(segment[SINCE] + part / PARTS * segment[MOVES], segment)
                     for part in range(PARTS + 1)])
    for at, limit, name, unit in (
            (AT_VELOCITY, mount.max_speed, 'max_speed', 'm/s'),
            (AT_RATE, mount.max_rate, 'max_rate', 'rad/s'),
            (AT_ACCELERATION, mount.max_acceleration, 'max_acceleration', 'm/s^2'),
            (AT_RATE_RATE, mount.max_angular_acceleration, 'max_angular_acceleration',
             'rad/s^2')):
        worst = float(np.linalg.norm(rows[:, at:at + 3], axis=1).max())
        if not worst <= limit:
            raise CommandRefused(f'cmd_mount: the way there needs {worst:.6g} {unit}, beyond '
                                 f'mount.{name} = {limit:g} {unit}')
    if scene.contact.enabled:
        lean = np.hypot(rows[:, AT_ROTATION + 6], rows[:, AT_ROTATION + 7])
        lowest = float((rows[:, AT_PLACE + 2] - deepest * lean).min())
        if not lowest > 0.0:
            raise CommandRefused(f'cmd_mount: would bring a clamp to the road or below it, by '
                                 f'{-lowest:.6g} m: keep the mount higher')
