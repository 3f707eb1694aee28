"""
Many runs of a scene: designs, batches on one machine or many, measures, pages, fits.

Needs the extra `[study]`.
"""
from typing import TYPE_CHECKING

from bristle_ros.lazy import lazily

if TYPE_CHECKING:
    from .store import open_study as open_study

__getattr__, __dir__ = lazily(__name__, {'store': ['open_study']})
