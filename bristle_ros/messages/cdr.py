"""Reads CDR, the bytes of a ROS 2 message, whoever wrote them; and writes it."""
import struct
from typing import Any


class CdrReader:
    """A cursor over CDR bytes. Whatever the bytes are, it raises nothing but ValueError."""

    def __init__(self, payload: bytes) -> None:
        if len(payload) < 4 or payload[0] != 0 or payload[1] > 1:
            raise ValueError('not plain CDR')
        self._order = '<' if payload[1] else '>'
        self._payload, self._at = payload, 4

    def _take(self, layout: str, size: int) -> tuple[Any, ...]:
        self._at += -(self._at - 4) % size
        try:
            values = struct.unpack_from(self._order + layout, self._payload, self._at)
        except struct.error as error:
            raise ValueError(f'message is too short: {error}') from None
        self._at += struct.calcsize(self._order + layout)
        return values

    def skip(self, size: int) -> None:
        """Pass over that many bytes."""
        self._at += size

    def stamp(self) -> int:
        """Return a time [ns]."""
        ((sec,), (nanosec,)) = self._take('i', 4), self._take('I', 4)
        return int(sec * 1_000_000_000 + nanosec)

    def count(self) -> int:
        """Return the length of a sequence; one longer than the message is refused."""
        (length,) = self._take('I', 4)
        if length > len(self._payload):
            raise ValueError(f'a sequence of {length} in {len(self._payload)} bytes')
        return int(length)

    def float64(self, count: int) -> tuple[float, ...]:
        """Return that many numbers."""
        return self._take(f'{count}d', 8)

    def string(self) -> str:
        """Return a text."""
        (length,) = self._take('I', 4)
        (raw,) = self._take(f'{min(length, len(self._payload))}s', 1)
        return bytes(raw).rstrip(b'\x00').decode()


class CdrWriter:
    """CDR bytes that grow; each method returns the offset at which it wrote."""

    def __init__(self) -> None:
        self.raw = bytearray(b'\x00\x01\x00\x00')

    def put(self, layout: str, *values: float) -> int:
        """Write numbers of one struct layout character, aligned to their size."""
        size = struct.calcsize(layout)
        self.raw += bytes(-(len(self.raw) - 4) % size)
        at = len(self.raw)
        self.raw += struct.pack(f'<{len(values)}{layout}', *values)
        return at

    def text(self, text: str) -> int:
        """Write a string."""
        raw = text.encode() + b'\x00'
        at = self.put('I', len(raw))
        self.raw += raw
        return at
