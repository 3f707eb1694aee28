"""The outputs of all rows of a brush, of which the kernels know one at a time."""
from bristle_ros.physics.contact import ContactLaw
from bristle_ros.physics.step import Model, output, Scratch, State
import numpy as np
from numpy.typing import NDArray


def observe_rows(models: tuple[Model, ...], states: tuple[State, ...], law: ContactLaw | None,
                 viscosity: float | None, scratch: Scratch, rows: NDArray[np.float64],
                 totals: NDArray[np.float64]) -> None:
    """
    Fill the outputs of the present states, one for each model.

    rows : (B, BRISTLE_COLUMNS), totals : (TOTALS,)   as output.py says
    """
    if len(models) == 1:
        output.observe(models[0], law, viscosity, states[0], scratch, rows, totals)
        return
    whole, first = np.zeros(output.ANGLE), 0
    for model, state in zip(models, states):
        end = first + model.bristles
        output.observe(model, law, viscosity, state, scratch, rows[first:end], totals)
        whole += totals[:output.ANGLE]
        first = end
    totals[:output.ANGLE] = whole
