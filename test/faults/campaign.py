#!/usr/bin/env python3
"""
Do faults to running nodes and check what is promised: campaign.py [--long] [--seed N] [FAULT ...].

The short form does a few in about a minute and is a part of the tests; the long one kills 50
times and takes a quarter of an hour. The seed fixes every random choice, all else is up to the
machine.
"""
import argparse
from collections import Counter
from concurrent.futures import ProcessPoolExecutor
import json
import multiprocessing
import os
from pathlib import Path
import random
import shutil
import subprocess
import sys
import tempfile
import time

HERE = Path(__file__).resolve().parent
sys.path[:0] = [str(HERE.parents[1]), str(HERE)]
os.environ['PYTHONPATH'] = str(HERE.parents[1])
os.environ['ROS_AUTOMATIC_DISCOVERY_RANGE'] = 'LOCALHOST'

from faults import FAULTS, TIMES  # noqa: E402
from promises import BrokenPromiseError, SCENE  # noqa: E402

BY_NAME = {fault.__name__: fault for fault in FAULTS}
SHORT = {'kill': 3, 'interrupt_start': 2, 'followed_clock': 1, 'full_disk': 1, 'nonsense': 1,
         'mangled': 1}


def do(name, number, seed, long, keep=None):
    """Do one fault; return (name, number, what broke or '', figures)."""
    place = Path(tempfile.mkdtemp(prefix=f'{name}_{number}_', dir=keep))
    start, broken, figures = time.monotonic(), '', {}
    try:
        # A text: a generator takes it for the same numbers in every version of Python.
        figures = BY_NAME[name](place, random.Random(f'{seed} {name} {number}'), long)
    except BrokenPromiseError as error:
        broken = str(error)
    if not broken:
        shutil.rmtree(place, ignore_errors=True)
    else:
        broken = f'{broken} (files: {place})'
    return name, number, broken, {**figures, 'took [s]': time.monotonic() - start}


def compile_first():
    """Fill the compile cache, which may take minutes: no limit below waits for that."""
    with tempfile.TemporaryDirectory() as place:
        scene = Path(place) / 'scene.yaml'
        scene.write_text(SCENE)
        subprocess.run([sys.executable, '-m', 'bristle_ros', 'simulate', scene, '--duration',
                        '0.01'], cwd=HERE.parents[1], stdout=subprocess.DEVNULL, check=True)


def own_domain(numbers):
    """Keep the graph of this worker apart from the other's."""
    os.environ['ROS_DOMAIN_ID'] = str(numbers.get())


def planned(options):
    """Return (name, number) of all that is to be done."""
    names = options.faults or (BY_NAME if options.long else SHORT)
    times = TIMES if options.long else SHORT
    return [(name, number) for name in names for number in range(times.get(name, 1))]


def main(arguments=None):
    """Run the campaign; return its exit code."""
    parser = argparse.ArgumentParser(description=__doc__.strip().splitlines()[0])
    parser.add_argument('faults', nargs='*', metavar='FAULT', help=', '.join(BY_NAME))
    parser.add_argument('--long', action='store_true', help='all of them, many times')
    parser.add_argument('--seed', type=int, default=random.SystemRandom().randrange(10**6))
    parser.add_argument('--jobs', type=int, default=2, help='how many at a time')
    options = parser.parse_args(arguments)
    unknown = set(options.faults) - set(BY_NAME)
    if unknown:
        parser.error(f'no such fault: {", ".join(unknown)}')
    print(f'seed {options.seed}', flush=True)
    compile_first()
    context = multiprocessing.get_context('spawn')
    domains = context.Queue()
    first = int(os.environ.get('ROS_DOMAIN_ID', 70))
    for number in range(options.jobs):
        domains.put(first + number)
    done, broken, lost = Counter(), [], []
    with ProcessPoolExecutor(options.jobs, context, own_domain, (domains,)) as pool:
        for future in [pool.submit(do, name, number, options.seed, options.long)
                       for name, number in planned(options)]:
            name, number, error, figures = future.result()
            done[name] += 1
            lost += [figures['lost [s]']] if 'lost [s]' in figures else []
            broken += [name] if error else []
            text = {key: round(value, 3) if isinstance(value, float) else value
                    for key, value in figures.items()}
            print(f'{name} {number}: {error or "held"} {json.dumps(text)}', flush=True)
    print(f'{sum(done.values())} faults, {sum(done.values()) - len(broken)} survived with all '
          f'promises held, {len(broken)} broken' + (f': {", ".join(broken)}' if broken else ''))
    if lost:
        print(f'kill -9 cost {max(lost):.3f} s at worst, {sorted(lost)[len(lost) // 2]:.3f} s in '
              f'the middle, {len(lost)} times')
    return 1 if broken else 0


if __name__ == '__main__':
    sys.exit(main())
