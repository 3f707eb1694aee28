#!/usr/bin/env python3
"""
Kills parts of a running study at drawn times and looks at what --resume makes of it.

    test/study/kills.py [--kills 20] [--seed N] [KIND ...]

KIND: worker, scheduler, client, disk, read_only, external (two workers started by hand, no kill).

After each: no row lost, none twice, none different from an undisturbed run. Needs the extra
[study]; `disk` needs root, for a disk of its own.
"""
import argparse
import os
from pathlib import Path
import random
import re
import shutil
import signal
import subprocess
import sys
import tempfile
import time

import psutil

ROOT = Path(__file__).resolve().parents[2]
KINDS = ('worker', 'scheduler', 'client', 'disk', 'read_only', 'external')
STUDY = """
scene: {scene}
set: {{solver.integration_time_step: 1.0e-3, solver.elements: 4}}
vary:
  road.penetration: {{from: 0.005, to: 0.03, count: 24}}
  drive.mean_speed: {{from: 6.0, to: 16.0, count: 20}}
duration: 1.0
settle: 0.2
sample: 2.0e-3
"""
LIMIT = 300.0


def bristle(*words):
    environment = os.environ | {'PYTHONPATH': str(ROOT)}
    return subprocess.Popen([sys.executable, '-m', 'bristle_ros', 'study', *words], text=True,
                            env=environment, stdout=subprocess.PIPE, stderr=subprocess.STDOUT)


def rows(folder):
    """Return the table as text without the wall times, and how many rows there are of each run."""
    sys.path.insert(0, str(ROOT))
    from bristle_ros.study import store
    table = store.table(folder).drop_columns(['wall_time'])
    return table.to_pandas().to_csv(float_format='%r'), table['run'].to_pylist()


class Cluster:
    """A scheduler and two workers, started by hand."""

    def __init__(self, folder):
        self.folder, self.processes = folder, []
        scheduler = self.start('scheduler', '--port', '0', '--no-dashboard')
        for line in scheduler.stdout:
            found = re.search(r'Scheduler at:\s+(tcp://\S+)', line)
            if found:
                self.address = found[1]
                break
        for _ in range(2):
            self.start('worker', self.address, '--nthreads', '1', '--no-dashboard')
        time.sleep(4.0)

    def start(self, *words):
        process = subprocess.Popen(
            [Path(sys.executable).with_name('dask'), *words], text=True, cwd=self.folder,
            env=os.environ | {'PYTHONPATH': str(ROOT)}, stdout=subprocess.PIPE,
            stderr=subprocess.STDOUT)
        self.processes.append(process)
        return process

    def stop(self):
        for process in reversed(self.processes):
            for child in children(process.pid):
                child.kill()
            process.kill()
            process.wait()


def children(pid):
    try:
        return psutil.Process(pid).children(recursive=True)
    except psutil.NoSuchProcess:
        return []


def workers_of(pid):
    return [child for child in children(pid) if 'spawn_main' in ' '.join(child.cmdline())]


def disturb(kind, study, folder, draw):
    """Run the study and disturb it once; return the exit code and what was printed."""
    if kind in ('scheduler', 'external'):
        cluster = Cluster(folder.parent)
        process = bristle(str(study), '--output', str(folder), '--scheduler', cluster.address)
        if kind == 'scheduler':
            time.sleep(draw)
            os.kill(cluster.processes[0].pid, signal.SIGKILL)
        code = finish(process)
        cluster.stop()
        return code
    process = bristle(str(study), '--output', str(folder), '--workers', '2')
    time.sleep(draw)
    while kind == 'read_only' and process.poll() is None and not (folder / 'study.json').exists():
        time.sleep(0.2)
    if kind == 'client':
        process.kill()
    elif kind == 'worker':
        found = workers_of(process.pid)
        if found:
            random.choice(found).kill()
    elif kind == 'read_only':
        subprocess.run(['chattr', '+i', folder / 'runs.parquet'], check=False)
        subprocess.run(['chattr', '+i', folder / 'halved.parquet'], check=False)
    code = finish(process)
    if kind == 'read_only':
        subprocess.run(['chattr', '-i', folder / 'runs.parquet', folder / 'halved.parquet'],
                       check=False)
    return code


def finish(process):
    try:
        printed = process.communicate(timeout=LIMIT)[0]
    except subprocess.TimeoutExpired:
        process.kill()
        return 'hang', process.communicate()[0]
    return process.returncode, printed


def main():
    parser = argparse.ArgumentParser(description=__doc__,
                                     formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument('kinds', nargs='*', default=KINDS)
    parser.add_argument('--kills', type=int, default=20)
    parser.add_argument('--seed', type=int, default=int(time.time()))
    options = parser.parse_args()
    print(f'seed {options.seed}')
    random.seed(options.seed)
    work = Path(tempfile.mkdtemp(prefix='kills-'))
    study = work / 'kills.yaml'
    study.write_text(STUDY.format(scene=ROOT / 'config/cutting_brush.yaml'))
    began = time.monotonic()
    code, printed = finish(bristle(str(study), '--output', str(work / 'whole'), '--workers', '2'))
    took = time.monotonic() - began
    assert code == 0, printed
    wanted, runs = rows(work / 'whole')
    print(f'undisturbed: {len(runs)} rows in {took:.1f} s')
    lost = doubled = differing = 0
    for number in range(options.kills):
        kind = options.kinds[number % len(options.kinds)]
        folder = work / f'{number}_{kind}'
        draw = random.uniform(0.15, 0.95) * took + (5.0 if kind == 'scheduler' else 0.0)
        if kind == 'disk':
            folder.mkdir()
            subprocess.run(['mount', '-t', 'tmpfs', '-o', f'size={random.randint(40, 260)}k',
                            'tmpfs', folder], check=True)
        code, printed = disturb(kind, study, folder, draw)
        if kind == 'disk':
            kept = folder.with_name(folder.name + '_kept')
            shutil.copytree(folder, kept)
            subprocess.run(['umount', folder], check=True)
            folder = kept
        before = len(rows(folder)[1]) if list(folder.glob('runs.parquet/part*')) else 0
        resume = ['--resume'] if (folder / 'study.json').exists() else []
        again, more = finish(bristle(str(study), '--output', str(folder), '--workers', '2',
                                     *resume))
        found, numbers = rows(folder)
        lost += len(set(runs) - set(numbers))
        doubled += len(numbers) - len(set(numbers))
        differing += sum(a != b for a, b in zip(found.splitlines(), wanted.splitlines()))
        last = printed.strip().splitlines()[-1:] or ['']
        print(f'{number}: {kind} at {draw:.1f} s: exit {code}, {before} rows, {last[0][:90]!r}; '
              f'resumed: exit {again}, {len(numbers)} rows'
              + (f'\n{more}' if again else '')
              + (f'\n{printed}' if 'Traceback' in printed else ''), flush=True)
    print(f'rows lost {lost}, doubled {doubled}, differing {differing}')
    shutil.rmtree(work)
    return int(bool(lost or doubled or differing))


if __name__ == '__main__':
    sys.exit(main())
