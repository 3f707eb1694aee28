"""
Why contact enters as half a step's acceleration: with that weight, and no other, it is passive.

One mode, unit mass and step, under a force f constant over each step. In frequency space the
increment of its displacement is H(z) f with z = exp(i a). If Re H >= 0 for all a, force
times increment summed over any sequence of forces is what the mode has taken up and lost, never
less: contact that gives nothing by force times increment gives nothing at all (Parseval).
"""
from bristle_ros.physics.step.scheme import generalized_alpha, hht, newmark
import numpy as np
import pytest

ANGLES = np.linspace(0.003, np.pi - 0.001, 300)
FREQUENCIES = (0.01, 0.1, 0.3, 1.0, 3.0, 10.0, 100.0, 1e4)      # omega h
DAMPING = (1e-6, 0.01, 0.1, 1.0, 10.0)                          # zeta


def least_real_part(scheme, weight=0.5, rate='strain', mass=0.0):
    """
    Return the smallest Re H, over all frequencies and damping, relative to the largest |H|.

    weight : of the force in the displacement: u gains weight h^2 f / m, v1 gains h f / m
    rate : 'strain', Kelvin-Voigt by the integrator's recursion of the strain; or 'velocity'
    mass : alpha_D h
    State: displacement, velocity, pseudo-acceleration, acceleration, strain rate and its own one.
    """
    worst = np.inf
    g, b = scheme.gamma, scheme.beta
    z = np.exp(1j * ANGLES)
    for omega in FREQUENCIES:
        for zeta in DAMPING:
            new, old = np.zeros((2, 6, 6))
            force = np.array([weight, 1.0, 0.0, 0.0, 0.0, 0.0])
            new[0, [0, 2]], old[0, [0, 1, 2]] = (1.0, -b), (1.0, 1.0, 0.5 - b)
            new[1, [1, 2]], old[1, [1, 2]] = (1.0, -g), (1.0, 1.0 - g)
            new[2, [2, 3]] = 1.0 - scheme.alpha_m, scheme.alpha_f - 1.0
            old[2, [2, 3]] = -scheme.alpha_m, scheme.alpha_f
            new[3, [3, 0]] = 1.0, omega ** 2
            new[3, 4 if rate == 'strain' else 1] += 2.0 * zeta * omega
            new[3, 1] += mass
            new[4, [0, 5]], old[4, [0, 4, 5]] = (1.0, -b), (1.0, 1.0, 0.5 - b)
            new[5, [4, 5]], old[5, [4, 5]] = (1.0, -g), (1.0, 1.0 - g)
            step, push = np.linalg.solve(new, old), np.linalg.solve(new, force)
            response = np.linalg.solve(
                z[:, None, None] * np.eye(6) - step, np.broadcast_to(push[:, None], (300, 6, 1)))
            h = (z - 1.0) * response[:, 0, 0]
            worst = min(worst, h.real.min() / abs(h).max())
    return worst


RADII = (0.0, 0.3, 0.6, 0.8, 0.9, 0.99, 1.0)
SCHEMES = ([pytest.param(generalized_alpha(r, 1e-8), id=f'generalized_alpha {r}') for r in RADII]
           + [pytest.param(hht(g, 1e-8), id=f'hht {g}') for g in (0.0, 0.005, 0.1, 1.0 / 3.0)]
           + [pytest.param(newmark(g, 1e-8), id=f'newmark {g}') for g in (0.0, 0.005, 1.0 / 3.0)])


@pytest.mark.parametrize('scheme', SCHEMES)
def test_contact_is_passive(scheme):
    assert least_real_part(scheme) >= -1e-11  # round-off: near an undamped pole |H| is large


@pytest.mark.parametrize('weight', [0.4, 0.6, 0.75, 1.0])
@pytest.mark.parametrize('radius', [0.3, 0.6, 0.8, 0.9])
def test_no_other_weight_is(radius, weight):
    assert least_real_part(generalized_alpha(radius, 1e-8), weight=weight) < -1e-3


@pytest.mark.parametrize('radius', [0.0, 0.3, 0.6, 0.8, 0.9])
def test_damping_through_nodal_velocities_is_not(radius):
    assert least_real_part(generalized_alpha(radius, 1e-8), rate='velocity') < -1e-6


@pytest.mark.parametrize('make', [hht, newmark])
def test_schemes_without_decay_are_the_trapezoidal_rule(make):
    assert tuple(make(0.0, 1e-8))[:5] == (0.0, 0.0, 0.25, 0.5, 1e-8)


@pytest.mark.parametrize('radius', RADII)
def test_spectral_radius_is_what_it_says(radius):
    # Chung, Hulbert (1993), J. Appl. Mech. 60, 371: at infinite frequency
    s = generalized_alpha(radius, 1e-8)
    w2 = 1e16
    new = np.array([[1.0, 0.0, -s.beta, 0.0], [0.0, 1.0, -s.gamma, 0.0],
                    [0.0, 0.0, 1.0 - s.alpha_m, s.alpha_f - 1.0], [1.0, 0.0, 0.0, 1.0 / w2]])
    old = np.array([[1.0, 1.0, 0.5 - s.beta, 0.0], [0.0, 1.0, 1.0 - s.gamma, 0.0],
                    [0.0, 0.0, -s.alpha_m, s.alpha_f], [0.0, 0.0, 0.0, 0.0]])
    values = np.linalg.eigvals(np.linalg.solve(new, old))
    # a double root for radius 0, which round-off splits
    assert abs(values).max() == pytest.approx(radius, abs=1e-3 if radius else 2e-3)
