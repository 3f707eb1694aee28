"""What Dask loads into each worker that we start."""
import signal


def dask_setup(worker):
    """Ignore Ctrl-C, which a terminal sends to all its processes: the client decides."""
    signal.signal(signal.SIGINT, signal.SIG_IGN)
