"""
The time integrator's numbers: generalized-alpha, HHT and Newmark in one form.

With pseudo-accelerations A (Arnold, Bruels 2007, doi 10.1007/s11044-007-9084-0) a step of length h

    u   = h v0 + h^2 ((1/2 - beta) A0 + beta A1)          u: increment over the step
    v1  = v0 + h ((1 - gamma) A0 + gamma A1)
    (1 - alpha_m) A1 + alpha_m A0 = (1 - alpha_f) a1 + alpha_f a0

holds the equation of motion exactly at the step's end, a1 = M^-1 f(x1, v1, t1). Solved for u:

    a1 = ca u - HA,  v1 = cv u + HV,  ca = (1 - alpha_m) / ((1 - alpha_f) beta h^2),
    cv = gamma / (beta h).

The contact force f, constant over the step, enters as an impulse and not through the
accelerations, which would remember it: u gains h^2 f / (2 m) and v1 gains h f / m. With these
weights its work is never positive, for any spectral radius, step and beta_D (test_passivity.py);
with others it is. Mass damping, at nodal velocities, breaks that by less than 4e-8 of the largest
response where alpha_D h is below 1e-4, ten times the paper's at 0.1 ms.
"""
from typing import NamedTuple

from bristle_ros.physics.compiler import jit

TIGHTEST = 1e-11        # tolerance that short steps are not held below: rounding is near
LOOSEST_STEP = 2e-4     # [s] the tolerance falls with the square of steps below


class Scheme(NamedTuple):
    """Coefficients of the integrator, and Newton's tolerance."""

    alpha_m: float
    alpha_f: float
    beta: float
    gamma: float
    tolerance: float    # of the last correction, relative to the element length and to 1 rad, at
    #                     LOOSEST_STEP and above


def generalized_alpha(spectral_radius: float, tolerance: float) -> Scheme:
    """Return the scheme with this spectral radius at infinity; Chung, Hulbert (1993)."""
    r = spectral_radius
    alpha_m = (2.0 * r - 1.0) / (r + 1.0)
    alpha_f = r / (r + 1.0)
    return Scheme(alpha_m, alpha_f, 0.25 * (1.0 - alpha_m + alpha_f) ** 2,
                  0.5 - alpha_m + alpha_f, tolerance)


def hht(amplitude_decay: float, tolerance: float) -> Scheme:
    """Return HHT with amplitude decay factor g: alpha_f = g; Hilber, Hughes, Taylor (1977)."""
    g = amplitude_decay
    return Scheme(0.0, g, 0.25 * (1.0 + g) ** 2, 0.5 + g, tolerance)


def newmark(amplitude_decay: float, tolerance: float) -> Scheme:
    """Return Newmark with amplitude decay factor g: gamma = 1/2 + g; first order unless g = 0."""
    g = amplitude_decay
    return Scheme(0.0, 0.0, 0.25 * (1.0 + g) ** 2, 0.5 + g, tolerance)


@jit
def newton_tolerance(tolerance, h):
    """
    Return what Newton's last correction may be in a step of length h.

    What is left of it in the increment acts like an acceleration of ca ~ 1/h^2 times it. In short
    steps it would outweigh the integrator's own error: free rotation over 1 s in 50,000 steps,
    1e-8 each, ends 0.16 % off; with this, 0.001 %.
    """
    ratio = min(h / LOOSEST_STEP, 1.0)
    return max(tolerance * ratio * ratio, min(tolerance, TIGHTEST))
