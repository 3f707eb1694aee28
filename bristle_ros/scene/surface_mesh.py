"""
The surface of the road as a mesh, for who draws it.

Heights are those of the scene's own pieces, cosines and points: at its nodes the mesh lies in the
surface that the wires touch. Only what is near the brush is there.
"""
import math
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from .road_profile import heights_of, spline
from .scene import Scene
from .surface import cross_section, Piece

TURN = math.radians(7.5)    # of a fillet between two nodes, at most
BY_WAVE = 8                 # nodes in the shortest wavelength of a profile, where they may be


class SurfaceMesh(NamedTuple):
    """Heights over a grid; axes of the road, y as if the kerb had come to its place."""

    x: NDArray[np.float64]      # [m] (n,) increasing
    y: NDArray[np.float64]      # [m] (m,) increasing
    z: NDArray[np.float64]      # [m] (n, m)

    def points(self) -> NDArray[np.float64]:
        """Return the nodes (n m, 3) [m], row by row of x."""
        x, y = np.meshgrid(self.x, self.y, indexing='ij')
        return np.stack((x, y, self.z), axis=-1).reshape(-1, 3)

    def triangles(self) -> NDArray[np.int64]:
        """Return the numbers of the nodes of each triangle (k, 3), turning left from above."""
        n, m = self.z.shape
        first = (np.arange(n - 1)[:, None] * m + np.arange(m - 1)).ravel()
        halves = np.stack(((first, first + m, first + m + 1),
                           (first, first + m + 1, first + 1)))
        return np.ascontiguousarray(halves.transpose(2, 0, 1)).reshape(-1, 3)


class SurfaceMesher:
    """
    Makes the mesh around a brush, anew only when that has moved, and no height twice on its way.

    side [m] : of the square that the mesh covers
    parts : int     of a side, in which the mesh follows the brush
    quads : int     four-sided faces, about, at most; the size of all meshes is the same
    """

    def __init__(self, scene: Scene, side: float, parts: int, quads: int) -> None:
        self._side, self._grid = side, side / parts
        self._height = heights_of(scene.profile)
        self._corners = np.zeros((2, 0))
        if scene.gutter.enabled:
            self._corners = _corners(cross_section(scene.gutter))
        self._columns = self._corners.shape[1] + 2
        wanted = min(side / _finest(scene, side), quads / (self._columns - 1)) / parts
        # rows in a part of a side; where there is no profile the ends alone
        self._rows = max(1, math.floor(wanted)) if scene.profile.kind != 'none' else 0
        self._parts = parts
        self._middle: tuple[int, int] | None = None
        self._mesh: SurfaceMesh | None = None

    @property
    def shape(self) -> tuple[int, int]:
        """Return the number of nodes along x and y."""
        return (self._parts * self._rows or 1) + 1, self._columns

    def around(self, x: float, y: float) -> tuple[SurfaceMesh, bool]:
        """
        Return the mesh around a place [m], and whether it is another one than before.

        y as if the kerb had come to its place.
        """
        middle = round(x / self._grid), round(y / self._grid)
        if self._mesh is not None and middle == self._middle:
            return self._mesh, False
        profile = self._profile(middle[0])
        self._middle = middle
        half, y = 0.5 * self._side, middle[1] * self._grid
        across = self._across(y - half, y + half)
        section = (np.interp(across, *self._corners) if self._corners.shape[1]
                   else np.zeros(len(across)))
        x = middle[0] * self._grid
        along = np.linspace(x - half, x + half, self.shape[0])
        self._mesh = SurfaceMesh(along, across, profile[:, None] + section)
        return self._mesh, True

    def _profile(self, middle: int) -> NDArray[np.float64]:
        """Return the profile's heights [m] along the mesh around this part of the way."""
        moved = self._rows * (middle - self._middle[0]) if self._middle else 0
        count = self.shape[0]
        if not self._middle or abs(moved) >= count:
            self._heights = self._height_at(middle, 0, count)
        elif moved > 0:
            self._heights = np.concatenate((
                self._heights[moved:], self._height_at(middle, count - moved, count)))
        elif moved < 0:
            self._heights = np.concatenate((
                self._height_at(middle, 0, -moved), self._heights[:moved]))
        return self._heights

    def _height_at(self, middle: int, first: int, last: int) -> NDArray[np.float64]:
        rows = max(self._rows, 1)
        places = (middle - 0.5 * self._parts) * self._grid + self._grid / rows * np.arange(
            first, last)
        heights: NDArray[np.float64] = self._height(places)
        return heights

    def _across(self, low: float, high: float) -> NDArray[np.float64]:
        """Return the nodes across: the ends, and corners or, for those outside, places between."""
        corners = self._corners[0]
        inside = corners[(corners > low) & (corners < high)]
        below, above = int((corners <= low).sum()), int((corners >= high).sum())
        first, last = (inside[0], inside[-1]) if len(inside) else (high, high)
        return np.concatenate((np.linspace(low, first, below + 1, endpoint=False), inside,
                               np.linspace(high, last, above + 1, endpoint=False)[::-1]))


def _finest(scene: Scene, side: float) -> float:
    """Return the distance [m] between rows that shows a profile."""
    profile = scene.profile
    if profile.kind == 'sine':
        return profile.wavelength / BY_WAVE
    if profile.kind == 'iso8608':
        return profile.shortest / BY_WAVE
    if profile.kind == 'file':
        return float(np.diff(spline(profile).x).min()) / 4.0
    return side


def _corners(pieces: list[Piece]) -> NDArray[np.float64]:
    """
    Return nodes y, z [m] (2, k) of a cross-section: those of its fillets.

    Every straight piece begins and ends at one, or goes on to infinity.
    """
    nodes = [node for piece in pieces if piece.side for node in _arc(piece)]
    y, z = np.array(nodes).T
    kept = np.concatenate(([True], np.diff(y) > 1e-9))
    return np.stack((y[kept], z[kept]))


def _arc(piece: Piece) -> list[tuple[float, float]]:
    """Return nodes (y, z) [m] from a fillet's beginning to its end, TURN apart or less."""
    begin = math.atan2(piece.along_z, piece.along_y)
    turn = math.atan2(piece.end_z, piece.end_y) - begin
    parts = math.ceil(abs(turn) / TURN)
    # from its centre across its direction: above it where it is convex, below where concave
    reach = piece.side * piece.radius
    return [(piece.y - reach * math.sin(angle), piece.z + reach * math.cos(angle))
            for angle in (begin + turn * part / parts for part in range(parts + 1))]
