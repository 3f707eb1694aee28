"""The records of motion: what a bristle feels of it (frame), what commands change, what stays."""
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from .carried import SEGMENT
from .drive import RAMP
from .hub import HUB, Hub

# frame record
ROTATION = 0        # 9  brush axes to road axes, row by row
SPIN = ROTATION + 9  # 3  Omega [rad/s], brush axes
SPIN_RATE = SPIN + 3  # 3  its rate [rad/s^2], brush axes
GRAVITY = SPIN_RATE + 3  # 3  gravity minus the mount's acceleration [m/s^2], brush axes
PATH_SPIN = GRAVITY + 3  # 3  of ROTATION itself, brush axes; SPIN, but not within load steps
VELOCITY = PATH_SPIN + 3  # 3  of the mount centre over the surface [m/s], road axes
HEIGHT = VELOCITY + 3  # 1  of the mount centre over the road plane [m]
HEIGHT_RATE = HEIGHT + 1  # 1
THETA = HEIGHT_RATE + 1  # 1  exact angle, speed of the brush, whatever the load steps are
OMEGA = THETA + 1   # 1
DRAG_SPIN = OMEGA + 1  # 1  speed about z of the brush, seen from here: 0 where it turns along
DRAG_RATE = DRAG_SPIN + 1  # 1  its rate
CLAMP = DRAG_RATE + 1  # 7  position and quaternion of the clamped node
PLACE = CLAMP + 7   # 2  of the mount centre in the surface's axes, x and y [m]; see path.py
FRAME = PLACE + 2

# motion: ramps of mean speed, yaw rate, penetration and sweeper velocity, and the approach
SPEED = 0
YAW = RAMP
PENETRATION = 2 * RAMP
FORWARD = 3 * RAMP
LEFT = 4 * RAMP
APPROACHING = 5 * RAMP      # 1 until the first command to the road

# basics: what the frame is made of, linear between load steps (twelve numbers), then the ramps'
# value, rate and integral
RAMPS = 5
RAMPED = 12
BASICS = RAMPED + 3 * RAMPS
RATES = (2, 5, 7, 9)    # of the basics: accelerations

# motion, where a command splits a load step: its time, and the loads that the step had reached
LOAD_SPLIT = APPROACHING + 1
SPLIT_BASICS = LOAD_SPLIT + 1
SPLIT_CLAMP = SPLIT_BASICS + RAMPED    # 2  cosine and sine that place the clamp on its chord
MOVED = SPLIT_CLAMP + 2     # 2  PLACE at the end of the last step
TURNING = MOVED + 2         # HUB  where the drive feels its load: hub.py
CARRY = TURNING + HUB       # SEGMENT  where the mount is carried: carried.py
MOTION = CARRY + SEGMENT


class Drive(NamedTuple):
    """What determines the brush frame's motion and no command changes; SI units."""

    profile: int
    alternating_speed: float
    frequency: float
    shape: float
    start_angle: float
    cos_attack: float
    sin_attack: float
    tilt_azimuth: float
    down_x: float           # gravity [m/s^2], road axes
    down_y: float
    down_z: float
    tip_depth: float        # of the lowest undeformed tip below the mount centre [m]
    penetration: float      # at the end of the approach [m]
    approach_time: float    # [s]
    mount_x: float          # of the mount centre in the sweeper's turning axes [m]
    mount_y: float
    time_step: float        # TS [s]; 0: exact at every time
    kerb_approach: float    # how much further away the kerb starts [m]
    table: NDArray[np.float64] | None   # (n, 6) of speeds: see `table_at`
    hub: Hub | None         # None: the speed is given
    carrier: bool | None    # None: the mount is never carried
