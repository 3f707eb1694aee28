"""
The one `jit`: compiler flags, and a cache that notices an edit in any kernel file.

It reaches into numba: tried with 0.68.1; test/physics/compiler/test_hooks.py names what is gone.
"""
import contextlib
import fcntl
import hashlib
import os
from pathlib import Path
import sys
import tempfile
from typing import Any
import zlib

SOURCES = sorted(Path(__file__).resolve().parents[1].rglob('*.py'))  # every kernel is in there


class CompilerRefused(RuntimeError):
    """The compiler cannot be used as the environment has it; `str()` is one line."""


def _check_threads():
    """Raise CompilerRefused where numba would end in a traceback, or print one and go on."""
    text = os.environ.get('NUMBA_NUM_THREADS')
    if text is not None and not (text.strip().isdecimal() and int(text) > 0):
        raise CompilerRefused(f'NUMBA_NUM_THREADS = {text!r}: must be a whole number above 0: '
                              'give one, or unset it')


_check_threads()
import numba  # noqa: E402  what it finds in the environment is checked before
from numba.core.caching import FunctionCache  # noqa: E402


def _cache_directory():
    """
    Return a folder named by what is in the kernel files and what compiles them, None without one.

    numba looks only at the outer function's own file, so an edit in a kernel that it calls would
    not count; a new folder for each content does what is needed.
    """
    digest = hashlib.sha256(numba.__version__.encode())
    for path in SOURCES:
        digest.update(path.read_bytes())
    try:
        home = Path(os.environ.get('XDG_CACHE_HOME') or Path.home() / '.cache')
        folder = home / 'bristle_ros' / digest.hexdigest()[:16]
        folder.mkdir(parents=True, exist_ok=True)
        with tempfile.TemporaryFile(dir=folder):
            return folder
    except (OSError, RuntimeError) as error:    # no home at all is a RuntimeError
        _say(f'no cache of compiled kernels ({_reason(error)}): compiling in memory, at each '
             'start')
        return None


def _reason(error):
    return getattr(error, 'strerror', None) or str(error) or type(error).__name__


def _say(text):
    if sys.stderr is not None:
        print(f'bristle_ros: {text}', file=sys.stderr, flush=True)


FOLDER = _cache_directory()
if FOLDER:
    numba.config.CACHE_DIR = str(FOLDER)  # type: ignore[attr-defined]

# 'contract' fuses multiply-add, 'nsz' and 'arcp' free the vectoriser; NaN and inf stay honest.
# error_model: the division check of Python is a branch, and a branch stops the vectoriser.
# _nrt: no reference counts, which took a tenth of a step; an allocation does not even compile.
_OPTIONS: dict[str, Any] = {'error_model': 'numpy', '_nrt': False}
_compiled = numba.njit(nogil=True, fastmath={'contract', 'nsz', 'arcp'}, **_OPTIONS)


class _Cache(FunctionCache):
    """
    numba's cache of one kernel, which trusts no file: a damaged one is compiled anew.

    Each file ends in a checksum, as zeros in the middle of machine code would be run. One process
    at a time saves: two that save variants of one kernel at once may give both the same file, and
    one of them would later run the other's machine code.
    """

    _told = False       # of all kernels: one line is enough
    _writable = True

    def __init__(self, function):
        super().__init__(function)
        file = self._cache_file
        dump, load = file._dump, file._load_data

        def dump_checked(entry):
            content = dump(entry)   # unpickling stops before what follows it
            return content + zlib.crc32(content).to_bytes(4, 'big')

        def load_checked(name):
            content = Path(file._data_path(name)).read_bytes()
            if zlib.crc32(content[:-4]) != int.from_bytes(content[-4:], 'big'):
                raise ValueError(f'{name} has another checksum')
            return load(name)

        file._dump, file._load_data = dump_checked, load_checked

    def load_overload(self, sig, target_context):
        """Return what is cached, or None to have it compiled."""
        try:
            return super().load_overload(sig, target_context)
        except Exception:   # whatever unpickling makes of garbage
            _Cache._tell('is damaged: compiling anew')
            try:
                with self._alone():
                    self._drop()
            except OSError:     # saving reads the index first, which may be what is damaged
                _Cache._writable = False
            return None

    def save_overload(self, sig, data):
        """Keep what was compiled, where that is possible."""
        if not _Cache._writable:
            return
        try:
            with self._alone():
                super().save_overload(sig, data)
        except OSError as error:
            _Cache._writable = False
            _Cache._tell(f'cannot be written ({_reason(error)}): compiling in memory, at each '
                         'start')

    def _drop(self):
        """Remove the kernel's files; the index last, or a later one could name what is left."""
        index = Path(self._cache_file._index_path)
        for path in index.parent.glob(f'{index.stem}.*.nbc'):
            path.unlink(missing_ok=True)
        index.unlink(missing_ok=True)

    @staticmethod
    @contextlib.contextmanager
    def _alone():
        with open(FOLDER / 'lock', 'w') as lock:
            fcntl.flock(lock, fcntl.LOCK_EX)
            yield

    @classmethod
    def _tell(cls, text):
        if not cls._told:
            _Cache._told = True
            _say(f'the cache of compiled kernels in {FOLDER} {text}')


def jit(function):
    """Compile a kernel; once for all values of its integer arguments, not for each constant."""
    dispatcher = _compiled(function)
    if numba.config.DISABLE_JIT:
        return dispatcher
    if FOLDER:
        dispatcher._cache = _Cache(function)
    resolve = dispatcher.get_call_template

    def get_call_template(args, kws):
        return resolve(tuple(map(numba.types.unliteral, args)), kws)

    dispatcher.get_call_template = get_call_template
    return dispatcher


def inlined(function):
    """Compile a kernel into the one that calls it: saves compiling all it calls once more."""
    return numba.njit(inline='always', **_OPTIONS)(function)
