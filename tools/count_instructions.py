#!/usr/bin/env python3
"""
Count the instructions of a step: tools/count_instructions.py [--step].

They say what a scene pays for, whatever else the machine does. The scene is cutting_brush at
0.1 ms, as it is and with each feature changed, or with --step as it is alone. Kernels are those
of x86-64-v3 everywhere. Prints a Markdown table. A child is stepped through, one instruction at a
time, which takes about 10 us for each.
"""
import ctypes
import os
from pathlib import Path
import signal
import sys

ROOT = Path(__file__).resolve().parent.parent
sys.path.insert(0, str(ROOT))
os.environ['NUMBA_CPU_NAME'] = 'x86-64-v3'  # before kernels are imported

from bristle_ros.report.lean.features import changed, FEATURES  # noqa: E402
from bristle_ros.report.precision.subjects import scene_of  # noqa: E402
from bristle_ros.simulation.simulation import Simulation  # noqa: E402

BEFORE = 2000   # steps: the brush is on its way down, and touches
STEPS = 20
TRACE_ME, SINGLE_STEP = 0, 9    # of linux/ptrace.h

_libc = ctypes.CDLL(None, use_errno=True)
_libc.ptrace.argtypes = [ctypes.c_long, ctypes.c_long, ctypes.c_void_p, ctypes.c_void_p]
_libc.ptrace.restype = ctypes.c_long


def _trace(request, process):
    if _libc.ptrace(request, process, None, None):
        number = ctypes.get_errno()
        raise OSError(number, f'ptrace: {os.strerror(number)}')


def instructions(work, *arguments):
    """Return how many instructions a child of this process executes to do some work and end."""
    child = os.fork()
    if child == 0:
        try:
            _trace(TRACE_ME, 0)
            os.kill(os.getpid(), signal.SIGSTOP)
            work(*arguments)
            os._exit(0)
        finally:    # an error: what it has counted is nothing
            os._exit(1)
    count, (_, status) = 0, os.waitpid(child, 0)
    while os.WIFSTOPPED(status):
        _trace(SINGLE_STEP, child)
        _, status = os.waitpid(child, 0)
        count += 1
    if status:
        raise OSError('a child could not be traced, or did not end well')
    return count


def of_steps(scene):
    """Return what a step takes on the mean: (instructions, iterations, matrices)."""
    simulation = Simulation(scene)
    simulation.advance(BEFORE)
    counts = [instructions(simulation.advance, steps) for steps in (1, 1 + STEPS)]
    simulation.advance(1)
    before = simulation.state.counts.sum(axis=0)
    simulation.advance(STEPS)
    made = simulation.state.counts.sum(axis=0) - before
    return (counts[1] - counts[0]) / STEPS, made[0] / STEPS, made[2] / STEPS


def main():
    """Print the table."""
    changes = {'as it is': {}}
    for feature in FEATURES if '--step' not in sys.argv[1:] else ():
        if feature.bristles == 1 and not feature.around:
            changes |= {feature.name: feature.present} if feature.present else {
                f'without {feature.name}': feature.absent}
    print('| cutting_brush, 0.1 ms | instructions a step | iterations | matrices |\n'
          '|---|---|---|---|')
    for name, change in changes.items():
        count, iterations, matrices = of_steps(changed(scene_of('cutting_brush', 1e-4), change))
        print(f'| {name} | {count:.0f} | {iterations:.2f} | {matrices:.3f} |', flush=True)


if __name__ == '__main__':
    main()
