"""The one `jit`: compiler flags, and a cache that notices an edit in any kernel file."""
import fcntl
import hashlib
import os
from pathlib import Path
import tempfile
from typing import Any

import numba

SOURCES = sorted(Path(__file__).resolve().parent.glob('*.py'))  # every kernel is in this folder


def _cache_directory():
    """
    Return a folder named by what is in the kernel files and what compiles them.

    numba looks only at the outer function's own file, so an edit in a kernel that it calls would
    not count; a new folder for each content does what is needed.
    """
    digest = hashlib.sha256(numba.__version__.encode())
    for path in SOURCES:
        digest.update(path.read_bytes())
    home = Path(os.environ.get('XDG_CACHE_HOME') or Path.home() / '.cache')
    folder = home / 'bristle_ros' / digest.hexdigest()[:16]
    try:
        folder.mkdir(parents=True, exist_ok=True)
        with tempfile.TemporaryFile(dir=folder):
            return folder
    except OSError:  # a read-only home: compile anew in each process
        return Path(tempfile.mkdtemp(prefix='bristle_ros_'))


numba.config.CACHE_DIR = str(_cache_directory())  # type: ignore[attr-defined]

# 'contract' fuses multiply-add, 'nsz' and 'arcp' free the vectoriser; NaN and inf stay honest.
# error_model: the division check of Python is a branch, and a branch stops the vectoriser.
# _nrt: no reference counts, which took a tenth of a step; an allocation does not even compile.
_OPTIONS: dict[str, Any] = {'error_model': 'numpy', '_nrt': False}
_compiled = numba.njit(cache=True, nogil=True, fastmath={'contract', 'nsz', 'arcp'}, **_OPTIONS)


def _save_alone(cache):
    """
    Let one process at a time save what it compiled.

    Two that save variants of one kernel at once may give both the same file: one of them would
    later run the other's machine code.
    """
    save = cache.save_overload

    def save_overload(signature, data):
        with open(Path(numba.config.CACHE_DIR) / 'lock', 'w') as lock:
            fcntl.flock(lock, fcntl.LOCK_EX)
            save(signature, data)

    cache.save_overload = save_overload


def jit(function):
    """Compile a kernel; once for all values of its integer arguments, not for each constant."""
    dispatcher = _compiled(function)
    if numba.config.DISABLE_JIT:
        return dispatcher
    _save_alone(dispatcher._cache)
    resolve = dispatcher.get_call_template

    def get_call_template(args, kws):
        return resolve(tuple(map(numba.types.unliteral, args)), kws)

    dispatcher.get_call_template = get_call_template
    return dispatcher


def inlined(function):
    """Compile a kernel into the one that calls it: saves compiling all it calls once more."""
    return numba.njit(inline='always', **_OPTIONS)(function)
