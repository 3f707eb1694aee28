"""Where the road touches wires beside their tips, for those who draw it."""
from typing import NamedTuple, TYPE_CHECKING

from bristle_ros.physics.contact import ALIVE, FORCE, OPEN, STATE, XI
import numpy as np
from numpy.typing import NDArray

if TYPE_CHECKING:
    from .simulation import Simulation


class Contacts(NamedTuple):
    """The k points beside the tips at which the road touches."""

    bristle: NDArray[np.int64]      # (k,) whose wire it is
    place: NDArray[np.float64]      # (k, 3) [m] mount axes
    force: NDArray[np.float64]      # (k, 3) [N] of the road on one wire, road axes


NONE = Contacts(np.zeros(0, np.int64), np.zeros((0, 3)), np.zeros((0, 3)))


def wire_contacts(simulation: 'Simulation', centreline: NDArray[np.float64]) -> Contacts:
    """
    Return the Contacts of the present state.

    centreline : (B, 2 n + 1, 3) [m] of it, mount axes. A point lies on its element's own curve,
    the parabola through its three nodes.
    """
    points = simulation.state.points
    if not points.size:
        return NONE
    used = (points[..., ALIVE] > 0.0) & (points[..., STATE] != OPEN)
    if not used.any():
        return NONE
    bristle, element = np.nonzero(used)
    found = points[bristle, element]
    xi = found[:, XI, None]
    place = (0.5 * xi * (xi - 1.0) * centreline[bristle, 2 * element]
             + (1.0 - xi * xi) * centreline[bristle, 2 * element + 1]
             + 0.5 * xi * (xi + 1.0) * centreline[bristle, 2 * element + 2])
    return Contacts(bristle, place, found[:, FORCE:FORCE + 3].copy())
