"""
Processes that do the report's work: a crew, one for each core, and single ones pinned to a core.

The process of the page itself simulates nothing: what it asks for is a function of a module and
its arguments, what it gets is the value, or a `Failed` with the reason in words.
"""
from contextlib import contextmanager
import math
import multiprocessing
from multiprocessing.connection import wait
import os
import signal
import time
import traceback
from typing import NamedTuple

GRACE = 150.0       # [s] on top of a job's limit, for compiling and a step that is under way
STILL = 300.0       # [s] by the clock in which a process has not worked for TICK: it hangs
TICK = 0.1          # [s]
MOST = 2 << 30      # [bytes] of a worker that is replaced after its job: it keeps the compiled
                    # functions of each kind of scene that it has simulated
ONE_THREAD = dict.fromkeys(('OMP_NUM_THREADS', 'OPENBLAS_NUM_THREADS', 'MKL_NUM_THREADS'), '1')


class Failed(NamedTuple):
    """A job that gave no value."""

    reason: str
    lost: bool = False      # its process died or did not come back


class Job(NamedTuple):
    """What a worker is asked: function(*arguments), of a module that it can import."""

    function: object
    arguments: tuple = ()
    label: str = ''


def cores():
    """Return the numbers of the cores that this process may use."""
    try:
        return sorted(os.sched_getaffinity(0))
    except AttributeError:
        return list(range(os.cpu_count() or 1))


def processor_time(process):
    """Return what a process and all its threads have used of processors [s], or None unknown."""
    try:
        with open(f'/proc/{process}/stat', encoding='ascii', errors='replace') as file:
            numbers = file.read().rpartition(')')[2].split()
        return (int(numbers[11]) + int(numbers[12])) / os.sysconf('SC_CLK_TCK')
    except (OSError, ValueError, IndexError):
        return None


def memory(process):
    """Return what a process has in memory [bytes], 0 unknown."""
    try:
        with open(f'/proc/{process}/statm', encoding='ascii') as file:
            return int(file.read().split()[1]) * os.sysconf('SC_PAGE_SIZE')
    except (OSError, ValueError, IndexError):
        return 0


class Patience:
    """
    When a job is given up: after so much of its own processor time, however busy the machine.

    Where that is not known, and for a process that does nothing, the clock on the wall decides.
    """

    def __init__(self, process, limit, clock=time.monotonic, used=processor_time):
        """Begin with a job of a process; limit : [s]."""
        self._process, self._limit, self._clock, self._used = process, limit, clock, used
        self._began = self._moved = clock()
        self._at_start = self._last = used(process)

    def over(self):
        """Whether the job has to be given up."""
        now, used = self._clock(), self._used(self._process)
        if used is None or self._at_start is None:
            return now - self._began > self._limit
        if used > self._last + TICK:
            self._last, self._moved = used, now
        return used - self._at_start > self._limit or now - self._moved > STILL


def _work(pipe, core):
    """Do jobs from a pipe until it closes; what a worker process does."""
    signal.signal(signal.SIGINT, signal.SIG_IGN)    # the parent's to answer
    signal.pthread_sigmask(signal.SIG_UNBLOCK, {signal.SIGINT})
    if core is not None:
        try:
            os.sched_setaffinity(0, {core})
        except (AttributeError, OSError):
            pass
    try:
        while True:
            function, arguments = pipe.recv()
            try:
                answer = function(*arguments)
            except (RuntimeError, ValueError, MemoryError) as error:
                answer = Failed(' '.join(str(error).split()) or type(error).__name__)
            except Exception:  # a fault of the report: told in the parent, with its place
                answer = traceback.format_exc()
                pipe.send((False, answer))
                continue
            pipe.send((True, answer))
    except (EOFError, OSError):
        pass


class Worker:
    """A process that does one job after the other and can be ended when one hangs."""

    def __init__(self, core=None):
        """Start it; core: the number of the one core that it stays on."""
        context = multiprocessing.get_context('spawn')
        self._core = core
        self.pipe, theirs = context.Pipe()
        self._process = context.Process(target=_work, args=(theirs, core), daemon=True)
        # Ctrl-C while the child imports would print where it was
        signal.pthread_sigmask(signal.SIG_BLOCK, {signal.SIGINT})
        before = {name: os.environ.get(name) for name in ONE_THREAD}
        os.environ.update(ONE_THREAD)
        try:
            self._process.start()
        finally:
            for name, value in before.items():
                if value is None:
                    os.environ.pop(name)
                else:
                    os.environ[name] = value
            signal.pthread_sigmask(signal.SIG_UNBLOCK, {signal.SIGINT})
        theirs.close()
        self._patience = None

    def give(self, job, limit=math.inf):
        """Send a job, of `limit` [s] of a processor."""
        self._patience = Patience(self._process.pid, limit + GRACE)
        self.pipe.send((job.function, job.arguments))

    def is_full(self):
        """Whether it has more in memory than one that begins anew should."""
        return memory(self._process.pid) > MOST

    def is_late(self):
        """Whether the job that it has was to be done by now."""
        return self._patience.over()

    def take(self):
        """Return the value of the job, waiting for it."""
        try:
            good, answer = self.pipe.recv()
        except (EOFError, OSError):
            return Failed('its process died', True)
        if not good:
            raise RuntimeError(f'a worker of the report failed:\n{answer}')
        return answer

    def call(self, function, *arguments):
        """Do one job; return its value, or Failed."""
        self.give(Job(function, arguments))
        return self.take()

    def end(self):
        """End the process."""
        self.pipe.close()
        self._process.terminate()
        self._process.join()


class Crew:
    """Workers for jobs whose order does not matter and that are not timed."""

    def __init__(self, count):
        """Start `count` of them when the first jobs come."""
        self._count = count
        self._workers = []

    def run(self, jobs, *, limit=math.inf, show=None):
        """
        Do jobs; return their values in their order, with Failed where there is none.

        limit : [s] of a processor for a job, after which (and GRACE) its process is replaced
        show(value, job, done, total) : called as each one ends
        """
        todo, found = list(enumerate(jobs))[::-1], {}
        while len(self._workers) < min(self._count, len(todo)):
            self._workers.append(Worker())
        busy = {}
        while len(found) < len(jobs):
            for at in range(len(self._workers)):
                if at not in busy and todo:
                    busy[at] = todo.pop()
                    self._workers[at].give(busy[at][1], limit)
            ready = wait([self._workers[at].pipe for at in busy], timeout=1.0)
            for at in list(busy):
                worker = self._workers[at]
                if worker.pipe in ready:
                    value = worker.take()
                elif worker.is_late():
                    value = Failed(f'did not come back within {limit + GRACE:g} s of a '
                                   'processor', True)
                else:
                    continue
                if isinstance(value, Failed) and value.lost or worker.is_full():
                    worker.end()
                    self._workers[at] = Worker()
                place, job = busy.pop(at)
                found[place] = value
                if show:
                    show(value, job, len(found), len(jobs))
        return [found[place] for place in range(len(jobs))]

    def end(self):
        """End the processes."""
        while self._workers:
            self._workers.pop().end()


@contextmanager
def crew(count):
    """Give a Crew, and end its processes afterwards."""
    made = Crew(count)
    try:
        yield made
    finally:
        made.end()
