"""Files that are written beside their place and renamed when whole: what exists is not damaged."""
import os
from pathlib import Path
import signal
import tempfile
import threading

from bristle_ros.scene import SceneError

INTERRUPTED = 130   # what a shell expects of a command that ended by Ctrl-C
_SIGNALS = [getattr(signal, name) for name in ('SIGINT', 'SIGTERM', 'SIGHUP')
            if hasattr(signal, name)]


class Stopped(KeyboardInterrupt):
    """SIGINT, SIGTERM or SIGHUP came; `code` is what a shell expects of a command it ended."""

    def __init__(self, number):
        """Take the signal's number."""
        super().__init__(signal.Signals(number).name)
        self.code = 128 + number


class StopSignals:
    """
    While entered, SIGINT, SIGTERM and SIGHUP raise Stopped in the main thread, and but once.

    What comes after the first is ignored until the process ends: it has something to keep. Signals
    that were ignored before (nohup, a job in the background) stay so.
    """

    def __enter__(self):
        """Change the handlers; only the main thread can."""
        self._stopped = False
        self._before = {number: handler for number, handler in _handlers().items()
                        if handler is not signal.SIG_IGN}
        for number in self._before:
            signal.signal(number, self._stop)

    def _stop(self, number, _frame):
        self._stopped = True
        for each in self._before:
            signal.signal(each, signal.SIG_IGN)
        raise Stopped(number)

    def __exit__(self, *_):
        """Put them back, unless one has come."""
        if not self._stopped:
            for number, handler in self._before.items():
                signal.signal(number, handler)


class Undisturbed:
    """While entered, no signal interrupts: a second Ctrl-C cuts nothing that the first keeps."""

    def __enter__(self):
        """Change the handlers; only the main thread can."""
        self._before = _handlers()
        for number in self._before:
            signal.signal(number, signal.SIG_IGN)

    def __exit__(self, *_):
        """Put them back."""
        for number, handler in self._before.items():
            signal.signal(number, handler)


def _handlers():
    """Return the handlers that there are; none in other threads, which hear no signals."""
    if threading.current_thread() is not threading.main_thread():
        return {}
    return {number: signal.getsignal(number) for number in _SIGNALS}


def check_new(path, key='--output', *, overwrite=False):
    """Raise SceneError where a file or folder stands already and may not be replaced."""
    if os.path.isdir(path):
        raise SceneError('is a directory: name another place', key=key, value=str(path))
    if not overwrite and os.path.lexists(path):
        raise SceneError('exists already: name another place, or give --overwrite', key=key,
                         value=str(path))


def check_place(output, formats, *, overwrite=False):
    """Return the path of a file to be written; raise SceneError for one that cannot be."""
    path = Path(output).expanduser()
    if path.suffix not in formats:
        raise SceneError(f'must end in one of {", ".join(formats)}', key='--output',
                         value=str(output))
    if not path.parent.is_dir():
        raise SceneError(f'there is no directory {str(path.parent)!r}: make it first',
                         key='--output', value=str(output))
    check_new(path, overwrite=overwrite)
    return path


def partial(path):
    """Return where that is kept which an interrupt leaves of the file `path`."""
    path = Path(path)
    return path.with_name(f'{path.stem}.partial{path.suffix}')


class WholeFile:
    """
    A file in the making, open as `file` between enter and exit.

    It stands beside `path` under a name of its own until it is whole. A KeyboardInterrupt, and a
    disk that is full, leave what there is as NAME.partial.EXT, which `kept` then names; with
    `keep` false, and after any other error, nothing is left. Raises SceneError, naming the path,
    where it cannot be written.
    """

    def __init__(self, path, *, text=False, overwrite=False, key='--output', keep=True):
        self.path, self._key, self._overwrite = Path(path), key, overwrite
        self.kept, self._keep = None, keep
        check_new(self.path, key, overwrite=overwrite)
        try:
            self.file = tempfile.NamedTemporaryFile(  # noqa: SIM115
                'w' if text else 'wb', dir=self.path.parent, prefix=f'.{self.path.name}.',
                delete=False, **({'newline': '', 'encoding': 'utf-8'} if text else {}))
            mask = os.umask(0o077)
            os.umask(mask)
            os.chmod(self.file.name, 0o666 & ~mask)     # as `open` would have made it
        except OSError as error:
            raise self._refusal(error) from None

    def __enter__(self):
        """Return the open file."""
        return self.file

    def __exit__(self, kind, error, trace):
        """Put the file in its place, or keep or drop what there is of it."""
        with Undisturbed():
            try:
                self.file.flush()
                os.fsync(self.file.fileno())
                self.file.close()
            except OSError as failed:   # a full disk tells at the end, too
                self._close()
                if kind is None:
                    kind, error = OSError, failed
            if kind is None:
                check_new(self.path, self._key, overwrite=self._overwrite)
                os.replace(self.file.name, self.path)
            elif self._keep and issubclass(kind, (KeyboardInterrupt, OSError)):
                os.replace(self.file.name, partial(self.path))
                self.kept = partial(self.path)
            else:
                os.unlink(self.file.name)
        if kind is not None and issubclass(kind, OSError):
            more = f'; {self.kept} has what could be written' if self.kept else ''
            raise self._refusal(error, more) from None

    def _close(self):
        try:
            self.file.close()
        except OSError:
            pass

    def _refusal(self, error, more=''):
        return SceneError(f'{(error.strerror or str(error)).lower()}: name another place{more}',
                          key=self._key, value=str(self.path))
