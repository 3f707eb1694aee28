"""
Reads MCAP files whatever has happened to them: cut off anywhere, or damaged inside.

The readers of the mcap package end with one of many exceptions; this one ends, and says where and
why. Records: https://mcap.dev/spec. Files and messages that rosbag2 has compressed are read too.
"""
from collections.abc import Iterator
import os
from pathlib import Path
import struct
import tempfile
from typing import NamedTuple
import zlib

from bristle_ros.scene import SceneError

MAGIC = b'\x89MCAP0\r\n'
ZSTD = b'\x28\xb5\x2f\xfd'   # what it compressed begins with; CDR begins with 0, MCAP with 0x89
LARGEST_CHUNK = 1 << 30     # [B] uncompressed: a mangled size must not take all memory

_HEADER, _FOOTER, _SCHEMA, _CHANNEL, _MESSAGE, _CHUNK = 1, 2, 3, 4, 5, 6
_ATTACHMENT, _METADATA, _DATA_END = 9, 12, 15
_frame = struct.Struct('<BQ')
_message = struct.Struct('<HIQQ')


class Channel(NamedTuple):
    """A topic of a file."""

    id: int  # noqa: A003
    topic: str
    encoding: str
    schema: str         # its type, `pkg/msg/Type`
    schema_encoding: str
    schema_text: bytes
    metadata: dict


class Message(NamedTuple):
    """A message; times in ns."""

    channel: Channel
    sequence: int
    log_time: int
    publish_time: int
    data: bytes


class Metadata(NamedTuple):
    """A record of text -> text."""

    name: str
    entries: dict


class Attachment(NamedTuple):
    """A file within the file."""

    name: str
    media_type: str
    log_time: int
    create_time: int
    data: bytes


class McapReader:
    """
    One pass over the records of a file in the order in which they were written.

    After the pass: `complete` (the end was there), `cut` (where the file stops without one, or
    ''), `damage` (one text for each part in between that could not be used).
    """

    def __init__(self, path):
        """Remember the path; `records` opens it."""
        self.path = Path(path)
        self.complete = False
        self.cut = ''
        self.damage = []
        self.profile = self.library = ''
        self._schemas = {}
        self._channels = {}

    def records(self) -> Iterator[Message | Metadata | Attachment]:
        """Yield what is in the file; raises SceneError when it is no MCAP file at all."""
        try:
            with open(self.path, 'rb') as stream:
                if stream.read(len(ZSTD)) == ZSTD:
                    with tempfile.TemporaryFile() as content:
                        self._decompress(stream, content)
                        yield from self._read(content)
                else:
                    yield from self._read(stream)
        except OSError as error:  # not there, not ours to read, a bad disk
            raise SceneError(f'cannot be read: {(error.strerror or str(error)).lower()}',
                             source=str(self.path)) from None

    def _decompress(self, stream, content):
        """Unpack rosbag2's file compression, as far as it goes."""
        import zstandard
        stream.seek(0)
        try:
            zstandard.ZstdDecompressor().copy_stream(stream, content)
        except zstandard.ZstdError as error:
            self.damage.append(f'cannot be decompressed to its end: {error}')

    def _read(self, stream):
        size = stream.seek(0, os.SEEK_END)
        stream.seek(0)
        magic = stream.read(len(MAGIC))
        if magic != MAGIC[:len(magic)]:
            raise SceneError('not an MCAP file; name a .mcap file or a bag directory',
                             source=str(self.path))
        crc = zlib.crc32(magic)
        at = len(magic)
        while at + _frame.size <= size:
            head = stream.read(_frame.size)
            opcode, length = _frame.unpack(head)
            if opcode == 0 or at + _frame.size + length > size:
                break
            body = stream.read(length)
            try:
                if opcode == _DATA_END:
                    self._check(_Fields(body).number('I'), crc, 'the data section')
                elif opcode == _FOOTER:
                    self.complete = stream.read(len(MAGIC)) == MAGIC
                    at += _frame.size + length
                    break
                else:
                    yield from self._record(opcode, body)
            except _Damaged as error:
                self.damage.append(f'byte {at}: {error}')
            crc = zlib.crc32(body, zlib.crc32(head, crc))
            at += _frame.size + length
        if not self.complete:
            self._stopped(stream, at, size)

    def _stopped(self, stream, at, size):
        """Tell a file that was cut off from one that goes on, but cannot be followed."""
        stream.seek(max(0, size - len(MAGIC)))
        if at > len(MAGIC) and stream.read() == MAGIC:
            self.damage.append(f'byte {at}: from here to the end it cannot be followed')
        else:
            self.cut = f'cut off after byte {at}'

    @staticmethod
    def _check(stated, actual, what):
        if stated not in (0, actual):
            raise _Damaged(f'the checksum of {what} does not fit')

    def _record(self, opcode, body):
        if opcode == _MESSAGE:
            yield self._read_message(body)
        elif opcode == _CHUNK:
            yield from self._read_chunk(body)
        elif opcode == _SCHEMA:
            fields = _Fields(body)
            number = fields.number('H')
            self._schemas[number] = fields.text(), fields.text(), fields.data('I')
        elif opcode == _CHANNEL:
            self._read_channel(body)
        elif opcode == _METADATA:
            fields = _Fields(body)
            yield Metadata(fields.text(), fields.pairs())
        elif opcode == _ATTACHMENT:
            yield self._read_attachment(body)
        elif opcode == _HEADER:
            fields = _Fields(body)
            self.profile, self.library = fields.text(), fields.text()

    def _read_chunk(self, body):
        fields = _Fields(body)
        fields.number('Q'), fields.number('Q')
        size, crc, compression = fields.number('Q'), fields.number('I'), fields.text()
        content = _decompress(compression, fields.data('Q'), size)
        self._check(crc, zlib.crc32(content), 'the chunk')
        at = 0
        while at + _frame.size <= len(content):
            opcode, length = _frame.unpack_from(content, at)
            at += _frame.size
            if opcode in (_MESSAGE, _CHANNEL, _SCHEMA):
                if at + length > len(content):
                    raise _Damaged('a record is longer than its chunk')
                yield from self._record(opcode, content[at:at + length])
            at += length

    def _read_message(self, body):
        if len(body) < _message.size:
            raise _Damaged('a message is too short')
        channel, sequence, log_time, publish_time = _message.unpack_from(body)
        if channel not in self._channels:
            raise _Damaged(f'a message of channel {channel}, which is not in the file')
        data = body[_message.size:]
        if data.startswith(ZSTD):   # rosbag2's compression of messages
            data = _decompress('zstd', data)
        return Message(self._channels[channel], sequence, log_time, publish_time, data)

    def _read_channel(self, body):
        fields = _Fields(body)
        number, schema = fields.number('H'), fields.number('H')
        topic, encoding, metadata = fields.text(), fields.text(), fields.pairs()
        self._channels[number] = Channel(
            number, topic, encoding, *self._schemas.get(schema, ('', '', b'')), metadata)

    def _read_attachment(self, body):
        fields = _Fields(body)
        log_time, create_time = fields.number('Q'), fields.number('Q')
        attachment = Attachment(
            fields.text(), fields.text(), log_time, create_time, fields.data('Q'))
        self._check(fields.number('I'), zlib.crc32(body[:-4]), f'{attachment.name!r}')
        return attachment


class _Damaged(ValueError):
    """A record is not what it should be."""


class _Fields:
    """A cursor over a record's bytes."""

    def __init__(self, body):
        self._body, self._at = body, 0

    def number(self, layout):
        try:
            (value,) = struct.unpack_from('<' + layout, self._body, self._at)
        except struct.error:
            raise _Damaged('it is too short') from None
        self._at += struct.calcsize('<' + layout)
        return value

    def data(self, layout):
        length = self.number(layout)
        raw = self._body[self._at:self._at + length]
        if len(raw) < length:
            raise _Damaged('it is too short')
        self._at += length
        return raw

    def text(self):
        try:
            return self.data('I').decode()
        except UnicodeDecodeError:
            raise _Damaged('a text in it is no UTF-8') from None

    def pairs(self):
        inner, pairs = _Fields(self.data('I')), {}
        while inner._at < len(inner._body):
            key = inner.text()
            pairs[key] = inner.text()
        return pairs


def _decompress(compression, data, size=None):
    """Return `size` bytes (None: what zstd states), or say what is wrong, whatever `data` is."""
    try:
        if size is None:
            import zstandard
            size = zstandard.get_frame_parameters(data).content_size
        if size > LARGEST_CHUNK:
            raise _Damaged(f'a chunk of {size} bytes')
        if compression == 'zstd':
            import zstandard
            # Its own idea of the size would be allocated before a byte is looked at.
            stated = zstandard.get_frame_parameters(data).content_size
            if stated not in (size, zstandard.CONTENTSIZE_UNKNOWN):
                raise _Damaged(f'a chunk of {stated} bytes that says {size}')
            content = zstandard.ZstdDecompressor().decompress(data, max_output_size=size)
        elif compression == 'lz4':
            import lz4.frame
            content = lz4.frame.LZ4FrameDecompressor().decompress(data, max_length=size)
        elif compression == '':
            content = data
        else:
            raise _Damaged(f'compression {compression!r} is not known')
    except _Damaged:
        raise
    except (ValueError, RuntimeError, MemoryError, EOFError) as error:
        raise _Damaged(f'the chunk cannot be decompressed: {error}') from None
    except Exception as error:
        if type(error).__name__ != 'ZstdError':  # named so that lz4 logs need no zstandard
            raise
        raise _Damaged(f'the chunk cannot be decompressed: {error}') from None
    if len(content) != size:
        raise _Damaged(f'a chunk of {len(content)} bytes that says {size}')
    return content
