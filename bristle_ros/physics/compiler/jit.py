"""
The one `jit`: compiler flags, and a cache that notices an edit in any kernel file.

What was compiled is looked for in the package first, where a wheel may carry it, then in the
user's cache. It reaches into numba: tried with 0.68.1; test/physics/compiler/test_hooks.py names
what is gone.
"""
import contextlib
import fcntl
import functools
import hashlib
import os
from pathlib import Path
import sys
import tempfile
from typing import Any

from bristle_ros.target import LEVELS, target

DIGEST = 16     # [bytes] of what each file ends in
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
import llvmlite  # noqa: E402
import numba  # noqa: E402  what it finds in the environment is checked before
from numba.core.caching import (CompileResultCacheImpl, FunctionCache,  # noqa: E402
                                InTreeCacheLocator, IndexDataCacheFile)
from numba.core.registry import CPUDispatcher  # noqa: E402

from .shortcuts import shortcuts  # noqa: E402

if target() in LEVELS and 'NUMBA_CPU_FEATURES' not in os.environ:
    numba.config.CPU_NAME = target()  # type: ignore[attr-defined]
    numba.config.CPU_FEATURES = ''  # type: ignore[attr-defined]    what the level has


def _content():
    """
    Return a name for what is in the kernel files and for what compiles them.

    numba looks only at the outer function's own file, so an edit in a kernel that it calls would
    not count; a new folder for each content does what is needed.
    """
    digest = hashlib.sha256(f'{numba.__version__} {llvmlite.__version__}'.encode())
    for path in SOURCES:
        digest.update(path.read_bytes())
    return digest.hexdigest()[:16]


def _cache_directory():
    """Return the user's folder for this content, None where there can be none."""
    try:
        home = Path(os.environ.get('XDG_CACHE_HOME') or Path.home() / '.cache')
        folder = home / 'bristle_ros' / CONTENT
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


CONTENT = _content()
FOLDER = _cache_directory()
SHIPPED = Path(__file__).resolve().parents[2] / 'kernels' / CONTENT     # read only; may be missing

# 'contract' fuses multiply-add, 'nsz' and 'arcp' free the vectoriser; NaN and inf stay honest.
# error_model: the division check of Python is a branch, and a branch stops the vectoriser.
# _nrt: no reference counts, which took a tenth of a step; an allocation does not even compile.
_OPTIONS: dict[str, Any] = {'error_model': 'numpy', '_nrt': False}
# Wrappers take their share of compiling: nobody calls kernels through C, and few from Python.
_compiled = functools.partial(numba.njit, nogil=True, no_cfunc_wrapper=True,
                              fastmath={'contract', 'nsz', 'arcp'}, **_OPTIONS)


@functools.cache
def _tell(text, folder):
    """Say what is the matter with the kernels in a folder, once for all of them."""
    _say(f'the cache of compiled kernels in {folder} {text}')


def _digest(content):
    return hashlib.blake2b(content, digest_size=DIGEST).digest()


class _Checked(FunctionCache):
    """
    numba's cache of one kernel, of which each file ends in a digest of what is before it.

    Zeros in the middle of machine code would be run.
    """

    def __init__(self, function, mark):
        super().__init__(function)
        self._cache_file = file = IndexDataCacheFile(
            self._cache_path, self._impl.filename_base + mark, self._cache_file._source_stamp)
        dump, load = file._dump, file._load_data

        def dump_checked(entry):
            content = dump(entry)   # unpickling stops before what follows it
            return content + _digest(content)

        def load_checked(name):
            content = Path(file._data_path(name)).read_bytes()
            if _digest(content[:-DIGEST]) != content[-DIGEST:]:
                raise ValueError(f'{name} has another digest')
            return load(name)

        file._dump, file._load_data = dump_checked, load_checked

    def names(self, sig, codegen):
        """Whether a file of this kernel is said to be there."""
        try:
            return self._index_key(sig, codegen) in self._cache_file._load_index()
        except Exception:   # whatever unpickling makes of garbage
            return False


class _InRoom(InTreeCacheLocator):
    """Keeps a kernel in a folder of its room's name: wherever the package is installed."""

    folder = FOLDER

    def __init__(self, function, path):
        super().__init__(function, path)
        self._cache_path = str(self.folder / Path(path).parent.name)


class _Carried(_InRoom):
    """The same in the package; nothing is written there."""

    folder = SHIPPED

    def ensure_cache_path(self):
        """Leave what is there as it is."""


class _UserFiles(CompileResultCacheImpl):
    _locator_classes = (_InRoom,)


class _ShippedFiles(CompileResultCacheImpl):
    _locator_classes = (_Carried,)


class _Shipped(_Checked):
    """What the package has of one kernel, read only."""

    _impl_class = _ShippedFiles

    def load_overload(self, sig, target_context):
        """Return what is there, or None."""
        try:
            return super().load_overload(sig, target_context)
        except Exception:   # whatever unpickling makes of garbage
            _tell('is damaged: compiling anew', SHIPPED)
            return None

    def save_overload(self, sig, data):
        """Keep nothing."""


class _Cache(_Checked):
    """
    What the package has of one kernel, and the user's cache: no file is trusted.

    A damaged one is compiled anew. One process at a time saves: two that save variants of one
    kernel at once may give both the same file, and one of them would later run the other's
    machine code.
    """

    _impl_class = _UserFiles
    _writable = True

    def __init__(self, function, mark):
        super().__init__(function, mark)
        self._shipped = _Shipped(function, mark) if SHIPPED.is_dir() else None

    def names(self, sig, codegen):
        """Whether a file of this kernel is said to be there, in the package or the cache."""
        return super().names(sig, codegen) or bool(
            self._shipped and self._shipped.names(sig, codegen))

    def load_overload(self, sig, target_context):
        """Return what is cached, or None to have it compiled."""
        found = self._shipped and self._shipped.load_overload(sig, target_context)
        if found:
            return found
        try:
            return super().load_overload(sig, target_context)
        except Exception:   # whatever unpickling makes of garbage
            _tell('is damaged: compiling anew', FOLDER)
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
            _tell(f'cannot be written ({_reason(error)}): compiling in memory, at each start',
                  FOLDER)

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


class Called(CPUDispatcher):
    """What Python calls of a kernel: a dispatcher of numba's that compiles it and all it calls."""

    def compile(self, sig):  # noqa: A003
        """Compile it for such arguments, or load it."""
        with shortcuts():
            return super().compile(sig)


class Kernel(CPUDispatcher):
    """
    A kernel as other kernels call it; Python calls `called`, which is compiled when it first does.

    To hand records over from Python takes code for each of their fields, which all but a few
    kernels never need: without it compiling takes two thirds.
    """

    @functools.cached_property
    def called(self):
        """What Python calls."""
        dispatcher = _compiled()(self.py_func)
        dispatcher.__class__ = Called
        return _cached(dispatcher, '-called')

    def __call__(self, *arguments):
        """Run it; compile it first for such arguments."""
        return self.called(*arguments)


def _cached(dispatcher, mark=''):
    if FOLDER:
        dispatcher._cache = _Cache(dispatcher.py_func, mark)
    elif SHIPPED.is_dir():
        dispatcher._cache = _Shipped(dispatcher.py_func, mark)
    return dispatcher


def jit(function):
    """Compile a kernel; once for all values of its integer arguments, not for each constant."""
    dispatcher = _compiled(no_cpython_wrapper=True)(function)
    if numba.config.DISABLE_JIT:
        return dispatcher
    dispatcher.__class__ = Kernel
    _cached(dispatcher)
    resolve = dispatcher.get_call_template

    def get_call_template(args, kws):
        return resolve(tuple(map(numba.types.unliteral, args)), kws)

    dispatcher.get_call_template = get_call_template
    return dispatcher


def inlined(function):
    """Compile a kernel into the one that calls it: saves compiling all it calls once more."""
    return numba.njit(inline='always', **_OPTIONS)(function)
