"""
The road in 3-D: a picture of a level one, a mesh with lines on it of one that is not.

Both repeat themselves after TILE, so that one sees it go by.
"""
from bristle_ros.scene import is_uneven, SurfaceMesher
import numpy as np

from . import colours

TILE = 0.25             # [m] after which the road repeats itself
TILES = 20
NEAR = 8                # tiles that are drawn of a road with a profile, whose mesh is fine,
STRIDE = 2              # and after which of them it follows the brush
QUADS = 4000            # faces of the mesh, about, at most
POINTS = 80             # of a line along the road, about
ABOVE = 3e-3            # [m] that lines lie above the road


def put_ground(nodes, scene):
    """Put the road of a scene there; return what shows it where a brush is."""
    return (Relief if is_uneven(scene.gutter, scene.profile) else Plane)(nodes, scene)


class Plane:
    """A level road."""

    def __init__(self, nodes, scene):
        """Put it there."""
        size = TILE * TILES
        self._picture = nodes.add_image('/road', _asphalt(), size, size, format='jpeg',
                                        cast_shadow=False, wxyz=(0.0, 1.0, 0.0, 0.0))

    def show(self, x, y, _):
        """Show it as seen by a mount over the place x, y [m]."""
        self._picture.position = -(x % TILE), -(y % TILE), -0.002


class Relief:
    """A road with a gutter, a profile or both: its mesh is changed when the brush has gone on."""

    def __init__(self, nodes, scene):
        """Make nothing yet."""
        self._nodes = nodes
        self._alike = scene.profile.kind == 'none'      # at all places along x
        tiles = TILES if self._alike else NEAR
        self._half = 0.5 * TILE * tiles
        self._mesher = SurfaceMesher(scene, TILE * tiles, tiles // STRIDE, QUADS)
        self._mesh = self._lines = None

    def show(self, x, y, kerb):
        """Show it as seen by a mount over the place x, y [m]; kerb [m] as Frame has it."""
        place = 0.0 if self._alike else x
        mesh, another = self._mesher.around(place, y - kerb)
        if another:
            self._renew(mesh)
        middle = TILE * (x // TILE) if self._alike else mesh.x[0] + self._half
        for handle in (self._mesh, self._lines):
            handle.position = middle - x, mesh.y[0] + self._half + kerb - y, 0.0

    def _renew(self, mesh):
        middle = mesh.x[0] + self._half, mesh.y[0] + self._half, 0.0
        points = (mesh.points() - middle).astype(np.float32)
        lines = (grid(mesh) - middle).astype(np.float32)
        if self._mesh is None:
            self._mesh = self._nodes.add_mesh_simple(
                '/road', points, mesh.triangles(), color=colours.RELIEF, side='double',
                cast_shadow=False, receive_shadow=False)
            self._lines = self._nodes.add_line_segments(
                '/road_lines', lines, colours.of_lines(colours.RELIEF_LINE), thickness=0.003)
        else:
            self._mesh.vertices = points
            self._lines.points = lines


def grid(mesh):
    """Return segments (k, 2, 3) [m] on a mesh: along and across, at each multiple of TILE."""
    points = mesh.points().reshape(*mesh.z.shape, 3) + (0.0, 0.0, ABOVE)
    step = max(1, len(mesh.x) // POINTS)
    rows = np.unique((*range(0, len(mesh.x), step), len(mesh.x) - 1))
    parts = []
    for y in TILE * np.arange(np.ceil(mesh.y[0] / TILE), np.floor(mesh.y[-1] / TILE) + 1):
        line = points[rows, 0]
        line[:, 1], line[:, 2] = y, [np.interp(y, mesh.y, z) + ABOVE for z in mesh.z[rows]]
        parts.append(np.stack((line[:-1], line[1:]), axis=1))
    for x in TILE * np.arange(np.ceil(mesh.x[0] / TILE), np.floor(mesh.x[-1] / TILE) + 1):
        line = points[np.abs(mesh.x - x).argmin()].copy()
        if len(mesh.x) == 2:
            line[:, 0] = x
        parts.append(np.stack((line[:-1], line[1:]), axis=1))
    return np.concatenate(parts)


def _asphalt(pixels=64):
    """Return a picture of the road, TILES by TILES times the same tile."""
    noise = np.random.Generator(np.random.PCG64(1)).uniform(0.0, 1.0, (pixels, pixels))
    grain = np.array(colours.ROAD_DARK) + noise[..., None] * (
        np.array(colours.ROAD) - np.array(colours.ROAD_DARK))
    grain[:2] = grain[:, :2] = colours.ROAD_LINE
    return np.tile(grain.astype(np.uint8), (TILES, TILES, 1))
