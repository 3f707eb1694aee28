"""Where the mount is over the road, followed chunk by chunk; for viewers, not for the physics."""
import math
from typing import NamedTuple, TYPE_CHECKING, TypeAlias

from bristle_ros.scene import is_uneven, Scene
import numpy as np
from numpy.typing import NDArray

if TYPE_CHECKING:
    from .simulation import Simulation

Quaternion: TypeAlias = tuple[float, float, float, float]


class Pose(NamedTuple):
    """Where the mount is over the road; `road` has its origin in the road plane."""

    position: NDArray[np.float64]   # [m] (3,) of the mount centre, road axes
    rotation: NDArray[np.float64]   # (3, 3) mount axes to road axes
    orientation: Quaternion         # the same as a quaternion x, y, z, w
    kerb: float = 0.0               # [m] how much further to the left the gutter still is


class MountPath:
    """
    Follows the mount over the road.

    `road` has its origin in the road plane below the sweeper's base at the start, and x forward at
    the start, so brushes of one sweeper share it. Height and heading are those of the simulation;
    the way that the sweeper has gone is summed over chunks by the trapezoidal rule, which leaves
    less than 0.1 mm in a metre. On a surface that is not level, and where the mount is carried, it
    is the state's own.
    """

    def __init__(self, scene: Scene) -> None:
        self._its = scene.solver.integration_time_step
        self._attack, self._azimuth = scene.road.attack_angle, scene.road.tilt_azimuth
        self._mount = scene.sweeper.mount_position
        self._uneven = is_uneven(scene.gutter, scene.profile)
        self._start = np.array(scene.sweeper.velocity)
        self._resets = 0
        self._restart()

    def _restart(self) -> None:
        self._step = 0
        self._way: NDArray[np.float64] = np.zeros(2)
        self._velocity = self._start

    def follow(self, simulation: 'Simulation', resets: int) -> Pose:
        """
        Go on to the state of the simulation, which has been reset `resets` times.

        Once at each chunk's end; returns the Pose.
        """
        if resets != self._resets:
            self._resets = resets
            self._restart()
        if simulation.carried:
            return simulation.mount_pose()
        height, heading, forward, left = simulation.sweeper_motion()
        c, s = math.cos(heading), math.sin(heading)
        velocity = np.array((c * forward - s * left, s * forward + c * left))
        elapsed = (simulation.step - self._step) * self._its
        self._way = self._way + 0.5 * elapsed * (self._velocity + velocity)
        self._step, self._velocity = simulation.step, velocity
        if self._uneven:    # its forces depend on the place: that of the state
            self._way = np.array(simulation.base_pose()[:2])
        x, y = self._mount
        position = np.array((self._way[0] + c * x - s * y, self._way[1] + s * x + c * y, height))
        return Pose(position, *tilted(heading, self._attack, self._azimuth),
                    simulation.kerb_offset())


def tilted(heading: float, attack: float, azimuth: float
            ) -> tuple[NDArray[np.float64], Quaternion]:
    """Return Rz(heading) Rz(azimuth) Ry(attack) Rz(-azimuth) as a matrix and as a quaternion."""
    ca, sa = math.cos(attack), math.sin(attack)
    cf, sf = math.cos(heading + azimuth), math.sin(heading + azimuth)
    ct, st = math.cos(azimuth), -math.sin(azimuth)
    matrix = np.array(((cf * ca * ct - sf * st, -cf * ca * st - sf * ct, cf * sa),
                       (sf * ca * ct + cf * st, -sf * ca * st + cf * ct, sf * sa),
                       (-sa * ct, sa * st, ca)))
    lean, turn, side = 0.5 * attack, 0.5 * heading, 0.5 * heading + azimuth
    return matrix, (-math.sin(lean) * math.sin(side), math.sin(lean) * math.cos(side),
                    math.cos(lean) * math.sin(turn), math.cos(lean) * math.cos(turn))
