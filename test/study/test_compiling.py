"""One process compiles, the others wait; one that was stopped does not hold them for ever."""
from contextlib import nullcontext
import fcntl
import os
from pathlib import Path
import tempfile
import threading
import time

from bristle_ros.scene import from_parameters
from bristle_ros.study import compiling
import pytest


@pytest.fixture
def lock(tmp_path, monkeypatch):
    """Another's lock, held; and no scene that is known to be compiled."""
    monkeypatch.setattr(tempfile, 'tempdir', str(tmp_path))
    monkeypatch.setattr(compiling, '_compiled', set())
    with open(Path(tmp_path) / f'bristle_ros-compiling-{os.getuid()}', 'a') as file:
        fcntl.flock(file, fcntl.LOCK_EX)
        yield file


def test_one_waits_until_the_other_has_compiled(lock):
    let_go = threading.Timer(0.3, lambda: fcntl.flock(lock, fcntl.LOCK_UN))
    began = time.monotonic()
    let_go.start()
    with compiling.one_compiles(from_parameters({}, '')):
        assert time.monotonic() - began >= 0.3
    let_go.join()


def test_a_stopped_process_does_not_hold_others_for_ever(lock, monkeypatch):
    monkeypatch.setattr(compiling, 'PATIENCE', 0.2)
    with compiling.one_compiles(from_parameters({}, '')):
        pass
    # what is known needs no lock
    assert isinstance(compiling.one_compiles(from_parameters({}, '')), nullcontext)
