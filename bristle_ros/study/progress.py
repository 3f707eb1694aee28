"""How far a study is: a bar in a terminal, a line now and then elsewhere."""
import sys
import time

QUIET = 10.0            # [s] between lines


class Progress:
    """Shows runs done, failed, a second and the time left, on stderr; use it in a `with`."""

    def __init__(self, total, done=0):
        self.total, self.done, self.failed = total, done, 0
        self._first, self._began, self._told = done, time.monotonic(), time.monotonic()
        self._bar = None

    def __enter__(self):
        """Put up the bar, where there is a terminal."""
        if sys.stderr.isatty():
            from rich.console import Console
            from rich.progress import BarColumn, Progress as Bar, TextColumn, TimeRemainingColumn
            self._bar = Bar(TextColumn('{task.description}'), BarColumn(), TimeRemainingColumn(),
                            console=Console(stderr=True), transient=True)
            self._task = self._bar.add_task('study', total=self.total, completed=self.done)
            self._bar.start()
        return self

    def __exit__(self, *_):
        """Take it down."""
        if self._bar:
            self._bar.stop()

    @property
    def rate(self):
        """Runs a second, since the start."""
        return (self.done - self._first) / max(time.monotonic() - self._began, 1e-9)

    def add(self, rows, failed):
        """Count rows that are done, and those of them that did not finish."""
        self.done += rows
        self.failed += failed
        if self._bar:
            self._bar.update(self._task, completed=self.done, description=self._said())
        elif time.monotonic() - self._told > QUIET:
            self._told = time.monotonic()
            left = (self.total - self.done) / max(self.rate, 1e-9)
            print(f'study: {self._said()}, {left:.0f} s left', file=sys.stderr, flush=True)

    def _said(self):
        failed = f', {self.failed} refused or stopped' if self.failed else ''
        return f'{self.done} of {self.total} runs{failed}, {self.rate:.3g} a second'
