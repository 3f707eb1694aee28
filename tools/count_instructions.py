#!/usr/bin/env python3
"""
Count the instructions of a step with each feature of a scene changed: tools/count_instructions.py.

They say what a scene pays for, whatever else the machine does. Needs valgrind; the scene is
cutting_brush at 0.1 ms. Prints a Markdown table. The first run compiles, so it is made without.
"""
import ctypes
from pathlib import Path
import re
import subprocess
import sys
import tempfile

ROOT = Path(__file__).resolve().parent.parent
sys.path.insert(0, str(ROOT))

from bristle_ros.report.features import CHANGES  # noqa: E402
from bristle_ros.report.work_precision import scene_of  # noqa: E402
from bristle_ros.simulation import Simulation  # noqa: E402

STEPS = 1000
NAMES = [name for name in CHANGES if 'bristles' not in name]


def step_them():
    """Advance each scene; a call of getsid, which nothing else makes, ends a count of valgrind."""
    libc = ctypes.CDLL(None)
    for name in NAMES:
        simulation = Simulation(CHANGES[name](scene_of('cutting_brush', 1e-4)))
        simulation.advance(2 * STEPS)   # the brush is on its way down: it touches
        before = simulation.state.counts.sum(axis=0)
        libc.getsid(0)
        simulation.advance(STEPS)
        libc.getsid(0)
        made = simulation.state.counts.sum(axis=0) - before
        print(f'{made[0] / STEPS:.2f} | {made[2] / STEPS:.3f}', flush=True)


def main():
    """Run this file under valgrind; print what it counted."""
    command = [sys.executable, __file__, 'steps']
    subprocess.run(command, check=True, stdout=subprocess.DEVNULL)
    with tempfile.TemporaryDirectory() as folder:
        done = subprocess.run(
            ['valgrind', '--tool=callgrind', '--dump-before=getsid', '--smc-check=all-non-file',
             f'--callgrind-out-file={folder}/out', *command], check=True, stdout=subprocess.PIPE,
            stderr=subprocess.DEVNULL, text=True)
        counts = [int(re.search(r'^(?:totals|summary): (\d+)', path.read_text(errors='replace'),
                                re.MULTILINE)[1])
                  for path in sorted(Path(folder).glob('out.*'),
                                     key=lambda path: int(path.suffix[1:]))]
    print('| cutting_brush, 0.1 ms | instructions a step | iterations | matrices |\n'
          '|---|---|---|---|')
    for name, made, count in zip(NAMES, done.stdout.splitlines(), counts[1::2]):
        print(f'| {name} | {count / STEPS:.0f} | {made} |')


if __name__ == '__main__':
    step_them() if sys.argv[1:] else main()
