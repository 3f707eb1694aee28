"""Carries out a study: batches to workers, what is missing and nothing else, Ctrl-C."""
import os
from pathlib import Path
import signal
import sys
import threading

from bristle_ros.command_line import INTERRUPTED
from bristle_ros.scene import SceneError

from . import store
from .batch import is_there, run_batch, run_scene, seconds_of
from .cluster import in_flight
from .progress import Progress
from .study_file import GENERATION

BATCH = 10.0            # [s] a batch should last: Dask is slow at millions of short tasks
LARGEST = 4096          # rows of a batch
PROBED = 3              # runs that are timed beforehand


class Stop:
    """Ctrl-C, counted: the first lets batches in flight finish, the second ends at once."""

    def __init__(self):
        self.asked = False

    def __enter__(self):
        """Take SIGINT and SIGTERM, which only the main thread can."""
        self._before = {}
        if threading.current_thread() is threading.main_thread():
            for number in (signal.SIGINT, signal.SIGTERM):
                self._before[number] = signal.signal(number, self._take)
        return self

    def _take(self, *_):
        if self.asked:
            os._exit(INTERRUPTED)
        self.asked = True
        print('study: finishing the batches in flight; Ctrl-C again ends at once',
              file=sys.stderr, flush=True)

    def __exit__(self, *_):
        """Give them back."""
        for number, handler in self._before.items():
            signal.signal(number, handler)


def carry_out(study, folder, client, *, resume=False, run=run_scene):
    """
    Run what is missing of a study; return whether it is complete.

    client : of Dask;  run : as of run_batch
    Raises SceneError, OSError of a worker that cannot write, and ClusterLost.
    """
    folder = Path(folder).resolve()
    kept = store.begin(study, folder, resume=resume)
    if not all(client.run(is_there, str(folder)).values()):
        raise SceneError('is not seen by every worker: name a place that all machines share',
                         key='--output', value=str(folder))
    if kept['batch'] is None:
        kept['batch'] = _batch_size(study, client, run)
        store.save(folder, kept)
    if study.keep:
        _make_curves(study, folder)
    with Stop() as stop, Progress(study.runs, store.count(folder)) as progress:
        if study.design == 'optimise':
            from .optimise import generations
            for first, values in generations(study, folder):
                _run_all(study, folder, client, run, kept['batch'], stop, progress,
                         first, values)
                if stop.asked:
                    break
        else:
            _run_all(study, folder, client, run, kept['batch'], stop, progress, 0, None)
    return store.count(folder) >= study.runs


def _run_all(study, folder, client, run, size, stop, progress, first, values):
    """Run the missing rows of a design, or those of a generation that begins at `first`."""
    end = study.runs if values is None else first + len(values)
    batches = ((at, min(at + size, end)) for at in range(first, end, size))

    def submit(batch):
        part = values and values[batch[0] - first:batch[1] - first]
        return client.submit(run_batch, study, str(folder), *batch, part, run, pure=False)

    for rows, failed, _ in in_flight(client, store.missing(batches, folder), submit,
                                     lambda: stop.asked):
        progress.add(rows, failed)


def _batch_size(study, client, run):
    """Return how many rows a batch has, from a few timed runs; it stays for the whole study."""
    workers = max(1, sum(client.nthreads().values()))
    if study.design == 'optimise':
        return max(1, GENERATION // (2 * workers))
    largest = max(1, min(LARGEST, study.runs // (4 * workers)))
    if run is not run_scene or study.runs <= 4 * workers:
        return largest
    timed = client.submit(seconds_of, study, probed(study), pure=False).result()
    each = sum(seconds for _, seconds in timed) / len(timed)
    return max(1, min(largest, int(BATCH / max(each, 1e-4))))


def probed(study):
    """Return the numbers of rows to be timed: first, middle, last."""
    return sorted({0, study.runs // 2, study.runs - 1})[:PROBED]


def _make_curves(study, folder):
    import numpy as np

    from . import design
    from .history import plan, Run
    scene = study.scene_of(design.rows(study, 0, 1)[0]) if study.design != 'optimise' else (
        study.scene)
    steps, every, _, _ = plan(study, scene)
    run = Run(scene, every)
    run.go(0)
    history = run.history()
    shapes = {name: np.shape(getattr(history, name))[1:] for name in study.keep}
    store.make_curves(study, folder, study.runs, shapes, steps // every + 1)

