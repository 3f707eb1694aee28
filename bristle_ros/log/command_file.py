"""Commands for an offline run: read from a CSV, or from the log of an earlier run."""
import csv
import math
from numbers import Real
from pathlib import Path

from bristle_ros.realtime import Event
from bristle_ros.scene import LONGEST, SceneError
from bristle_ros.simulation import CommandRefused, values_of

_VALUES = {'cmd_brush_speed': ('rad/s',), 'cmd_vel': ('vx', 'vy', 'yaw rate'),
           'cmd_penetration': ('m',), 'cmd_drive_torque': ('N m',), 'reset': (),
           'cmd_mount': ('x', 'y', 'z', 'qx', 'qy', 'qz', 'qw', 'vx', 'vy', 'vz', 'wx', 'wy',
                         'wz')}
_WAY_OUT = "lines read 't,topic,values...', such as '0.5,cmd_vel,1.5,0,0'"


def read_commands(path, its):
    """
    Read commands as (place, Event) pairs in file order; place names file and line in errors.

    A command at `t` [s] takes effect at the first step that starts at `t` or after. Those of a log
    keep the very step at which they took effect. Raises SceneError.
    """
    path = Path(path).expanduser()
    if path.suffix == '.csv':
        return _read_csv(path, its)
    if path.name.endswith(('.mcap', '.mcap.zstd')) or path.is_dir():
        return _read_log(path, its)
    raise SceneError('must be a .csv, an .mcap or a bag directory', key='--commands',
                     value=str(path))


def step_at(t, its):
    """Return the first step that starts at `t` [s] or after, forgiving 1e-9 of rounding."""
    count = t / its
    nearest = round(count)
    return nearest if abs(count - nearest) <= 1e-9 * max(1, nearest) else math.ceil(count)


def _read_csv(path, its):
    try:
        with open(path, newline='', encoding='utf-8-sig') as file:
            rows = csv.reader(file)
            found = []
            for row in rows:
                cells = [cell.strip() for cell in row]
                place = f'{path}:{rows.line_num}'
                header = not found and cells[:2] == ['t', 'topic']
                if any(cells) and not cells[0].startswith('#') and not header:
                    found.append((place, _event(cells, place, its)))
            return found
    except (OSError, UnicodeDecodeError, csv.Error) as error:
        reason = getattr(error, 'strerror', None) or str(error)
        raise SceneError(f'cannot be read ({reason})', key='--commands', value=str(path)) from None


def _event(cells, place, its):
    if len(cells) < 2:
        raise SceneError(f'{",".join(cells)!r}: {_WAY_OUT}', source=place)
    while len(cells) > 2 and cells[-1] == '':  # a spreadsheet pads short lines with commas
        cells.pop()
    names = _VALUES.get(cells[1], ())
    names += ('value',) * (len(cells) - 2 - len(names))
    values = [_number(cell, name, place) for cell, name in zip(cells[2:], names)]
    return event_at(_number(cells[0], 't', place), cells[1], values, its, place)


def event_at(t, topic, values, its, place):
    """Return the Event of a command at `t` [s]; raise SceneError, naming `place`."""
    if not (isinstance(t, Real) and 0.0 <= t <= LONGEST):
        raise SceneError(f'must be seconds from the start, 0 to {LONGEST:.0f}', key='t', value=t,
                         source=place)
    if not isinstance(topic, str) or topic not in _VALUES:
        raise SceneError(f'must be one of {", ".join(_VALUES)}', key='topic', value=topic,
                         source=place)
    names = _VALUES[topic]
    try:
        values = values_of(topic, values)
    except CommandRefused as refused:
        raise SceneError(str(refused), source=place) from None
    if len(values) != len(names):
        takes = f'{len(names)} ({", ".join(names)})' if names else 'none'
        raise SceneError(f'{topic} with {len(values)} values: takes {takes}', source=place)
    kind, topic = ('reset', '') if topic == 'reset' else ('command', topic)
    return Event(step_at(t, its), kind, topic, values)


def _number(text, name, place):
    try:
        return float(text)
    except ValueError:
        raise SceneError(f'must be a number; {_WAY_OUT}', key=name, value=text,
                         source=place) from None


def _read_log(path, its):
    from .recording import logged_commands as commands_of_log
    log_its, commands = commands_of_log(path)
    found = []
    for step, topic, values in commands:
        # A log made with another step length keeps its times instead of its steps.
        step = step if log_its == its else step_at(step * log_its, its)
        kind = topic if topic in ('reset', 'load') else 'command'
        found.append((f'{path}, step {step}',
                      Event(step, kind, topic if kind == 'command' else '', values)))
    return found
