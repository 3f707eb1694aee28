"""Which node the arguments of a node make, and which sections of a parameter file are for it."""
from collections.abc import Container, Iterable, Iterator
import re

from .error import SceneError

_NAMES = ('__node', '__name')
_NAMESPACE = '__ns',


def full_name(arguments: Iterable[str], name: str) -> str:
    """
    Return the fully qualified name that rcl gives a node that calls itself `name`.

    arguments : of the process; `-r __ns:=/left` and `-r __node:=front` after --ros-args count. As
    in rcl, of several rules the first that fits wins; one that begins with `NODE:` is for the node
    of that name, which for a namespace is the name after renaming.
    """
    rules = [_rule(word) for flag, word in ros_arguments(arguments) if flag in ('-r', '--remap')]

    def find(kinds: Container[str], node: str, default: str) -> str:
        return next((new for of, kind, new in rules if kind in kinds and of in ('', node)),
                    default)

    name = find(_NAMES, name, name)
    return f'{find(_NAMESPACE, name, "").rstrip("/")}/{name}'


def matches(section: str, node: str) -> bool:
    """
    Return whether a section of a parameter file is for the node, by rcl's rules.

    node : str, fully qualified. In the section, `*` stands for one name of the path and `**` for
    any number of them; a leading slash may be left out.
    """
    parts = section.strip('/').split('/')
    pattern = ''.join({'*': r'/\w+', '**': r'(?:/\w+)*'}.get(part) or '/' + re.escape(part)
                      for part in parts)
    return re.fullmatch(pattern, node, re.ASCII) is not None


def ros_arguments(arguments: Iterable[str]) -> Iterator[tuple[str, str]]:
    """Yield (flag, word) of the flags between --ros-args and `--` that a scene can depend on."""
    ours = False
    words = iter(arguments)
    for word in words:
        if word in ('--ros-args', '--'):
            ours = word == '--ros-args'
        elif ours and word in ('-p', '--param', '-r', '--remap', '--params-file'):
            yield word, next(words, '')


def split_override(text: str) -> tuple[str, str, str]:
    """Return (node or '', key, value) of `-p [node:]key:=value`; raise SceneError."""
    rule, assigned, value = text.partition(':=')
    node, _, key = rule.rpartition(':')
    if not assigned or not key:
        raise SceneError(f'{rule!r} is not an override: write -p key:=value', source='-p')
    return node, key, value


def _rule(word: str) -> tuple[str, str, str]:
    old, _, new = word.partition(':=')
    node, _, kind = old.rpartition(':')
    return node, kind, new
