"""The ROS 2 node, and the one that watches it: the only room that imports rclpy."""
from typing import TYPE_CHECKING

from bristle_ros.lazy import lazily

if TYPE_CHECKING:
    from .watch import Watch as Watch

__getattr__, __dir__ = lazily(__name__, {
    'watch': ['Watch'],
})
