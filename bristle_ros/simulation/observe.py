"""The outputs of all rows of a brush, of which the kernels know one at a time."""
from functools import reduce

from bristle_ros.physics.contact import ContactLaw
from bristle_ros.physics.step import Model, output, Scratch, State
import numpy as np
from numpy.typing import NDArray

from .model import rows_of, states_of


def observe_rows(models: tuple[Model, ...], law: ContactLaw | None, viscosity: float | None,
                 state: State, scratch: Scratch, rows: NDArray[np.float64],
                 totals: NDArray[np.float64]) -> None:
    """
    Fill the outputs of the present state.

    rows : (B, BRISTLE_COLUMNS), totals : (TOTALS,)   as output.py says
    """
    found = []
    for part, model, own in zip(rows_of(models), models, states_of(state, models)):
        output.observe(model, law, viscosity, own, scratch, rows[part], totals)
        found.append(totals[:output.ANGLE].copy())
    totals[:output.ANGLE] = reduce(np.add, found)
