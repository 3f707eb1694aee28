"""What one key of a scene may hold: unit, range and meaning, and the check of a value."""
from dataclasses import dataclass, field
import math
from numbers import Integral, Real
import sys

from .error import SceneError

_KINDS = {'float': 'a number', 'int': 'a whole number', 'bool': 'true or false', 'str': 'text',
          'pair': 'two numbers'}


@dataclass(frozen=True, kw_only=True)
class Key:
    """
    One key of a scene file, which is also one ROS parameter.

    kind: 'float', 'int', 'bool', 'str' or 'pair' (two floats); minimum, maximum: inclusive, of
    each number; choices: the texts allowed, empty when any is.
    """

    name: str
    kind: str
    default: object
    unit: str
    minimum: float
    maximum: float
    choices: tuple
    description: str

    @property
    def range(self):  # noqa: A003
        """Say in words what the key accepts, as the error messages do."""
        if self.choices:
            return 'one of ' + ', '.join(self.choices)
        words = _KINDS[self.kind]
        if self.kind not in ('float', 'int', 'pair'):
            return words
        if self.maximum == math.inf:
            bounds = f'at least {self.minimum:.9g}{self._unit} (.inf is allowed)'
        else:
            bounds = f'from {self.minimum:.9g} to {self.maximum:.9g}{self._unit}'
        return f'{words} {bounds}'

    @property
    def _unit(self):
        return '' if self.unit in ('', '1') else ' ' + self.unit

    def check(self, value):
        """Return `value` in the key's type; raise SceneError when the key cannot take it."""
        try:
            return getattr(self, '_' + self.kind)(value)
        except (TypeError, ValueError, OverflowError):
            hint = self._hint(value)
            raise SceneError(f'must be {self.range}{hint}', key=self.name, value=value) from None

    def _hint(self, value):
        # YAML takes on, no, 12 for a truth or a number; a name that reads so needs quotes.
        if self.kind == 'str' and not self.choices and isinstance(value, (bool, Real)):
            return ' (put it in quotes)'
        if self.kind in ('float', 'int') and isinstance(value, str) and _is_number(value):
            return ' (without the quotes)'
        return ''

    def _float(self, value):
        if isinstance(value, bool) or not isinstance(value, Real):
            raise TypeError
        value = float(value)
        if abs(value) < sys.float_info.min:
            value = 0.0  # rcl cannot read what is smaller, and nothing here is
        if not self.minimum <= value <= self.maximum:  # NaN fails too
            raise ValueError
        return value

    def _int(self, value):
        number = self._float(value)
        if number != int(number):
            raise ValueError
        return int(value) if isinstance(value, Integral) else int(number)

    def _bool(self, value):
        if not isinstance(value, bool):
            raise TypeError
        return value

    def _str(self, value):
        if not isinstance(value, str) or (self.choices and value not in self.choices):
            raise TypeError
        if any(ord(letter) < 32 for letter in value):
            raise ValueError
        return value

    def _pair(self, value):
        if isinstance(value, (str, bytes)):
            raise TypeError
        first, second = value
        return self._float(first), self._float(second)


def _is_number(value):
    try:
        return math.isfinite(float(value))
    except ValueError:
        return False


def number(default, unit, minimum, maximum, description):
    """Declare a float field of a section."""
    return _field('float', default, unit, minimum, maximum, description)


def count(default, minimum, maximum, description):
    """Declare an integer field of a section."""
    return _field('int', default, '1', minimum, maximum, description)


def switch(default, description):
    """Declare a boolean field of a section."""
    return _field('bool', default, '', -math.inf, math.inf, description)


def text(default, description):
    """Declare a text field of a section."""
    return _field('str', default, '', -math.inf, math.inf, description)


def choice(default, choices, description):
    """Declare a text field of a section that takes one of a few values."""
    return _field('str', default, '', -math.inf, math.inf, description, choices)


def pair(default, unit, minimum, maximum, description):
    """Declare a field of two floats."""
    return _field('pair', default, unit, minimum, maximum, description)


def _field(kind, default, unit, minimum, maximum, description, choices=()):
    return field(default=default, metadata={
        'kind': kind, 'default': default, 'unit': unit, 'minimum': minimum, 'maximum': maximum,
        'choices': choices, 'description': description})


def key_of(name, declared):
    """Make the Key called `name` (dotted) from a field declared with the functions above."""
    return Key(name=name, **declared.metadata)
