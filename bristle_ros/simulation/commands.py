"""What may be commanded: the limits of a scene, known before anything is compiled."""
from collections.abc import Iterable
import math
from numbers import Real
from typing import Any, SupportsFloat, TypeAlias

from bristle_ros.scene import carrying_refusal, depth_refusal, Scene

Values: TypeAlias = SupportsFloat | Iterable[SupportsFloat]     # of a command

BRAKING = 'cmd_mount', (0.0,) * 6   # a command, when there have been none for too long
HIGHEST = 10.0  # [m] that a command may lift the brush: what road.penetration may be


class CommandRefused(ValueError):
    """A command that cannot be followed; `str()` is one line with the topic, value and limit."""


def values_of(topic: str, values: Values) -> tuple[float, ...]:
    """Return the values of a command, also a bare number, as a tuple of floats."""
    given: Any = values
    if isinstance(values, Real) or getattr(values, 'ndim', 1) == 0:
        given = values,
    try:
        if any(isinstance(value, (str, bytes)) for value in (given, *given)):
            raise TypeError
        return tuple(float(value) for value in given)
    except (TypeError, ValueError, OverflowError):
        raise CommandRefused(f'{topic}: {values!r}: must be numbers') from None


def _check_drive(scene: Scene, topic: str, value: float) -> None:
    drive = scene.drive
    if topic == 'cmd_brush_speed':
        if drive.mode == 'torque':
            raise CommandRefused(f'{topic}: with drive.mode: torque speed is a result; there is '
                                 'cmd_drive_torque')
        if abs(value) > drive.max_speed:
            raise CommandRefused(f'{topic}: {value:g} rad/s is beyond drive.max_speed = '
                                 f'{drive.max_speed:g} rad/s')
    if topic == 'cmd_drive_torque':
        if drive.mode != 'torque':
            raise CommandRefused(f'{topic}: needs drive.mode: torque, this is {drive.mode}')
        if 0.0 < drive.stall_torque < abs(value):
            raise CommandRefused(f'{topic}: {value:g} N m is beyond drive.stall_torque = '
                                 f'{drive.stall_torque:g} N m')


def check_command(scene: Scene, topic: str, given: Values) -> tuple[float, ...]:
    """Return the values of a command as a tuple; raise CommandRefused where it cannot be."""
    wanted = {'cmd_brush_speed': 1, 'cmd_vel': 3, 'cmd_penetration': 1, 'cmd_drive_torque': 1,
              'cmd_mount': 13}
    if not isinstance(topic, str) or topic not in wanted:
        raise CommandRefused(f'{topic}: no such command; there are {", ".join(wanted)}')
    values = values_of(topic, given)
    if len(values) != wanted[topic] and (topic, values) != BRAKING:
        raise CommandRefused(f'{topic}: {len(values)} values, wants {wanted[topic]}')
    if not all(math.isfinite(value) for value in values):
        raise CommandRefused(f'{topic}: {values} is not finite')
    _check_drive(scene, topic, values[0])
    refusal = carrying_refusal(scene) if topic == 'cmd_mount' else ''
    if refusal:
        raise CommandRefused(f'{topic}: {refusal}')
    if topic == 'cmd_vel':
        if math.hypot(*values[:2]) > scene.sweeper.max_speed:
            raise CommandRefused(
                f'{topic}: {math.hypot(*values[:2]):g} m/s is beyond sweeper.max_speed = '
                f'{scene.sweeper.max_speed:g} m/s')
        if abs(values[2]) > scene.sweeper.max_yaw_rate:
            raise CommandRefused(
                f'{topic}: {values[2]:g} rad/s is beyond sweeper.max_yaw_rate = '
                f'{scene.sweeper.max_yaw_rate:g} rad/s')
    if topic == 'cmd_penetration':
        too_deep = depth_refusal(scene, values[0])
        if too_deep:
            raise CommandRefused(f'{topic}: {values[0]:g} m {too_deep}')
        if values[0] < -HIGHEST:
            raise CommandRefused(f'{topic}: {values[0]:g} m; the brush is lifted by at most '
                                 f'{HIGHEST:g} m (-{HIGHEST:g})')
    return values
