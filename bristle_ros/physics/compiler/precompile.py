"""Compiling kernels for what they are going to be called with, before anything calls them."""
from typing import Any, TypeAlias

from numba import typeof
from numba.core.registry import cpu_target

# a kernel, and arguments of the types that it is called with
Call: TypeAlias = tuple[Any, tuple[Any, ...]]


def called(kernel: Any) -> Any:
    """Return the kernel that Python calls."""
    return getattr(kernel, 'called', kernel)


def plain(kernel: Any) -> Any:
    """Return the Python function of a kernel."""
    return getattr(kernel, 'py_func', kernel)


def compile_for(call: Call) -> None:
    """Compile a kernel, or load it, without running it."""
    kernel, arguments = call
    kernel.compile(tuple(map(typeof, arguments)))


def is_cached(call: Call) -> bool:
    """Whether the cache of compiled kernels names it; without a cache, and uncompiled, True."""
    kernel, arguments = call
    cache = getattr(kernel, '_cache', None)
    if not hasattr(cache, 'names'):
        return True
    found: bool = cache.names(tuple(map(typeof, arguments)), cpu_target.target_context.codegen())
    return found
