"""What rosbag2 wants to know about a bag beside its messages: `metadata.yaml` and QoS profiles."""
import os
from typing import NamedTuple

import yaml

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


def qos_text():
    """Return the `offered_qos_profiles` of a channel."""
    return _dump(QOS)


class TopicCount(NamedTuple):
    """A topic of a bag, and how many messages it has."""

    name: str
    type: str
    hash: str
    messages: int


def bag_information(files, topics, start, end):
    """
    Return rosbag2's information on a bag, format version 9, as ROS 2 Jazzy writes it.

    `files`: names; `topics`: TopicCount each; `start`, `end` [ns]: first and last log time.
    """
    total = sum(topic.messages for topic in topics)
    times = {'duration': {'nanoseconds': end - start},
             'starting_time': {'nanoseconds_since_epoch': start}}
    return {
        'version': 9,
        'storage_identifier': 'mcap',
        **times,
        'message_count': total,
        'topics_with_message_count': [{
            'topic_metadata': {
                'name': topic.name, 'type': topic.type, 'serialization_format': 'cdr',
                'offered_qos_profiles': QOS, 'type_description_hash': topic.hash},
            'message_count': topic.messages} for topic in topics],
        'compression_format': '',
        'compression_mode': '',
        'relative_file_paths': files,
        'files': [{'path': name, **times, 'message_count': total} for name in files],
        'custom_data': None,
        'ros_distro': 'jazzy'}


def serialized(information):
    """Return the value of the `rosbag2` metadata record in a file."""
    return {'serialized_metadata': _dump(information)}


def write_metadata(directory, information):
    """Write `metadata.yaml`, whole or not at all."""
    path = directory / 'metadata.yaml'
    part = directory / '.metadata.yaml.part'
    try:
        with open(part, 'w', encoding='utf-8') as stream:
            stream.write(_dump({'rosbag2_bagfile_information': information}))
            stream.flush()
            os.fdatasync(stream.fileno())
        part.replace(path)
    except OSError:
        part.unlink(missing_ok=True)
        raise
