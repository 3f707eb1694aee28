"""
Reads a profile of the road: CSV `x,z` [m], header optional, x increasing.

A text `data:x,z;x,z` holds the points itself: that is how a log carries them.
"""
from collections.abc import Iterable
import csv
import math

import numpy as np

from .error import SceneError

MOST_POINTS = 200_000
INLINE = 'data:'


def read_profile(path: str) -> tuple[np.ndarray, np.ndarray]:
    """Return x and z [m] (n,) of the points; raise SceneError with the line that will not do."""
    if not path:
        raise SceneError('a profile of kind file needs one: give a CSV file x,z',
                         key='profile.file', value=path)
    try:
        if path.startswith(INLINE):
            points = _points(csv.reader(path.removeprefix(INLINE).split(';')), INLINE)
        else:
            with open(path, newline='', encoding='utf-8') as file:
                points = _points(csv.reader(file), path)
    except (OSError, UnicodeDecodeError, csv.Error) as error:
        reason = getattr(error, 'strerror', None) or 'not a CSV file'
        raise _refused(path, f'cannot be read ({reason}): give a CSV file x,z') from None
    if len(points) < 2:
        raise _refused(path, f'holds {len(points)} point{"s" * (len(points) != 1)}: '
                             'a profile needs at least two')
    x, z = np.array(points).T
    return np.ascontiguousarray(x), np.ascontiguousarray(z)


def inline(path: str) -> str:
    """Return the text that holds the points of a file itself."""
    x, z = read_profile(path)
    return INLINE + ';'.join(f'{a!r},{b!r}' for a, b in zip(x.tolist(), z.tolist()))


def _points(rows: Iterable[list[str]], path: str) -> list[tuple[float, float]]:
    points: list[tuple[float, float]] = []
    for number, row in enumerate(rows, 1):
        point = _point(row)
        if point is None:
            if number == 1 or not any(cell.strip() for cell in row):
                continue    # a header, an empty line
            raise _refused(path, f'line {number}: must be two numbers x,z')
        _check(point, points, path, number)
        points.append(point)
    return points


def _point(row: list[str]) -> tuple[float, float] | None:
    try:
        x, z = row
        return float(x), float(z)
    except ValueError:
        return None


def _check(point: tuple[float, float], before: list[tuple[float, float]], path: str,
           number: int) -> None:
    if not all(math.isfinite(value) and abs(value) <= 1e6 for value in point):
        raise _refused(path, f'line {number}: {point[0]:g},{point[1]:g}: must be finite, within '
                             '1e6 m')
    if before and not point[0] - before[-1][0] >= 1e-9:
        raise _refused(path, f'line {number}: x = {point[0]:.9g} does not go on from '
                             f'{before[-1][0]:.9g}: x must increase, by 1e-9 m at least')
    if len(before) == MOST_POINTS:
        raise _refused(path, f'holds more than {MOST_POINTS} points: leave some out')


def _refused(path: str, problem: str) -> SceneError:
    return SceneError(problem, key='profile.file', value=path)
