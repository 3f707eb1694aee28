"""One MCAP file on disk as rosbag2 would write it, readable up to the last flush at any moment."""
import time

from mcap.writer import CompressionType, Writer

from .bag_metadata import bag_information, FileCount, serialized, TopicCount
from .output import Output

COMPRESSIONS = {'none': CompressionType.NONE, 'lz4': CompressionType.LZ4,
                'zstd': CompressionType.ZSTD}
CHUNK_SIZE = 64 * 1024      # [B] of messages in a chunk; what damage at one place costs
FLUSH_PERIOD = 0.5          # [s] the longest a message waits for its chunk to be written
SYNC_PERIOD = 1.0           # [s] between calls for the disk itself, against power cuts

# [B] Upper bounds of what MCAP and metadata add to the payloads.
_END = 4096                 # footer, statistics, the indexes of the head's records
_PER_MESSAGE = 9 + 22 + 16  # its record and its entry in the message index
_PER_CHUNK = 256            # a chunk's own record and index,
_PER_CHUNK_CHANNEL = 64     # and what each channel adds: a message index and its place
_PER_CHANNEL = 2048         # its entry in rosbag2's metadata, and in the statistics


class McapFile:
    """Messages, metadata and attachments into one new file. Thread and queue: log.py."""

    def __init__(self, path, compression='zstd', library='bristle_ros'):
        """Make the file `path`; FileExistsError if it is there."""
        self._path = path
        self._output = Output(path)
        # Chunks are ended here and not by the writer, so that `_whole` knows each one's end.
        self._writer = Writer(self._output, chunk_size=1 << 62, enable_data_crcs=True,
                              compression=COMPRESSIONS[compression])
        self._schemas = {}
        self._topics = {}       # channel -> TopicCount without its count
        self._counts = {}       # channel -> messages added
        self._start, self._end = None, 0
        self._whole = 0         # [B] what is surely readable
        self._tail = _END       # [B] what ending the file now would add, at most
        self._flushed = self.count()
        self._pending_since, self._pending = None, 0    # the chunk that is growing: [s], [B],
        self._beside = 0        # [B] and at most what else it will have
        self._synced_at = time.monotonic()
        self._ended = False
        try:
            self._writer.start(profile='ros2', library=library)
            self._describe()
        except BaseException:
            self.remove()
            raise

    @property
    def messages(self):
        """How many have been added."""
        return sum(self._counts.values())

    def channel(self, topic, type_name, schema, metadata, encodings=('cdr', 'ros2msg')):
        """
        Return a new channel.

        `schema`: the text of `type_name`, bytes; `metadata`: text -> text, with rosbag2's
        `offered_qos_profiles` and `topic_type_hash`; `encodings`: of messages and schema.
        """
        size = _PER_CHANNEL + len(topic) + sum(len(key) + len(value) + 8
                                               for key, value in metadata.items())
        new = (type_name, schema) not in self._schemas
        size += new * (len(schema) + len(type_name) + 64)
        # Once in a chunk, once more at the end.
        self._output.reserve(self.size_with(b'') + 2 * size)
        if new:
            self._schemas[type_name, schema] = self._writer.register_schema(
                type_name, encodings[1], schema)
        channel = self._writer.register_channel(
            topic, encodings[0], self._schemas[type_name, schema], metadata)
        self._tail += size
        self._beside += size
        self._topics[channel] = TopicCount(
            topic, type_name, metadata.get('topic_type_hash', ''), 0,
            metadata.get('offered_qos_profiles', ''))
        self._counts[channel] = 0
        return channel

    def size_with(self, payload):
        """Return the most that the file can have [B] if it takes `payload` and ends then."""
        chunk = _PER_CHUNK + _PER_CHUNK_CHANNEL * len(self._topics)
        return (self._output.tell() + self._pending + self._beside + len(payload) + _PER_MESSAGE
                + 2 * chunk + self._tail)

    def add(self, channel, log_time, publish_time, payload):
        """Add a message; times in ns. When there is no room for it, nothing has happened."""
        self._output.reserve(self.size_with(payload))
        self._writer.add_message(channel, log_time, payload, publish_time)
        self._counts[channel] += 1
        self._start = log_time if self._start is None else min(self._start, log_time)
        self._end = max(self._end, log_time)
        if self._pending_since is None:
            self._pending_since = time.monotonic()
        self._pending += len(payload)
        self._beside += _PER_MESSAGE
        if self._pending >= CHUNK_SIZE:
            self.flush()

    def add_metadata(self, name, entries):
        """Add a record of text -> text, at once."""
        self._writer.add_metadata(name, entries)
        self._whole = self._output.tell()

    def add_attachment(self, name, media_type, data):
        """Add a file within the file, at once."""
        self._writer.add_attachment(0, 0, name, media_type, data)
        self._whole = self._output.tell()

    def due(self):
        """Return the seconds until `keep` has something to do, None if it has nothing."""
        if self._pending_since is None:
            return None
        return max(0.0, self._pending_since + FLUSH_PERIOD - time.monotonic())

    def keep(self):
        """Bring what waited for FLUSH_PERIOD into the file, about once a second to the disk."""
        if self.due() == 0.0:
            self.flush()

    def flush(self):
        """Bring all there is into the file."""
        self._writer.flush()
        if self._pending_since is not None:
            self._tail += _PER_CHUNK + _PER_CHUNK_CHANNEL * len(self._topics)
            self._pending_since, self._pending, self._beside = None, 0, 0
        self._whole, self._flushed = self._output.tell(), self.count()
        if time.monotonic() - self._synced_at >= SYNC_PERIOD:
            self._output.sync()
            self._synced_at = time.monotonic()

    def count(self):
        """Return the FileCount of what was added so far."""
        return FileCount(self._path.name, self._start or 0, self._end, tuple(
            topic._replace(messages=self._counts[channel])
            for channel, topic in self._topics.items()))

    def end(self):
        """Write all that a complete file has; returns the Output, which still is to be closed."""
        self.flush()
        self._describe()
        self._writer.finish()
        self._ended = True
        return self._output

    def finish(self):
        """Complete the file and close it; returns its FileCount."""
        self.end().close()
        return self.count()

    def abandon(self):
        """
        Close after an error, complete if there is room, else cut back to what is readable.

        Returns the FileCount of what is in it.
        """
        if self._ended:
            return self.count()  # what failed was bringing it to the disk
        try:
            if self._output.broken:
                raise OSError('nothing can be written any more')
            self.end()
        except Exception:  # whatever it was, what is whole stays so
            self._output.close(self._whole)
            return self._flushed
        self._output.close()
        return self.count()

    def remove(self):
        """Close it and leave nothing behind."""
        try:
            self._output.close()
        finally:
            self._path.unlink(missing_ok=True)

    def _describe(self):
        self.add_metadata('rosbag2', serialized(bag_information([self.count()])))
