"""How kernels are compiled: flags, the cache and its key, vectors, the shared queue."""
# flake8: noqa: F401  what other rooms may use
from .jit import CompilerRefused, inlined, jit
from .lanes import (halves8, join4, load4, load8, push_first4, push_last4, splat4, splat_of8,
                    splats6, store4, store8, transpose4)
from .precompile import Call, called, compile_for, is_cached, plain
from .work_queue import take
