"""How the brush moves over the road, and what that does to a wire in its frame."""
# flake8: noqa: F401  what other rooms may use
from .drive import approach_at, CONSTANT, RAMP, ramp_at, SINE, VAP
from .frame import (APPROACHING, asked_speed, BASICS, CLAMP, DRAG_RATE, DRAG_SPIN, Drive,
                    drive_clamp, FORWARD, FRAME, frame_at, GRAVITY, HEIGHT, HEIGHT_RATE,
                    is_polygon, kerb_offset, LEFT, MOVED, new_motion, OMEGA, PENETRATION, PLACE,
                    renew_rates, ROTATION, SPEED, SPIN, SPIN_RATE, split_load_step, THETA,
                    turn_frame, TURNING, VELOCITY, YAW)
from .hub import (ACCELERATION, ADDED, ASKED, ATTEMPTS, CARRIED, COMMAND, DRIVE_WORK,
                  drive_torque, END, HUB, Hub, LASTS, MOUNT_RATE, PSEUDO, REACTION, START,
                  STARTED, TORQUE)
from .path import follow_path, keep_place, way_within
