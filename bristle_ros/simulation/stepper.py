"""Steps a brush: batches of steps, whose bristles several threads share out."""
from collections.abc import Iterable
from concurrent.futures import ThreadPoolExecutor
import os
from typing import Any, TypeAlias

from bristle_ros.physics.contact import ContactLaw
from bristle_ros.physics.motion import FRAME
from bristle_ros.physics.step import (advance, advance_alone, BATCH, fill_frames, Model,
                                      Scratch, State)
import numpy as np
from numpy.typing import NDArray

from .model import new_scratch

CHECKPOINT = 200    # steps from one checkpoint to the next: copying is a few steps' work
SHARE = 2   # bristles that a thread must get at least, to be worth waking

# step, status and bristle
Failure: TypeAlias = tuple[int, int, int]


class Stepper:
    """
    Advances the bristles of a state; what they give depends on no number of threads.

    Bristles feel the brush's motion and the road, not each other, so each makes all steps of a
    batch before the next one begins: its matrices stay in the cache, and threads take one after
    the other from a queue. When one fails, the others are past that step already: the state goes
    back to the last checkpoint and comes again as far as the failed step.
    """

    def __init__(self, model: Model, law: ContactLaw | None, viscosity: float | None, state: State,
                 *, accounting: bool = False, threads: int | None = None) -> None:
        """
        Take model, law and viscosity as kernels do.

        accounting: keep the energy accounts; threads: None for what the machine has.
        """
        self.model = model
        self._features = law, viscosity, state.audit if accounting else None
        self._state = state
        available = threads or len(os.sched_getaffinity(0))
        self.threads = max(1, min(available, model.bristles // SHARE))
        self._queue = np.zeros(1, np.int64)
        self._scratch = [new_scratch(model) for _ in range(self.threads)]
        self._table = np.zeros((2 * BATCH + 1, FRAME))
        self._pool: ThreadPoolExecutor | None = None
        self._checkpoint: list[NDArray[Any]] = []
        # what was advanced since: (steps, motion, model) of each batch
        self._since: list[tuple[int, NDArray[np.float64], Model]] = []

    def advance(self, steps: int) -> tuple[int, int]:
        """
        Advance by `steps` steps; return 0, or the status and bristle of the first failure.

        After a failure all bristles are at the start of the failed step. Runs without the GIL.
        """
        if self.model.bristles == 1:
            return self._alone(steps), 0
        while steps > 0:
            batch = min(steps, BATCH)
            failure = self._batch(batch)
            if failure:
                return failure
            steps -= batch
        return 0, 0

    def warm(self) -> None:
        """Compile what stepping needs by taking no step."""
        if self.model.bristles == 1:
            self._alone(0)
        else:
            self._run(0)

    def _alone(self, steps: int) -> int:
        status: int = advance_alone(self.model, *self._features, self._state, self._scratch[0],
                                    self._table, steps)
        return status

    def forget(self) -> None:
        """Keep nothing of what was: the state has been put elsewhere."""
        self._since = []

    def _batch(self, steps: int) -> tuple[int, int] | None:
        if not self._since or sum(batch[0] for batch in self._since) >= CHECKPOINT:
            if not self._checkpoint:
                self._checkpoint = [np.empty_like(array) for array in self._state]
            _copy(self._state, self._checkpoint)
            self._since = []
        self._since.append((steps, self._state.motion.copy(), self.model))
        failure: tuple[int, int] | None = None
        failed = self._run(steps)
        while failed is not None:   # once more as far as that; another may fail before it
            steps, failure = failed[0], failed[1:]
            self._since[-1] = (steps, *self._since[-1][1:])
            _copy(self._checkpoint, self._state)
            failed = self._again()
        if failure:
            self.forget()
        return failure

    def _again(self) -> Failure | None:
        """Make the steps since the checkpoint once more; the outcome of the last batch."""
        failed = None
        for steps, motion, model in self._since:
            self._state.motion[:] = motion
            self.model = model
            failed = self._run(steps)
        return failed

    def _run(self, steps: int) -> Failure | None:
        """Make the steps from now on; None, or (step, status, bristle) of a failure."""
        fill_frames(self.model, self._features[0], self._state, self._scratch[0], steps,
                    self._table)
        if self.threads > 1 and self._pool is None:
            self._pool = ThreadPoolExecutor(self.threads - 1, 'stepper')
        self._queue[0] = 0
        others = [self._pool.submit(self._work, scratch, steps)
                  for scratch in self._scratch[1:]] if self._pool else []
        failures = [self._work(self._scratch[0], steps), *(other.result() for other in others)]
        failed = min(filter(None, failures), default=None)
        if failed is None:
            self._state.step[0] += steps
        return failed

    def _work(self, scratch: Scratch, steps: int) -> Failure | None:
        """Take bristles until none is left; None, or (step, status, bristle) of a failure."""
        status = advance(self.model, *self._features, self._state, scratch, self._table,
                         self._queue, steps)
        if status:
            return int(scratch.failed[1]), status, int(scratch.failed[2])
        return None


def _copy(source: Iterable[NDArray[Any]], into: Iterable[NDArray[Any]]) -> None:
    for array, other in zip(source, into):
        other[...] = array
