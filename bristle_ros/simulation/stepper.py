"""Steps a brush: batches of steps, whose bristles several threads share out."""
from collections.abc import Iterable
from concurrent.futures import ThreadPoolExecutor
import os
from typing import Any, TypeAlias

from bristle_ros.physics.contact import ContactLaw
from bristle_ros.physics.motion import keep_place
from bristle_ros.physics.step import (advance, BATCH, fill_frames, Model, Scratch, State,
                                      STRESS_MAX, STRESS_MIN)
import numpy as np
from numpy.typing import NDArray

from .model import new_scratch, rows_of, states_of

CHECKPOINT = 200    # steps from one checkpoint to the next: copying is a few steps' work
SHARE = 2   # bristles that a thread must get at least, to be worth waking

# step, status and bristle
Failure: TypeAlias = tuple[int, int, int]


class Stepper:
    """
    Advances the bristles of a state; what they give depends on no number of threads.

    Bristles feel the brush's motion and the road, not each other, so each makes all steps of a
    batch before the next one begins: its matrices stay in the cache, and threads take one after
    the other from a queue. Kernels know one row of a brush at a time: each has its model, its part
    of the state and its queue. When one bristle fails, others are past that step already: the
    state goes back to the last checkpoint and comes again as far as the failed step.
    """

    def __init__(self, models: tuple[Model, ...], law: ContactLaw | None,
                 viscosity: float | None, state: State, *, accounting: bool = False,
                 threads: int | None = None) -> None:
        """
        Take law and viscosity as kernels do, and the model of each row.

        accounting: keep the energy accounts; threads: None for what the machine has.
        """
        self.models = models
        self._features = law, viscosity, state.audit if accounting else None
        self._state = state
        available = threads or len(os.sched_getaffinity(0))
        self._states = states_of(state, models)
        self._firsts = [part.start for part in rows_of(models)]
        self._bristles = len(state.nodes)
        self.threads = max(1, min(available, self._bristles // SHARE))
        self._queues = np.zeros((len(models), 1), np.int64)
        # each thread's, for each row: frames have the row's clamp
        tables = [new_scratch(model).table for model in models]
        self._scratch = [[new_scratch(model, law)._replace(table=table)
                          for model, table in zip(models, tables)] for _ in range(self.threads)]
        self._begin_extremes(True)
        self._pool: ThreadPoolExecutor | None = None
        self._checkpoint: list[NDArray[Any]] = []
        # what was advanced since: (steps, motion, models, fresh) of each batch
        self._since: list[tuple[int, NDArray[np.float64], tuple[Model, ...], bool]] = []
        self._fresh = True  # the extremes of the stress begin with the next step

    def advance(self, steps: int) -> tuple[int, int]:
        """
        Advance by `steps` steps; return 0, or the status and bristle of the first failure.

        After a failure all bristles are at the start of the failed step. Runs without the GIL.
        """
        if steps == 0:
            return 0, 0
        if self._bristles == 1:
            self._begin_extremes(self._fresh)
            self._fresh = False
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
        if self._bristles == 1:
            self._alone(0)
        else:
            self._run(0)

    def _alone(self, steps: int) -> int:
        status: int = advance(self.models[0], *self._features, self._state, self._scratch[0][0],
                              self._queues[0], steps, True)
        return status

    def forget(self) -> None:
        """Keep nothing of what was: the state has been put elsewhere."""
        self._since = []
        self._fresh = True

    def begin_sample(self) -> None:
        """Let the extremes of the stress be those from here on."""
        self._fresh = True

    def _begin_extremes(self, fresh: bool) -> None:
        if fresh:
            self._state.audit[:, STRESS_MIN:STRESS_MIN + 4] = np.inf
            self._state.audit[:, STRESS_MAX:STRESS_MAX + 4] = -np.inf

    def _batch(self, steps: int) -> tuple[int, int] | None:
        if not self._since or sum(batch[0] for batch in self._since) >= CHECKPOINT:
            if not self._checkpoint:
                self._checkpoint = [np.empty_like(array) for array in self._state]
            _copy(self._state, self._checkpoint)
            self._since = []
        self._since.append((steps, self._state.motion.copy(), self.models, self._fresh))
        self._begin_extremes(self._fresh)
        self._fresh = False
        failure: tuple[int, int] | None = None
        failed = self._run(steps)
        while failed is not None:   # once more as far as that; another may fail before it
            steps, failure = failed[0], failed[1:]
            self._since[-1] = (steps, *self._since[-1][1:])
            _copy(self._checkpoint, self._state)
            failed = self._again()
        if failure:
            self._since = []
        return failure

    def _again(self) -> Failure | None:
        """Make the steps since the checkpoint once more; the outcome of the last batch."""
        failed = None
        for steps, motion, models, fresh in self._since:
            self._begin_extremes(fresh)
            self._state.motion[:] = motion
            self.models = models
            failed = self._run(steps)
        return failed

    def _run(self, steps: int) -> Failure | None:
        """Make the steps from now on; None, or (step, status, bristle) of a failure."""
        failed = self._share(steps)
        if failed is None:
            keep_place(self._scratch[0][0].table, self._state.motion, steps)
            self._state.step[0] += steps
        return failed

    def _share(self, steps: int) -> Failure | None:
        """Advance the bristles alone by `steps` steps, on all threads; what `_run` returns."""
        for model, state, scratch in zip(self.models, self._states, self._scratch[0]):
            fill_frames(model, self._features[0], state, scratch, steps)
        if self.threads > 1 and self._pool is None:
            self._pool = ThreadPoolExecutor(self.threads - 1, 'stepper')
        self._queues[:] = 0
        others = [self._pool.submit(self._work, scratch, steps)
                  for scratch in self._scratch[1:]] if self._pool else []
        failures = [self._work(self._scratch[0], steps), *(other.result() for other in others)]
        return min(filter(None, failures), default=None)

    def _work(self, scratches: list[Scratch], steps: int) -> Failure | None:
        """Take bristles until none is left; None, or (step, status, bristle) of a failure."""
        law, viscosity, audit = self._features
        found: list[Failure] = []
        for model, state, scratch, queue, first in zip(
                self.models, self._states, scratches, self._queues, self._firsts):
            status = advance(model, law, viscosity, None if audit is None else state.audit, state,
                             scratch, queue, steps, False)
            if status:
                found.append((int(scratch.failed[1]), status, first + int(scratch.failed[2])))
        return min(found, default=None)


def _copy(source: Iterable[NDArray[Any]], into: Iterable[NDArray[Any]]) -> None:
    for array, other in zip(source, into):
        other[...] = array
