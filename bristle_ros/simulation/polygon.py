"""
What an integrator makes of the jumps of a clamp's velocity at the corners of a polygon.

Where the clamp is driven along chords (displacement load case, load steps longer than ITS), nodes
that follow it have their increments prescribed, and velocity and pseudo-acceleration come from the
integrator's own update (physics/step/scheme.py). What these are off by, d = (v - chord's, h A),
then follows d1 = M d0,

    M = [[1 - gamma / beta, 1 - gamma / (2 beta)], [-1 / beta, 1 - 1 / (2 beta)]],

and begins as (-jump, 0) at a corner. Its eigenvalues are the scheme's at infinite frequency.
"""
from typing import NamedTuple

from bristle_ros.physics.step import Scheme
from bristle_ros.scene import Scene
import numpy as np

SMALL = 0.01    # of a jump: below it the ringing is over
MOST = 1000     # corners that are added up


class Ring(NamedTuple):
    """The deviation of the velocity at the ends of the steps behind a corner, per jump."""

    at: np.ndarray      # (steps,) from corner to corner, what is left of earlier ones included
    lasts: int          # steps until it stays below SMALL of a jump, at most all of them


def load_steps(scene: Scene) -> int:
    """Return the integration steps from corner to corner; 0 where the clamp is on its circle."""
    solver = scene.solver
    if solver.load_case != 'displacement' or solver.time_step == 0.0:
        return 0
    count = round(solver.time_step / solver.integration_time_step)
    return count if count > 1 else 0    # with one, the corners are the ends of all steps


def ring_of(scheme: Scheme, steps: int, corners: int) -> Ring:
    """
    Return how velocities ring behind the last of some corners.

    steps : int     from corner to corner, 2 or more;  corners : int    1 or more
    Where nothing decays the corners add up for ever: those beyond MOST are left out.
    """
    by_velocity, by_pseudo = scheme.gamma / scheme.beta, 0.5 / scheme.beta
    once = np.array([[1.0 - by_velocity, 1.0 - 0.5 * by_velocity],
                     [-1.0 / scheme.beta, 1.0 - by_pseudo]])
    between = np.linalg.matrix_power(once, steps)
    deviation = np.zeros(2)
    for _ in range(min(corners, MOST)):
        deviation = between @ deviation + (-1.0, 0.0)
    found = np.empty(steps)
    for i in range(steps):
        deviation = once @ deviation
        found[i] = deviation[0]
    above = np.flatnonzero(np.abs(found) > SMALL)
    return Ring(found, int(above[-1]) + 1 if above.size else 0)
