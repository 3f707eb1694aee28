#!/usr/bin/env python3
"""
Measures what a study costs beside its runs: measure_study.py speed | rows | compile [--rows N].

speed: rows of about 0.1 s by bare simulate calls in a loop, in one process and in two, and by
study with 1 and 2 workers; are the rows the same?
rows: a study of N cheap rows (a free wire that oscillates: 4 elements, 500 steps of 1 ms);
resident memory of client and workers, and rows a second, over time. CSV and a figure beside the
study.
compile: workers that begin together on an empty cache of kernels; how many of them compile?
"""
import argparse
import csv
from multiprocessing import get_context
import os
from pathlib import Path
import subprocess
import sys
import tempfile
import time

ROOT = Path(__file__).resolve().parent.parent
sys.path.insert(0, str(ROOT))
os.environ['PYTHONPATH'] = str(ROOT)

LONG = """scene: {config}/cutting_brush.yaml
set: {{solver.integration_time_step: 2.0e-4, solver.elements: 6}}
vary:
  road.penetration: {{from: 0.01, to: 0.03}}
  drive.mean_speed: {{from: 8.0, to: 12.0}}
design: sobol
samples: {rows}
duration: 2.0
settle: 0.5
sample: 1.0e-3
"""
CHEAP = """scene: {config}/free_rotation.yaml
set: {{solver.integration_time_step: 1.0e-3, solver.elements: 4, damping.mass: 5.0}}
vary:
  drive.mean_speed: {{from: 5.0, to: 16.0}}
  drive.alternating_speed: {{from: 0.0, to: 2.0}}
  drive.frequency: {{from: 2.0, to: 20.0}}
design: sobol
samples: {rows}
duration: 0.5
settle: 0.1
sample: 2.0e-2
"""


def write(text, rows):
    """Write a study file of so many rows; return its path."""
    folder = Path(tempfile.mkdtemp(prefix='measure-'))
    path = folder / 'study.yaml'
    path.write_text(text.format(config=ROOT / 'config', rows=rows))
    return path


def bare(path, first, end):
    """Return the wall time of simulate calls in a loop."""
    from bristle_ros import simulate
    from bristle_ros.study import design
    from bristle_ros.study.study_file import read_study
    study = read_study(path)
    scenes = [study.scene_of(row) for row in design.rows(study, first, end)]
    simulate(scenes[0], study.duration, sample=study.sample)
    began = time.perf_counter()
    for scene in scenes:
        simulate(scene, study.duration, sample=study.sample)
    return time.perf_counter() - began


def studied(path, folder, workers):
    """Return the wall time of a study once its workers are there and have compiled."""
    from bristle_ros.study.batch import seconds_of
    from bristle_ros.study.campaign import carry_out
    from bristle_ros.study.cluster import open_cluster
    from bristle_ros.study.study_file import read_study
    study = read_study(path)
    with open_cluster(None, workers) as client:
        client.run(seconds_of, study, [0])
        began = time.perf_counter()
        carry_out(study, folder, client)
        return time.perf_counter() - began


def overhead(rows):
    """Print what rows cost bare and in a study."""
    from bristle_ros.study import store
    path = write(LONG, rows)
    one = bare(path, 0, rows)
    with get_context('spawn').Pool(2) as pool:
        halves = pool.starmap(bare, [(path, 0, rows // 2), (path, rows // 2, rows)])
    took = {workers: studied(path, path.with_name(f'of_{workers}'), workers)
            for workers in (1, 2)}
    tables = [store.table(path.with_name(f'of_{workers}')).drop_columns(['wall_time'])
              .to_pandas().to_csv() for workers in (1, 2)]
    print(f'{rows} rows; bare: {one:.2f} s ({one / rows:.3f} s each), two processes '
          f'{max(halves):.2f} s (x {one / max(halves):.2f})')
    print(f'study: 1 worker {took[1]:.2f} s (overhead {took[1] / one - 1:.1%}), 2 workers '
          f'{took[2]:.2f} s (x {took[1] / took[2]:.2f}); includes 3 probes, 1 % at half the step')
    print('rows of 1 and 2 workers:', 'equal' if tables[0] == tables[1] else 'DIFFERENT')


def kernels():
    """Return how many kernels this process compiled, and how many it took from the cache."""
    import gc

    from numba.core.dispatcher import Dispatcher
    found = [each.stats for each in gc.get_objects() if isinstance(each, Dispatcher)]
    return (sum(sum(each.cache_misses.values()) for each in found),
            sum(sum(each.cache_hits.values()) for each in found))


def compiling(workers):
    """Print what each of many workers does that all begin on an empty cache."""
    os.environ['XDG_CACHE_HOME'] = tempfile.mkdtemp(prefix='measure-cache-')
    from bristle_ros.study.batch import seconds_of
    from bristle_ros.study.cluster import open_cluster
    from bristle_ros.study.study_file import read_study
    study = read_study(write(LONG, workers))
    with open_cluster(None, workers) as client:
        began = time.perf_counter()
        client.run(seconds_of, study, [0])
        took = time.perf_counter() - began
        found = list(client.run(kernels).values())
    made, taken = (sum(one[i] > 0 for one in found) for i in (0, 1))
    print(f'{workers} workers on an empty cache, {took:.0f} s: {made} compiled, '
          f'{sum(one[0] == 0 and one[1] > 0 for one in found)} took all from the cache '
          f'({taken} took some); (compiled, taken) of each: {sorted(found)}')


def memory(rows):
    """Print and draw the memory of a study's processes over time."""
    import psutil
    path = write(CHEAP, rows)
    folder = path.with_name('study')
    process = subprocess.Popen([sys.executable, '-m', 'bristle_ros', 'study', str(path),
                                '--output', str(folder), '--workers', '2'])
    began, log = time.monotonic(), []
    client = psutil.Process(process.pid)
    while process.poll() is None:
        time.sleep(2.0)
        try:
            sizes = sorted(child.memory_info().rss for child in client.children(recursive=True)
                           if 'spawn_main' in ' '.join(child.cmdline()))
            own = client.memory_info().rss
        except psutil.Error:
            continue
        done = sum(int(part.name[15:24]) - int(part.name[5:14])
                   for part in (folder / 'runs.parquet').glob('part-*'))
        log.append((round(time.monotonic() - began, 1), done, own / 2**20,
                    max(sizes, default=0) / 2**20))
    with open(path.with_name('memory.csv'), 'w', newline='') as file:
        csv.writer(file).writerows([('t', 'rows', 'client_MiB', 'largest_worker_MiB'), *log])
    draw(log, path.with_name('memory.png'))
    busy = [line for line in log if 0 < line[1] < rows]
    fifth = max(1, len(busy) // 5)
    print(f'exit {process.returncode}; {rows} rows in {log[-1][0]} s')
    for name, part in (('first', busy[:fifth + 1]), ('last', busy[-fifth - 1:])):
        rate = (part[-1][1] - part[0][1]) / max(part[-1][0] - part[0][0], 1e-9)
        print(f'{name} fifth: {rate:.1f} rows a second; client {part[-1][2]:.0f} MiB, largest '
              f'worker {part[-1][3]:.0f} MiB')
    print(f'largest: client {max(line[2] for line in log):.0f} MiB with the page; '
          f'{path.with_name("memory.csv")}, memory.png')


def draw(log, place):
    """Draw memory and rows over time."""
    from matplotlib.figure import Figure
    figure = Figure(figsize=(7, 4), layout='constrained')
    axes = figure.subplots()
    t, done, client, worker = zip(*log)
    axes.plot(t, client, label='client [MiB]')
    axes.plot(t, worker, label='largest worker [MiB]')
    axes.set(xlabel='t [s]', ylabel='resident memory [MiB]', ylim=(0, None))
    other = axes.twinx()
    other.plot(t, done, color='grey', linestyle='--', label='rows')
    other.set_ylabel('rows')
    axes.legend(loc='lower right')
    figure.savefig(place, dpi=90)


if __name__ == '__main__':
    parser = argparse.ArgumentParser(description=__doc__,
                                     formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument('what', choices=('speed', 'rows', 'compile'))
    parser.add_argument('--rows', type=int, help='a power of 2; default 128, rows: 131072; '
                        'compile: workers, default 8')
    options = parser.parse_args()
    measured, usual = {'speed': (overhead, 128), 'rows': (memory, 131072),
                       'compile': (compiling, 8)}[options.what]
    measured(options.rows or usual)
