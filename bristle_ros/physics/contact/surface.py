"""
The surface of the road: signed gap and normal at a point, only of what the scene has.

The surface is z = c(y) + p(x). With d(y, z) the signed distance from the gutter's cross-section,
n its unit gradient and p' the profile's slope, the gap is

    g(x, y, z) = d(y, z - p(x)) / sqrt(1 + (n_z p')^2)

whose zeros are the surface and whose gradient there is the unit normal: the distance to first
order, near the surface and at any slope. Without a profile it is the distance itself. What is
None in a Surface compiles to nothing.
"""
from math import cos, floor, inf, pi, sin, sqrt
from typing import NamedTuple

from bristle_ros.physics.compiler import jit, load8, store8
import numpy as np

# a piece of the cross-section, a row each: see scene/surface.py
SIDE = 0            # 0 straight, 1 convex fillet, -1 concave
PLACE = 1           # 2  a point of it, or the fillet's centre [m]
ALONG = 3           # 2  direction, or that at the fillet's beginning
END = 5             # 2  first and last place along it [m], or the direction at the fillet's end
RADIUS = 7          # [m]

SLACK = 1e-12       # [m] by which pieces overlap: no point falls between two
ROUND = 6755399441055744.0      # 1.5 * 2^52: added and taken off again it rounds to the nearest


class Gutter(NamedTuple):
    """The cross-section of the gutter, and the friction of channel and kerb."""

    pieces: np.ndarray      # (n, 8)
    first: int              # piece from which on the friction is that of the gutter
    approach: float         # how much further away it starts [m]
    static: float
    kinetic: float
    decay: float


SINE = 0
WAVES = 1
SPLINE = 2


class Profile(NamedTuple):
    """The profile along x; what its kind does not use is empty."""

    kind: int               # SINE, WAVES or SPLINE
    amplitude: float        # of the sine [m]
    wave_number: float      # [1/m]
    phase: float            # [rad]
    waves: np.ndarray       # (3 n,) amplitudes [m], wave numbers [1/m], phases [turns]
    spline: np.ndarray      # (3, n) x, z [m] and second derivative [1/m]
    spacing: float          # [m] of places at which heights of the waves are kept
    off: float              # [m] by which chords between these miss the waves at most


class Surface(NamedTuple):
    """What the road's surface is made of; each part is None where the scene has none."""

    gutter: Gutter | None
    profile: Profile | None


@jit
def _sine(profile, x):
    """Return height and slope of a sine."""
    by_x = 2.0 * pi * profile.wave_number
    angle = by_x * x + profile.phase
    return profile.amplitude * sin(angle), by_x * profile.amplitude * cos(angle)


@jit
def _waves(waves, x, sums):
    """
    Return height and slope of a sum of cosines, eight at a time.

    sums : (16,)    scratch
    The angle is u turns; with u = k / 2 + r, |r| <= 1/4, cos(2 pi u) = (-1)^k cos(2 pi r). Taylor
    series to 1e-17 on |2 pi r| <= pi / 2.
    """
    height = load8(waves, 0) * 0.0
    slope = height
    count = waves.size // 3
    for i in range(0, count, 8):
        amplitude, wave_number = load8(waves, i), load8(waves, count + i)
        u = wave_number * x + load8(waves, 2 * count + i)
        half = (u + u + ROUND) - ROUND
        odd = half - 2.0 * ((0.5 * half + ROUND) - ROUND)
        sign = 1.0 - 2.0 * (odd * odd)
        r = (2.0 * pi) * (u - 0.5 * half)
        square = r * r
        even_part = square * (1.0 / 2432902008176640000.0) - 1.0 / 6402373705728000.0
        odd_part = square * (1.0 / 51090942171709440000.0) - 1.0 / 121645100408832000.0
        for by_even, by_odd in ((1.0 / 20922789888000.0, 1.0 / 355687428096000.0),
                                (-1.0 / 87178291200.0, -1.0 / 1307674368000.0),
                                (1.0 / 479001600.0, 1.0 / 6227020800.0),
                                (-1.0 / 3628800.0, -1.0 / 39916800.0),
                                (1.0 / 40320.0, 1.0 / 362880.0), (-1.0 / 720.0, -1.0 / 5040.0),
                                (1.0 / 24.0, 1.0 / 120.0), (-0.5, -1.0 / 6.0), (1.0, 1.0)):
            even_part = even_part * square + by_even
            odd_part = odd_part * square + by_odd
        scaled = amplitude * sign
        height = height + scaled * even_part
        slope = slope - scaled * wave_number * (odd_part * r)
    store8(sums, 0, height)
    store8(sums, 8, slope)
    high = 0.0
    steep = 0.0
    for i in range(8):
        high += sums[i]
        steep += sums[8 + i]
    return high, 2.0 * pi * steep


@jit
def _spline(spline, x):
    """Return height and slope of a natural cubic spline whose end heights are held."""
    count = spline.shape[1]
    if x <= spline[0, 0]:
        return spline[1, 0], 0.0
    if x >= spline[0, count - 1]:
        return spline[1, count - 1], 0.0
    low, high = 0, count - 1
    while high - low > 1:
        middle = (low + high) // 2
        if spline[0, middle] <= x:
            low = middle
        else:
            high = middle
    step = spline[0, high] - spline[0, low]
    b = (x - spline[0, low]) / step
    a = 1.0 - b
    left, right = spline[2, low] * step, spline[2, high] * step
    rise = (spline[1, high] - spline[1, low]) / step
    return (a * spline[1, low] + b * spline[1, high]
            - step * a * b * ((1.0 + a) * left + (1.0 + b) * right) / 6.0,
            rise + ((3.0 * b * b - 1.0) * right - (3.0 * a * a - 1.0) * left) / 6.0)


@jit
def profile_height(profile, x, sums):
    """Return height [m] and slope of the profile at x [m]; sums : (16,) scratch."""
    if profile is None:
        return 0.0, 0.0
    if profile.kind == WAVES:
        return _waves(profile.waves, x, sums)
    if profile.kind == SPLINE:
        return _spline(profile.spline, x)
    return _sine(profile, x)


@jit
def _section_gap(gutter, y, z):
    """
    Return signed distance from the cross-section [m], its gradient (y, z), and the nearest piece.

    Of the pieces whose sector the point lies in the nearest one counts: near the surface there is
    but one, since each piece begins in the direction in which the one before it ends.
    """
    if gutter is None:
        return z, 0.0, 1.0, 0
    pieces = gutter.pieces
    nearest = inf
    n1, n2 = 0.0, 1.0
    found = 0
    for i in range(pieces.shape[0]):
        w1, w2 = y - pieces[i, PLACE], z - pieces[i, PLACE + 1]
        c, s = pieces[i, ALONG], pieces[i, ALONG + 1]
        along = c * w1 + s * w2
        side = pieces[i, SIDE]
        if side == 0.0:
            if along < pieces[i, END] - SLACK or along > pieces[i, END + 1] + SLACK:
                continue
            m1, m2 = -s, c
            gap = m1 * w1 + m2 * w2
        else:
            if along < -SLACK or pieces[i, END] * w1 + pieces[i, END + 1] * w2 > SLACK:
                continue
            distance = sqrt(w1 * w1 + w2 * w2)
            if distance < 1e-15:
                continue
            gap = side * (distance - pieces[i, RADIUS])
            m1, m2 = side * w1 / distance, side * w2 / distance
        if abs(gap) < abs(nearest):
            nearest, n1, n2, found = gap, m1, m2, i
    return nearest, n1, n2, found


@jit
def gap_at(surface, x, y, z, sums):
    """
    Return the gap at a point in surface axes [m], the unit normal there (3), and the piece.

    sums : (16,)    scratch. The normal is that of the surface through the point on which the gap
    would be constant; at a gap of zero the gap's gradient.
    """
    height, slope = profile_height(surface.profile, x, sums)
    return _gap_over(surface.gutter, height, slope, y, z)


@jit
def _gap_over(gutter, height, slope, y, z):
    """Return the gap where the profile has a height and a slope; see gap_at."""
    distance, n2, n3, piece = _section_gap(gutter, y, z - height)
    n1 = -slope * n3
    scale = 1.0 / sqrt(1.0 + n1 * n1)
    return distance * scale, n1 * scale, n2 * scale, n3 * scale, piece


@jit
def _kept_height(profile, i, room, sums):
    """Return the height at place i [spacings], kept since it was last asked for."""
    at = i & (room.places.size - 1)
    if room.places[at] != i:
        room.heights[at] = profile_height(profile, i * profile.spacing, sums)[0]
        room.places[at] = i
    return room.heights[at]


@jit
def _most_height(profile, x, room, sums):
    """Return what height and slope of the profile are at most, from heights that are kept."""
    if profile is None:
        return 0.0, 0.0
    if room.places.size == 0:
        return profile_height(profile, x, sums)
    u = x / profile.spacing
    i = floor(u)
    low = _kept_height(profile, i, room, sums)
    rise = _kept_height(profile, i + 1, room, sums) - low
    return (low + (u - i) * rise + profile.off,
            (abs(rise) + 4.0 * profile.off) / profile.spacing)


@jit
def least_gap_at(surface, x, y, z, room, sums):
    """
    Return what the gap at a point outside is at least [m]; itself where no heights are kept.

    A sum of hundreds of waves takes a microsecond, the chord of two kept heights next to nothing.
    Between them the sum is at most `off` above the chord, and at most 4 off / spacing steeper: by
    the bound on its second derivative.
    """
    height, slope = _most_height(surface.profile, x, room, sums)
    return _gap_over(surface.gutter, height, slope, y, z)[0]
