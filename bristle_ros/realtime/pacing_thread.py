"""The thread that runs a driver's chunks when they are due. Knows no ROS."""
import threading
import time


class PacingThread:
    """
    Runs chunks at absolute deadlines on the steady clock and hands each to `deliver(chunk)`.

    It ends by itself after a chunk that failed, and `on_end(error)` tells whoever waits: with the
    StepFailure, or with what `deliver` raised. Kernels run without the GIL, so callbacks of other
    threads stay responsive meanwhile.
    """

    def __init__(self, driver, deliver, on_end):
        self._driver, self._deliver, self._on_end = driver, deliver, on_end
        self._wake = threading.Event()
        self._stopping = False
        self._busy = threading.Lock()   # held while a chunk runs and is delivered
        self._chunks = 0
        self._thread = threading.Thread(target=self._run, name='pacing', daemon=True)

    def start(self):
        """Begin; the step reached is due now."""
        self._driver.start()
        self._thread.start()

    def wake(self):
        """Look again at when the next chunk is due: something about it has changed."""
        self._wake.set()

    def settle(self):
        """Return when the chunk that was running, if any, has been delivered."""
        with self._busy:
            pass

    def between_chunks(self, look):
        """Return look(), called while no chunk runs."""
        with self._busy:
            return look()

    def step_once(self, limit=30.0):
        """Run one chunk of a paused driver; return whether it was delivered within `limit` [s]."""
        before, end = self._chunks, self._driver.now() + limit * 1e9
        if not self._driver.step_once():
            return False
        self.wake()
        while self._chunks == before and self._thread.is_alive() and self._driver.now() < end:
            time.sleep(2e-4)
        self.settle()
        return self._chunks > before

    def stop(self, limit=None):
        """End after the chunk that is running; return whether it has ended within `limit` [s]."""
        self._stopping = True
        self.wake()
        if self._thread.ident is not None and self._thread is not threading.current_thread():
            self._thread.join(limit)
        return not self._thread.is_alive()

    def _run(self):
        error = None
        try:
            while not self._stopping and error is None:
                if self._wait():
                    error = self._run_chunk()
        except Exception as unexpected:  # shown by the thread that waits for our end
            error = unexpected
        if error is not None:
            self._on_end(error)

    def _run_chunk(self):
        """Run what is due, if it still is; return why it failed, or None."""
        with self._busy:
            if not self._driver.due():
                return None     # paused since, and whoever did that was told the time
            chunk = self._driver.run_chunk()
            self._deliver(chunk)
            self._chunks += 1
            return chunk.failure

    def _wait(self):
        """Wait until the next chunk is due; False when woken before, to look again."""
        deadline = self._driver.next_deadline()
        if deadline is None:
            self._wake.wait()
        else:
            delay = (deadline - self._driver.now()) * 1e-9
            if delay <= 0.0 or not self._wake.wait(delay):
                return True
        self._wake.clear()
        return False
