"""The verb `view`: a page that shows a scene, a log or a node in 3-D, its curves, and controls."""
from typing import TYPE_CHECKING

from bristle_ros.lazy import lazily

if TYPE_CHECKING:
    from .frame import Frame as Frame

__getattr__, __dir__ = lazily(__name__, {
    'frame': ['Frame'],
})
