"""Where the mount is and how it moves: ramps of the scene's commands, or the way it is carried."""
import math

from bristle_ros.physics.motion import (approach_at as compiled_approach_at, APPROACHING, Drive,
                                        FORWARD, kerb_offset as compiled_kerb_offset, LEFT, MOVED,
                                        PENETRATION, RAMP, ramp_at as compiled_ramp_at, SPEED, YAW)
from bristle_ros.scene import Scene
import numpy as np
from numpy.typing import NDArray

from .carried import is_carried, MountState, quaternion_of, state_at
from .mount_path import Pose, tilted

# A few commands a second are not worth a compiled function that has to be loaded.
ramp_at = getattr(compiled_ramp_at, 'py_func', compiled_ramp_at)
approach_at = getattr(compiled_approach_at, 'py_func', compiled_approach_at)
kerb_offset = getattr(compiled_kerb_offset, 'py_func', compiled_kerb_offset)

SLACK = 2e-5    # of an integration step, when a time is compared with a ramp's end


class Mount:
    """
    The mount of a simulation, at times [s] of the present command.

    motion : the record that the kernels step by; `follow` writes ramps there, the rest reads
    """

    def __init__(self, scene: Scene, drive: Drive, motion: NDArray[np.float64]) -> None:
        """Take the record of a simulation, and what its frames are made from."""
        self._scene, self._drive, self._motion = scene, drive, motion
        self._its = scene.solver.integration_time_step

    @property
    def carried(self) -> bool:
        """Whether the mount is carried: since the first cmd_mount."""
        return is_carried(self._motion)

    def state(self, now: float) -> MountState:
        """Return where the mount is and how it moves, road axes."""
        motion = self._motion
        if self.carried:
            return state_at(now, motion)
        height, heading, forward, left = self.sweeper(now)
        yaw, (x, y) = ramp_at(motion, YAW, now)[0], self._scene.sweeper.mount_position
        c, s = math.cos(heading), math.sin(heading)
        forward, left = forward - yaw * y, left + yaw * x
        road = self._scene.road
        rise = (approach_at(now, road.penetration, road.approach_time) if motion[APPROACHING]
                else ramp_at(motion, PENETRATION, now))[1]
        rotation, _ = tilted(heading, road.attack_angle, road.tilt_azimuth)
        place = np.array((motion[MOVED], motion[MOVED + 1] + self.kerb_offset(now), height))
        return MountState(place, np.array((c * forward - s * left, s * forward + c * left, -rise)),
                          rotation, yaw * rotation[2])

    def pose(self, now: float) -> Pose:
        """Return where a mount that is carried is."""
        state = self.state(now)
        return Pose(state.position, state.rotation, quaternion_of(state.rotation),
                    self.kerb_offset(now))

    def sweeper(self, now: float) -> tuple[float, float, float, float]:
        """Return (height of the mount [m], heading [rad], forward, left [m/s] of the base)."""
        motion = self._motion
        depth = (self._depth(now) if motion[APPROACHING]
                 else ramp_at(motion, PENETRATION, now)[0])
        return (self._drive.tip_depth - depth, ramp_at(motion, YAW, now)[2],
                ramp_at(motion, FORWARD, now)[0], ramp_at(motion, LEFT, now)[0])

    def kerb_offset(self, now: float) -> float:
        """Return how much further away than `gutter.kerb_distance` the gutter still is [m]."""
        offset: float = kerb_offset(now, self._drive)[0]
        return offset

    def base_pose(self, now: float) -> tuple[float, float, float]:
        """Return x, y [m], heading [rad] of the sweeper's base; of a mount that is carried."""
        motion = self._motion
        if self.carried:
            state = self.state(now)
            x, y, _ = state.position.tolist()
            _, _, turn, whole = quaternion_of(state.rotation)
            return x, y, 2.0 * math.atan2(turn, whole)     # about z, whatever the tilt
        heading = ramp_at(motion, YAW, now)[2]
        c, s = math.cos(heading), math.sin(heading)
        x, y = self._scene.sweeper.mount_position
        return (float(motion[MOVED]) - (c * x - s * y),
                float(motion[MOVED + 1]) - (s * x + c * y) + self.kerb_offset(now), heading)

    def follow(self, topic: str, values: tuple[float, ...], now: float) -> None:
        """Ramp to what cmd_brush_speed, cmd_penetration or cmd_vel ask for."""
        scene, motion = self._scene, self._motion
        if topic == 'cmd_brush_speed':
            self._ramp(SPEED, now, values[0], scene.drive.max_acceleration)
        elif topic == 'cmd_penetration':
            if motion[APPROACHING]:
                motion[PENETRATION:PENETRATION + RAMP] = (
                    now, self._depth(now), self._depth(now), 0.0, 0.0, 0.0)
                motion[APPROACHING] = 0.0
            self._ramp(PENETRATION, now, values[0], scene.road.max_rate)
        else:
            change = math.hypot(values[0] - ramp_at(motion, FORWARD, now)[0],
                                values[1] - ramp_at(motion, LEFT, now)[0])
            duration = change / scene.sweeper.max_acceleration
            self._ramp(FORWARD, now, values[0], None, duration)
            self._ramp(LEFT, now, values[1], None, duration)
            self._ramp(YAW, now, values[2], scene.sweeper.max_yaw_acceleration)

    def _ramp(self, at: int, now: float, target: float, limit: float | None,
              duration: float = 0.0) -> None:
        motion = self._motion
        value, _, integral = ramp_at(motion, at, now)
        if limit is not None:
            duration = abs(target - value) / limit
        # whole steps: a kink inside a step would be missed, or taken for all of it
        duration = math.ceil(duration / self._its - 1e-9) * self._its
        slack = SLACK * self._its if duration else 0.0
        motion[at:at + RAMP] = (now, value, target, duration, integral, slack)

    def _depth(self, now: float) -> float:
        road = self._scene.road
        depth: float = approach_at(now, road.penetration, road.approach_time)[0]
        return depth
