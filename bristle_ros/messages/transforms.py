"""/tf as CDR bytes, without ROS: `road` -> `brush_mount` -> `brush`."""
from collections.abc import Callable
from typing import Literal

from bristle_ros.simulation import Pose, Snapshot
import numpy as np

from .cdr import CdrReader, CdrWriter
from .encode import BRUSH_FRAME, MOUNT_FRAME, ROAD_FRAME, TF, Topic, TRANSFORMS


def encode_transforms(stamp: int, prefix: str, snapshot: Snapshot, mount: Pose,
                      mode: Literal['all', 'mount', 'none']) -> bytes:
    """
    Return the TFMessage of `road` -> `brush_mount` -> `brush`.

    mode : 'all', or 'mount' for the first of the two alone
    mount : Pose
    """
    half = 0.5 * snapshot.theta
    links = [(ROAD_FRAME, MOUNT_FRAME, mount.position.tolist(), mount.orientation)]
    if mode == 'all':
        spin = 0.0, 0.0, float(np.sin(half)), float(np.cos(half))
        links.append((MOUNT_FRAME, BRUSH_FRAME, (0.0, 0.0, 0.0), spin))
    writer = CdrWriter()
    writer.put('I', len(links))
    for parent, child, position, orientation in links:
        writer.put('I', *divmod(stamp, 1_000_000_000))
        writer.text(prefix + parent)
        writer.text(prefix + child)
        writer.put('d', *position, *orientation)
    return bytes(writer.raw)


def decode_transforms(payload: bytes) -> tuple[float, ...]:
    """Return translation and rotation of both links of a logged TFMessage, 14 numbers."""
    cdr = CdrReader(payload)
    values: list[float] = []
    for _ in range(cdr.count()):
        cdr.stamp()
        cdr.string()
        cdr.string()
        values += cdr.float64(7)
    if len(values) != 14:
        raise ValueError(f'{len(values)} numbers, must be 14')
    return tuple(values)


def _nowhere() -> Pose:
    raise ValueError('to encode transforms takes the mount: give mount_now')


def transforms_topic(prefix: str = '', mount_now: Callable[[], Pose] = _nowhere) -> Topic:
    """Return the Topic of /tf in logs: both links; `mount_now()` is the mount's Pose."""
    def encode(snapshot: Snapshot, stamp: int) -> bytes:
        return encode_transforms(stamp, prefix, snapshot, mount_now(), 'all')

    fields = tuple(f'transforms[{link}].{name}' for link in range(2) for name in (
        *(f'transform.translation.{axis}' for axis in 'xyz'),
        *(f'transform.rotation.{axis}' for axis in 'xyzw')))
    return Topic(TRANSFORMS, TF, encode, decode_transforms, fields, (3, 4, 3, 4))


def decode_pose(payload: bytes, prefix: str) -> tuple[float, ...] | None:
    """Return position and quaternion x, y, z, w of `brush_mount` on the road, if it is told."""
    cdr = CdrReader(payload)
    for _ in range(cdr.count()):
        cdr.stamp()
        cdr.string()
        child, values = cdr.string(), cdr.float64(7)
        if child == prefix + MOUNT_FRAME:
            return values
    return None
