"""One process of a machine compiles; the others wait and take what it left in the cache."""
from contextlib import contextmanager, nullcontext
import fcntl
import os
from pathlib import Path
import tempfile
import time

from bristle_ros.simulation import kind_of

PATIENCE = 300.0        # [s] for the one that compiles, which may have been stopped
_compiled = set()       # kinds of scenes that this process has built


def one_compiles(scene):
    """
    Return a context in which to build a scene's simulation.

    Of scenes that need the same functions the first is built by one process at a time.
    """
    kind = kind_of(scene)
    return nullcontext() if kind in _compiled else _alone(kind)


@contextmanager
def _alone(kind):
    path = Path(tempfile.gettempdir()) / f'bristle_ros-compiling-{os.getuid()}'
    with open(path, 'a') as lock:
        _take(lock)
        yield
    _compiled.add(kind)


def _take(lock):
    """Wait for the lock, but not for ever: to compile twice does no harm."""
    end = time.monotonic() + PATIENCE
    while True:
        try:
            fcntl.flock(lock, fcntl.LOCK_EX | fcntl.LOCK_NB)
            return
        except BlockingIOError:
            if time.monotonic() > end:
                return
            time.sleep(0.1)
