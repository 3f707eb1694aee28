"""Gaps of other programs' nodes to the surface of a scene, compiled: theirs would be as fast."""
from bristle_ros.physics.compiler import jit
from bristle_ros.physics.contact import gap_at
from bristle_ros.simulation import surface_of
import numpy as np


@jit
def _fill(surface, places, gaps, sums):
    for i in range(places.shape[0]):
        gap, n1, n2, n3, _ = gap_at(surface, places[i, 0], places[i, 1], places[i, 2], sums)
        gaps[i, 0] = gap
        gaps[i, 1] = n1
        gaps[i, 2] = n2
        gaps[i, 3] = n3


def surface_gaps(scene):
    """Return a function from places (n, 3) [m] to gaps (n,) [m] and unit normals (n, 3)."""
    surface, sums = surface_of(scene), np.zeros(16)

    def gaps(places):
        found = np.empty((len(places), 4))
        _fill(surface, places, found, sums)
        return found[:, 0], found[:, 1:]
    return gaps
