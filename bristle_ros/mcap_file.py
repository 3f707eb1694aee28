"""One MCAP file on disk as rosbag2 would write it, readable up to the last flush at any moment."""
import os
import time

from mcap.writer import CompressionType, Writer

from .bag_metadata import bag_information, serialized, TopicCount

COMPRESSIONS = {'none': CompressionType.NONE, 'lz4': CompressionType.LZ4,
                'zstd': CompressionType.ZSTD}
CHUNK_SIZE = 64 * 1024      # [B] of messages in a chunk; what damage at one place costs
FLUSH_PERIOD = 0.5          # [s] the longest a message waits for its chunk to be written
SYNC_PERIOD = 1.0           # [s] between waits for the disk itself, against power cuts


class _Output:
    """
    A file without a buffer, which knows how far it is whole.

    Buffered files raise their write errors a second time when they are closed, or never.
    """

    def __init__(self, path):
        self._fd = os.open(path, os.O_WRONLY | os.O_CREAT | os.O_EXCL | os.O_CLOEXEC, 0o666)
        self._position = 0

    def write(self, data):
        view = memoryview(data)
        while view:
            done = os.write(self._fd, view)
            self._position += done
            view = view[done:]
        return len(data)

    def tell(self):
        return self._position

    def flush(self):
        pass

    def sync(self):
        os.fdatasync(self._fd)
        if os.fstat(self._fd).st_nlink == 0:
            raise FileNotFoundError('it was deleted')

    def close(self, length=None):
        """Close it, at most `length` bytes long."""
        try:
            if length is not None:
                os.ftruncate(self._fd, length)
        finally:
            os.close(self._fd)


class McapFile:
    """Messages, metadata and attachments into one new file. Thread and queue: log.py."""

    def __init__(self, path, compression='zstd', library='bristle_ros'):
        """Make the file `path`; FileExistsError if it is there."""
        self.name = path.name
        self._output = _Output(path)
        # Chunks are ended here and not by the writer, so that `_whole` knows each one's end.
        self._writer = Writer(self._output, chunk_size=1 << 62, enable_data_crcs=True,
                              compression=COMPRESSIONS[compression])
        self._schemas = {}
        self._topics = {}       # channel -> TopicCount without its count
        self._counts = {}       # channel -> messages added
        self._start, self._end = None, 0
        self._whole = 0         # [B] what is surely readable
        self._flushed = self.information()
        self._pending_since, self._pending = None, 0    # the chunk that is growing: [s], [B]
        self._synced_at = time.monotonic()
        try:
            self._writer.start(profile='ros2', library=library)
            self.add_metadata('rosbag2', serialized(self.information()))
        except BaseException:
            self._output.close()
            raise

    def channel(self, topic, type_name, schema, metadata, *, encodings=('cdr', 'ros2msg')):
        """
        Return a new channel.

        `schema`: the text of `type_name`, bytes; `metadata`: text -> text, with rosbag2's
        `offered_qos_profiles` and `topic_type_hash`; `encodings`: of messages and schema.
        """
        if (type_name, schema) not in self._schemas:
            self._schemas[type_name, schema] = self._writer.register_schema(
                type_name, encodings[1], schema)
        channel = self._writer.register_channel(
            topic, encodings[0], self._schemas[type_name, schema], metadata)
        self._topics[channel] = TopicCount(
            topic, type_name, metadata.get('topic_type_hash', ''), 0)
        self._counts[channel] = 0
        return channel

    def add(self, channel, log_time, publish_time, payload):
        """Add a message; times in ns."""
        self._writer.add_message(channel, log_time, payload, publish_time)
        self._counts[channel] += 1
        self._start = log_time if self._start is None else min(self._start, log_time)
        self._end = max(self._end, log_time)
        if self._pending_since is None:
            self._pending_since = time.monotonic()
        self._pending += len(payload)
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
        self._pending_since, self._pending = None, 0
        self._whole, self._flushed = self._output.tell(), self.information()
        if time.monotonic() - self._synced_at >= SYNC_PERIOD:
            self._output.sync()
            self._synced_at = time.monotonic()

    def information(self):
        """Return rosbag2's information on what was added so far."""
        topics = [topic._replace(messages=self._counts[channel])
                  for channel, topic in self._topics.items()]
        return bag_information([self.name], topics, self._start or 0, self._end)

    def finish(self):
        """Write the index and close; returns rosbag2's information."""
        self.flush()
        information = self.information()
        self.add_metadata('rosbag2', serialized(information))
        self._writer.finish()
        self._output.sync()
        self._output.close()
        return information

    def abandon(self):
        """Close after a write error, cut back to what is readable; returns information on that."""
        self._output.close(self._whole)
        return self._flushed
