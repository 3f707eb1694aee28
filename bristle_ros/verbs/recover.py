"""The `recover` verb: an indexed, complete log out of one that was cut off or damaged."""
from pathlib import Path
import sys
from typing import NamedTuple

from bristle_ros.command_line import Parser
from bristle_ros.log import Attachment, Bag, Message, PART, reason_of, Recording
from bristle_ros.scene import SceneError


class Recovered(NamedTuple):
    """What `recover` saved."""

    output: Path
    messages: int
    lost: list          # one text for each part that could not be used


def default_output(path):
    """Return `run1_recovered` for the directory `run1`, `run1_recovered.mcap` for a file."""
    path = Path(path).expanduser()
    stem = Path(path.name.removesuffix('.zstd')).stem
    return path.with_name(f'{path.name}_recovered' if path.is_dir() else
                          f'{stem}_recovered.mcap')


def recover(path, output=None):
    """
    Copy what can be read into a new log.

    `output`: a bag directory, or a file if it ends in `.mcap`. Raises SceneError when the log or
    the place for the new one cannot be used, or nothing is in it.
    """
    recording = Recording(path)
    output = Path(output or default_output(path)).expanduser()
    if not any(isinstance(record, Message) for record in recording.records()):
        raise SceneError('no message in it that could be saved', source=str(recording.path))
    bag = Bag(output, '--output', first=recording.part)
    try:
        count = _copy(recording, bag)
        bag.finish()
    except OSError as error:
        raise SceneError(f'{reason_of(error)}; name another place', key='--output',
                         value=str(output)) from None
    return Recovered(output, count, recording.damage + [recording.cut] * bool(recording.cut))


def _copy(recording, bag):
    """Copy all there is, one file into one where the new log is a directory too."""
    channels, count, seen = {}, 0, {'rosbag2', PART}  # of which each file gets its own
    for record in recording.records(bag.split):
        if isinstance(record, Message):
            source = record.channel
            key = source.topic, source.schema
            if key not in channels:
                channels[key] = bag.channel(
                    source.topic, source.schema, source.schema_text, source.metadata,
                    (source.encoding, source.schema_encoding))
            bag.add(channels[key], record.log_time, record.publish_time, record.data)
            bag.keep()
            count += 1
        elif record.name not in seen:
            seen.add(record.name)
            if isinstance(record, Attachment):
                bag.add_attachment(record.name, record.media_type, record.data)
            else:
                bag.add_metadata(record.name, record.entries)
    return count


def main(argv=None):
    """Run the verb; returns its exit code."""
    parser = Parser('recover', 'Make a complete log out of one that was cut off.')
    parser.add_argument('log', help='an .mcap file or a bag directory')
    parser.add_argument('--output', help='where to (default: beside it, NAME_recovered)')
    options = parser.parse_args(sys.argv[1:] if argv is None else argv)
    result = recover(options.log, options.output)
    for text in result.lost:
        print(text)
    whole = '' if result.lost else ' (the log was complete)'
    print(f'{options.log}: saved {result.messages} messages into {result.output}{whole}')
    return 0
