"""
Reads ROS 2 parameter files and `-p key:=value` texts as rcl_yaml_param_parser does.

PyYAML's own idea of numbers differs (1e5 is text to it, yes and 1:30 are not what ROS makes of
them), so only its event stream is used: what a scalar means is decided here, as in `get_value` of
rcl_yaml_param_parser/src/parse.c (Jazzy). A key given twice, which rcl overwrites without a
word, is refused.
"""
from collections.abc import Iterator
import re
import sys
from typing import Any, NamedTuple, TypeAlias

import yaml

from .error import SceneError

_TRUE = frozenset('Y y yes Yes YES true True TRUE on On ON'.split())
_FALSE = frozenset('N n no No NO false False FALSE off Off OFF'.split())
# What strtoll(base 0) and strtod of the C library read to the end.
_INTEGER = re.compile(r'\s*([+-]?)(?:(0[xX][0-9a-fA-F]+)|(0[0-7]*)|([1-9][0-9]*))\Z', re.ASCII)
_DECIMAL = re.compile(r'\s*[+-]?(?:\d+\.?\d*|\.\d+)(?:[eE][+-]?\d+)?\Z', re.ASCII)
_HEX = re.compile(
    r'\s*[+-]?0[xX](?:[0-9a-fA-F]+\.?[0-9a-fA-F]*|\.[0-9a-fA-F]+)(?:[pP][+-]?\d+)?\Z', re.ASCII)
_INFINITY = re.compile(r'\s*([+-]?)inf(?:inity)?\Z', re.ASCII | re.IGNORECASE)
_NAN = re.compile(r'\s*[+-]?nan(?:\([0-9a-zA-Z_]*\))?\Z', re.ASCII | re.IGNORECASE)
_DOTTED = {sign + '.' + word: float(sign + 'inf')
           for sign in ('', '+', '-') for word in ('inf', 'Inf', 'INF')}
_DOTTED.update(dict.fromkeys(('.nan', '.NaN', '.NAN'), float('nan')))
_PARAMETERS = 'ros__parameters'
_DEEPEST = 30


Scalar: TypeAlias = bool | int | float | str
Events: TypeAlias = Iterator[Any]   # PyYAML's, which has no types


class Entry(NamedTuple):
    """One key as a file gives it: the node section it stands in, dotted name, value, and line."""

    section: str
    key: str
    value: object
    line: int


def read_scalar(text: str, *, quoted: bool = False) -> Scalar:
    """Return what rcl makes of a scalar: a bool, int, float or str."""
    if quoted:
        return text
    if text in _TRUE or text in _FALSE:
        return text in _TRUE
    number: float | None = _read_integer(text)
    if number is None:
        number = _read_double(text)
    return text if number is None else number


def _read_integer(text: str) -> int | None:
    match = _INTEGER.match(text)
    if match is None or len(text) > 100:
        return None
    sign, hexadecimal, octal, decimal = match.groups()
    size = int(hexadecimal, 16) if hexadecimal else int(octal, 8) if octal else int(decimal)
    value = -size if sign == '-' else size
    # Beyond 64 bits strtoll fails, and strtod reads it.
    return value if -2**63 <= value < 2**63 else None


def _read_double(text: str) -> float | None:
    if text in _DOTTED:
        return _DOTTED[text]
    infinity = _INFINITY.match(text)
    if infinity:
        return float(infinity.group(1) + 'inf')
    if _NAN.match(text):
        return float('nan')
    decimal = _DECIMAL.match(text)
    if decimal is None and _HEX.match(text) is None:
        return None
    try:
        value = float(text) if decimal else float.fromhex(text)
    except OverflowError:
        return None
    # strtod calls overflow and underflow errors, and rcl then keeps the text.
    digits = re.split('[eE]' if decimal else '[pP]', re.sub('0[xX]', '', text))[0]
    vanished = abs(value) < sys.float_info.min and re.search('[1-9a-fA-F]', digits)
    return None if vanished or value in (float('inf'), float('-inf')) else value


def read_text(text: str, source: str) -> Scalar | list[Scalar] | None:
    """Return the value of a `-p key:=value` text: a scalar, a list of one type, or None."""
    value = None
    events = _events(text, source)
    for event in events:
        if isinstance(event, (yaml.ScalarEvent, yaml.SequenceStartEvent)):
            value = _value(event, events, source)
        elif isinstance(event, (yaml.MappingStartEvent, yaml.AliasEvent)):
            raise SceneError(f'{text!r} is not a value: a number, a text or a list', source=source)
    return value


def read_file(content: bytes | str, source: str) -> list[Entry]:
    """Return the Entries of a parameter file's bytes, in order; `source` names it in errors."""
    entries: list[Entry] = []
    events = _events(content, source)
    for event in events:
        if isinstance(event, yaml.MappingStartEvent):
            _sections(events, '', entries, source, 0)
        elif isinstance(event, (yaml.ScalarEvent, yaml.SequenceStartEvent, yaml.AliasEvent)):
            raise _not_parameters(event, source)
    given: dict[tuple[str, str], Entry] = {}
    for entry in entries:
        first = given.setdefault((entry.section, entry.key), entry)
        if first is not entry:
            raise SceneError(f'given twice, first on line {first.line}: keep one of them',
                             key=entry.key, value=entry.value, source=f'{source}:{entry.line}')
    return entries


def _events(content: bytes | str, source: str) -> Events:
    """Yield PyYAML's events, with its many-lined errors turned into one line."""
    try:
        yield from yaml.parse(content, Loader=yaml.SafeLoader)
    except yaml.MarkedYAMLError as error:
        mark = error.problem_mark or error.context_mark
        place = f'{source}:{mark.line + 1}' if mark else source
        raise SceneError(f'not YAML: {error.problem or error.context}', source=place) from None
    except yaml.reader.ReaderError as error:
        raise SceneError(f'not a text file: {error.reason} at position {error.position}; '
                         'save it as UTF-8', source=source) from None


def _sections(events: Events, path: str, entries: list[Entry], source: str, depth: int) -> None:
    """Read the names of nodes, nested or not, down to each one's parameters."""
    for name in _keys(events, source, depth):
        event = next(events)
        here = f'{path}/{name.value}' if path else name.value
        if not isinstance(event, yaml.MappingStartEvent):
            raise _not_parameters(name, source)
        if name.value != _PARAMETERS:
            _sections(events, here, entries, source, depth + 1)
        elif not path:
            raise _not_parameters(name, source)
        else:
            _parameters(events, path, '', entries, source, depth + 1)


def _parameters(events: Events, section: str, prefix: str, entries: list[Entry], source: str,
                depth: int) -> None:
    for name in _keys(events, source, depth):
        event = next(events)
        key = prefix + name.value
        if isinstance(event, yaml.MappingStartEvent):
            _parameters(events, section, key + '.', entries, source, depth + 1)
        else:
            value = _value(event, events, f'{source}:{name.start_mark.line + 1}: {key}')
            entries.append(Entry(section, key, value, name.start_mark.line + 1))


def _keys(events: Events, source: str, depth: int) -> Events:
    """Yield the key events of a mapping; the caller takes each one's value off `events`."""
    for event in events:
        if isinstance(event, yaml.MappingEndEvent):
            return
        place = f'{source}:{event.start_mark.line + 1}'
        if depth > _DEEPEST:
            raise SceneError(f'nested more than {_DEEPEST} deep', source=place)
        if not isinstance(event, yaml.ScalarEvent) or not event.value:
            raise SceneError('a key must be a name', source=place)
        yield event


def _value(event: Any, events: Events, place: str) -> Scalar | list[Scalar] | None:
    if isinstance(event, yaml.AliasEvent):
        raise SceneError('ROS 2 reads no YAML aliases (*): write the value out', source=place)
    if isinstance(event, yaml.ScalarEvent):
        return _scalar(event, place)
    items: list[Scalar] = []
    for item in events:
        if isinstance(item, yaml.SequenceEndEvent):
            return items or None  # rcl sets no value for []
        if not isinstance(item, yaml.ScalarEvent):
            raise SceneError('a list may hold only plain values', source=place)
        items.append(_scalar(item, place))
        if type(items[-1]) is not type(items[0]):
            raise SceneError('a list must hold values of one type for ROS 2 to read it: write '
                             '[1.5, 0.0], not [1.5, 0]', source=place)
    raise SceneError('a list without an end', source=place)


def _scalar(event: Any, place: str) -> Scalar:
    quoted = event.style in ('"', "'")
    if not quoted and not event.value:
        raise SceneError('has no value: give one or leave the key out', source=place)
    return read_scalar(event.value, quoted=quoted or event.tag == 'tag:yaml.org,2002:str')


def _not_parameters(event: Any, source: str) -> SceneError:
    return SceneError(
        "not a ROS 2 parameter file: keys belong under '/**:' and, below it, 'ros__parameters:'",
        source=f'{source}:{event.start_mark.line + 1}')
