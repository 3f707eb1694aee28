"""
What viewers draw: /tf and `bristle_markers` as CDR bytes, without ROS.

Marker arrays are made from a template that is laid out once: each message is a copy in which
stamps, points and actions are filled in. For 104 bristles of 25 nodes that takes 0.2 ms, where
filling and serialising ROS's own classes takes 16 ms; a chunk is 5 ms.
"""
from collections.abc import Callable
import struct
from typing import Literal, TypeAlias

from bristle_ros.scene import Scene
from bristle_ros.simulation import Pose, Snapshot
import numpy as np
from numpy.typing import NDArray

from .cdr import CdrReader
from .encode import BRUSH_FRAME, MOUNT_FRAME, ROAD_FRAME, TF, Topic, TRANSFORMS

TF_MODES = ('all', 'mount', 'none')     # of `run.publish_tf`
FORCE_SCALE = 0.5       # [m/N] length of the arrows of contact forces,
LONGEST = 1.0           # and their greatest length, in lengths of a bristle: impacts are high
ROAD_THICKNESS = 1e-3   # [m] drawn, below the plane
ARROW, CUBE, LINE_LIST = 0, 1, 5
ADD, DELETE = 0, 2
_BLUE, _GREY, _RED = (0.2, 0.5, 0.9, 1.0), (0.5, 0.5, 0.5, 0.35), (0.9, 0.3, 0.1, 1.0)


Numbers: TypeAlias = tuple[float, ...]


class _Writer:
    """CDR bytes that grow; each method returns the offset at which it wrote."""

    def __init__(self) -> None:
        self.raw = bytearray(b'\x00\x01\x00\x00')

    def put(self, layout: str, *values: float) -> int:
        """Write numbers of one struct layout character, aligned to their size."""
        size = struct.calcsize(layout)
        self.raw += bytes(-(len(self.raw) - 4) % size)
        at = len(self.raw)
        self.raw += struct.pack(f'<{len(values)}{layout}', *values)
        return at

    def text(self, text: str) -> int:
        raw = text.encode() + b'\x00'
        at = self.put('I', len(raw))
        self.raw += raw
        return at


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
    writer = _Writer()
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


class Markers:
    """
    The MarkerArray of a scene: bristles, road, contact forces.

    - `bristles`: one LINE_LIST through all nodes of all bristles, frame `brush_mount`
    - `road`: a plate under the brush, its upper face in the road plane, frame `road`
    - `contact_force`: for each bristle the force of the road on its tip as an ARROW of
      FORCE_SCALE, frame `brush_mount`. Every message says for each whether it is there (ADD) or
      not (DELETE), so that none stays when a viewer misses a message.
    """

    def __init__(self, scene: Scene) -> None:
        bristle, brush = scene.bristle, scene.brush
        self._bristles, nodes = brush.bristle_count, 2 * scene.solver.elements + 1
        self._longest = LONGEST * bristle.length
        self._writer = _Writer()
        self._stamps: list[int] = []
        self._actions: list[int] = []
        ends: list[int] = []
        prefix = scene.run.frame_prefix
        touches = scene.contact.enabled
        width = max(bristle.breadth, 1e-3)
        self._writer.put('I', 1 + touches * (1 + self._bristles))
        # A strip for each bristle would save a third of the bytes, take as long to fill, and cost
        # a viewer an object each.
        lines = 2 * (nodes - 1) * self._bristles
        at = self._marker(prefix + MOUNT_FRAME, 'bristles', 0, LINE_LIST, (width, 0.0, 0.0), _BLUE,
                          lines)
        self._lines = slice(at, at + 24 * lines)
        self._road = None
        if touches:
            side = 4.0 * (brush.mount_radius + bristle.length * np.sin(brush.mount_angle))
            side = max(side, bristle.length)
            self._road = self._marker(prefix + ROAD_FRAME, 'road', 0, CUBE,
                                      (side, side, ROAD_THICKNESS), _GREY)
            self._actions.clear()
            for bristle_id in range(self._bristles):
                ends.append(self._marker(prefix + MOUNT_FRAME, 'contact_force', bristle_id, ARROW,
                                         (width, 3.0 * width, 0.0), _RED, 2))
        raw = np.frombuffer(self._writer.raw, dtype=np.uint8)
        self._template = raw
        self._stamp_bytes = np.add.outer(self._stamps, np.arange(8))
        self._ends = np.add.outer(ends, np.arange(48)).astype(np.intp)

    def _marker(self, frame: str, namespace: str, number: int, kind: int, scale: Numbers,
                colour: Numbers, points: int = 0) -> int:
        """Lay out a marker; return the offset of its points, or of its position if it has none."""
        put = self._writer.put
        self._stamps.append(put('I', 0, 0))
        self._writer.text(frame)
        self._writer.text(namespace)
        put('i', number, kind)
        self._actions.append(put('i', ADD))
        at = put('d', *(0.0,) * 6, 1.0, *scale)
        put('f', *colour)
        put('I', 0, 0)          # lifetime: until it is replaced
        put('B', 0)             # not locked to its frame: drawn where it was at its stamp
        put('I', points)
        if points:
            at = put('d', *(0.0,) * (3 * points))
        put('I', 0)             # colours of points
        self._writer.text('')   # texture: name, header, format, data
        put('I', 0, 0)
        for _ in range(2):
            self._writer.text('')
        put('I', 0, 0)          # texture's data, its coordinates
        for _ in range(3):
            self._writer.text('')   # text, mesh, mesh's file
        put('I', 0)
        put('B', 0)
        return at

    def encode(self, stamp: int, snapshot: Snapshot, centreline: NDArray[np.float64],
               mount: Pose) -> bytes:
        """
        Return the array's bytes.

        centreline : (B, nodes, 3) [m] from clamp to tip, mount axes
        mount : Pose
        """
        raw = self._template.copy()
        raw[self._stamp_bytes] = np.frombuffer(
            struct.pack('<iI', *divmod(stamp, 1_000_000_000)), dtype=np.uint8)
        pairs = np.stack((centreline[:, :-1], centreline[:, 1:]), axis=2)
        raw[self._lines] = _bytes(pairs).ravel()
        if self._road is not None:
            at = self._road
            x, y, _ = mount.position.tolist()
            raw[at:at + 24] = _bytes(np.array((x, y, -0.5 * ROAD_THICKNESS)))
            forces = snapshot.contact_force @ mount.rotation
            sizes = np.sqrt(np.einsum('ij,ij->i', forces, forces))
            scale = FORCE_SCALE * np.minimum(
                1.0, self._longest / np.maximum(FORCE_SCALE * sizes, 1e-300))
            tips = snapshot.tip_position_mount
            arrows = np.stack((tips, tips + scale[:, None] * forces), axis=1)
            raw[self._ends] = _bytes(arrows).reshape(self._bristles, 48)
            raw[self._actions] = np.where(sizes > 0.0, ADD, DELETE)  # their lowest byte
        return raw.tobytes()


def _bytes(values: NDArray[np.float64]) -> NDArray[np.uint8]:
    return np.ascontiguousarray(values, dtype='<f8').view(np.uint8)
