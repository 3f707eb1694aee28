"""
Where compiled kernels are kept: looked for in the package first, then in the user's cache.

No edit in a kernel file goes unnoticed, and no file is trusted. It reaches into numba: tried with
0.68.1; test/physics/compiler/test_hooks.py names what is gone.
"""
import contextlib
import fcntl
import functools
import hashlib
import os
from pathlib import Path
import sys
import tempfile

import llvmlite
import numba
from numba.core.caching import (CompileResultCacheImpl, FunctionCache, InTreeCacheLocator,
                                IndexDataCacheFile, NullCache)

DIGEST = 16     # [bytes] of what each file ends in
SOURCES = sorted(Path(__file__).resolve().parents[1].rglob('*.py'))  # every kernel is in there


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

    def load_overload(self, sig, target_context):
        """
        Return what is there, or None.

        numba's own prepares to compile first, which takes a third of a warm start, and scipy's
        BLAS; what does compile prepares by itself.
        """
        with self._guard_against_spurious_io_errors():
            return self._load_overload(sig, target_context)

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


def cache_of(function, mark=''):
    """Return the cache of a kernel's code; `mark` tells variants of one function apart."""
    if FOLDER:
        return _Cache(function, mark)
    return _Shipped(function, mark) if SHIPPED.is_dir() else NullCache()
