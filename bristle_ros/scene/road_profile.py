"""The profile of the road along x: cosines with the spectrum of ISO 8608, or a spline; checks."""
from collections.abc import Callable
import math
from typing import NamedTuple

import numpy as np

from .error import SceneError, spell
from .points_file import PROFILE, read_points
from .surface import Profile

STEEPEST = math.radians(80.0)
WIDTHS_OF_SLOPE = 4.0       # times its root mean square: what a random profile may reach


def waves(profile: Profile) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """
    Return amplitude [m], wave number [1/m] and phase [rad] of the cosines of an ISO 8608 profile.

    Gd(n) = Gd(0.1/m) (n / (0.1/m))^-2, Gd(0.1/m) = 16e-6 4^k m^3, k = 0 for class A. A band of
    width dn has the variance Gd(n) dn, which is that of a cosine with A^2 / 2.
    """
    edges = np.geomspace(1.0 / profile.longest, 1.0 / profile.shortest, profile.bands + 1)
    middle = np.sqrt(edges[:-1] * edges[1:])
    density = 16e-6 * 4.0 ** 'ABCDEFGH'.index(profile.roughness_class) * (middle / 0.1) ** -2
    phase = np.random.Generator(np.random.PCG64(profile.seed)).uniform(
        0.0, 2.0 * math.pi, profile.bands)
    return np.sqrt(2.0 * density * np.diff(edges)), middle, phase


class Spline(NamedTuple):
    """A natural cubic spline through points; its end heights are held beyond them."""

    x: np.ndarray           # [m] increasing
    z: np.ndarray           # [m]
    bend: np.ndarray        # [1/m] second derivative at the points


def spline(profile: Profile) -> Spline:
    """Return the spline through the points of the profile's file; raise SceneError."""
    x, z = read_points(profile.file, PROFILE)
    # tridiagonal: h_i-1 b_i-1 + 2 (h_i-1 + h_i) b_i + h_i b_i+1 = 6 (slope_i - slope_i-1)
    step = np.diff(x)
    right = 6.0 * np.diff(np.diff(z) / step)
    bend = np.zeros(len(x))
    diagonal = 2.0 * (step[:-1] + step[1:])
    for i in range(1, len(right)):
        part = step[i] / diagonal[i - 1]
        diagonal[i] -= part * step[i]
        right[i] -= part * right[i - 1]
    for i in range(len(right) - 1, -1, -1):
        bend[i + 1] = (right[i] - step[i + 1] * bend[i + 2]) / diagonal[i]
    return Spline(x, z, bend)


def heights_of(profile: Profile) -> Callable[[np.ndarray], np.ndarray]:
    """Return the function from places x [m] to heights [m], for who draws; not for the steps."""
    if profile.kind == 'sine':
        turn = 2.0 * math.pi / profile.wavelength
        return lambda x: profile.amplitude * np.sin(turn * x + profile.phase)
    if profile.kind == 'iso8608':
        amplitude, wave_number, phase = waves(profile)
        return lambda x: np.cos(2.0 * math.pi * np.outer(x, wave_number) + phase) @ amplitude
    if profile.kind == 'file':
        curve = spline(profile)
        return lambda x: _on_spline(curve, x)
    return np.zeros_like


def _on_spline(curve: Spline, x: np.ndarray) -> np.ndarray:
    """Return the heights [m] of a spline at each x [m]."""
    within = np.clip(x, curve.x[0], curve.x[-1])
    low = np.clip(np.searchsorted(curve.x, within, side='right') - 1, 0, len(curve.x) - 2)
    step = curve.x[low + 1] - curve.x[low]
    b = (within - curve.x[low]) / step
    a = 1.0 - b
    bend = (1.0 + a) * curve.bend[low] + (1.0 + b) * curve.bend[low + 1]
    height: np.ndarray = a * curve.z[low] + b * curve.z[low + 1] - step * step * a * b * bend / 6.0
    return height


def check_profile(profile: Profile) -> None:
    """Raise SceneError for a profile that cannot be, or is too steep."""
    if profile.kind == 'sine':
        slope = 2.0 * math.pi * profile.amplitude / profile.wavelength
        _check_slope(slope, 'profile.amplitude', profile.amplitude)
    elif profile.kind == 'iso8608':
        if profile.shortest >= profile.longest:
            raise SceneError(
                f'not below profile.longest = {spell(profile.longest)} m: lower it or raise that',
                key='profile.shortest', value=profile.shortest)
        amplitude, wave_number, _ = waves(profile)
        slope = math.sqrt(0.5 * float(((2.0 * math.pi * wave_number * amplitude) ** 2).sum()))
        _check_slope(WIDTHS_OF_SLOPE * slope, 'profile.roughness_class', profile.roughness_class)
    else:
        _check_spline(spline(profile), profile.file)


def _check_slope(slope: float, key: str, value: object) -> None:
    if slope > math.tan(STEEPEST):
        raise SceneError(
            f'makes slopes of {math.degrees(math.atan(slope)):.1f} degrees: 80 are the most',
            key=key, value=value)


def _check_spline(curve: Spline, file: str) -> None:
    """Refuse slopes beyond the steepest: at the points and where the bend passes through zero."""
    step, a, b = np.diff(curve.x), curve.bend[:-1], curve.bend[1:]
    chord = np.diff(curve.z) / step
    left, right = chord - step * (2.0 * a + b) / 6.0, chord + step * (a + 2.0 * b) / 6.0
    with np.errstate(divide='ignore', invalid='ignore'):
        place = np.where(a * b < 0.0, a / (a - b), 0.0)
    inside = left + step * place * (a + 0.5 * place * (b - a))
    slopes = np.abs(np.stack((left, right, inside)))
    steepest = int(slopes.max(axis=0).argmax())
    slope = float(slopes[:, steepest].max())
    if not slope <= math.tan(STEEPEST):
        raise SceneError(
            f'climbs at {math.degrees(math.atan(slope)):.1f} degrees behind x = '
            f'{curve.x[steepest]:.6g} m: 80 are the most', key='profile.file', value=file)
