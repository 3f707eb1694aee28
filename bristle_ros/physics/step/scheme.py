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

from bristle_ros.physics.compiler import inlined, jit
from bristle_ros.physics.wire import StepCoefficients

LARGEST_SHARE = 0.1     # of the step's local error that Newton may leave
HELD = 1e-8             # tolerance below which no local error takes it
TIGHTEST = 1e-11        # that short steps are not held below: rounding is near
LOOSEST_STEP = 2e-4     # [s] both bounds fall with the square of steps below


class Scheme(NamedTuple):
    """Coefficients of the integrator, and Newton's tolerance."""

    alpha_m: float
    alpha_f: float
    beta: float
    gamma: float
    tolerance: float    # of the last correction, relative to the element length and to 1 rad, at
    #                     LOOSEST_STEP and above
    share: float        # of the step's local error that is enough, where less
    tied: bool          # False: it never is


def generalized_alpha(spectral_radius: float, tolerance: float, tied: bool = True) -> Scheme:
    """Return the scheme with this spectral radius at infinity; Chung, Hulbert (1993)."""
    r = spectral_radius
    alpha_m = (2.0 * r - 1.0) / (r + 1.0)
    alpha_f = r / (r + 1.0)
    return Scheme(alpha_m, alpha_f, 0.25 * (1.0 - alpha_m + alpha_f) ** 2,
                  0.5 - alpha_m + alpha_f, tolerance, _share(r), tied)


def hht(amplitude_decay: float, tolerance: float, tied: bool = True) -> Scheme:
    """Return HHT with amplitude decay factor g: alpha_f = g; Hilber, Hughes, Taylor (1977)."""
    g = amplitude_decay
    return Scheme(0.0, g, 0.25 * (1.0 + g) ** 2, 0.5 + g, tolerance,
                  _share((1.0 - g) / (1.0 + g)), tied)


def newmark(amplitude_decay: float, tolerance: float, tied: bool = True) -> Scheme:
    """Return Newmark with amplitude decay factor g: gamma = 1/2 + g; first order unless g = 0."""
    g = amplitude_decay
    return Scheme(0.0, 0.0, 0.25 * (1.0 + g) ** 2, 0.5 + g, tolerance,
                  _share((1.0 - g) / (1.0 + g)), tied)


def _share(spectral_radius):
    """
    Return the part of a step's local error that Newton may leave.

    What is left is in A, and so in the next estimate, which allows the next step as much again: it
    has to die out. At infinite frequency it takes 1 / (1 - spectral radius) steps for that.
    """
    return min(LARGEST_SHARE, 0.5 * (1.0 - spectral_radius))


@inlined
def step_coefficients(scheme, mass_damping, viscosity, h):
    """
    Return the StepCoefficients of a step of length h; the equations are above.

    mass_damping [1/s] : float      alpha_D;  viscosity [s] : float or None    beta_D
    """
    ca = (1.0 - scheme.alpha_m) / ((1.0 - scheme.alpha_f) * scheme.beta * h * h)
    cv = scheme.gamma / (scheme.beta * h)
    drift = h * (1.0 - 0.5 * scheme.gamma / scheme.beta)
    factor = 1.0
    if viscosity is not None:
        factor = 1.0 + viscosity * cv
    return StepCoefficients(h, ca, cv, 1.0 - scheme.gamma / scheme.beta, drift, factor,
                            ca + mass_damping * cv, 0.5 * ca * h * h - mass_damping * drift)


@jit
def newton_tolerance(scheme, h, error):
    """
    Return what Newton's last correction may be in a step of length h.

    error : float   local error that the step is expected to have, as relative as the result

    What is left of the correction acts like a local error, so a share of that is well below what
    matters. It also acts like an acceleration of ca ~ 1/h^2 times it, which in short steps would
    outweigh the integrator's own error: free rotation over 1 s in 50,000 steps, 1e-8 each, ends
    0.16 % off; with bounds that fall with h^2, 0.001 %.
    """
    ratio = min(h / LOOSEST_STEP, 1.0) ** 2
    most = max(scheme.tolerance * ratio, min(scheme.tolerance, TIGHTEST))
    if not scheme.tied:
        return most
    least = max(min(scheme.tolerance, HELD) * ratio, min(scheme.tolerance, TIGHTEST))
    return min(max(scheme.share * error, least), most)
