"""A log on disk: a bare MCAP file, or rosbag2's directory of files that are each complete."""
from pathlib import Path

from bristle_ros.scene import SceneError

from .bag_metadata import bag_information, PART, write_metadata
from .file import McapFile

MEGABYTE = 1_000_000


class Bag:
    """
    Takes messages, metadata and attachments; begins a new file before one grows too large.

    Each file has all metadata, attachments and channels that were given, so that it can be used
    alone. Raises OSError when the disk does.
    """

    def __init__(self, path, key, *, compression='zstd', max_size=0, first=0):
        """
        Make the directory `path`, or the file if it ends in `.mcap`, which is never split.

        `key`: what a message about a bad path calls it; `max_size` [B] of a file, 0: any;
        `first`: which part of a log its first file is. Raises SceneError.
        """
        self.place = Path(path).expanduser()
        bare = self.place.suffix == '.mcap'
        self._directory = None if bare else self.place
        self._max_size = 0 if bare else max_size
        self._compression = compression
        self._first = first
        self._head = []         # what each file begins with: (method of McapFile, arguments)
        self._latched = []      # messages that each file begins with: arguments of `_put`
        self._channels = []     # arguments of McapFile.channel; their places are our channels
        self._known = {}        # our channel -> the present file's
        self._done = []         # FileCounts of files that were completed
        self._closing = []      # (Output, thread) of files that are being closed
        self._split = False
        self._file = None
        try:
            self.place.parent.mkdir(parents=True, exist_ok=True)
            if not bare:
                self.place.mkdir()  # the one of two that comes second fails here
            try:
                self._open()
            except OSError:
                self.discard()
                raise
        except (OSError, ValueError) as error:
            raise SceneError(f'{reason_of(error)}; name another place', key=key,
                             value=str(path)) from None

    @property
    def _path(self):
        name = f'{self.place.name}_{len(self._done)}.mcap'
        return self._directory / name if self._directory else self.place

    def channel(self, *arguments, **keywords):
        """Return a new channel; see McapFile.channel."""
        self._channels.append((arguments, keywords))
        return len(self._channels) - 1

    def add_metadata(self, name, entries):
        """Add a record of text -> text to this file and to those that follow."""
        self._to_all('add_metadata', name, entries)

    def add_attachment(self, name, media_type, data):
        """Add a file within the file to this one and to those that follow."""
        self._to_all('add_attachment', name, media_type, data)

    def _to_all(self, method, *arguments):
        self._head.append((method, arguments))
        getattr(self._file, method)(*arguments)

    def add(self, channel, log_time, publish_time, payload):
        """Add a message; times in ns."""
        full = self._max_size and self._file.messages and (
            self._file.size_with(payload) > self._max_size)
        first = full or self._split
        if first:
            self._next()
            for latched, published, content in self._latched:
                self._put(latched, log_time, published, content)
        self._put(channel, log_time, publish_time, payload)
        if first:
            self._file.flush()  # a file that is killed at once then has a channel to read

    def latch(self, channel, log_time, publish_time, payload):
        """Add a message to this file and, at the time of their first, to those that follow."""
        self.add(channel, log_time, publish_time, payload)
        self._latched.append((channel, publish_time, payload))

    def _put(self, channel, log_time, publish_time, payload):
        if channel not in self._known:
            arguments, keywords = self._channels[channel]
            self._known[channel] = self._file.channel(*arguments, **keywords)
        self._file.add(self._known[channel], log_time, publish_time, payload)

    def split(self):
        """Have the next message begin a new file, if this one has any and need not be bare."""
        self._split = self._directory is not None and self._file.messages > 0

    def due(self):
        """Return the seconds until `keep` has something to do, None if it has nothing."""
        return self._file.due()

    def keep(self):
        """Bring what has waited long enough into the file, and raise what closing others found."""
        self._file.keep()
        for output, thread in self._closing:
            if not thread.is_alive():
                output.check()
        self._closing = [(output, thread) for output, thread in self._closing if thread.is_alive()]

    def flush(self):
        """Bring all there is into the file."""
        self._file.flush()

    def finish(self):
        """Complete the log."""
        file, self._file = self._file, None
        try:
            self._done.append(file.finish())
        except OSError:
            self._file = file
            raise
        self._describe()
        for output, thread in self._closing:
            thread.join()
            output.check()

    def abandon(self):
        """Complete what can be completed after an error; raises OSError when nothing can."""
        if self._file is not None:  # else there was no room for another
            self._done.append(self._file.abandon())
        self._describe()

    def discard(self):
        """Leave nothing behind of a log that could not be begun."""
        if self._file is not None:
            self._file.remove()
        if self._directory:
            self._directory.rmdir()

    def _open(self):
        file = McapFile(self._path, self._compression)
        try:
            file.add_metadata(PART, {'number': str(self._first + len(self._done))})
            for method, arguments in self._head:
                getattr(file, method)(*arguments)
        except OSError:
            file.remove()
            raise
        self._file, self._known = file, {}

    def _next(self):
        self._split = False
        output = self._file.end()
        # The disk may take its time: the messages that come now must not wait for it.
        self._closing.append((output, output.closing()))
        self._done.append(self._file.count())
        self._file = None
        self._open()

    def _describe(self):
        if self._directory:
            write_metadata(self._directory, bag_information(self._done))


def reason_of(error):
    """Return what an error says, as a part of a line."""
    if isinstance(error, FileExistsError):
        return 'exists already'
    if isinstance(error, OSError):
        return (error.strerror or str(error)).lower()
    return f'{type(error).__name__}: {error}'
