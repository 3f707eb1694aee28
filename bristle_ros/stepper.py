"""Steps a brush: batches of steps, whose bristles several threads share out."""
from concurrent.futures import ThreadPoolExecutor
import os

import numpy as np

from .model import new_scratch
from .physics.frame import FRAME
from .physics.stepping import advance, BATCH, fill_frames

SHARE = 2   # bristles that a thread must get at least, to be worth waking


class Stepper:
    """
    Advances the bristles of a state; what they give depends on no number of threads.

    Bristles feel the brush's motion and the road, not each other, so each makes all steps of a
    batch before the next one begins: its matrices stay in the cache, and threads share out the
    bristles.
    """

    def __init__(self, model, law, viscosity, state, *, accounting=False, threads=None):
        """
        Take model, law and viscosity as kernels do.

        accounting: keep the energy accounts; threads: None for what the machine has.
        """
        self.model = model
        self._features = law, viscosity, state.audit if accounting else None
        self._state = state
        available = threads or len(os.sched_getaffinity(0))
        self.threads = max(1, min(available, model.bristles // SHARE))
        self._scratch = [new_scratch(model) for _ in range(self.threads)]
        self._table = np.zeros((2 * BATCH + 1, FRAME))
        self._pool = None
        self._saved = [np.empty_like(array) for array in state] if model.bristles > 1 else None

    def advance(self, steps):
        """
        Advance by `steps` steps; return 0, or the status and bristle of the first failure.

        After a failure all bristles are at the start of the failed step. Runs without the GIL.
        """
        while steps > 0:
            batch = min(steps, BATCH)
            failure = self._batch(batch)
            if failure:
                return failure
            steps -= batch
        return 0, 0

    def warm(self):
        """Compile what stepping needs by taking no step."""
        self._run(0)

    def _batch(self, steps):
        if self._saved:
            _copy(self._state, self._saved)
        failure = None
        while True:
            failed = self._run(steps)
            if failed is None:
                self._state.step[0] += steps
                return failure
            steps, *failure = failed
            if self._saved is None:
                self._state.step[0] += steps
                return failure
            # The others are past that step already, or one of them fails before it: once more.
            _copy(self._saved, self._state)

    def _run(self, steps):
        """Make the steps from now on; None, or (step, status, bristle) of a failure."""
        law = self._features[0]
        fill_frames(self.model, law, self._state, self._scratch[0], steps, self._table)
        if self.threads > 1 and self._pool is None:
            self._pool = ThreadPoolExecutor(self.threads - 1, 'stepper')
        others = [self._pool.submit(self._share, i, steps) for i in range(1, self.threads)]
        outcomes = [self._share(0, steps), *(other.result() for other in others)]
        return min(filter(None, outcomes), default=None)

    def _share(self, first, steps):
        scratch = self._scratch[first]
        status = advance(self.model, *self._features, self._state, scratch, self._table, first,
                         self.threads, steps)
        if status:
            return int(scratch.failed[0]), status, int(scratch.failed[1])
        return None


def _copy(source, into):
    for array, other in zip(source, into):
        other[...] = array
