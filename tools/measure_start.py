#!/usr/bin/env python3
"""
Measure what a node takes from its start until it is ready, its cache of kernels empty.

    tools/measure_start.py [--python PYTHON] [--repeats 1] [SCENE.yaml ...]

Without scenes those of config/. PYTHON is of an environment with the package in it, by default
this one with the checkout: a wheel of tools/build_wheel.py brings its kernels along, and nothing
is compiled then. Prints a Markdown table; the last column is what the node left in its cache.
"""
import argparse
import os
from pathlib import Path
import re
import select
import signal
import subprocess
import sys
import tempfile
import time

ROOT = Path(__file__).resolve().parent.parent
LONGEST = 300.0     # [s]
READY = re.compile(r' ready: .*compiled in ([\d.]+) s')


def start(python, scene, home):
    """Start a node and end it; return the times [s] until it is ready and of its compiling."""
    began = time.monotonic()
    node = subprocess.Popen(
        [python, '-m', 'bristle_ros', 'brush_node', '--ros-args', '--params-file', scene],
        cwd=home, stdout=subprocess.DEVNULL, stderr=subprocess.PIPE, bufsize=0,
        env={**os.environ, 'XDG_CACHE_HOME': home})
    text = b''
    try:
        while time.monotonic() < began + LONGEST:
            if select.select([node.stderr], [], [], 1.0)[0]:
                some = os.read(node.stderr.fileno(), 65536)
                text += some
                found = READY.search(text.decode(errors='replace'))
                if found:
                    return time.monotonic() - began, float(found[1])
                if not some:
                    break
        sys.exit(f'{scene}: not ready: {text.decode(errors="replace")[-500:]}')
    finally:
        node.send_signal(signal.SIGINT)
        node.wait()


def main():
    """Print the table."""
    parser = argparse.ArgumentParser(description=__doc__.strip().splitlines()[0])
    parser.add_argument('--python', help='of an environment that has the package')
    parser.add_argument('--repeats', type=int, default=1)
    parser.add_argument('scenes', nargs='*', type=Path)
    options = parser.parse_args()
    if not options.python:
        os.environ['PYTHONPATH'] = str(ROOT)
    print('| scene | ready after [s] | of it compiling or loading [s] | left in the cache [MB] |\n'
          '|---|---|---|---|')
    for scene in options.scenes or sorted((ROOT / 'config').glob('*.yaml')):
        ready, compiling, left = [], [], 0
        for _ in range(options.repeats):
            with tempfile.TemporaryDirectory() as home:
                for times, one in zip((ready, compiling), start(
                        options.python or sys.executable, scene.resolve(), home)):
                    times.append(one)
                left = sum(file.stat().st_size for file in Path(home).rglob('*.nb[ic]'))
        print(f'| {scene.stem} | {spread(ready)} | {spread(compiling)} | {left / 1e6:.1f} |',
              flush=True)


def spread(times):
    """Return the least and the largest of times as text."""
    return ' to '.join(f'{one:.2g}' for one in sorted({min(times), max(times)}))


if __name__ == '__main__':
    main()
