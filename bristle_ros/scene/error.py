"""The one error of unusable input: file, key, value, and what would do, on one line."""
import math
from typing import Any


class SceneError(ValueError):
    """
    Input that cannot be used; `str()` is the one line a user reads.

    problem: what is wrong and what would do; key, value: where in the scene, as it was given;
    source: the file and line, or the option, that gave it. All but the problem may be left out.
    """

    def __init__(self, problem: str, *, key: str = '', value: object = None,
                 source: str = '') -> None:
        """Keep the parts: whoever knows the file adds it with `at`."""
        super().__init__(problem)
        self.problem = problem
        self.key = key
        self.value = value
        self.source = source

    def __reduce__(self) -> tuple[Any, ...]:
        """Keep the parts when the error crosses a process border."""
        return SceneError, (self.problem,), self.__dict__

    def __str__(self) -> str:
        """Put the parts on one line."""
        given = '' if self.value is None else f' = {spell(self.value)}'
        parts = [self.source, self.key + given, self.problem]
        return ': '.join(' '.join(part.split()) for part in parts if part)

    def at(self, source: object) -> 'SceneError':
        """Return the error with `source` filled in, where it has none yet."""
        return SceneError(
            self.problem, key=self.key, value=self.value, source=self.source or str(source))


def spell(value: object) -> str:
    """Write a value as a scene file spells it."""
    if isinstance(value, bool):
        return 'true' if value else 'false'
    if isinstance(value, float):
        return _spell_float(float(value))
    if isinstance(value, str):
        return _spell_text(value)
    if hasattr(value, '__iter__') and not isinstance(value, (bytes, dict)):
        return '[' + ', '.join(spell(item) for item in value) + ']'
    return repr(value)


def _spell_float(value: float) -> str:
    if not math.isfinite(value):
        return '.nan' if math.isnan(value) else '.inf' if value > 0 else '-.inf'
    spelling = repr(value)
    if 'e' in spelling and '.' not in spelling:
        # Readers of YAML 1.1 take 1e-05 for text; rcl and ours take both.
        spelling = spelling.replace('e', '.0e')
    return spelling


def _spell_text(value: str) -> str:
    escapes = {'\\': '\\\\', '"': '\\"', '\n': '\\n', '\t': '\\t', '\r': '\\r'}
    return '"' + ''.join(
        escapes.get(letter) or (letter if letter.isprintable() else f'\\U{ord(letter):08x}')
        for letter in value) + '"'
