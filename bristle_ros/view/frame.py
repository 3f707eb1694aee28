"""What a page shows of one instant, and of the time between: no numba, no viser, no ROS."""
import math
from typing import NamedTuple

from bristle_ros.scene import brush_rows, tip_depth
import numpy as np

TRACKED = 13    # bristles whose tips leave a trail, at most
# Columns of the rows that curves are made of; SI, whole brush.
COLUMNS = ('t', 'omega', 'normal_force', 'torque', 'power', 'stress')


NOWHERE = np.zeros((0, 3), np.float32)


class Frame(NamedTuple):
    """The brush at one instant; B bristles of n nodes."""

    t: float                    # [s] simulation time
    theta: float                # [rad] angle of the brush
    centreline: np.ndarray      # [m] (B, n, 3) from clamp to tip, mount axes
    force: np.ndarray           # [N] (B, 3) of the road on one wire's tip, mount axes
    mount: np.ndarray           # [m] (3,) mount centre, road axes
    orientation: tuple          # of the mount on the road: quaternion x, y, z, w
    stress: object = None       # [Pa] (B,) largest size at a clamp's corners; None: not known
    exact: bool = True          # False: the wires are drawn straight, they are not known
    kerb: float = 0.0           # [m] how much further to the left the gutter still is
    beside: tuple = (NOWHERE, NOWHERE)  # where wires touch beside tips [m], and forces [N]: (k, 3)


class Status(NamedTuple):
    """What a page says of a run."""

    state: str = 'compiling'    # or running, paused, ended; reading, playing
    t: float = 0.0              # [s]
    asked: float = 1.0          # real-time factor; 0: as fast as it goes
    reached: float = 0.0
    late: object = 0            # chunks; None where that is not known
    error: object = 0.0         # estimated local error, per length of the bristle; or None
    speed: float = 0.0          # [rad/s] of the brush
    text: str = ''              # why it ended, or what else there is to say
    warnings: tuple = ()        # of results that make no sense


class Update(NamedTuple):
    """What is new since a source was last asked."""

    frame: object       # Frame, or None
    rows: np.ndarray    # (k, len(COLUMNS)) one for each chunk
    trail: np.ndarray   # [m] (k, tracked, 3) tips on the road, road axes; NaN in the air
    status: Status
    afresh: bool = False    # what came before is not before it: curves and trails begin anew


def tracked(bristles):
    """Return the numbers of the bristles whose tips leave a trail, evenly spread."""
    return np.unique(np.arange(min(bristles, TRACKED)) * bristles // min(bristles, TRACKED))


def row_of(snapshot, scene):
    """Return the row of a snapshot: COLUMNS."""
    normal = float(snapshot.contact_force[:, 2].sum()) * scene.brush.wires_per_bristle
    torque = -float(snapshot.brush_torque[2])
    return (snapshot.t, snapshot.omega, normal, torque, torque * snapshot.omega,
            float(stress_of(snapshot).max()))


def stress_of(snapshot):
    """Return the largest size of the axial stress at each clamp's corners [Pa]: (B,)."""
    return np.abs(snapshot.clamp_stress).max(axis=1)


def trail_of(snapshot, mount, bristles):
    """Return the tips of these bristles on the road [m] (len, 3); NaN for those in the air."""
    points = mount.position + snapshot.tip_position_road[bristles]
    points[~(np.abs(snapshot.tip_force[bristles]).sum(axis=1) > 0.0)] = np.nan
    return points


def frame_of(simulation, snapshot, mount):
    """Return the Frame of the present state and its snapshot; mount: its Pose over the road."""
    from bristle_ros.simulation import wire_contacts    # what draws a page does without numba
    centreline = simulation.centreline()
    contacts = wire_contacts(simulation, centreline)
    return Frame(
        snapshot.t, snapshot.theta, centreline.astype(np.float32),
        (snapshot.tip_force @ mount.rotation).astype(np.float32), mount.position,
        mount.orientation, stress_of(snapshot).astype(np.float32), kerb=mount.kerb,
        beside=(contacts.place.astype(np.float32),
                (contacts.force @ mount.rotation).astype(np.float32)))


def resting_pose(scene):
    """
    Return the mount's position [m] (3,) and quaternion x, y, z, w where nothing says it moved.

    The attack angle turns about the horizontal axis across the way that the low side faces.
    """
    road, half = scene.road, 0.5 * scene.road.attack_angle
    height = tip_depth(scene) - (road.penetration if scene.contact.enabled else 0.0)
    sine = math.sin(half)
    return (np.array((*scene.sweeper.mount_position, height)),
            (-sine * math.sin(road.tilt_azimuth), sine * math.cos(road.tilt_azimuth), 0.0,
             math.cos(half)))


def straight(scene, theta):
    """Return the undeformed wires at an angle of the brush [m]: (B, 2, 3), mount axes."""
    circles = []
    for row in brush_rows(scene):
        azimuth = theta + np.array(row.azimuths)
        ends = np.array([row.radius, row.tip_radius])
        lines = np.empty((row.count, 2, 3))
        lines[..., 0] = np.cos(azimuth)[:, None] * ends
        lines[..., 1] = np.sin(azimuth)[:, None] * ends
        lines[..., 2] = 0.0, -row.tip_depth
        circles.append(lines)
    return np.concatenate(circles)


def rotation_of(quaternion):
    """Return the matrix (3, 3) of a quaternion x, y, z, w of length 1."""
    x, y, z, w = quaternion
    return np.array((
        (1 - 2 * (y * y + z * z), 2 * (x * y - z * w), 2 * (x * z + y * w)),
        (2 * (x * y + z * w), 1 - 2 * (x * x + z * z), 2 * (y * z - x * w)),
        (2 * (x * z - y * w), 2 * (y * z + x * w), 1 - 2 * (x * x + y * y))))
