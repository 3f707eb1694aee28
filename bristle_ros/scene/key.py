"""What one key of a scene may hold: unit, range and meaning, and the check of a value."""
from collections.abc import Iterable
from dataclasses import dataclass, Field, field
import math
from numbers import Integral, Real
import sys
from typing import Any, get_args, get_origin, Literal, TypeAlias, TypeVar

from .error import SceneError

Kind: TypeAlias = Literal['float', 'int', 'bool', 'str', 'pair', 'numbers', 'counts']
Value: TypeAlias = float | bool | str | tuple[float, ...]
Choice = TypeVar('Choice', bound=str)
Declared = TypeVar('Declared', bound=Value)

_KINDS: dict[Kind, str] = {
    'float': 'a number', 'int': 'a whole number', 'bool': 'true or false', 'str': 'text',
    'pair': 'two numbers', 'numbers': 'a list of numbers',
    'counts': 'a list of whole numbers'}
LISTS = ('pair', 'numbers', 'counts')     # kinds of which each number is within the bounds


@dataclass(frozen=True, kw_only=True)
class Key:
    """
    One key of a scene file, which is also one ROS parameter.

    kind: 'float', 'int', 'bool', 'str', 'pair' (two floats), 'numbers' or 'counts' (any number of
    floats or ints, none at first); minimum, maximum: inclusive, of each number; choices: the texts
    allowed, empty when any is.
    """

    name: str
    kind: Kind
    default: Value
    unit: str
    minimum: float
    maximum: float
    choices: tuple[str, ...]
    description: str

    @property
    def range(self) -> str:  # noqa: A003
        """Say in words what the key accepts, as the error messages do."""
        if self.choices:
            return 'one of ' + ', '.join(self.choices)
        words = _KINDS[self.kind]
        if self.kind not in ('float', 'int', *LISTS):
            return words
        if self.maximum == math.inf:
            bounds = f'at least {self.minimum:.9g}{self._unit} (.inf is allowed)'
        else:
            bounds = f'from {self.minimum:.9g} to {self.maximum:.9g}{self._unit}'
        return f'{words} {bounds}'

    @property
    def _unit(self) -> str:
        return '' if self.unit in ('', '1') else ' ' + self.unit

    def check(self, value: object) -> Value:
        """Return `value` in the key's type; raise SceneError when the key cannot take it."""
        try:
            checked: Value = getattr(self, '_' + self.kind)(value)
            return checked
        except (TypeError, ValueError, OverflowError):
            hint = self._hint(value)
            raise SceneError(f'must be {self.range}{hint}', key=self.name, value=value) from None

    def _hint(self, value: object) -> str:
        # YAML takes on, no, 12 for a truth or a number; a name that reads so needs quotes.
        if self.kind == 'str' and not self.choices and isinstance(value, (bool, Real)):
            return ' (put it in quotes)'
        if self.kind in ('float', 'int') and isinstance(value, str) and _is_number(value):
            return ' (without the quotes)'
        return ''

    def _float(self, value: object) -> float:
        if isinstance(value, bool) or not isinstance(value, Real):
            raise TypeError
        number = float(value)
        if abs(number) < sys.float_info.min:
            number = 0.0  # rcl cannot read what is smaller, and nothing here is
        if not self.minimum <= number <= self.maximum:  # NaN fails too
            raise ValueError
        return number

    def _int(self, value: object) -> int:
        number = self._float(value)
        if number != int(number):
            raise ValueError
        return int(value) if isinstance(value, Integral) else int(number)

    def _bool(self, value: object) -> bool:
        if not isinstance(value, bool):
            raise TypeError
        return value

    def _str(self, value: object) -> str:
        if not isinstance(value, str) or (self.choices and value not in self.choices):
            raise TypeError
        if any(ord(letter) < 32 for letter in value):
            raise ValueError
        return value

    def _pair(self, value: Any) -> tuple[float, float]:
        if isinstance(value, (str, bytes)):
            raise TypeError
        first, second = value
        return self._float(first), self._float(second)

    def _numbers(self, value: Any) -> tuple[float, ...]:
        return tuple(map(self._float, _items(value)))

    def _counts(self, value: Any) -> tuple[int, ...]:
        return tuple(map(self._int, _items(value)))


def _items(value: Any) -> Iterable[object]:
    # rcl makes nothing of [], and hands it on as no value
    if isinstance(value, (str, bytes)):
        raise TypeError
    items: Iterable[object] = () if value is None else value
    return items


def _is_number(value: str) -> bool:
    try:
        return math.isfinite(float(value))
    except ValueError:
        return False


def number(default: float, unit: str, minimum: float, maximum: float, description: str) -> float:
    """Declare a float field of a section."""
    return _field('float', default, unit, minimum, maximum, description)


def count(default: int, minimum: int, maximum: int, description: str) -> int:
    """Declare an integer field of a section."""
    return _field('int', default, '1', minimum, maximum, description)


def switch(default: bool, description: str) -> bool:
    """Declare a boolean field of a section."""
    return _field('bool', default, '', -math.inf, math.inf, description)


def text(default: str, description: str) -> str:
    """Declare a text field of a section."""
    return _field('str', default, '', -math.inf, math.inf, description)


def choice(default: Choice, description: str) -> Choice:
    """Declare a field of a section that takes one of the texts of its type, a Literal."""
    return _field('str', default, '', -math.inf, math.inf, description)


def pair(default: tuple[float, float], unit: str, minimum: float, maximum: float,
         description: str) -> tuple[float, float]:
    """Declare a field of two floats."""
    return _field('pair', default, unit, minimum, maximum, description)


def numbers(unit: str, minimum: float, maximum: float, description: str) -> tuple[float, ...]:
    """Declare a field of any number of floats, none at first."""
    return _field('numbers', (), unit, minimum, maximum, description)


def counts(minimum: int, maximum: int, description: str) -> tuple[int, ...]:
    """Declare a field of any number of integers, none at first."""
    return _field('counts', (), '1', minimum, maximum, description)


def _field(kind: Kind, default: Declared, unit: str, minimum: float, maximum: float,
           description: str) -> Declared:
    return field(default=default, metadata={
        'kind': kind, 'default': default, 'unit': unit, 'minimum': minimum, 'maximum': maximum,
        'description': description})


def key_of(name: str, declared: Field[Any]) -> Key:
    """Make the Key called `name` (dotted) from a field declared with the functions above."""
    choices = get_args(declared.type) if get_origin(declared.type) is Literal else ()
    return Key(name=name, choices=choices, **declared.metadata)
