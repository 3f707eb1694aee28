"""
The brush in 3-D: wires, mount, road, forces, trails, as nodes of viser's scene.

Axes are the road's, the origin is on the road below the mount centre: the road goes by, and the
camera need not follow. Only what changes is sent: two positions and three arrays a frame.
"""
from collections import deque
import math

from bristle_ros.scene import bristle_count, brush_rows, longest, reach, widest
import numpy as np

from . import colours
from .frame import rotation_of, tracked
from .ground import put_ground

FORCE_SCALE = 0.5       # [m/N] of arrows, the force of all wires that a bristle stands for
LONGEST = 0.6           # and their greatest length, in lengths of a bristle
TRAIL = 100             # points of a trail, at most


class Stage:
    """What is seen of one scene."""

    def __init__(self, server, scene):
        """Put everything there; the brush itself comes with the first frame."""
        self._scene, self._nodes = scene, server.scene
        self._server = server
        self._longest, self._reach = longest(scene), reach(scene)
        self._depth = max(row.tip_depth for row in brush_rows(scene))
        self._mount = self._nodes.add_frame('/mount', show_axes=False)
        self._board = self._nodes.add_frame('/mount/board', show_axes=False)
        self._put_board()
        self._ground = put_ground(self._nodes, scene) if scene.contact.enabled else None
        self._wires = self._arrows = self._trails = None
        self.largest = 0.0      # [N] or [Pa] where the scale of colours ends
        self.by_stress = False  # colour wires by the stress at their clamps, not by force
        self._trail, self._tracked = deque(maxlen=TRAIL), len(tracked(bristle_count(scene)))
        self._place_camera()

    def _place_camera(self):
        # a bristle's length from the front left, so that the low side of a tilted brush is seen
        size = max(self._reach, 0.5 * self._depth)
        self._server.initial_camera.position = (1.7 * size, -2.4 * size, 1.2 * size + self._depth)
        self._server.initial_camera.look_at = (0.0, 0.0, 0.45 * self._depth)

    def _put_board(self):
        radius = max(widest(self._scene), 0.02)
        thick = 0.08 * radius
        self._nodes.add_cylinder('/mount/board/disc', radius * 1.06, thick, colours.BOARD,
                                 radial_segments=64, position=(0.0, 0.0, 0.5 * thick))
        self._nodes.add_cylinder('/mount/shaft', 0.16 * radius, 1.4 * radius, colours.SHAFT,
                                 position=(0.0, 0.0, 0.7 * radius))
        for number in range(4):     # without them nobody sees the disc turn
            angle = 0.5 * math.pi * number
            self._nodes.add_cylinder(
                f'/mount/board/bolt{number}', 0.09 * radius, 0.6 * thick,
                colours.BOLT if number == 0 else colours.SHAFT, radial_segments=6,
                position=(0.7 * radius * math.cos(angle), 0.7 * radius * math.sin(angle),
                          1.3 * thick))

    def colour_by(self, stress):
        """Colour the wires by the stress at their clamps, or by the force on them."""
        if stress != self.by_stress:
            self.by_stress, self.largest = stress, 0.0

    def show(self, frame):
        """Show a Frame."""
        x, y, height = frame.mount.tolist()
        qx, qy, qz, qw = frame.orientation
        self._mount.position = 0.0, 0.0, height
        self._mount.wxyz = qw, qx, qy, qz
        self._board.wxyz = math.cos(0.5 * frame.theta), 0.0, 0.0, math.sin(0.5 * frame.theta)
        if self._ground is not None:
            self._ground.show(x, y, frame.kerb)
        self._show_wires(frame)
        self._show_forces(frame)
        self._show_trails(frame)

    def _show_wires(self, frame):
        line = frame.centreline
        points = np.stack((line[:, :-1], line[:, 1:]), axis=2).reshape(-1, 2, 3)
        size = np.sqrt(np.einsum('ij,ij->i', frame.force, frame.force))
        if self.by_stress:
            size = np.zeros(len(line)) if frame.stress is None else frame.stress
        self.largest = colours.scale_end(self.largest, size[size > 0.0])
        shade = colours.of_lines(colours.of_wires(size, self.largest, frame.exact))
        pairs = np.repeat(shade, 2 * (line.shape[1] - 1), axis=0).reshape(-1, 2, 3)
        if self._wires is None or self._wires.points.shape != points.shape:
            thick = 1.2 * max(self._scene.bristle.breadth, 0.004 * self._longest)
            self._wires = self._nodes.add_line_segments(
                '/mount/wires', points, pairs, thickness=thick)
        else:
            self._wires.points = points
            self._wires.colors = pairs

    def _show_forces(self, frame):
        points = arrows_of(self._scene, frame)
        if self._arrows is None:
            if not len(points):
                return
            thick = 0.006 * self._longest
            self._arrows = self._nodes.add_arrows(
                '/mount/forces', points, colours.ARROW, shaft_radius=thick,
                head_radius=2.6 * thick, head_length=7.0 * thick)
        else:
            self._arrows.visible = bool(len(points))
            if len(points):
                self._arrows.points = points

    def add_trail(self, points):
        """Remember where tips were on the road: (k, tips, 3), one row for each chunk."""
        self._trail.extend(points)

    def forget_trail(self):
        """Start trails anew."""
        self._trail.clear()

    def _show_trails(self, frame):
        # Of one size all the time, which costs a browser the least: what is not there is a point.
        x, y, _ = frame.mount.tolist()
        pairs = np.zeros((TRAIL - 1, self._tracked, 2, 3), np.float32)
        points = np.array(self._trail).reshape(len(self._trail), self._tracked, 3)
        if len(points) > 1:
            known = np.stack((points[:-1], points[1:]), axis=2) - (x, y, -0.001)
            known[~np.isfinite(known).all(axis=(2, 3))] = 0.0
            pairs[-len(known):] = known
        pairs = pairs.reshape(-1, 2, 3)
        if self._trails is None:
            age = np.linspace(0.0, 1.0, TRAIL - 1)[:, None]
            shade = np.array(colours.ROAD) + age * np.subtract(colours.TRAIL, colours.ROAD)
            shade = np.repeat(colours.of_lines(shade), 2 * self._tracked, axis=0)
            self._trails = self._nodes.add_line_segments(
                '/trails', pairs, shade.reshape(-1, 2, 3),
                thickness=0.005 * self._longest)
        else:
            self._trails.points = pairs

    def remove(self):
        """Take everything away."""
        for name in ('/mount', '/road', '/road_lines', '/trails'):
            if self._nodes.get_handle_by_name(name) is not None:
                self._nodes.remove_by_name(name)


def arrows_of(scene, frame):
    """Return start and end of an arrow for each force of the road on a wire [m]: (n, 2, 3)."""
    wires = scene.brush.wires_per_bristle
    places, forces = (np.concatenate(parts) for parts in zip(
        (frame.centreline[:, -1], frame.force), frame.beside))
    size = wires * np.sqrt(np.einsum('ij,ij->i', forces, forces))
    there = size > 0.0
    scale = wires * FORCE_SCALE * np.minimum(
        1.0, LONGEST * longest(scene) / np.maximum(FORCE_SCALE * size[there], 1e-30))
    places = places[there]
    return np.stack((places, places + scale[:, None] * forces[there]), axis=1)


def tip_on_road(frame):
    """Return the tip of bristle 0 in road axes [m] (3,)."""
    return frame.mount + rotation_of(frame.orientation) @ frame.centreline[0, -1]
