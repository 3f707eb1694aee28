"""What rosbag2 wants to know about a bag beside its messages: `metadata.yaml` and QoS profiles."""
import os
from typing import NamedTuple

import yaml

METADATA = 'metadata.yaml'  # written when all files are complete
PART = 'bristle_ros.part'   # metadata record: which file of its log a file is
_FOREVER = {'sec': 9223372036, 'nsec': 854775807}
QOS = [{
    'history': 'keep_last', 'depth': 10, 'reliability': 'reliable', 'durability': 'volatile',
    'deadline': _FOREVER, 'lifespan': _FOREVER,
    'liveliness': 'automatic', 'liveliness_lease_duration': _FOREVER,
    'avoid_ros_namespace_conventions': False}]


class _NoAliases(yaml.SafeDumper):
    """Writes `_FOREVER` out each time: yaml-cpp reads anchors, but people read this too."""

    def ignore_aliases(self, data):
        return True


def _dump(data):
    return yaml.dump(data, Dumper=_NoAliases, sort_keys=False)


def qos_text(*, latched=False):
    """Return the `offered_qos_profiles` of a channel; who comes late gets what is `latched`."""
    return _dump([{**QOS[0], 'depth': 1, 'durability': 'transient_local'}] if latched else QOS)


class TopicCount(NamedTuple):
    """A topic of a bag, and how many messages it has."""

    name: str
    type: str  # noqa: A003
    hash: str  # noqa: A003
    messages: int
    qos: str = ''       # as `qos_text` gives it


class FileCount(NamedTuple):
    """What one file of a bag holds; times in ns."""

    name: str
    start: int          # first log time
    end: int            # last
    topics: tuple       # of TopicCount

    @property
    def messages(self):
        """How many it holds."""
        return sum(topic.messages for topic in self.topics)


def bag_information(files):
    """Return rosbag2's information on a bag of FileCounts: version 9, as ROS 2 Jazzy writes it."""
    totals = {}
    for topic in (topic for file in files for topic in file.topics):
        before = totals.get((topic.name, topic.type))
        totals[topic.name, topic.type] = topic._replace(
            messages=topic.messages + (before.messages if before else 0))
    filled = [file for file in files if file.messages] or files
    start, end = min(file.start for file in filled), max(file.end for file in filled)
    return {
        'version': 9,
        'storage_identifier': 'mcap',
        **_times(start, end),
        'message_count': sum(file.messages for file in files),
        'topics_with_message_count': [{
            'topic_metadata': {
                'name': topic.name, 'type': topic.type, 'serialization_format': 'cdr',
                'offered_qos_profiles': _profiles(topic), 'type_description_hash': topic.hash},
            'message_count': topic.messages} for topic in totals.values()],
        'compression_format': '',
        'compression_mode': '',
        'relative_file_paths': [file.name for file in files],
        'files': [{'path': file.name, **_times(file.start, file.end),
                   'message_count': file.messages} for file in files],
        'custom_data': None,
        'ros_distro': 'jazzy'}


def _profiles(topic):
    try:
        profiles = yaml.safe_load(topic.qos)
    except yaml.YAMLError:  # a file that was mangled, and is being recovered
        profiles = None
    return profiles if isinstance(profiles, list) else QOS


def _times(start, end):
    return {'duration': {'nanoseconds': end - start},
            'starting_time': {'nanoseconds_since_epoch': start}}


def serialized(information):
    """Return the value of the `rosbag2` metadata record in a file."""
    return {'serialized_metadata': _dump(information)}


def write_metadata(directory, information):
    """Write `metadata.yaml`, whole or not at all."""
    path = directory / METADATA
    part = directory / f'.{METADATA}.part'
    try:
        with open(part, 'w', encoding='utf-8') as stream:
            stream.write(_dump({'rosbag2_bagfile_information': information}))
            stream.flush()
            os.fdatasync(stream.fileno())
        part.replace(path)
    except OSError:
        part.unlink(missing_ok=True)
        raise
