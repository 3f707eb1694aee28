"""
The process that simulates for a page, so that neither page nor compiler stops the brush.

Chunks come first: what is to be shown is copied at a chunk's end when the page is ready for it,
and frames that it is not ready for are never made.
"""
from collections import deque
import os
import queue
import signal
import threading
import time

from bristle_ros.scene import bristle_count

from .frame import frame_of, row_of, Status, tracked, trail_of

RATE = 30.0         # [Hz] of frames, at most
DOUBTS = 1.0        # [s] between looks at what makes the run doubtful
KEPT = 4000         # chunks that a page which hangs may miss
SHOWN, FAILED, END = 'shown', 'failed', ('end',)
GONE = 'the process that simulates has ended'


class Outbox:
    """What has happened since the page was last told; a thread of its own tells it."""

    def __init__(self, connection, scene):
        self._connection, self._scene = connection, scene
        self._tracked = tracked(bristle_count(scene))
        self._rows = deque(maxlen=KEPT)
        self._frame, self._wanted, self._due = None, True, 0.0

    def deliver(self, chunk, simulation):
        """Take a chunk's end; the pacing thread calls this."""
        self._rows.append((row_of(chunk.last, self._scene),
                           trail_of(chunk.last, chunk.mount, self._tracked)))
        if self._wanted:
            self._wanted = False
            self._frame = frame_of(simulation, chunk.last, chunk.mount)

    def wait(self):
        """Wait until the next frame is due."""
        now = time.monotonic()
        self._due = max(self._due + 1.0 / RATE, now)
        time.sleep(self._due - now)

    def send(self, status):
        """Tell the page; blocks while it is not listening."""
        rows = [self._rows.popleft() for _ in range(len(self._rows))]
        frame, self._frame = self._frame, None
        self._connection.send((SHOWN, (frame, rows, status)))
        self._wanted = True


class Run:
    """A scene that is simulated at its pace, with commands from a connection."""

    def __init__(self, connection, scene):
        """Compile; this takes up to a minute where the cache is empty."""
        from bristle_ros.realtime import Driver, PacingThread
        from bristle_ros.simulation import MountPath, RunWatch, Simulation
        self._outbox = Outbox(connection, scene)
        simulation = Simulation(scene)
        self._driver = driver = Driver(simulation)
        driver.mount, driver.watch = MountPath(scene), RunWatch(simulation)
        self._doubts, self._doubts_due = (), 0.0
        self._last, self._ended = None, ''
        self._pacing = PacingThread(driver, self._deliver, self._end)

    def start(self):
        """Go."""
        self._pacing.start()

    def _deliver(self, chunk):
        self._last = chunk.last
        self._outbox.deliver(chunk, self._driver.simulation)

    def _end(self, error):
        self._ended = str(error)

    def obey(self, order, *values):
        """Do what the page asks for."""
        driver = self._driver
        if order == 'command':
            driver.command(*values)
        elif order == 'factor':
            driver.real_time_factor = values[0]
        elif order == 'pause':
            driver.pause()
        elif order == 'resume':
            driver.resume()
        elif order == 'step':
            driver.step_once()
        elif order == 'reset':
            driver.reset()
            driver.step_once()      # while paused: so that the start is seen
        self._pacing.wake()

    def tell(self):
        """Tell the page what there is to show, 30 times a second."""
        while True:
            self._outbox.wait()
            self._outbox.send(self._status())

    def _status(self):
        driver, last = self._driver, self._last
        if time.monotonic() >= self._doubts_due:
            self._doubts_due = time.monotonic() + DOUBTS
            self._doubts = tuple(str(doubt) for doubt in driver.warnings(ended=False)
                                 if doubt.acts)
        error, speed = (last.error_estimate, float(last.omega)) if last else (0.0, 0.0)
        state = 'ended' if self._ended else 'paused' if driver.paused else 'running'
        return Status(
            state, driver.total_step * driver.its, driver.real_time_factor, driver.reached(),
            driver.late_chunks, error, speed, self._ended, self._doubts)


def main(connection, make, *arguments):
    """
    Run in a process of its own until the connection is closed at the other end.

    make(connection, *arguments) -> a Run or what is like one
    """
    signal.signal(signal.SIGINT, signal.SIG_IGN)    # the page is told, and closes the connection
    orders = queue.SimpleQueue()

    def listen():
        try:
            while True:
                order = connection.recv()
                if order == END:
                    os._exit(0)     # also while it compiles
                orders.put(order)
        except (EOFError, OSError):
            os._exit(0)

    def obey(run):
        while True:
            run.obey(*orders.get())

    threading.Thread(target=listen, name='listen', daemon=True).start()
    try:
        run = make(connection, *arguments)
        run.start()
        threading.Thread(target=obey, args=(run,), name='obey', daemon=True).start()
        run.tell()
    except (BrokenPipeError, ConnectionError):
        pass
    except (RuntimeError, ValueError, OSError) as error:    # SceneError and StepFailure are such
        connection.send((FAILED, ' '.join(str(error).split())))
