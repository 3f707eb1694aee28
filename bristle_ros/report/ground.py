"""
The surface of the road a second time, from the keys of a scene alone: slow, in numpy, for checks.

The kernels' pieces, sectors and sums are not used here. The cross-section is a function of y: its
height comes from lines and arcs over intervals of y, its distance from the nearest point of any of
them, its sign from the height. Profiles are summed one wave at a time; the spline of a file comes
from a dense matrix.
"""
import math

from bristle_ros.scene import waves
import numpy as np

WAVES_AT_ONCE = 64
FAR = 1e3       # [m] that the level parts of the cross-section reach


class Ground:
    """
    The surface z = c(y) + p(x) of a scene, axes of the surface: y = 0 where the base starts.

    `gap` is the distance to first order, d / sqrt(1 + (n_z p')^2) with d the distance from the
    cross-section at the point lowered by p; `inside` is exact whatever the distance.
    """

    def __init__(self, scene):
        """Take the keys of a scene."""
        self.scene = scene
        self.uneven = scene.gutter.enabled or scene.profile.kind != 'none'
        self._lines, self._arcs = _section(scene.gutter) if scene.gutter.enabled else (
            [((-FAR, 0.0), (FAR, 0.0))], [])
        self._waves = waves(scene.profile) if scene.profile.kind == 'iso8608' else None
        self._spline = _natural(scene.profile.file) if scene.profile.kind == 'file' else None

    def bend(self):
        """Return the largest curvature of the surface, about [1/m]."""
        gutter, profile = self.scene.gutter, self.scene.profile
        found = 0.0
        if gutter.enabled:
            found = 1.0 / min(gutter.lip_radius, gutter.foot_radius, gutter.edge_radius)
        if profile.kind == 'sine':
            found += profile.amplitude * (2.0 * math.pi / profile.wavelength) ** 2
        elif profile.kind == 'iso8608':
            amplitude, number, _ = self._waves
            each = (2.0 * math.pi * number) ** 2 * amplitude
            found += 4.0 * math.sqrt(0.5 * float(each @ each))
        elif profile.kind == 'file':
            found += float(np.abs(self._spline[2]).max())
        return found

    def profile(self, x):
        """Return height [m] and slope of the profile at each x [m]."""
        profile = self.scene.profile
        if profile.kind == 'sine':
            k = 2.0 * math.pi / profile.wavelength
            return (profile.amplitude * np.sin(k * x + profile.phase),
                    profile.amplitude * k * np.cos(k * x + profile.phase))
        if profile.kind == 'iso8608':
            return self._summed(x)
        if profile.kind == 'file':
            return _on_natural(*self._spline, x)
        return np.zeros_like(x), np.zeros_like(x)

    def _summed(self, x):
        height, slope = np.zeros_like(x), np.zeros_like(x)
        for at in range(0, len(self._waves[0]), WAVES_AT_ONCE):
            amplitude, number, phase = (part[at:at + WAVES_AT_ONCE] for part in self._waves)
            angle = 2.0 * math.pi * number * x[..., None] + phase
            height += np.cos(angle) @ amplitude
            slope -= np.sin(angle) @ (2.0 * math.pi * number * amplitude)
        return height, slope

    def section(self, y):
        """Return height [m] and slope of the cross-section at each y [m]."""
        height, slope = np.zeros_like(y), np.zeros_like(y)
        for (y0, z0), (y1, z1) in self._lines:
            on = (y >= y0) & (y <= y1)
            tilt = (z1 - z0) / (y1 - y0)
            height[on], slope[on] = z0 + tilt * (y[on] - y0), tilt
        for middle, radius, side, (low, high) in self._arcs:
            on = (y > low) & (y < high)
            up = np.sqrt(radius ** 2 - (y[on] - middle[0]) ** 2)
            height[on], slope[on] = middle[1] + side * up, -side * (y[on] - middle[0]) / up
        return height, slope

    def inside(self, points):
        """Return how far below the surface points (..., 3) are, upright [m]; above it negative."""
        return self.profile(points[..., 0])[0] + self.section(points[..., 1])[0] - points[..., 2]

    def gap(self, points):
        """Return gaps [m] (...) and unit normals (..., 3) of points (..., 3) [m]."""
        height, slope = self.profile(points[..., 0])
        y, z = points[..., 1], points[..., 2] - height
        distance, foot = self._nearest(y, z)
        across = self.section(foot)[1]
        up = 1.0 / np.sqrt(1.0 + across ** 2)
        normal = np.stack((-slope * up, -across * up, up), axis=-1)
        size = np.sqrt(1.0 + (slope * up) ** 2)
        signed = np.where(z < self.section(y)[0], -distance, distance)
        return signed / size, normal / size[..., None]

    def _nearest(self, y, z):
        """Return distance from the cross-section [m], and y of its nearest point [m]."""
        best, foot = np.full_like(y, np.inf), np.zeros_like(y)
        for (y0, z0), (y1, z1) in self._lines:
            along = np.array((y1 - y0, z1 - z0))
            share = np.clip(((y - y0) * along[0] + (z - z0) * along[1]) / (along @ along), 0, 1)
            at_y, at_z = y0 + share * along[0], z0 + share * along[1]
            _keep(best, foot, np.hypot(y - at_y, z - at_z), at_y)
        for middle, radius, side, (low, high) in self._arcs:
            from_y, from_z = y - middle[0], z - middle[1]
            far = np.hypot(from_y, from_z)
            at_y = middle[0] + radius * from_y / np.maximum(far, 1e-300)
            on = (side * from_z > 0.0) & (at_y > low) & (at_y < high)
            _keep(best, foot, np.where(on, np.abs(far - radius), np.inf), at_y)
        return best, foot

    def friction(self, y):
        """Return the largest mu_s that may hold at each y [m]: near its beginning the gutter's."""
        road, gutter = self.scene.friction.static, self.scene.gutter
        own = gutter.friction_static
        if not gutter.enabled or own < 0.0:
            return np.full_like(y, road)
        begins = gutter.kerb_distance - gutter.channel_width
        return np.where(y < begins - gutter.lip_radius, road, np.where(
            y > begins + gutter.lip_radius, own, max(road, own)))

    def beside(self, t):
        """Return how much further away than in its place the gutter is at t [s]: [m]."""
        if not self.scene.gutter.enabled:
            return 0.0
        return self.scene.gutter.approach * (1.0 - self._share(t))

    def height(self, t):
        """Return the part of the approach that is done at t [s], times the penetration [m]."""
        return self.scene.road.penetration * self._share(t)

    def _share(self, t):
        approach = self.scene.road.approach_time
        s = min(1.0, t / approach) if approach > 0.0 else 1.0
        return s * s * (3.0 - 2.0 * s)


def mount_to_road(road, heading):
    """Return the matrix from mount axes to road axes, the tilt's turned with the heading [rad]."""
    toward = _about_z(road.tilt_azimuth)
    c, s = math.cos(road.attack_angle), math.sin(road.attack_angle)
    lean = np.array(((c, 0.0, s), (0.0, 1.0, 0.0), (-s, 0.0, c)))
    return _about_z(heading) @ toward @ lean @ toward.T


def _about_z(angle):
    c, s = math.cos(angle), math.sin(angle)
    return np.array(((c, -s, 0.0), (s, c, 0.0), (0.0, 0.0, 1.0)))


def _keep(best, foot, distance, at_y):
    nearer = distance < best
    best[nearer], foot[nearer] = distance[nearer], at_y[nearer]


def _section(gutter):
    """Return lines ((y, z), (y, z)) and arcs (middle, radius, side, (y, y)) of a gutter."""
    d, fall = gutter.kerb_distance, gutter.channel_width * math.tan(gutter.channel_slope)
    top = gutter.kerb_height - fall
    corners = np.array((
        (-FAR, 0.0), (d - gutter.channel_width, 0.0), (d, -fall),
        (d + abs(gutter.kerb_height) * math.tan(gutter.kerb_batter), top), (FAR, top)))
    at_edge = (gutter.foot_radius, gutter.edge_radius)
    radii = (gutter.lip_radius, *(at_edge if gutter.kerb_height > 0.0 else at_edge[::-1]))
    starts, ends, arcs = [corners[0]], [], []
    for before, corner, after, radius in zip(corners, corners[1:], corners[2:], radii):
        back, on = before - corner, after - corner
        back, on = back / np.hypot(*back), on / np.hypot(*on)
        half = 0.5 * math.acos(max(-1.0, min(1.0, float(back @ on))))
        if math.pi / 2.0 - half < 1e-10:
            ends.append(corner)
            starts.append(corner)
            continue
        taken = radius / math.tan(half)
        bisector = (back + on) / np.hypot(*(back + on))
        first, last = corner + taken * back, corner + taken * on
        ends.append(first)
        starts.append(last)
        # a convex edge has its middle below it, and the arc above the middle
        side = -1.0 if bisector[1] > 0.0 else 1.0
        arcs.append((corner + radius / math.sin(half) * bisector, radius, side,
                     (first[0], last[0])))
    ends.append(corners[-1])
    return list(zip(starts, ends)), arcs


def _natural(file):
    """Return x, z and second derivatives of the natural spline through `data:x,z;x,z`."""
    x, z = np.array([point.split(',') for point in file.removeprefix('data:').split(';')],
                    dtype=float).T
    step, count = np.diff(x), len(x)
    matrix, right = np.eye(count), np.zeros(count)
    for i in range(1, count - 1):
        matrix[i, i - 1:i + 2] = step[i - 1], 2.0 * (step[i - 1] + step[i]), step[i]
        right[i] = 6.0 * ((z[i + 1] - z[i]) / step[i] - (z[i] - z[i - 1]) / step[i - 1])
    return x, z, np.linalg.solve(matrix, right)


def _on_natural(x, z, bend, at):
    """Return height and slope of a natural spline; its end heights are held."""
    i = np.clip(np.searchsorted(x, at) - 1, 0, len(x) - 2)
    step, right, left = x[i + 1] - x[i], at - x[i], x[i + 1] - at
    height = ((bend[i] * left ** 3 + bend[i + 1] * right ** 3) / (6.0 * step)
              + (z[i] / step - bend[i] * step / 6.0) * left
              + (z[i + 1] / step - bend[i + 1] * step / 6.0) * right)
    slope = ((bend[i + 1] * right ** 2 - bend[i] * left ** 2) / (2.0 * step)
             + (z[i + 1] - z[i]) / step - step * (bend[i + 1] - bend[i]) / 6.0)
    return (np.where(at < x[0], z[0], np.where(at > x[-1], z[-1], height)),
            np.where((at < x[0]) | (at > x[-1]), 0.0, slope))
