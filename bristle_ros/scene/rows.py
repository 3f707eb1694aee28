"""Rows of bristles on one brush: what each has of its own, and what follows for all of them."""
from dataclasses import dataclass
import math
from typing import Any, TYPE_CHECKING

from .error import SceneError

if TYPE_CHECKING:
    from .scene import Scene

# the list of the rows: the key of the one value that holds where it is left out
ONE_VALUE = {
    'row_radii': 'brush.mount_radius', 'row_angles': 'brush.mount_angle',
    'row_lengths': 'bristle.length', 'row_orientations': 'brush.mount_orientation',
    'row_counts': 'brush.bristle_count', 'row_offsets': ''}


@dataclass(frozen=True)
class Row:
    """A circle of bristles, all alike; lengths in m, angles in rad."""

    radius: float
    angle: float
    length: float
    orientation: float
    count: int
    offset: float       # azimuth of its first bristle, from that of the brush's first one

    @property
    def azimuths(self) -> list[float]:
        """Return the azimuth of each bristle [rad], from that of the brush's first one."""
        return [self.offset + 2.0 * math.pi * i / self.count for i in range(self.count)]

    @property
    def tip_radius(self) -> float:
        """Return how far the undeformed tips are from the axis [m]."""
        return self.radius + self.length * math.sin(self.angle)

    @property
    def tip_depth(self) -> float:
        """Return how far the undeformed tips are below the mount centre, along the axis [m]."""
        return self.length * math.cos(self.angle)


def brush_rows(scene: 'Scene') -> tuple[Row, ...]:
    """Return the rows of a scene's brush; bristles are numbered row by row."""
    brush = scene.brush
    sizes = [len(getattr(brush, name)) for name in ONE_VALUE]
    ones = (brush.mount_radius, brush.mount_angle, scene.bristle.length, brush.mount_orientation,
            brush.bristle_count, 0.0)
    columns: list[Any] = [getattr(brush, name) or (one,) * max(1, *sizes)
                          for name, one in zip(ONE_VALUE, ones)]
    return tuple(Row(*values) for values in zip(*columns))


def bristle_count(scene: 'Scene') -> int:
    """Return how many bristles are simulated, those of all rows."""
    return sum(row.count for row in brush_rows(scene))


def longest(scene: 'Scene') -> float:
    """Return the length of the longest bristle [m]."""
    return max(row.length for row in brush_rows(scene))


def widest(scene: 'Scene') -> float:
    """Return the radius of the widest circle of clamps [m]."""
    return max(row.radius for row in brush_rows(scene))


def reach(scene: 'Scene') -> float:
    """Return how far the farthest undeformed tip is from the axis [m]."""
    return max(row.tip_radius for row in brush_rows(scene))


def tip_depth(scene: 'Scene') -> float:
    """Return how far below the mount centre the lowest undeformed tip is, along the normal [m]."""
    cosine, sine = math.cos(scene.road.attack_angle), math.sin(scene.road.attack_angle)
    return max(row.tip_depth * cosine + row.tip_radius * sine for row in brush_rows(scene))


def check_rows(brush: Any, most: int) -> None:
    """Raise SceneError where the lists of a Brush section do not fit together."""
    given = {name: getattr(brush, name) for name in ONE_VALUE if getattr(brush, name)}
    if not given:
        return
    first, values = next(iter(given.items()))
    for name, others in given.items():
        if len(others) != len(values):
            raise SceneError(f'{_rows(len(others))}, but brush.{first} has {len(values)}: give '
                             'one entry a row', key=f'brush.{name}', value=others)
    if brush.row_offsets and brush.row_offsets[0] != 0.0:
        raise SceneError('offsets are counted from the first bristle of the first row: begin with '
                         '0.0, and turn the brush by brush.start_angle', key='brush.row_offsets',
                         value=brush.row_offsets)
    total = sum(brush.row_counts) if brush.row_counts else len(values) * brush.bristle_count
    if total > most:
        key = 'row_counts' if brush.row_counts else 'bristle_count'
        raise SceneError(f'{total} bristles in all: give at most {most}', key=f'brush.{key}',
                         value=getattr(brush, key))


def _rows(number: int) -> str:
    return f'{number} row' + 's' * (number != 1)
