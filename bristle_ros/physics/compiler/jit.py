"""
The one `jit`: compiler flags, and what Python calls of a kernel.

It reaches into numba: tried with 0.68.1; test/physics/compiler/test_hooks.py names what is gone.
"""
import functools
import os
from typing import Any

from bristle_ros.target import LEVELS, target


class CompilerRefused(RuntimeError):
    """The compiler cannot be used as the environment has it; `str()` is one line."""


def _check_threads():
    """Raise CompilerRefused where numba would end in a traceback, or print one and go on."""
    text = os.environ.get('NUMBA_NUM_THREADS')
    if text is not None and not (text.strip().isdecimal() and int(text) > 0):
        raise CompilerRefused(f'NUMBA_NUM_THREADS = {text!r}: must be a whole number above 0: '
                              'give one, or unset it')


_check_threads()
import numba  # noqa: E402  what it finds in the environment is checked before
from numba.core.registry import CPUDispatcher  # noqa: E402

from .kernel_cache import cache_of  # noqa: E402
from .shortcuts import shortcuts  # noqa: E402

if target() in LEVELS and 'NUMBA_CPU_FEATURES' not in os.environ:
    numba.config.CPU_NAME = target()  # type: ignore[attr-defined]
    # what the level has; LLVM would fill half of a 512-bit register, for the sake of processors
    # whose clock falls when they use all of it: 4 % slower on a Zen 4, the bits are the same
    numba.config.CPU_FEATURES = (  # type: ignore[attr-defined]
        '-prefer-256-bit' if target() == 'x86-64-v4' else '')

# 'contract' fuses multiply-add, 'nsz' and 'arcp' free the vectoriser; NaN and inf stay honest.
# error_model: the division check of Python is a branch, and a branch stops the vectoriser.
# _nrt: no reference counts, which took a tenth of a step; an allocation does not even compile.
_OPTIONS: dict[str, Any] = {'error_model': 'numpy', '_nrt': False}
# Wrappers take their share of compiling: nobody calls kernels through C, and few from Python.
_compiled = functools.partial(numba.njit, nogil=True, no_cfunc_wrapper=True,
                              fastmath={'contract', 'nsz', 'arcp'}, **_OPTIONS)


class Called(CPUDispatcher):
    """What Python calls of a kernel: a dispatcher of numba's that compiles it and all it calls."""

    def compile(self, sig):  # noqa: A003
        """Compile it for such arguments, or load it."""
        with shortcuts():
            return super().compile(sig)


class Kernel(CPUDispatcher):
    """
    A kernel as other kernels call it; Python calls `called`, which is compiled when it first does.

    To hand records over from Python takes code for each of their fields, which all but a few
    kernels never need: without it compiling takes two thirds.
    """

    @functools.cached_property
    def called(self):
        """What Python calls."""
        dispatcher = _compiled()(self.py_func)
        dispatcher.__class__ = Called
        dispatcher._cache = cache_of(self.py_func, '-called')
        return dispatcher

    @functools.cached_property
    def _cache(self):
        """Where its code is kept; most kernels are parts of others, and nothing asks for it."""
        return cache_of(self.py_func)

    def __call__(self, *arguments):
        """Run it; compile it first for such arguments."""
        return self.called(*arguments)


def jit(function):
    """Compile a kernel; once for all values of its integer arguments, not for each constant."""
    dispatcher = _compiled(no_cpython_wrapper=True)(function)
    if numba.config.DISABLE_JIT:
        return dispatcher
    dispatcher.__class__ = Kernel
    del dispatcher._cache   # numba's, so that the property is found
    resolve = dispatcher.get_call_template

    def get_call_template(args, kws):
        return resolve(tuple(map(numba.types.unliteral, args)), kws)

    dispatcher.get_call_template = get_call_template
    return dispatcher


def inlined(function):
    """Compile a kernel into the one that calls it: saves compiling all it calls once more."""
    return numba.njit(inline='always', **_OPTIONS)(function)
