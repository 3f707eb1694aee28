"""The mean of what the brush does to the sweeper, chunk by chunk: what a simulator applies."""
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

if TYPE_CHECKING:
    from .simulation import Simulation


class MeanWrench:
    """Follows a simulation whose mount may be carried; starts at its start."""

    def __init__(self) -> None:
        self._resets = self._step = 0
        self._impulse: NDArray[np.float64] = np.zeros(6)

    def follow(self, simulation: 'Simulation', resets: int) -> NDArray[np.float64]:
        """
        Return the mean since the last call, once at each chunk's end: (6,) [N, N m], mount axes.

        resets : int    of the simulation so far; after one, the mean since then
        """
        if resets != self._resets:
            self._resets, self._step, self._impulse = resets, 0, np.zeros(6)
        impulse, steps = simulation.wrench_impulse(), simulation.step - self._step
        mean = (impulse - self._impulse) / (max(steps, 1) * simulation.its)
        self._step, self._impulse = simulation.step, impulse
        return mean
