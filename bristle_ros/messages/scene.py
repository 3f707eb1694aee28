"""
What a log needs to be used, as one message: `~/scene`, a std_msgs/String that holds JSON.

Tools that copy messages leave a file's metadata, attachments and channel metadata behind; a
message comes along, and a recorder hears it too.
"""
from collections.abc import Mapping
import json
from typing import TypeAlias

from .encode import decode_string, encode_string

Texts: TypeAlias = Mapping[str, str]

SCENE = '~/scene'
SECTIONS = ('scene', 'machine', 'run', 'topics')


def encode_scene(yaml: str, machine: Texts, run: Texts, topics: Texts) -> bytes:
    """
    Return the message.

    yaml : str, the scene file. The others are text to text: what `machine.provenance` says; step
    [s] and origin of time [ns] of the run; and topics, full name to that before remapping.
    """
    return encode_string(json.dumps({
        'scene': {'yaml': yaml}, 'machine': machine, 'run': run, 'topics': topics}))


def decode_scene(payload: bytes) -> dict[str, dict[str, str]]:
    """Return section -> (text -> text), or {} for a message that is none."""
    try:
        content = json.loads(decode_string(payload))
    except ValueError:
        return {}
    if not isinstance(content, dict) or not all(
            isinstance(content.get(section), dict) for section in SECTIONS):
        return {}
    return {section: {key: str(text) for key, text in content[section].items()}
            for section in SECTIONS}
