"""
The laws of a point of the wire and the road: unilateral contact, Coulomb friction, over one step.

All in road axes (z the road's normal), over one step of length h from gap g0 to gap g1. The force
is constant over the step, and the laws hold between it and the displacement over the step:

    spring    f_n (g1 - g0) = Phi(g0) - Phi(g1),  Phi = Kn min(g, 0)^2 / 2      (discrete gradient)
    rigid     g1 >= 0,  f_n >= 0,  f_n g1 = 0
    friction  |f_t| <= mu f_n, opposite to the slip s where it slips, s = 0 where it sticks

so that the work of the contact is what the spring stores, minus what damping and friction take: at
no step size can it inject energy. Discrete gradient: Gonzalez, Simo (1996); for contact Laursen,
Love (2002), Int. J. Numer. Meth. Eng. 53, 245. Friction: the paper's eq. (1),
mu = mu_k + (mu_s - mu_k) exp(-c_v |s| / h); stick is taken wherever it is admissible.
"""
from math import exp
from typing import NamedTuple

from bristle_ros.physics.compiler import jit

from .surface import Surface

OPEN = 0.0
SLIP = 1.0
STICK = 2.0
UNSOLVED = -1.0     # the compliance is not positive definite: the step is too long for the load


class Wire(NamedTuple):
    """How contact is looked for along the wire."""

    samples: int        # parts of an element in which the lowest minimum of the gap is looked for


class ContactLaw(NamedTuple):
    """Normal and friction law of the wire, and what it touches."""

    stiffness: float    # Kn [N/m]; 0 stands for rigid
    damping: float      # Hunt-Crossley [s/m]
    static: float       # mu_s
    kinetic: float      # mu_k
    decay: float        # c_v [s/m]
    surface: Surface | None = None      # None: the nominal plane
    wire: Wire | None = None            # None: the tip alone touches
    older: bool = False     # solved by rules that bits of old logs need


@jit
def spring_energy(stiffness, gap):
    """Return what the contact spring stores at this gap [J]."""
    if gap < 0.0:
        return 0.5 * stiffness * gap * gap
    return 0.0


@jit
def normal_slope(law, h, gap0, gap1):
    """
    Return the normal force [N] of a step from gap0 to gap1 [m], and its derivative by gap1 [N/m].

    The spring's discrete gradient times the Hunt-Crossley factor 1 + damping * (penetration rate).
    Never negative, and monotone: it falls as gap1 grows. Finite stiffness.
    """
    if gap0 <= 0.0:
        if gap1 <= 0.0:
            force = -0.5 * law.stiffness * (gap0 + gap1)
            slope = -0.5 * law.stiffness
        else:
            force = 0.5 * law.stiffness * gap0 * gap0 / (gap1 - gap0)
            slope = -force / (gap1 - gap0)
    elif gap1 < 0.0:
        force = 0.5 * law.stiffness * gap1 * gap1 / (gap0 - gap1)
        slope = law.stiffness * gap1 / (gap0 - gap1) + force / (gap0 - gap1)
    else:
        return 0.0, 0.0
    factor = 1.0 + law.damping * (gap0 - gap1) / h
    if factor < 0.0:
        return 0.0, 0.0
    return force * factor, slope * factor - force * law.damping / h


@jit
def normal_force(law, h, gap0, gap1):
    """Return the normal force [N] alone; see `normal_slope`."""
    return normal_slope(law, h, gap0, gap1)[0]


@jit
def holding_force(w, base1, base2, normal):
    """Return the friction force (two components) that holds the tip at this normal force."""
    s1 = base1 + w[0, 2] * normal
    s2 = base2 + w[1, 2] * normal
    inverse = 1.0 / (w[0, 0] * w[1, 1] - w[0, 1] * w[1, 0])
    return (s2 * w[0, 1] - s1 * w[1, 1]) * inverse, (s1 * w[1, 0] - s2 * w[0, 0]) * inverse


@jit
def friction_coefficient(law, speed):
    """Return mu at this slip speed [m/s] and its derivative [s/m]."""
    fall = (law.static - law.kinetic) * exp(-law.decay * speed)
    return law.kinetic + fall, -law.decay * fall
