"""
What to simulate: a Scene, from a ROS 2 parameter file or from a node's parameters, fully checked.

Keys, ranges and meanings: sections.py. Spelling of values in YAML: parameter_file.py. A scene
that exists can be used: every check raises SceneError, one line with file, key, value and what
would do.
"""
from collections.abc import Iterable, Mapping
from dataclasses import dataclass, field, fields, replace
import difflib
import math
from numbers import Real
import os
from typing import Any, get_type_hints, TypeAlias

from .error import SceneError, spell
from .key import Key, key_of, number
from .machine import check_drive, check_mount
from .names import full_name, matches, ros_arguments, split_override
from .parameter_file import Entry, read_file, read_text
from .presets import PRESET, PRESETS
from .rows import ONE_VALUE, tip_depth, widest
from .sections import (Air, Bristle, Brush, Contact, Damping, Drive, Friction, Log, Mount, Road,
                       Run, SceneSection, Solver, Sweeper, WITH_TABLE)
from .surface import check_surface, Gutter, Profile

__all__ = ['SceneError', 'Scene', 'Bristle', 'Brush', 'Road', 'Contact', 'Friction', 'Damping',
           'Air', 'Drive', 'Gutter', 'Mount', 'Profile', 'Sweeper', 'Solver', 'Run', 'Log', 'load',
           'from_parameters', 'from_arguments', 'keys', 'depth_refusal', 'describe_keys',
           'gutter_friction', 'steps', 'to_yaml', 'to_parameters', 'with_contents']

# Parameters that every ROS 2 node has beside its own.
_OF_EVERY_NODE = ('use_sim_time', 'start_type_description_service')
_NODE = 'brush_node'
_FILES = ('profile.file', 'drive.file')     # keys that name a file
Parameter: TypeAlias = float | bool | str | list[float]
Given: TypeAlias = dict[str, tuple[object, str]]    # dotted key to value, and what gave it
LONGEST = 2.0**31 - 1.0     # [s] of simulated time: what a stamp of ROS holds


@dataclass(frozen=True, kw_only=True)
class Scene:
    """Everything a run depends on. Immutable, comparable, made of plain Python values."""

    bristle: Bristle = field(default_factory=Bristle)
    brush: Brush = field(default_factory=Brush)
    road: Road = field(default_factory=Road)
    gutter: Gutter = field(default_factory=Gutter)
    profile: Profile = field(default_factory=Profile)
    contact: Contact = field(default_factory=Contact)
    friction: Friction = field(default_factory=Friction)
    damping: Damping = field(default_factory=Damping)
    air: Air = field(default_factory=Air)
    gravity: float = number(9.81, 'm/s^2', 0.0, 1000.0, 'along the road normal; 0: none')
    drive: Drive = field(default_factory=Drive)
    sweeper: Sweeper = field(default_factory=Sweeper)
    mount: Mount = field(default_factory=Mount)
    solver: Solver = field(default_factory=Solver)
    run: Run = field(default_factory=Run)
    log: Log = field(default_factory=Log)

    def __post_init__(self) -> None:
        """Check what no section can check alone; raise SceneError."""
        object.__setattr__(self, 'gravity', _KEYS['gravity'].check(self.gravity))
        _check_combinations(self)


def _check_combinations(scene: Scene) -> None:
    friction, contact, drive = scene.friction, scene.contact, scene.drive
    _check_rows(scene)
    if friction.kinetic > friction.static:
        raise SceneError(
            f'kinetic friction above friction.static = {spell(friction.static)}: lower it to that '
            'or raise friction.static', key='friction.kinetic', value=friction.kinetic)
    if contact.normal_stiffness == math.inf and contact.damping > 0.0:
        raise SceneError(
            'a rigid road (contact.normal_stiffness = .inf) has no penetration to damp: set it to '
            '0.0 or give a finite stiffness', key='contact.damping', value=contact.damping)
    too_deep = depth_refusal(scene, scene.road.penetration)
    if too_deep:
        raise SceneError(too_deep, key='road.penetration', value=scene.road.penetration)
    if contact.enabled:
        check_surface(scene.gutter, scene.profile)
        _check_gutter_friction(scene)
    if drive.profile == 'table':
        from .drive_table import speed_table  # with numpy, which most scenes need not
        speed_table(drive)
    check_drive(scene)
    check_mount(scene)
    if abs(drive.mean_speed) > drive.max_speed:
        raise SceneError(
            f'beyond drive.max_speed = {spell(drive.max_speed)} rad/s: lower it or raise that',
            key='drive.mean_speed', value=drive.mean_speed)
    if math.hypot(*scene.sweeper.velocity) > scene.sweeper.max_speed:
        raise SceneError(
            f'faster than sweeper.max_speed = {spell(scene.sweeper.max_speed)} m/s: lower it or '
            'raise the limit', key='sweeper.velocity', value=scene.sweeper.velocity)
    if scene.run.frame_prefix.startswith('/'):
        raise SceneError('tf2 knows no frames that begin with /: leave it out',
                         key='run.frame_prefix', value=scene.run.frame_prefix)
    if 0.0 < scene.log.max_size < 0.1:
        raise SceneError('too small to split a log by: give 0.1 or more, or 0 for one file',
                         key='log.max_size', value=scene.log.max_size)
    if scene.log.max_size > 0.0 and scene.log.path.endswith('.mcap'):
        raise SceneError('needs a directory, which log.path is when it does not end in .mcap',
                         key='log.max_size', value=scene.log.max_size)
    if scene.run.max_load > 0.0 and scene.solver.step != 'adaptive':
        raise SceneError('fixed steps have no budget: give solver.step: adaptive',
                         key='run.max_load', value=scene.run.max_load)
    if scene.solver.time_step > 0.0:
        steps(scene, scene.solver.time_step, 'solver.time_step')
    steps(scene, scene.run.chunk, 'run.chunk')
    steps(scene, scene.run.sample, 'run.sample')


def _check_rows(scene: Scene) -> None:
    """Refuse one value for all rows that a list of the rows' own would hide."""
    values = to_parameters(scene)
    for name, one in ONE_VALUE.items():
        if one and getattr(scene.brush, name) and values[one] != _KEYS[one].default:
            raise SceneError(f'brush.{name} has one for each row: leave this out', key=one,
                             value=values[one])


def _check_gutter_friction(scene: Scene) -> None:
    static, kinetic, _ = gutter_friction(scene)
    if scene.gutter.enabled and kinetic > static:
        raise SceneError(
            f'kinetic friction above the static one of the gutter, {spell(static)}: lower it to '
            'that or raise gutter.friction_static', key='gutter.friction_kinetic',
            value=scene.gutter.friction_kinetic)


def gutter_friction(scene: Scene) -> tuple[float, float, float]:
    """Return mu_s, mu_k and c_v [s/m] of channel and kerb: their own, or the road's."""
    road, own = scene.friction, scene.gutter
    return (road.static if own.friction_static < 0.0 else own.friction_static,
            road.kinetic if own.friction_kinetic < 0.0 else own.friction_kinetic,
            road.decay if own.friction_decay < 0.0 else own.friction_decay)


def depth_refusal(scene: Scene, penetration: float) -> str | None:
    """
    Return why the road cannot be at this penetration [m], or None where it can.

    At tip depth - radius sin(attack_angle) of the widest row the lowest clamp is in the road.
    Lifting is fine.
    """
    if not scene.contact.enabled:
        return None
    deepest = tip_depth(scene) - widest(scene) * math.sin(scene.road.attack_angle)
    if penetration < deepest:
        return None
    return (f'would bring a clamp to the road or below it: stay below {deepest:.6g} m, which is '
            'how far the lowest undeformed tip is below its clamp')


def steps(scene: Scene | float, seconds: float, key: str) -> int:
    """
    Return how many integration steps `seconds` are.

    scene : Scene, or the integration time step itself [s]
    key : str, names the value in the error
    Raises SceneError, naming the nearest good value, unless it is a whole number >= 1 of them (to
    1e-9 relative).
    """
    its = scene.solver.integration_time_step if isinstance(scene, Scene) else float(scene)
    if not (isinstance(seconds, Real) and 0.0 < seconds < math.inf):
        raise SceneError('must be a time above 0 s', key=key, value=seconds)
    if seconds > LONGEST:
        raise SceneError(f'must be a time of at most {LONGEST:.0f} s, which is what stamps hold',
                         key=key, value=seconds)
    seconds = float(seconds)
    whole = max(1, round(seconds / its))
    if abs(seconds - whole * its) > 1e-9 * seconds:
        raise SceneError(
            f'not a whole multiple of solver.integration_time_step = {spell(its)} s: the nearest '
            f'is {spell(float(f"{whole * its:.12g}"))}', key=key, value=seconds)
    return whole


def _all_keys() -> dict[str, Key]:
    found: list[Key] = []
    for item in fields(Scene):
        if item.metadata:
            found.append(key_of(item.name, item))
        else:
            found.extend(_SECTIONS[item.name].keys())
    return {key.name: key for key in found}


_SECTIONS: dict[str, type[SceneSection]] = {
    name: kind for name, kind in get_type_hints(Scene).items()
    if isinstance(kind, type) and issubclass(kind, SceneSection)}
_KEYS = _all_keys()
_READ = {**_KEYS, PRESET.name: PRESET}     # what files and -p may have


def keys() -> tuple[Key, ...]:
    """Return every Key of a scene in file order; ROS parameters are declared from them."""
    return tuple(_KEYS.values())


def describe_keys() -> str:
    """Return the text of `scene --keys`: each key with default, unit, range and meaning."""
    lines = []
    for key in _READ.values():
        unit = f' [{key.unit}]' if key.unit not in ('', '1') else ''
        lines.append(f'{key.name}{unit}: {spell(key.default)}')
        lines.append(f'    {key.description}; {key.range}')
    return '\n'.join(lines)


def load(path: str | os.PathLike[str], overrides: Mapping[str, object] | None = None,
         node: str | None = None) -> Scene:
    """
    Read a scene file.

    path : of a ROS 2 parameter file (YAML or JSON)
    overrides : dict, dotted key to a value, or to a text as in `-p key:=value`; they win
    node : whose sections hold, as `/left/brush_node`. None: all whose name ends in brush_node,
    whatever the namespace; what the file says last wins
    Raises SceneError.
    """
    given = _read(path, node and '/' + node.lstrip('/'))
    for key, value in (overrides or {}).items():
        _override(given, key, value)
    return _build(given, str(path))


def from_parameters(mapping: Mapping[str, object], source: str) -> Scene:
    """
    Make a scene from parameters that are already values.

    mapping : dict, dotted key to value; keys left out take their defaults
    source : str, names where they came from in errors
    Raises SceneError.
    """
    return _build({key: (value, source) for key, value in mapping.items()}, source)


def from_arguments(arguments: Iterable[str], node_name: str = 'brush_node',
                   notes: list[str] | None = None) -> Scene:
    """
    Make a scene from the command line of a node: --ros-args with --params-file and -p, in order.

    Sections of files are matched with the node's full name, as its remappings make it. `notes`, a
    list, takes a line for each file that is for a brush_node, but not for this one.

    rcl itself keeps an integer of a file against a double given by `-p` (it stores both and looks
    at the integer first), forgets which line a value came from, and drops keys given twice.
    Raises SceneError. Other ROS arguments (topics, log levels) are passed over.
    """
    given: Given = {}
    source = '--ros-args'
    notes = [] if notes is None else notes
    node = full_name(arguments, node_name)
    for flag, word in ros_arguments(arguments):
        if flag == '--params-file':
            source = word
            given.update(_read(source, node, notes))
        elif flag in ('-p', '--param'):
            only, key, value = split_override(word)
            if only in ('', node.rpartition('/')[2]):  # rcl forgets such ones in a namespace
                _override(given, key, value)
    return _build(given, source)


def to_parameters(scene: Scene) -> dict[str, Parameter]:
    """Return every key of a scene: dotted name to a float, int, bool, str or list of floats."""
    values: dict[str, Parameter] = {}
    for name in _KEYS:
        value: Any = scene
        for part in name.split('.'):
            value = getattr(value, part)
        values[name] = list(value) if isinstance(value, tuple) else value
    return values


def to_yaml(scene: Scene) -> str:
    """Return a complete scene file that loads back to an equal scene."""
    lines, section = ['/**:', '  ros__parameters:'], ''
    for name, value in to_parameters(scene).items():
        head, _, leaf = name.rpartition('.')
        if head and head != section:
            lines.append(f'    {head}:')
        section = head
        bare = _KEYS[name].choices and value
        lines.append('  ' * (3 if head else 2) + f'{leaf}: {bare or spell(value)}')
    return '\n'.join(lines) + '\n'


def _read(path: str | os.PathLike[str], node: str | None, notes: list[str] | None = None
          ) -> Given:
    """
    Return dotted key to (value, place) of a file's sections that are for the node.

    node : fully qualified; None: any that is called brush_node. Where a file has none, `notes`
    takes that as a line, and without it that is an error.
    """
    try:
        with open(path, 'rb') as file:
            content = file.read()
    except (OSError, ValueError) as error:
        reason = getattr(error, 'strerror', None) or error
        problem = f'cannot be read ({reason}): give a scene file'
        raise SceneError(problem, source=str(path)) from None
    entries = read_file(content, str(path))
    given: Given = {entry.key: (_beside(path, entry), f'{path}:{entry.line}')
                    for entry in entries if _is_ours(entry.section, node)}
    others = list(dict.fromkeys(entry.section for entry in entries))
    if others and not given:
        problem = f'has no section for {node or _NODE}, only for {", ".join(others)}'
        if notes is None:
            raise SceneError(f'{problem}: name it /** or {node or _NODE}', source=str(path))
        if any(_is_ours(section, None) for section in others):
            notes.append(f'{path}: {problem}')
    return given


def _beside(path: str | os.PathLike[str], entry: Entry) -> object:
    """Return an entry's value; the name of a file is relative to the scene file."""
    if entry.key in _FILES and isinstance(entry.value, str):
        return _absolute(entry.value, os.path.dirname(os.path.abspath(path)))
    return entry.value


def _absolute(file: str, folder: str) -> str:
    if not file or file.startswith('data:'):
        return file
    return os.path.normpath(os.path.join(folder, file))


def with_contents(scene: Scene) -> Scene:
    """Return the scene with the points of its files in place of these."""
    if scene.profile.kind == 'file':
        from .points_file import inline, PROFILE  # with numpy, which most scenes need not
        scene = replace(scene, profile=replace(
            scene.profile, file=inline(scene.profile.file, PROFILE)))
    if scene.drive.profile == 'table':
        from .points_file import inline, SPEEDS
        scene = replace(scene, drive=replace(scene.drive, file=inline(scene.drive.file, SPEEDS)))
    return scene


def _is_ours(section: str, node: str | None) -> bool:
    if node:
        return matches(section, node)
    name = section.rpartition('/')[2]
    return name == _NODE or all(part in ('', '*', '**') for part in section.split('/'))


def _override(given: Given, key: str, value: object) -> None:
    if isinstance(value, str):
        value = read_text(value, f'-p {key}') if value else value
    given[key] = (value, '-p')


def _build(given: Given, source: str) -> Scene:
    parts: dict[str, dict[str, Any]] = {name: {} for name in ('', *_SECTIONS)}
    for name, (value, place) in given.items():
        if name in _OF_EVERY_NODE and not isinstance(value, bool):
            raise SceneError('must be true or false', key=name, value=value, source=place)
        if name in _OF_EVERY_NODE or name.startswith('qos_overrides.'):
            continue
        if value is None and name in _SECTIONS:
            continue  # rcl hands on `road: {}` as a parameter without a value
        if name not in _READ:
            raise SceneError(_nearest(name), key=name, value=value, source=place)
        try:
            checked = _READ[name].check(value)
        except SceneError as error:
            raise error.at(place) from None
        if name in _FILES and isinstance(checked, str):
            checked = _absolute(checked, os.getcwd())
        section, _, leaf = name.rpartition('.')
        parts[section][leaf] = checked
    _check_table(parts['drive'], given)
    preset = parts['solver'].pop('preset', '')
    parts['solver'] = {**PRESETS.get(preset, {}), **parts['solver']}
    try:
        sections: dict[str, Any] = {name: section(**parts[name])
                                    for name, section in _SECTIONS.items()}
        return Scene(**sections, **parts[''])
    except SceneError as error:
        raise error.at(given[error.key][1] if error.key in given else source) from None


def _check_table(drive: dict[str, Any], given: Given) -> None:
    """Refuse a mean speed beside a table, also the usual one; 0 is what a log of one has."""
    for name in ('drive.mean_speed', 'drive.alternating_speed'):
        value = drive.get(name.rpartition('.')[2])
        if drive.get('profile') == 'table' and value:
            raise SceneError(WITH_TABLE, key=name, value=value, source=given[name][1])


def _nearest(name: str) -> str:
    """Say what a key that does not exist was probably meant to be."""
    if name in _SECTIONS:
        return f'is a section of keys, such as {_SECTIONS[name].keys()[0].name}'
    by_leaf = [key for key in _KEYS if key.rpartition('.')[2] == name.rpartition('.')[2]]
    near = difflib.get_close_matches(name, _READ, 1) or by_leaf
    return f'unknown key, did you mean {near[0]}?' if near else (
        'unknown key: `python3 -m bristle_ros scene --keys` lists them all')
