"""What every part of the report is given: how long it may be, who works, and who is told."""
import sys
import time
from typing import NamedTuple

from .timing import Timer
from .workers import Crew

BAR = 20    # characters of the bar


class Context(NamedTuple):
    """The form of the report, and its workers."""

    quick: bool
    drawn: int              # cases of the campaign that are drawn at random
    seed: int
    case_limit: float       # [s] of one case of the campaign
    builds: int             # sets of compiled functions that drawn cases need; 0: any number
    crew: Crew              # for what is not timed
    timer: Timer
    progress: object        # Progress


class Progress:
    """
    Says on stderr how far the report is and what is left: a bar on a terminal, else lines.

    parts : dict of the parts to come to their weights, the time [s] that each usually takes
    """

    def __init__(self, parts, stream=None, clock=time.monotonic):
        """Write to a stream, by default stderr."""
        self._stream = stream or sys.stderr
        self._clock = clock
        self.began = clock()
        self._weights = dict(parts)
        self._done, self._part, self._share = 0.0, None, 0.0
        self._told = -1e9

    def part(self, name):
        """Begin a part; the one before it is done."""
        self._done += self._weights.get(self._part, 0.0)
        self._part, self._share = name, 0.0
        self(f'{name} begins')

    def count(self, done, total, text):
        """Say that so many of a part's jobs are done."""
        self._share = max(self._share, min(0.95, done / max(1, total)))
        self(text)

    def left(self):
        """Return the time [s] that is probably left."""
        total = sum(self._weights.values())
        done = self._done + self._share * self._weights.get(self._part, 0.0)
        spent = self._clock() - self.began
        # the first seconds tell little: mix what is usual with what was seen
        pace = (spent + 10.0) / (done + 10.0)
        return max(0.0, pace * (total - done))

    def __call__(self, text):
        """Show what is done now."""
        now = self._clock()
        total = sum(self._weights.values()) or 1.0
        share = (self._done + self._share * self._weights.get(self._part, 0.0)) / total
        full = min(BAR, int(BAR * share))
        line = (f'[{"#" * full}{"." * (BAR - full)}] {now - self.began:4.0f} s, about '
                f'{self.left():.0f} s left: {text}')
        if self._stream.isatty():
            self._stream.write('\r\x1b[K' + line[:110])
        elif now - self._told > 2.0:    # a log need not have every run
            self._told = now
            self._stream.write(line + '\n')
        self._stream.flush()

    def close(self):
        """End the line."""
        if self._stream.isatty():
            self._stream.write('\r\x1b[K')
            self._stream.flush()
