"""The surface of the road: distances and normals against what they mean."""
import math
from typing import NamedTuple

from bristle_ros.physics.contact.surface import gap_at, least_gap_at, profile_height
from bristle_ros.scene.scene import Scene
from bristle_ros.scene.surface import Gutter, Profile
from bristle_ros.simulation.surface import surface_of
import numpy as np
import pytest

SUMS = np.zeros(16)
KERB = Gutter(enabled=True, kerb_distance=0.2)
EDGE = Gutter(enabled=True, kerb_distance=0.14, channel_slope=0.0, kerb_height=-0.08)
ROUGH = Profile(kind='iso8608', shortest=0.02, seed=7)
SINE = Profile(kind='sine', amplitude=0.0025, wavelength=0.08, phase=0.3)


def surface(gutter=None, profile=None):
    return surface_of(Scene(gutter=gutter or Gutter(), profile=profile or Profile()))


def height_above(gutter, y):
    """Return the height of the cross-section [m] at y, from the corners and tangent circles."""
    d, s = gutter.kerb_distance, math.tan(gutter.channel_slope)
    w, h = gutter.channel_width, gutter.kerb_height
    face = math.copysign(1.0 / math.tan(gutter.kerb_batter), h)
    corners = [(d - w, 0.0), (d, -w * s), (d + h / face, h - w * s)]
    slopes = [0.0, -s, face, 0.0]
    radii = [gutter.lip_radius, gutter.foot_radius, gutter.edge_radius]
    if h < 0.0:
        radii[1:] = radii[:0:-1]
    z = np.where(y < corners[0][0], 0.0, np.where(
        y < d, -s * (y - d + w), np.where(y < corners[2][0], corners[1][1] + face * (y - d),
                                          h - w * s)))
    for (at, level), before, after, radius in zip(corners, slopes, slopes[1:], radii):
        if before == after:
            continue
        side = math.copysign(1.0, after - before)   # of the centre: above a concave corner
        # the centre is `radius` away from both sides, measured along their normals
        lift = side * radius
        a, b = lift * math.hypot(1.0, before), lift * math.hypot(1.0, after)
        centre = (a - b) / (after - before)
        middle = a + before * centre
        first = centre + lift * before / math.hypot(1.0, before)
        last = centre + lift * after / math.hypot(1.0, after)
        inside = (y - at > min(first, last)) & (y - at < max(first, last))
        arc = middle - side * np.sqrt(np.maximum(radius ** 2 - (y - at - centre) ** 2, 0.0))
        z = np.where(inside, level + arc, z)
    return z


@pytest.mark.parametrize('gutter', [KERB, EDGE, Gutter(
    enabled=True, kerb_distance=0.2, foot_radius=0.04, edge_radius=0.03, kerb_batter=0.6)])
def test_gutter_gap_is_the_distance_from_its_cross_section(gutter):
    """Against the nearest of a million points of the curve; near it, on both sides."""
    y = np.linspace(-0.2, 0.4, 600_001)
    z = height_above(gutter, y)
    rng = np.random.default_rng(1)
    for i in rng.integers(100_000, 500_000, 200):
        across = rng.uniform(-0.009, 0.009)     # less than the smallest radius
        slope = (z[i + 1] - z[i - 1]) / (y[i + 1] - y[i - 1])
        normal = np.array((-slope, 1.0)) / math.hypot(1.0, slope)
        point = np.array((y[i], z[i])) + across * normal
        gap, n1, n2, n3, _ = gap_at(surface(gutter), 0.7, *point, SUMS)
        nearest = np.sqrt(((y - point[0]) ** 2 + (z - point[1]) ** 2).min())
        assert n1 == 0.0
        assert abs(abs(gap) - nearest) < 2e-6
        assert gap * across > 0.0 or abs(gap) < 2e-6
        assert math.hypot(n2, n3) == pytest.approx(1.0, abs=1e-12)
        if abs(across) > 1e-4:
            # towards the nearest point
            foot = np.argmin((y - point[0]) ** 2 + (z - point[1]) ** 2)
            off = point - (y[foot], z[foot])
            assert abs(off @ (-n3, n2)) < 2e-6


def test_rough_profile_is_its_cosines():
    profile = ROUGH
    edges = np.geomspace(1.0 / profile.longest, 1.0 / profile.shortest, 401)
    n = np.sqrt(edges[1:] * edges[:-1])
    a = np.sqrt(2.0 * 256e-6 * (n / 0.1) ** -2 * np.diff(edges))
    phi = np.random.Generator(np.random.PCG64(7)).uniform(0.0, 2.0 * np.pi, 400)
    rough = surface(profile=profile)
    for x in (-3.3, 0.0, 0.123456, 17.0):
        height, slope = profile_height(rough.profile, x, SUMS)
        angle = 2.0 * np.pi * n * x + phi
        assert height == pytest.approx((a * np.cos(angle)).sum(), abs=1e-14)
        assert slope == pytest.approx((-2.0 * np.pi * n * a * np.sin(angle)).sum(), abs=1e-12)


def test_rough_profile_has_the_spectrum_of_its_class():
    """Variance from band to band of the standard: that of Gd, by the mean over a long way."""
    rough = surface(profile=Profile(kind='iso8608', roughness_class='B', shortest=0.05, bands=64))
    x = np.arange(0.0, 400.0, 0.01)
    z = np.array([profile_height(rough.profile, at, SUMS)[0] for at in x])
    variance = 64e-6 * 0.1 ** 2 * (1.0 - 0.05)      # integral of Gd from 1/m to 20/m
    assert z.var() == pytest.approx(variance, rel=0.02)


def test_spline_goes_through_its_points_smoothly_and_ends_level(tmp_path):
    x = np.array((0.0, 0.1, 0.15, 0.3, 0.32))
    z = np.array((0.0, 0.01, -0.02, 0.005, 0.0))
    file = tmp_path / 'profile.csv'
    file.write_text('x,z\n' + ''.join(f'{a},{b}\n' for a, b in zip(x, z)))
    curve = surface(profile=Profile(kind='file', file=str(file)))

    def at(place):
        return profile_height(curve.profile, place, SUMS)
    for place, height in zip(x, z):
        assert at(place)[0] == pytest.approx(height, abs=1e-15)
    assert at(-1.0) == (0.0, 0.0)
    assert at(9.0) == (0.0, 0.0)
    e = 1e-6
    for place in x[1:-1]:
        assert at(place - e)[1] == pytest.approx(at(place + e)[1], abs=1e-4)
        bends = [(at(place + s * 2 * e)[1] - at(place + s * e)[1]) / (s * e) for s in (-1.0, 1.0)]
        assert bends[0] == pytest.approx(bends[1], rel=1e-3)
    assert abs(at(e)[1] - at(2 * e)[1]) / e < 1e-3      # natural: no bend at the ends


@pytest.mark.parametrize(('gutter', 'profile'), [
    (None, SINE), (None, ROUGH), (KERB, SINE), (EDGE, ROUGH)])
def test_gap_vanishes_on_the_surface_and_its_gradient_is_the_normal(gutter, profile):
    """Normal against differences; the height of a sum is the sum of the heights."""
    both = surface(gutter, profile)
    rng = np.random.default_rng(2)
    for _ in range(100):
        x, y = rng.uniform(-1.0, 1.0), rng.uniform(-0.1, 0.35)
        if gutter and abs(y - gutter.kerb_distance) < 0.002:
            continue
        z = profile_height(both.profile, x, SUMS)[0]
        if gutter:
            z += float(height_above(gutter, np.array(y)))
        gap, *normal, _ = gap_at(both, x, y, z, SUMS)
        assert abs(gap) < 1e-12
        e = 1e-7
        by_difference = [
            (gap_at(both, *(np.array((x, y, z)) + e * axis), SUMS)[0]
             - gap_at(both, *(np.array((x, y, z)) - e * axis), SUMS)[0]) / (2.0 * e)
            for axis in np.eye(3)]
        assert np.abs(np.array(by_difference) - normal).max() < 2e-5


class Kept(NamedTuple):
    """What `least_gap_at` needs of a Room."""

    places: np.ndarray
    heights: np.ndarray


@pytest.mark.parametrize(('gutter', 'roughness'), [(None, 'C'), (KERB, 'C'), (None, 'F')])
def test_kept_heights_bound_the_gap_from_below_and_closely(gutter, roughness):
    """So few places that each is taken over and over, behind the origin and far before it."""
    profile = Profile(kind='iso8608', shortest=0.02, seed=7, roughness_class=roughness)
    road, kept = surface(gutter, profile), Kept(np.full(64, -(1 << 62)), np.zeros(64))
    rng = np.random.default_rng(3)
    found = 0
    for x, y, above in zip(rng.uniform(-300.0, 300.0, 3000), rng.uniform(-0.1, 0.3, 3000),
                           rng.uniform(0.0, 0.03, 3000)):
        z = profile_height(road.profile, x, SUMS)[0] + above
        gap = gap_at(road, x, y, z, SUMS)[0]
        if gap > 0.0:
            least = least_gap_at(road, x, y, z, kept, SUMS)
            assert 0.75 * gap - 2.0 * road.profile.off < least <= gap
            assert least_gap_at(road, x, y, z, kept, SUMS) == least     # of what is kept now
            found += 1
    assert found > 1000
    assert 0 < road.profile.off < (2e-5 if roughness == 'C' else 2e-4)


@pytest.mark.parametrize('profile', [None, SINE])
def test_where_no_heights_are_kept_the_gap_is_exact(profile):
    road, kept = surface(KERB, profile), Kept(np.zeros(0, int), np.zeros(0))
    for point in np.random.default_rng(4).uniform((-1.0, -0.1, 0.0), (1.0, 0.3, 0.1), (50, 3)):
        assert least_gap_at(road, *point, kept, SUMS) == gap_at(road, *point, SUMS)[0]
