#!/usr/bin/env python3
"""
Build a wheel that carries compiled kernels, for levels of x86-64 and for some Pythons.

    tools/build_wheel.py [--target x86-64-v4 ...] [--python python3.11 ...] [--output dist]
                         [SCENE.yaml ...]

Each Python must have what requirements.txt names: kernels depend on the versions of numba,
llvmlite and Python, and others than these compile their own. The processor must have each target,
as kernels are run once. Prints the size of what is carried.
"""
import argparse
import os
from pathlib import Path
import shutil
import subprocess
import sys
import tempfile

ROOT = Path(__file__).resolve().parent.parent


def kernels(pythons, targets, scenes, folder):
    """Compile into folder/bristle_ros, all targets of one Python into the same files."""
    for python in pythons:
        for target in targets:
            subprocess.run(
                [python, '-m', 'bristle_ros', 'compile', '--target', target, *scenes], check=True,
                cwd=ROOT, env={**os.environ, 'XDG_CACHE_HOME': str(folder),
                               'PYTHONPATH': str(ROOT)})


def wheel(carried, output):
    """Build the wheel of a copy of the checkout with the kernels in it; return its path."""
    with tempfile.TemporaryDirectory() as work:
        source = Path(work) / 'source'
        shutil.copytree(ROOT, source, ignore=shutil.ignore_patterns(
            '.*', '__pycache__', '*.egg-info', 'build', 'install', 'dist'))
        shutil.copytree(carried, source / 'bristle_ros/kernels',
                        ignore=shutil.ignore_patterns('lock'))
        subprocess.run([sys.executable, '-m', 'pip', 'wheel', '--no-deps', '--quiet',
                        '--no-build-isolation', '--wheel-dir', work, str(source)], check=True)
        [made] = Path(work).glob('*.whl')
        output.mkdir(parents=True, exist_ok=True)
        return Path(shutil.copy(made, output))


def main():
    """Build it."""
    parser = argparse.ArgumentParser(description=__doc__.strip().splitlines()[0])
    parser.add_argument('--target', action='append', default=[])
    parser.add_argument('--python', action='append', default=[])
    parser.add_argument('--output', type=Path, default=ROOT / 'dist')
    parser.add_argument('scenes', nargs='*')
    options = parser.parse_args()
    with tempfile.TemporaryDirectory() as folder:
        kernels(options.python or [sys.executable], options.target or ['x86-64-v4', 'x86-64-v3'],
                [str(Path(scene).resolve()) for scene in options.scenes], folder)
        carried = Path(folder) / 'bristle_ros'
        files = [path for path in carried.rglob('*') if path.is_file()]
        print(f'{len(files)} files of compiled kernels, '
              f'{sum(path.stat().st_size for path in files) / 1e6:.1f} MB')
        made = wheel(carried, options.output)
    print(f'{made}: {made.stat().st_size / 1e6:.1f} MB')


if __name__ == '__main__':
    main()
