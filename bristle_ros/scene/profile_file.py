"""Reads a profile of the road: CSV `x,z` [m], header optional, x increasing."""
import csv
import math

import numpy as np

from .error import SceneError

MOST_POINTS = 200_000


def read_profile(path: str) -> tuple[np.ndarray, np.ndarray]:
    """Return x and z [m] (n,) of the points; raise SceneError with the line that will not do."""
    if not path:
        raise SceneError('a profile of kind file needs one: give a CSV file x,z',
                         key='profile.file', value=path)
    points: list[tuple[float, float]] = []
    try:
        with open(path, newline='', encoding='utf-8') as file:
            for number, row in enumerate(csv.reader(file), 1):
                point = _point(row)
                if point is None:
                    if number == 1 or not any(cell.strip() for cell in row):
                        continue    # a header, an empty line
                    raise _refused(path, f'line {number}: must be two numbers x,z')
                _check(point, points, path, number)
                points.append(point)
    except (OSError, UnicodeDecodeError, csv.Error) as error:
        reason = getattr(error, 'strerror', None) or 'not a CSV file'
        raise _refused(path, f'cannot be read ({reason}): give a CSV file x,z') from None
    if len(points) < 2:
        raise _refused(path, f'holds {len(points)} point{"s" * (len(points) != 1)}: '
                             'a profile needs at least two')
    x, z = np.array(points).T
    return np.ascontiguousarray(x), np.ascontiguousarray(z)


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
