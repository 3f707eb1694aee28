"""A log as it lies on disk, whole or not: its scene, where it was made, and what happened when."""
from collections.abc import Iterator
from pathlib import Path
import re
from typing import NamedTuple

from bristle_ros.messages import decode_scene, encode as messages, SCENE
from bristle_ros.scene import from_parameters, read_file, SceneError

from .bag_metadata import METADATA, PART
from .reader import Attachment, McapReader, Message, Metadata
from .writer import CONTRACT_NAME

_OUTPUTS = {topic.name for topic in messages.TOPICS}
_STAMPED = {topic.type for topic in messages.TOPICS}
# what was done before a key was there
OLDER = {'contact.points': 'tip', 'solver.largest_error': 2e-4, 'solver.newton': 'tolerance',
         'solver.tolerance': 1e-8}


class Entry(NamedTuple):
    """One message of a log."""

    name: str           # of its topic before remapping: 'tip_pose', 'cmd_vel', '~/events', ...
    step: int           # since the run's start, through resets
    message: Message


class Recording:
    """
    A log directory or file. Raises SceneError when it cannot be used at all.

    `scene`, `machine` (text -> text) and `origin` [ns] come from its first records, or from the
    message `~/scene` where `ros2 bag` has copied or recorded the messages alone. `recorded`: it
    was made by a recorder, whose log times say when messages came. After `entries` has been
    walked through, `cut` and `damage` (texts) say what is missing.
    """

    def __init__(self, path):
        """Find the files and read what comes before the first message."""
        self.path = Path(path).expanduser()
        self.files = _files(self.path)
        self.cut, self.damage = '', []
        self.recorded, self._begins = False, True
        self._head = {}
        self._read_head()

    @property
    def scene(self):
        """Return the Scene that was simulated."""
        text = self._entry('scene', 'yaml')
        if self._head.get('attachment', text.encode()) != text.encode():
            raise SceneError('its scene is damaged: record and attachment differ',
                             source=str(self.path))
        return scene_of(text, f'{self.path}: scene')

    @property
    def machine(self):
        """Return what `machine.provenance` said where it was made."""
        return self._head.get('machine', {})

    @property
    def integration_time_step(self):
        """[s] of the run."""
        return self._number('integration_time_step', float)

    @property
    def origin(self):
        """[ns] added to simulation time in the log's stamps."""
        return self._number('time_origin_ns', int)

    @property
    def part(self):
        """Which file of its log it begins with; 0 is the start."""
        try:
            return int(self._head.get('part', {}).get('number', 0))
        except ValueError:
            return 0

    def from_start(self):
        """Raise SceneError unless it begins where its run did; returns itself."""
        if self.part:
            raise SceneError(
                f'part {self.part} of a log, without what came before it; name the directory '
                'of all parts', source=str(self.path))
        if not self._begins:
            raise SceneError('does not begin where its run did; name a log of all of it',
                             source=str(self.path))
        return self

    def records(self, between=None) -> Iterator[Message | Metadata | Attachment]:
        """Yield all there is, of all files, in order; calls `between` between two files."""
        self.cut, self.damage = '', []
        part, usable = None, 0
        for number, file in enumerate(self.files):
            if number and between:
                between()
            reader = McapReader(file)
            try:
                for record in reader.records():
                    if isinstance(record, Metadata) and record.name == PART:
                        part = self._follow(file, part, record.entries.get('number', ''))
                    yield record
                usable += 1
            except SceneError as error:
                if len(self.files) == 1 or not usable and number == len(self.files) - 1:
                    raise
                self.damage.append(str(error))
            if reader.cut and number < len(self.files) - 1:
                self.damage.append(f'{file}: {reader.cut}, and another file follows')
            elif reader.cut:
                self.cut = f'{file}: {reader.cut}'
            self.damage += [f'{file}: {text}' for text in reader.damage]
        if part is not None and not self.cut and self._has_no_last_file():
            self.cut = (f'{self.path}: without {METADATA}, which is written last; it may have '
                        'been cut off between two files')

    def _has_no_last_file(self):
        return self.path.is_dir() and not (self.path / METADATA).exists()

    def _follow(self, file, before, number):
        """Return the part that this file is, after telling whether any is missing before it."""
        part = int(number) if number.isdecimal() else 0
        if before is not None and part != before + 1:
            self.damage.append(f'{file}: part {part} of a log comes after part {before}')
        return part

    def entries(self) -> Iterator[Entry]:
        """Yield the messages in the order in which they were logged."""
        its, origin, stamp = self.integration_time_step, self.origin, self.origin
        for record in self.records():
            if isinstance(record, Message):
                if not self.recorded:
                    stamp = record.log_time
                elif record.channel.schema in _STAMPED:
                    stamp = _header_stamp(record, stamp)
                yield Entry(self.name_of(record.channel),
                            messages.total_step(stamp, its, origin), record)

    def name_of(self, channel):
        """Return the topic's name before remapping; a guess where nothing says it."""
        last = channel.topic.rpartition('/')[2]
        names = self._head.get('topics') or {channel.topic: last if last in _OUTPUTS else ''}
        return (channel.metadata.get(CONTRACT_NAME) or names.get(channel.topic)
                or channel.topic)

    def _read_head(self):
        for record in self.records():
            if isinstance(record, Message):
                if 'scene' not in self._head:
                    self._read_messages()
                break
            if isinstance(record, Metadata) and record.name.startswith('bristle_ros.'):
                self._head[record.name.removeprefix('bristle_ros.')] = record.entries
            elif isinstance(record, Attachment) and record.name == 'scene.yaml':
                self._head['attachment'] = record.data

    def _read_messages(self):
        """Find out from the messages what the first records do not say."""
        begins = output = False
        for record in self.records():
            if not isinstance(record, Message):
                continue
            type_name, topic = record.channel.schema, record.channel.topic
            if type_name in _STAMPED and not output:
                output = True
                self.recorded = _header_stamp(record, record.log_time) != record.log_time
            elif type_name == messages.STRING and topic.endswith(SCENE[1:]):
                self._head |= decode_scene(record.data)
            elif type_name == messages.STRING and not output:
                begins |= is_event(Entry('', 0, record), 'start')
            if output and 'scene' in self._head:
                break
        self._begins = begins or self.recorded

    def _entry(self, record, key):
        try:
            return self._head[record][key]
        except KeyError:
            raise SceneError(f'holds no {record}; only logs of bristle_ros can be used for this',
                             source=str(self.path)) from None

    def _number(self, key, kind):
        text = self._entry('run', key)
        try:
            value = kind(text)
        except ValueError:
            value = -1
        if not (value > 0 or kind is int and value == 0) or value == float('inf'):
            raise SceneError('is damaged', key=key, value=text, source=str(self.path))
        return value


def _header_stamp(message, default):
    """Return the stamp [ns] in the header that a message begins with."""
    try:
        return messages.decode_stamp(message.data)
    except ValueError:
        return default


def scene_of(yaml, source):
    """
    Return the Scene of a log; raise SceneError, naming `source`.

    A key that was not there when the log was written stands for what was done then.
    """
    given = {entry.key: entry.value for entry in read_file(yaml.encode(), source)}
    return from_parameters({**OLDER, **given}, source)


def logged_commands(path):
    """
    Return the integration time step of a log, and its commands as (step, topic, values).

    A reset has the topic 'reset', a load decision 'load' and the error tolerance; timeouts are the
    commands they gave.
    """
    recording = Recording(path).from_start()
    found = []
    for entry in recording.entries():
        type_name = entry.message.channel.schema
        if entry.name in messages.command_types(True):
            try:
                values = messages.decode_command(type_name, entry.message.data)
            except ValueError as error:
                raise SceneError(f'{entry.name} at step {entry.step}: {error}',
                                 source=str(recording.path)) from None
            found.append((entry.step, entry.name, values))
        elif entry.name == messages.EVENTS and is_event(entry, 'reset'):
            found.append((entry.step, 'reset', ()))
        elif entry.name == messages.EVENTS and is_event(entry, 'load'):
            found.append((entry.step, 'load', (load_tolerance(entry),)))
    return recording.integration_time_step, found


def load_tolerance(entry):
    """Return the error tolerance of an event 'load'; ValueError where it has none."""
    tolerance = messages.decode_event(entry.message.data).get('error_tolerance')
    if not isinstance(tolerance, float) or not 0.0 < tolerance < 1.0:
        raise ValueError(f'{tolerance!r} is no error tolerance')
    return tolerance


def is_event(entry, kind):
    """Return whether an entry of `~/events` is of that kind."""
    try:
        return messages.decode_event(entry.message.data).get('event') == kind
    except ValueError:
        return False


def _files(path):
    """Return the MCAP files of a log in their order."""
    if path.is_dir():
        found = {file.name.removesuffix('.zstd'): file  # the one that is not compressed is newer
                 for ending in ('*.mcap.zstd', '*.mcap') for file in path.glob(ending)}
        files = sorted(found.values(), key=lambda file: (
            int((re.search(r'_(\d+)\.mcap(\.zstd)?$', file.name) or [0, 0])[1]), file.name))
        if not files:
            other = any(path.glob('*.db3*'))
            raise SceneError('a bag of SQLite; `ros2 bag convert` makes one of mcap of it' if other
                             else 'no .mcap file in it; name a log', source=str(path))
        return files
    if not path.exists():
        raise SceneError('no such file or directory; name a log', source=str(path))
    return [path]
