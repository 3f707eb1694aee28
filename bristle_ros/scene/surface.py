"""
The surface of the road: height over the nominal plane z = c(y) + p(x), gutter and profile.

The gutter's cross-section c is straight pieces with fillets between them; the profile p is a sine,
a sum of cosines with the spectrum of ISO 8608, or a natural cubic spline through the points of a
file. Here are their keys, their refusals and their geometry; the kernels only evaluate them.
"""
from dataclasses import dataclass
from itertools import pairwise
import math
from typing import Literal, NamedTuple

from .error import SceneError
from .key import choice, count, number, switch, text
from .sections import SceneSection

INHERITED = -1.0                    # friction of a gutter that is the road's


@dataclass(frozen=True, kw_only=True)
class Gutter(SceneSection):
    """A channel beside a kerb, along x, to the left of the brush; or an edge that falls away."""

    enabled: bool = switch(False, 'whether there is a gutter')
    kerb_distance: float = number(
        0.30, 'm', -100.0, 100.0, "d: y of the foot of the kerb's face; the base starts at 0")
    approach: float = number(
        0.0, 'm', -100.0, 100.0, 'how much further away the kerb starts; closed in approach_time')
    channel_width: float = number(
        0.25, 'm', 1e-3, 10.0, 'w: the channel falls from y = d - w to y = d')
    channel_slope: float = number(0.174533, 'rad', 0.0, 1.0, 's: slope of the channel')
    kerb_height: float = number(
        0.125, 'm', -10.0, 10.0, 'H: above its foot; below 0 the road falls away there')
    kerb_batter: float = number(
        0.20944, 'rad', 0.175, 1.5, 'b: of the face from the vertical')
    lip_radius: float = number(0.05, 'm', 1e-4, 10.0, 'fillet where the channel begins')
    foot_radius: float = number(0.010, 'm', 1e-4, 10.0, 'fillet at the concave foot of the face')
    edge_radius: float = number(0.015, 'm', 1e-4, 10.0, 'fillet at the convex edge of the face')
    friction_static: float = number(
        INHERITED, '1', INHERITED, 100.0, "mu_s of channel and kerb; -1: the road's")
    friction_kinetic: float = number(
        INHERITED, '1', INHERITED, 100.0, "mu_k of channel and kerb; -1: the road's")
    friction_decay: float = number(
        INHERITED, 's/m', INHERITED, 1e6, "c_v of channel and kerb; -1: the road's")


@dataclass(frozen=True, kw_only=True)
class Profile(SceneSection):
    """Height of the road along x."""

    kind: Literal['none', 'sine', 'iso8608', 'file'] = choice('none', 'what the profile is')
    amplitude: float = number(0.003, 'm', 0.0, 1.0, 'sine: A sin(2 pi x / wavelength + phase)')
    wavelength: float = number(0.060, 'm', 1e-4, 1e4, 'of the sine')
    phase: float = number(0.0, 'rad', -1e6, 1e6, 'of the sine')
    roughness_class: Literal['A', 'B', 'C', 'D', 'E', 'F', 'G', 'H'] = choice(
        'C', 'iso8608: class of the spectrum, carried on below its own wavelengths')
    shortest: float = number(0.005, 'm', 1e-4, 1e3, 'iso8608: shortest wavelength')
    longest: float = number(1.0, 'm', 1e-3, 1e4, 'iso8608: longest wavelength')
    bands: int = count(400, 1, 10000, 'iso8608: cosines, log-spaced')
    seed: int = count(1, 0, 2**31 - 1, 'iso8608: of the phases')
    file: str = text(
        '', 'file: CSV x,z [m], x increasing, relative to the scene file; or data:x,z;x,z itself')


class Piece(NamedTuple):
    """A straight piece of the cross-section, or a fillet; (y, z) plane."""

    side: float         # 0: straight; 1: convex, -1: concave fillet
    y: float            # a point of a straight piece, or the centre of a fillet [m]
    z: float
    along_y: float      # direction, for a fillet at its beginning
    along_z: float
    end_y: float        # direction at a fillet's end; first and last place along a straight piece
    end_z: float
    radius: float       # [m]


def corners(gutter: Gutter) -> tuple[list[tuple[float, float]], list[float], list[str]]:
    """Return the corners (y, z) [m] of the cross-section, and radius and key of each fillet."""
    d, fall = gutter.kerb_distance, gutter.channel_width * math.tan(gutter.channel_slope)
    top = d + abs(gutter.kerb_height) * math.tan(gutter.kerb_batter)
    points = [(d - gutter.channel_width, 0.0), (d, -fall), (top, gutter.kerb_height - fall)]
    keys = ['lip_radius', 'foot_radius', 'edge_radius']
    if gutter.kerb_height < 0.0:    # the edge comes first there
        keys = ['lip_radius', 'edge_radius', 'foot_radius']
    return points, [float(getattr(gutter, key)) for key in keys], keys


def cross_section(gutter: Gutter) -> list[Piece]:
    """
    Return the pieces of the gutter's cross-section from right to left, y increasing.

    Each piece begins where the one before it ends, in its direction. A fillet of radius R takes
    R tan(turn / 2) of both its sides. Raises SceneError where that does not fit.
    """
    points, radii, keys = corners(gutter)
    angles = [0.0, *(math.atan2(b[1] - a[1], b[0] - a[0]) for a, b in pairwise(points)),
              0.0]
    lengths = [math.inf, *(math.dist(a, b) for a, b in pairwise(points)), math.inf]
    turns = [after - before for before, after in pairwise(angles)]
    taken = [radius * math.tan(abs(turn) / 2.0) for radius, turn in zip(radii, turns)]
    for i, length in enumerate(lengths[1:-1]):
        if taken[i] + taken[i + 1] > length:
            raise SceneError(
                f'the fillets gutter.{keys[i]} and gutter.{keys[i + 1]} take '
                f'{taken[i] + taken[i + 1]:.4g} m of the {length:.4g} m between them: make them '
                f'smaller, or {("the channel wider", "the face higher")[i]}',
                key=f'gutter.{keys[i]}', value=radii[i])
    pieces = []
    for i, angle in enumerate(angles):
        y, z = points[max(i - 1, 0)]
        c, s = math.cos(angle), math.sin(angle)
        first = -math.inf if i == 0 else taken[i - 1]
        last = (-taken[0] if i == 0 else
                math.inf if i == len(angles) - 1 else lengths[i] - taken[i])
        pieces.append(Piece(0.0, y, z, c, s, first, last, 0.0))
        if i < len(turns) and abs(turns[i]) > 1e-9:
            pieces.append(_fillet(points[i], angle, angles[i + 1], radii[i], taken[i]))
    return pieces


def _fillet(corner: tuple[float, float], before: float, after: float, radius: float,
            taken: float) -> Piece:
    """Return the arc that touches both sides of a corner; angles of its sides [rad]."""
    side = 1.0 if after < before else -1.0
    c, s = math.cos(before), math.sin(before)
    # from where it leaves the first side, the centre is across it: below a convex edge
    y = corner[0] - taken * c + side * radius * s
    z = corner[1] - taken * s - side * radius * c
    return Piece(side, y, z, c, s, math.cos(after), math.sin(after), radius)


def is_uneven(gutter: Gutter, profile: Profile) -> bool:
    """Whether the surface is anything else than the nominal plane."""
    return gutter.enabled or profile.kind != 'none'


def check_surface(gutter: Gutter, profile: Profile) -> None:
    """Raise SceneError for a surface that cannot be."""
    if gutter.enabled:
        _check_gutter(gutter)
    if profile.kind != 'none':
        from .road_profile import check_profile  # with numpy, which most scenes need not
        check_profile(profile)


def _check_gutter(gutter: Gutter) -> None:
    if gutter.kerb_height == 0.0:
        raise SceneError('a kerb without height: give one above 0 m, or below it for an edge that '
                         'falls away', key='gutter.kerb_height', value=0.0)
    for name in ('static', 'kinetic', 'decay'):
        value = getattr(gutter, 'friction_' + name)
        if value < 0.0 and value != INHERITED:
            raise SceneError("must be 0 or more, or -1.0 for the road's",
                             key='gutter.friction_' + name, value=value)
    if gutter.kerb_height < 0.0 and gutter.channel_slope > math.pi / 2.0 - gutter.kerb_batter:
        raise SceneError(
            f'steeper than the face below it: stay below pi/2 - gutter.kerb_batter = '
            f'{math.pi / 2.0 - gutter.kerb_batter:.4g} rad', key='gutter.channel_slope',
            value=gutter.channel_slope)
    cross_section(gutter)
