"""What a run leaves in MCAP files: writing it beside the run, and reading what is there."""
from typing import TYPE_CHECKING

from bristle_ros.lazy import lazily

if TYPE_CHECKING:
    from .bag import Bag as Bag, reason_of as reason_of
    from .bag_metadata import PART as PART
    from .command_file import event_at as event_at, read_commands as read_commands
    from .head import head_of as head_of
    from .machine import (differences as differences, measured_on as measured_on,
                          provenance as provenance)
    from .reader import Attachment as Attachment, Message as Message
    from .recorded import in_order as in_order
    from .recording import (is_event as is_event, load_tolerance as load_tolerance,
                            logged_commands as logged_commands, Recording as Recording,
                            scene_of as scene_of)
    from .writer import Log as Log

__getattr__, __dir__ = lazily(__name__, {
    'bag': ['Bag', 'reason_of'],
    'bag_metadata': ['PART'],
    'command_file': ['event_at', 'read_commands'],
    'head': ['head_of'],
    'machine': ['differences', 'measured_on', 'provenance'],
    'reader': ['Attachment', 'Message'],
    'recorded': ['in_order'],
    'recording': ['is_event', 'load_tolerance', 'logged_commands', 'Recording', 'scene_of'],
    'writer': ['Log'],
})
