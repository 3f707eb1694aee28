"""One module a verb; each has main(arguments), which returns the exit code."""
from typing import TYPE_CHECKING

from bristle_ros.lazy import lazily

if TYPE_CHECKING:
    from .bench import best_of as best_of, measure as measure

__getattr__, __dir__ = lazily(__name__, {
    'bench': ['best_of', 'measure'],
})
