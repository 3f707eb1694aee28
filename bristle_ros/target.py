"""
The processor that kernels are compiled for: a level of x86-64, not the one they happen to run on.

Code of a level runs on every processor that has it, and gives the same bits there: so kernels can
be compiled once and shipped, and a log can be verified on another machine of that level. Time and
bits are those of code for the very processor, where that was tried (AVX-512).
"""
from functools import cache
import os

# x86-64 psABI, table of micro-architecture levels, in LLVM's names; each on top of those below it
LEVELS = {
    'x86-64-v4': ('avx512f', 'avx512bw', 'avx512cd', 'avx512dq', 'avx512vl'),
    'x86-64-v3': ('avx', 'avx2', 'bmi', 'bmi2', 'f16c', 'fma', 'lzcnt', 'movbe'),
    'x86-64-v2': ('cx16', 'popcnt', 'sahf', 'sse3', 'ssse3', 'sse4.1', 'sse4.2'),
}
CHOSEN = 'NUMBA_CPU_NAME'   # what the environment may say instead


def level_of(features: dict[str, bool]) -> str:
    """Return the highest level whose features are all there, '' for none."""
    found = ''
    for level, needed in reversed(LEVELS.items()):
        if not all(features.get(name) for name in needed):
            break
        found = level
    return found


@cache
def target() -> str:
    """Return what kernels are compiled for: a level, or the name of another processor."""
    chosen = os.environ.get(CHOSEN)
    if chosen:
        return chosen
    from llvmlite import binding
    return level_of(dict(binding.get_host_cpu_features())) or str(binding.get_host_cpu_name())
