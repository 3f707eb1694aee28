"""The wall clock, and which chunk is due."""
from typing import TYPE_CHECKING

from bristle_ros.lazy import lazily

if TYPE_CHECKING:
    from .driver import Driver as Driver, Event as Event
    from .pacing_thread import PacingThread as PacingThread

__getattr__, __dir__ = lazily(__name__, {
    'driver': ['Driver', 'Event'],
    'pacing_thread': ['PacingThread'],
})
