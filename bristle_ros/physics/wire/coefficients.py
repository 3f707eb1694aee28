"""What a time integrator makes of a step's length, as the kernels of a wire take it."""
from typing import NamedTuple

from bristle_ros.physics.compiler import inlined


class StepCoefficients(NamedTuple):
    """
    Numbers of one step.

    With u the increment over it and zero marking its start, acceleration = ca u - HA and
    velocity = cv u + HV, HV = keep v0 + drift a0.
    """

    h: float                # [s] length of the step
    ca: float               # [1/s^2]
    cv: float               # [1/s]
    keep: float
    drift: float            # [s]
    factor: float           # by which beta_D stiffens the material: 1 + beta_D cv
    mass_factor: float      # [1/s^2] by which alpha_D stiffens inertia: ca + alpha_D cv
    gain: float             # residual per unit of contact force: ca h^2 / 2 - alpha_D drift


@inlined
def pseudo_step(ca):
    """Return the coefficients of a static search, where inertia alone holds back: ca [1/s^2]."""
    return StepCoefficients(0.0, ca, 0.0, 0.0, 0.0, 1.0, ca, 0.0)
