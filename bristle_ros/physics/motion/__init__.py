"""How the brush moves over the road, and what that does to a wire in its frame."""
# flake8: noqa: F401  what other rooms may use
from .carried import (AT_ACCELERATION, AT_PLACE, AT_RATE, AT_RATE_RATE, AT_ROTATION, AT_VELOCITY,
                      CARRIED, CARRIED_AT, carried_at, CUBIC, FROM, jacobian_factors, MOVES,
                      SEGMENT, SINCE, TURNS, VECTOR)
from .drive import approach_at, CONSTANT, RAMP, ramp_at, SINE, VAP
from .frame import (drive_clamp, frame_at, is_carried, is_polygon, kerb_offset, new_motion,
                    turn_frame)
from .hub import (ACCELERATION, ADDED, ASKED, ATTEMPTS, COMMAND, DRIVE_WORK, drive_torque, END,
                  HUB, Hub, LASTS, MOUNT_RATE, OWED, PSEUDO, REACTION, START, STARTED, TORQUE)
from .loads import asked_speed, renew_rates, split_load_step
from .path import follow_path, keep_place, way_within
from .records import (APPROACHING, BASICS, CARRY, CLAMP, DRAG_RATE, DRAG_SPIN, Drive, FORWARD,
                      FRAME, GRAVITY, HEIGHT, HEIGHT_RATE, LEFT, MOVED, OMEGA, PATH_SPIN,
                      PENETRATION, PLACE, ROTATION, SPEED, SPIN, SPIN_RATE, THETA, TURNING,
                      VELOCITY, YAW)
