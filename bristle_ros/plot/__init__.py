"""The verb `plot`: a log, or the arrays of `simulate`, as one page of figures."""
from typing import TYPE_CHECKING

from bristle_ros.lazy import lazily

if TYPE_CHECKING:
    from .series import read as read

__getattr__, __dir__ = lazily(__name__, {'series': ['read']})
