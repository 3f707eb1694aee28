"""The bytes of one MCAP file on disk: unbuffered, with room kept for its end, synced beside."""
import ctypes
import errno
import os
import resource
import threading

_MARGIN = 256 * 1024    # [B] asked for beyond what is needed, so that it is asked for seldom
_KEEP_SIZE = 1          # FALLOC_FL_KEEP_SIZE: the room does not show in the file's length
_FULL = {errno.ENOSPC, errno.EDQUOT, errno.EFBIG}


class Output:
    """
    A new file. Errors of the disk are raised by the next call.

    There is no buffer: buffered files raise their write errors a second time when closed, or
    never. `broken`: a write has failed, so what lies after the last whole record is of no use.
    """

    def __init__(self, path):
        """Make the file; FileExistsError if it is there."""
        self._fd = os.open(path, os.O_WRONLY | os.O_CREAT | os.O_EXCL | os.O_CLOEXEC, 0o666)
        self.broken = False
        self._position = 0
        self._room = 0          # [B] up to which the disk has promised to take it
        self._error = None
        self._syncing = None

    def write(self, data):
        """Write all of it."""
        view = memoryview(data)
        try:
            while view:
                done = os.write(self._fd, view)
                self._position += done
                view = view[done:]
        except OSError:
            self.broken = True
            raise
        return len(data)

    def tell(self):
        """Return the bytes written."""
        return self._position

    def flush(self):
        """Do nothing: the writer of the mcap package asks for it."""

    def reserve(self, length):
        """
        Have the disk promise to take a file of `length` bytes.

        Raises OSError when it cannot, while there still is the room promised before. Where a file
        system cannot promise, nothing happens, and a full disk is found when it is full.
        """
        limit, _ = resource.getrlimit(resource.RLIMIT_FSIZE)
        if limit != resource.RLIM_INFINITY and length > limit:
            raise OSError(errno.EFBIG, os.strerror(errno.EFBIG))
        if length <= self._room:
            return
        for end in (length + _MARGIN, length):
            number = _allocate(self._fd, self._position, end - self._position)
            if number not in _FULL:
                self._room = end  # granted, or nobody promises anything here
                return
        raise OSError(number, os.strerror(number))

    def sync(self):
        """Begin to bring it to the disk itself, unless that is under way."""
        if self._syncing is None or not self._syncing.is_alive():
            self.check()
            # A busy disk may take seconds, in which the next messages must leave this process.
            self._syncing = threading.Thread(target=self._sync, name='log sync', daemon=True)
            self._syncing.start()

    def check(self):
        """Raise what a sync has found, once."""
        error, self._error = self._error, None
        if error is not None:
            raise error

    def _sync(self):
        try:
            os.fdatasync(self._fd)
            if os.fstat(self._fd).st_nlink == 0:
                raise FileNotFoundError('it was deleted')
        except OSError as error:
            self._error = error

    def close(self, length=None):
        """Close it at its length, or at `length` bytes; the room kept goes back to the disk."""
        try:
            os.ftruncate(self._fd, self._position if length is None else length)
            if self._syncing is not None:
                self._syncing.join()
            self._sync()
        finally:
            os.close(self._fd)
        self.check()

    def closing(self):
        """Close it from a thread of its own, which is returned; `check` says how that went."""
        def close():
            try:
                self.close()
            except OSError as error:
                self._error = error
        thread = threading.Thread(target=close, name='log close', daemon=True)
        thread.start()
        return thread


def _allocate(fd, offset, length):
    """Return 0 or an error number; what stands at `offset` and after stays as it is."""
    try:
        fallocate = ctypes.CDLL(None, use_errno=True).fallocate
    except AttributeError:
        return errno.EOPNOTSUPP  # not every system has it
    fallocate.argtypes = ctypes.c_int, ctypes.c_int, ctypes.c_int64, ctypes.c_int64
    return 0 if fallocate(fd, _KEEP_SIZE, offset, length) == 0 else ctypes.get_errno()
