"""Compiled kernels of the bristle: arrays and floats in, arrays changed in place."""
from . import compiler  # noqa: F401  before any kernel: it checks what numba finds
