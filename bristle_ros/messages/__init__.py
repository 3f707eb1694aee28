"""What is in each ROS message, as bytes, without ROS."""
from typing import TYPE_CHECKING

from bristle_ros.lazy import lazily

if TYPE_CHECKING:
    from .definitions import schema_text as schema_text, TYPE_HASHES as TYPE_HASHES
    from .encode import (command_types as command_types, decode_diagnostics as decode_diagnostics,
                         TOPICS as TOPICS)
    from .scene import decode_scene as decode_scene, encode_scene as encode_scene, SCENE as SCENE
    from .transforms import (decode_pose as decode_pose, encode_transforms as encode_transforms,
                             transforms_topic as transforms_topic)
    from .urdf import robot_description as robot_description

__getattr__, __dir__ = lazily(__name__, {
    'definitions': ['schema_text', 'TYPE_HASHES'],
    'encode': ['command_types', 'decode_diagnostics', 'TOPICS'],
    'scene': ['decode_scene', 'encode_scene', 'SCENE'],
    'transforms': ['decode_pose', 'encode_transforms', 'transforms_topic'],
    'urdf': ['robot_description'],
})
