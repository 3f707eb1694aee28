"""Where batches run: workers of this machine, or of a scheduler that is there already (Dask)."""
from contextlib import contextmanager
import logging

from bristle_ros.scene import SceneError
import dask
from distributed import as_completed, Client, KilledWorker, LocalCluster
from distributed.client import FutureCancelledError
from distributed.comm import CommClosedError
from distributed.comm.addressing import parse_address, parse_host_port

PATIENCE = 15.0         # [s] for a scheduler to answer
DEATHS = 20             # of the workers that ran a batch, before it is given up
_PRELOAD = 'bristle_ros.study.worker'


class ClusterLost(Exception):
    """The scheduler went away, or workers died over and over; `str()` is one line."""


@contextmanager
def open_cluster(address, workers):
    """
    Enter with a Client: of the scheduler at `address`, or of `workers` processes of this machine.

    Raises SceneError where there is no scheduler, ClusterLost where it goes away.
    """
    try:
        with _client(address, workers) as client:
            yield client
    except (FutureCancelledError, CommClosedError):
        raise ClusterLost('the scheduler has gone') from None


@contextmanager
def _client(address, workers):
    for name in list(logging.root.manager.loggerDict):
        if name.startswith('distributed'):
            logging.getLogger(name).setLevel(logging.CRITICAL)  # we tell it on one line
    dask.config.set({'distributed.scheduler.allowed-failures': DEATHS,
                     'distributed.worker.preload': [_PRELOAD],
                     'distributed.comm.timeouts.connect': f'{PATIENCE}s',
                     'distributed.client.heartbeat': '5s'})
    if address:
        client = _connect(address)
        try:
            yield client
        finally:
            _close(client)
        return
    # no limit of memory: a worker that Dask pauses or ends would take its batch along
    with LocalCluster(n_workers=workers, threads_per_worker=1, processes=True, memory_limit=0,
                      dashboard_address=':0', silence_logs=logging.CRITICAL) as cluster:
        client = Client(cluster)
        try:
            yield client
        finally:
            _close(client)


def _connect(address):
    try:
        parse_host_port(parse_address(address)[1])
        client = Client(address, timeout=PATIENCE, set_as_default=False)
    except (OSError, ValueError) as error:
        line = str(error).partition('\n')[0] or type(error).__name__
        raise SceneError(f'no scheduler answers ({line}): start one with `dask scheduler`',
                         key='--scheduler', value=address) from None
    if not client.nthreads():
        client.close()
        raise SceneError('has no workers: start some with `dask worker`', key='--scheduler',
                         value=address)
    return client


def _close(client):
    try:
        client.close(timeout=5.0)
    except (OSError, TimeoutError, RuntimeError):
        pass    # it has gone before


def in_flight(client, jobs, submit, stopped):
    """
    Yield the result of each of `jobs` as it is done, with few of them submitted at a time.

    submit(job) : returns a Future;  stopped() : whether no more are to be begun
    Raises ClusterLost, and what a job raised.
    """
    jobs = iter(jobs)
    room = sum(client.nthreads().values()) + 1      # one waits, so that no worker does
    running = as_completed(loop=client.loop)
    held = 0
    while True:
        while held < room and not stopped():
            job = next(jobs, None)
            if job is None:
                break
            running.add(submit(job))
            held += 1
        if not held:
            return
        future = next(running)
        held -= 1
        yield _result(future)


def _result(future):
    try:
        return future.result()
    except KilledWorker as error:
        raise ClusterLost(f'{DEATHS} workers died, one after the other, with the same batch '
                          f'({error.task})') from None
