#!/usr/bin/env python3
"""
Count the instructions of a step with each feature of a scene changed: tools/count_instructions.py.

They say what a scene pays for, whatever else the machine does. Needs valgrind; the scene is
cutting_brush at 0.1 ms. Prints a Markdown table. The first run compiles, so it is made without.
"""
import os
from pathlib import Path
import re
import subprocess
import sys
import tempfile

ROOT = Path(__file__).resolve().parent.parent
sys.path.insert(0, str(ROOT))

from bristle_ros.report.lean.features import changed, FEATURES  # noqa: E402
from bristle_ros.report.precision.subjects import scene_of  # noqa: E402
from bristle_ros.simulation.simulation import Simulation  # noqa: E402
import llvmlite.binding  # noqa: E402

STEPS = 1000
CHANGES = {'as it is': {}}
for feature in FEATURES:
    if feature.bristles == 1 and not feature.around:
        CHANGES |= {feature.name: feature.present} if feature.present else {
            f'without {feature.name}': feature.absent}
NAMES = list(CHANGES)


def step_them(folder):
    """Advance each scene in two children, by STEPS and by none: valgrind counts each child's."""
    for name in NAMES:
        simulation = Simulation(changed(scene_of('cutting_brush', 1e-4), CHANGES[name]))
        simulation.advance(2 * STEPS)   # the brush is on its way down: it touches
        for steps in (0, STEPS):
            child = os.fork()
            if child == 0:
                before = simulation.state.counts.sum(axis=0)
                simulation.advance(steps)
                made = simulation.state.counts.sum(axis=0) - before
                (folder / f'{os.getpid()}.made').write_text(f'{name}|{made[0]}|{made[2]}')
                os._exit(0)
            os.waitpid(child, 0)


def main():
    """Run this file under valgrind; print what it counted."""
    with tempfile.TemporaryDirectory() as folder:
        command = [sys.executable, __file__, folder]
        # The same code in both runs: valgrind shows another processor.
        host = {**os.environ, 'NUMBA_CPU_NAME': llvmlite.binding.get_host_cpu_name(),
                'NUMBA_CPU_FEATURES': llvmlite.binding.get_host_cpu_features().flatten()}
        subprocess.run(command, check=True, env=host)
        for path in Path(folder).iterdir():
            path.unlink()
        subprocess.run(
            ['valgrind', '--quiet', '--trace-children=yes', '--tool=cachegrind', '--cache-sim=no',
             f'--cachegrind-out-file={folder}/%p', *command], check=True, env=host)
        counts, made = {}, {}
        for path in Path(folder).glob('*.made'):
            name, iterations, matrices = path.read_text().split('|')
            summary = re.search(r'^summary: (\d+)', path.with_suffix('').read_text(), re.MULTILINE)
            counts.setdefault(name, []).append(int(summary[1]))
            made[name] = max(made.get(name, (0, 0)), (int(iterations), int(matrices)))
    print('| cutting_brush, 0.1 ms | instructions a step | iterations | matrices |\n'
          '|---|---|---|---|')
    for name in NAMES:
        iterations, matrices = made[name]
        count = max(counts[name]) - min(counts[name])
        print(f'| {name} | {count / STEPS:.0f} | {iterations / STEPS:.2f} | '
              f'{matrices / STEPS:.3f} |')


if __name__ == '__main__':
    step_them(Path(sys.argv[1])) if sys.argv[1:] else main()
