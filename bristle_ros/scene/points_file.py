"""
Reads points of a curve: CSV of two numbers a line, header optional, the first one increasing.

A text `data:x,z;x,z` holds the points itself: that is how a log carries them.
"""
from collections.abc import Iterable
import csv
import math
from typing import NamedTuple

import numpy as np

from .error import SceneError

MOST_POINTS = 200_000
INLINE = 'data:'
APART = 1e-9        # that the first numbers must be, in their unit


class Points(NamedTuple):
    """What a file of points is for, as its refusals say it."""

    key: str
    what: str
    first: str          # names and units of the numbers
    second: str
    first_unit: str
    largest: float      # that each may be, in its unit


PROFILE = Points('profile.file', 'a profile', 'x', 'z', 'm', 1e6)
SPEEDS = Points('drive.file', 'a table', 't', 'speed', 's', 1e6)


def read_points(path: str, kind: Points) -> tuple[np.ndarray, np.ndarray]:
    """Return the numbers (n,) of each column; raise SceneError with the line that will not do."""
    columns = f'{kind.first},{kind.second}'
    if not path:
        raise SceneError(f'{kind.what} needs one: give a CSV file {columns}', key=kind.key,
                         value=path)
    try:
        if path.startswith(INLINE):
            points = _points(csv.reader(path.removeprefix(INLINE).split(';')), INLINE, kind)
        else:
            with open(path, newline='', encoding='utf-8') as file:
                points = _points(csv.reader(file), path, kind)
    except (OSError, UnicodeDecodeError, csv.Error) as error:
        reason = getattr(error, 'strerror', None) or 'not a CSV file'
        raise _refused(path, kind, f'cannot be read ({reason}): give a CSV file {columns}'
                       ) from None
    if len(points) < 2:
        raise _refused(path, kind, f'holds {len(points)} point{"s" * (len(points) != 1)}: '
                                   f'{kind.what} needs at least two')
    x, z = np.array(points).T
    return np.ascontiguousarray(x), np.ascontiguousarray(z)


def inline(path: str, kind: Points) -> str:
    """Return the text that holds the points of a file itself."""
    x, z = read_points(path, kind)
    return INLINE + ';'.join(f'{a!r},{b!r}' for a, b in zip(x.tolist(), z.tolist()))


def _points(rows: Iterable[list[str]], path: str, kind: Points) -> list[tuple[float, float]]:
    points: list[tuple[float, float]] = []
    for number, row in enumerate(rows, 1):
        point = _point(row)
        if point is None:
            if number == 1 or not any(cell.strip() for cell in row):
                continue    # a header, an empty line
            raise _refused(path, kind, f'line {number}: must be two numbers '
                                       f'{kind.first},{kind.second}')
        _check(point, points, path, number, kind)
        points.append(point)
    return points


def _point(row: list[str]) -> tuple[float, float] | None:
    try:
        x, z = row
        return float(x), float(z)
    except ValueError:
        return None


def _check(point: tuple[float, float], before: list[tuple[float, float]], path: str,
           number: int, kind: Points) -> None:
    name, unit = kind.first, kind.first_unit
    if not all(math.isfinite(value) and abs(value) <= kind.largest for value in point):
        raise _refused(path, kind, f'line {number}: {point[0]:g},{point[1]:g}: must be finite, '
                                   f'within {kind.largest:.0e} {unit}'.replace('e+0', 'e'))
    if before and not point[0] - before[-1][0] >= APART:
        raise _refused(path, kind, f'line {number}: {name} = {point[0]:.9g} does not go on from '
                                   f'{before[-1][0]:.9g}: {name} must increase, by {APART:g} '
                                   f'{unit} at least')
    if len(before) == MOST_POINTS:
        raise _refused(path, kind, f'holds more than {MOST_POINTS} points: leave some out')


def _refused(path: str, kind: Points, problem: str) -> SceneError:
    return SceneError(problem, key=kind.key, value=path)
