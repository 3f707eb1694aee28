"""
What viewers draw: `bristle_markers` as CDR bytes, without ROS.

Marker arrays are made from a template that is laid out once: each message is a copy in which
stamps, points and actions are filled in. For 104 bristles of 25 nodes that takes 0.2 ms, where
filling and serialising ROS's own classes takes 16 ms; a chunk is 5 ms.
"""
import struct
from typing import TypeAlias

from bristle_ros.scene import bristle_count, is_uneven, longest, reach, Scene, SurfaceMesher
from bristle_ros.simulation import Contacts, Pose, Snapshot
import numpy as np
from numpy.typing import NDArray

from .cdr import CdrWriter
from .encode import MOUNT_FRAME, ROAD_FRAME

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


class Markers:
    """
    The MarkerArray of a scene: bristles, road, contact forces.

    - `bristles`: one LINE_LIST through all nodes of all bristles, frame `brush_mount`
    - `road`, frame `road`: a plate under the brush, its upper face in the road plane; where the
      scene has a gutter or a profile, its surface as a TRIANGLE_LIST. That is made anew when the
      brush has gone on by an eighth of it; while the kerb approaches, its position moves
    - `contact_force`: for each bristle the force of the road at its tip as an ARROW of
      FORCE_SCALE, frame `brush_mount`. Every message says for each whether it is there (ADD) or
      not (DELETE), so that none stays when a viewer misses a message
    - `wire_force`: the same for each point beside the tips at which the road touches; as many as
      there have been at one time, those that are not in use DELETEd
    """

    def __init__(self, scene: Scene) -> None:
        self._bristles, nodes = bristle_count(scene), 2 * scene.solver.elements + 1
        self._longest = LONGEST * longest(scene)
        self._writer = CdrWriter()
        self._stamps: list[int] = []
        self._actions: list[int] = []
        self._positions: list[int] = []
        self._arrows: list[int] = []    # offsets of their points: those at tips, then the others
        self._sizes: list[int] = []     # of messages with so many of the others
        self._prefix = prefix = scene.run.frame_prefix
        touches = scene.contact.enabled
        self._width = width = max(scene.bristle.breadth, 1e-3)
        self._writer.put('I', 1 + touches)
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
            for number in range(self._bristles):
                self._lay_arrow('contact_force', number)
        self._lay_out()
        self._sizes.append(self._template.size)

    def _lay_arrow(self, namespace: str, number: int) -> None:
        self._arrows.append(self._marker(
            self._prefix + MOUNT_FRAME, namespace, number, ARROW,
            (self._width, 3.0 * self._width, 0.0), _RED, 2))
        markers = 2 + len(self._arrows)     # after bristles and road
        struct.pack_into('<I', self._writer.raw, 4, markers)

    def _lay_out(self) -> None:
        """Make the template of what has been laid out."""
        self._template = np.frombuffer(self._writer.raw, dtype=np.uint8).copy()
        self._stamp_bytes = np.add.outer(self._stamps, np.arange(8))
        self._ends = np.add.outer(self._arrows, np.arange(48)).astype(np.intp)

    def _lay_for(self, count: int) -> None:
        """Have arrows for so many points beside the tips; the offsets before stay."""
        there = len(self._arrows) - self._bristles
        if count <= there:
            return
        before = self._template
        for number in range(there, count):
            self._lay_arrow('wire_force', number)
            self._sizes.append(len(self._writer.raw))
        self._lay_out()
        self._template[8:before.size] = before[8:]     # a mesh may be in it

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
               mount: Pose, contacts: Contacts | None = None) -> bytes:
        """
        Return the array's bytes.

        centreline : (B, nodes, 3) [m] from clamp to tip, mount axes
        mount : Pose;  contacts : Contacts beside the tips
        """
        if contacts is not None and self._road is not None:
            self._lay_for(len(contacts.bristle))
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
            forces, starts = snapshot.tip_force, snapshot.tip_position_mount
            if len(self._arrows) > self._bristles:
                forces, starts = self._with_points(forces, starts, contacts)
            forces = forces @ mount.rotation
            sizes = np.sqrt(np.einsum('ij,ij->i', forces, forces))
            scale = FORCE_SCALE * np.minimum(
                1.0, self._longest / np.maximum(FORCE_SCALE * sizes, 1e-300))
            arrows = np.stack((starts, starts + scale[:, None] * forces), axis=1)
            raw[self._ends] = _bytes(arrows).reshape(-1, 48)
            raw[self._actions] = np.where(sizes > 0.0, ADD, DELETE)  # their lowest byte
        return raw.tobytes()

    def _with_points(self, forces: NDArray[np.float64], starts: NDArray[np.float64],
                     contacts: Contacts | None
                     ) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
        """Return forces and their places with those beside the tips, 0 where there is none."""
        rest = np.zeros((2, len(self._arrows) - self._bristles, 3))
        if contacts is not None:
            rest[0, :len(contacts.force)] = contacts.force
            rest[1, :len(contacts.place)] = contacts.place
        return np.concatenate((forces, rest[0])), np.concatenate((starts, rest[1]))

    def _renew_mesh(self, mesher: SurfaceMesher, mount: Pose) -> None:
        """Put the surface around the mount into the template, where it is not there yet."""
        x, y, _ = mount.position.tolist()
        mesh, another = mesher.around(x, y - mount.kerb)
        if another:
            self._template[self._mesh] = _bytes(mesh.points()[mesh.triangles()]).ravel()

    def decode(self, payload: bytes
               ) -> tuple[NDArray[np.float64], NDArray[np.float64], float,
                          tuple[NDArray[np.float64], NDArray[np.float64]]]:
        """
        Return what `encode` was given: centreline, force at each tip in mount axes, mount.kerb.

        Shapes (B, nodes, 3), (B, 3), (); the last one is known where the road is not level, else
        0. Then places and forces beside the tips, mount axes, (k, 3) each.

        A force whose arrow would be too long has the length that it was drawn with. Raises
        ValueError for the message of another scene.
        """
        raw = np.frombuffer(payload, dtype=np.uint8)
        beside = 0
        if self._road is not None and raw.size > self._sizes[0]:
            (count,) = struct.unpack_from('<I', payload, 4)
            beside = max(0, min(count, raw.size // 48) - 2 - self._bristles)
            self._lay_for(beside)
        if not 0 <= raw.size - self._sizes[beside] < 4:     # a middleware may fill it up to four
            raise ValueError(f'{raw.size} bytes, must be {self._sizes[beside]}')
        pairs = raw[self._lines].view('<f8').reshape(self._bristles, -1, 2, 3)
        line = np.concatenate((pairs[:, :1, 0], pairs[:, :, 1]), axis=1)
        force, kerb = np.zeros((self._bristles, 3)), 0.0
        if self._mesher is not None and self._road is not None:
            kerb = float(raw[self._road + 8:self._road + 16].view('<f8')[0])
        points = np.zeros((2, 0, 3))
        if self._road is not None:
            arrows = self._bristles + beside
            ends = raw[self._ends[:arrows]].view('<f8').reshape(-1, 2, 3)
            there = raw[self._actions[:arrows]] == ADD
            forces = np.where(there[:, None], (ends[:, 1] - ends[:, 0]) / FORCE_SCALE, 0.0)
            force, others = np.split(forces, [self._bristles])
            used = there[self._bristles:]
            points = np.stack((ends[self._bristles:, 0][used], others[used]))
        return line, force, kerb, (points[0], points[1])


def _bytes(values: NDArray[np.float64]) -> NDArray[np.uint8]:
    return np.ascontiguousarray(values, dtype='<f8').view(np.uint8)
