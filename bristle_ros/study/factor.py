"""One key that a study varies: its values in a grid, and what a number from 0 to 1 stands for."""
import json
import math
from typing import NamedTuple

from bristle_ros.scene import SceneError


class Factor(NamedTuple):
    """
    A varied key.

    values : tuple of what it takes, or None where it is a range `low` to `high`
    count : of a range, in a grid;  log : whether a range is even in the logarithm
    whole : whether only whole numbers will do
    """

    key: str
    values: tuple | None
    low: float = 0.0
    high: float = 0.0
    count: int = 0
    log: bool = False
    whole: bool = False

    @property
    def size(self):
        """How many values it has in a grid."""
        return len(self.values) if self.values is not None else self.count

    @property
    def is_number(self):
        """Whether it is a number in every row."""
        return self.values is None or all(
            isinstance(value, (int, float)) and not isinstance(value, bool)
            for value in self.values)

    def at(self, place):
        """Return the value for a number from 0 to 1, both included."""
        if self.values is not None:
            return self.values[min(int(place * len(self.values)), len(self.values) - 1)]
        if self.log:
            value = math.exp(math.log(self.low) + place * math.log(self.high / self.low))
        else:
            value = self.low + place * (self.high - self.low)
        value = min(max(value, self.low), self.high)
        return round(value) if self.whole else value

    def in_grid(self, number):
        """Return the value number 0 to size - 1 of a grid."""
        if self.values is not None:
            return self.values[number]
        return self.at(number / (self.count - 1) if self.count > 1 else 0.0)

    def column(self, value):
        """Return a value as a table keeps it: a number, a truth, or text."""
        return json.dumps(list(value)) if isinstance(value, (list, tuple)) else value


def read_factor(key, given, design, source):
    """Make the Factor of a Key from what the study file gives for it; raise SceneError."""
    def refuse(problem, value=given):
        raise SceneError(problem, key=f'vary.{key.name}', value=value, source=source)

    if isinstance(given, list):
        if not given:
            refuse('has no values')
        try:
            values = tuple(key.check(value) for value in given)
        except SceneError as error:
            raise SceneError(error.problem, key=f'vary.{key.name}', value=error.value,
                             source=source) from None
        if len(set(values)) < len(values):
            refuse('has a value twice')
        return Factor(key.name, values)
    if not isinstance(given, dict):
        refuse('must be a list of values, or {from: a, to: b}')
    wanted = {'from', 'to', 'scale'} | ({'count'} if design == 'grid' else set())
    for name in given:
        if name not in wanted:
            refuse('count is for a grid: samples says how many rows there are' if name == 'count'
                   else f'must hold {", ".join(sorted(wanted))}', name)
    if key.kind not in ('float', 'int'):
        refuse(f'{key.name} is no number: give a list of values')
    ends = []
    for name in ('from', 'to'):
        if name not in given:
            refuse(f'has no {name}')
        try:
            ends.append(key.check(given[name]))
        except SceneError as error:
            raise SceneError(error.problem, key=f'vary.{key.name}.{name}', value=given[name],
                             source=source) from None
    low, high = ends
    if not low < high < math.inf:
        refuse('is an empty range, or has no end: give from < to')
    scale = given.get('scale', 'linear')
    if scale not in ('linear', 'log'):
        refuse('scale must be linear or log', scale)
    if scale == 'log' and low <= 0.0:
        refuse('a log scale needs from above 0', low)
    count = given.get('count', 0)
    if design == 'grid' and not (type(count) is int and count >= 2):
        refuse('count must be a whole number of at least 2', count)
    return Factor(key.name, None, float(low), float(high), count, scale == 'log',
                  key.kind == 'int')
