"""
What viewers draw: /tf and `bristle_markers` as CDR bytes, without ROS.

Marker arrays are made from a template that is laid out once: each message is a copy in which
stamps, points and actions are filled in. For 104 bristles of 25 nodes that takes 0.2 ms, where
filling and serialising ROS's own classes takes 16 ms; a chunk is 5 ms.
"""
from collections.abc import Callable
import struct
from typing import Literal, TypeAlias

from bristle_ros.scene import bristle_count, is_uneven, longest, reach, Scene, SurfaceMesher
from bristle_ros.simulation import Pose, Snapshot
import numpy as np
from numpy.typing import NDArray

from .cdr import CdrReader
from .encode import BRUSH_FRAME, MOUNT_FRAME, ROAD_FRAME, TF, Topic, TRANSFORMS

TF_MODES = ('all', 'mount', 'none')     # of `run.publish_tf`
FORCE_SCALE = 0.5       # [m/N] length of the arrows of contact forces,
LONGEST = 1.0           # and their greatest length, in lengths of a bristle: impacts are high
ROAD_THICKNESS = 1e-3   # [m] drawn, below the plane
QUADS = 1600            # faces, about, of a road that is not level, at most
PARTS = 8               # of its length in which its mesh follows the brush
ARROW, CUBE, LINE_LIST, TRIANGLE_LIST = 0, 1, 5, 11
ADD, DELETE = 0, 2
_BLUE, _GREY, _RED = (0.2, 0.5, 0.9, 1.0), (0.5, 0.5, 0.5, 0.35), (0.9, 0.3, 0.1, 1.0)
_STONE = (0.55, 0.55, 0.52, 1.0)


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
    - `road`, frame `road`: a plate under the brush, its upper face in the road plane; where the
      scene has a gutter or a profile, its surface as a TRIANGLE_LIST. That is made anew when the
      brush has gone on by an eighth of it; while the kerb approaches, its position moves
    - `contact_force`: for each bristle the force of the road at its tip as an ARROW of
      FORCE_SCALE, frame `brush_mount`. Every message says for each whether it is there (ADD) or
      not (DELETE), so that none stays when a viewer misses a message.
    """

    def __init__(self, scene: Scene) -> None:
        self._bristles, nodes = bristle_count(scene), 2 * scene.solver.elements + 1
        self._longest = LONGEST * longest(scene)
        self._writer = _Writer()
        self._stamps: list[int] = []
        self._actions: list[int] = []
        self._positions: list[int] = []
        ends: list[int] = []
        prefix = scene.run.frame_prefix
        touches = scene.contact.enabled
        width = max(scene.bristle.breadth, 1e-3)
        self._writer.put('I', 1 + touches * (1 + self._bristles))
        # A strip for each bristle would save a third of the bytes, take as long to fill, and cost
        # a viewer an object each.
        lines = 2 * (nodes - 1) * self._bristles
        at = self._marker(prefix + MOUNT_FRAME, 'bristles', 0, LINE_LIST, (width, 0.0, 0.0), _BLUE,
                          lines)
        self._lines = slice(at, at + 24 * lines)
        self._road: int | None = None
        self._mesher: SurfaceMesher | None = None
        if touches:
            self._road = self._lay_road(scene)
            self._actions.clear()
            for bristle_id in range(self._bristles):
                ends.append(self._marker(prefix + MOUNT_FRAME, 'contact_force', bristle_id, ARROW,
                                         (width, 3.0 * width, 0.0), _RED, 2))
        self._template = np.frombuffer(self._writer.raw, dtype=np.uint8).copy()
        self._stamp_bytes = np.add.outer(self._stamps, np.arange(8))
        self._ends = np.add.outer(ends, np.arange(48)).astype(np.intp)

    def _lay_road(self, scene: Scene) -> int:
        """Lay the road out; return the offset of its position."""
        side = max(4.0 * reach(scene), longest(scene))
        frame = scene.run.frame_prefix + ROAD_FRAME
        if not is_uneven(scene.gutter, scene.profile):
            self._marker(frame, 'road', 0, CUBE, (side, side, ROAD_THICKNESS), _GREY)
            return self._positions[-1]
        self._mesher = mesher = SurfaceMesher(scene, side, PARTS, QUADS)
        rows, columns = mesher.shape
        corners = 6 * (rows - 1) * (columns - 1)
        at = self._marker(frame, 'road', 0, TRIANGLE_LIST, (1.0, 1.0, 1.0), _STONE, corners)
        self._mesh = slice(at, at + 24 * corners)
        return self._positions[-1]

    def _marker(self, frame: str, namespace: str, number: int, kind: int, scale: Numbers,
                colour: Numbers, points: int = 0) -> int:
        """Lay out a marker; return the offset of its points."""
        put = self._writer.put
        self._stamps.append(put('I', 0, 0))
        self._writer.text(frame)
        self._writer.text(namespace)
        put('i', number, kind)
        self._actions.append(put('i', ADD))
        self._positions.append(put('d', *(0.0,) * 6, 1.0, *scale))
        put('f', *colour)
        put('I', 0, 0)          # lifetime: until it is replaced
        put('B', 0)             # not locked to its frame: drawn where it was at its stamp
        put('I', points)
        at = put('d', *(0.0,) * (3 * points)) if points else 0
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
        if self._mesher is not None:
            self._renew_mesh(self._mesher, mount)
        raw = self._template.copy()
        raw[self._stamp_bytes] = np.frombuffer(
            struct.pack('<iI', *divmod(stamp, 1_000_000_000)), dtype=np.uint8)
        pairs = np.stack((centreline[:, :-1], centreline[:, 1:]), axis=2)
        raw[self._lines] = _bytes(pairs).ravel()
        if self._road is not None:
            place = np.array((0.0, mount.kerb, 0.0))
            if self._mesher is None:
                place = np.array((*mount.position[:2], -0.5 * ROAD_THICKNESS))
            raw[self._road:self._road + 24] = _bytes(place)
            forces = snapshot.tip_force @ mount.rotation
            sizes = np.sqrt(np.einsum('ij,ij->i', forces, forces))
            scale = FORCE_SCALE * np.minimum(
                1.0, self._longest / np.maximum(FORCE_SCALE * sizes, 1e-300))
            tips = snapshot.tip_position_mount
            arrows = np.stack((tips, tips + scale[:, None] * forces), axis=1)
            raw[self._ends] = _bytes(arrows).reshape(self._bristles, 48)
            raw[self._actions] = np.where(sizes > 0.0, ADD, DELETE)  # their lowest byte
        return raw.tobytes()

    def _renew_mesh(self, mesher: SurfaceMesher, mount: Pose) -> None:
        """Put the surface around the mount into the template, where it is not there yet."""
        x, y, _ = mount.position.tolist()
        mesh, another = mesher.around(x, y - mount.kerb)
        if another:
            self._template[self._mesh] = _bytes(mesh.points()[mesh.triangles()]).ravel()

    def decode(self, payload: bytes
               ) -> tuple[NDArray[np.float64], NDArray[np.float64], float]:
        """
        Return what `encode` was given: centreline, force on each wire in mount axes, mount.kerb.

        Shapes (B, nodes, 3), (B, 3), (); the last one is known where the road is not level, else
        0.

        A force whose arrow would be too long has the length that it was drawn with. Raises
        ValueError for the message of another scene.
        """
        raw = np.frombuffer(payload, dtype=np.uint8)
        if not 0 <= raw.size - self._template.size < 4:     # a middleware may fill it up to four
            raise ValueError(f'{raw.size} bytes, must be {self._template.size}')
        pairs = raw[self._lines].view('<f8').reshape(self._bristles, -1, 2, 3)
        line = np.concatenate((pairs[:, :1, 0], pairs[:, :, 1]), axis=1)
        force, kerb = np.zeros((self._bristles, 3)), 0.0
        if self._mesher is not None and self._road is not None:
            kerb = float(raw[self._road + 8:self._road + 16].view('<f8')[0])
        if self._road is not None:
            ends = raw[self._ends].view('<f8').reshape(self._bristles, 2, 3)
            there = raw[self._actions] == ADD
            force[there] = (ends[there, 1] - ends[there, 0]) / FORCE_SCALE
        return line, force, kerb


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


def _bytes(values: NDArray[np.float64]) -> NDArray[np.uint8]:
    return np.ascontiguousarray(values, dtype='<f8').view(np.uint8)
