"""From a scene's gutter and profile to the Surface that the kernels evaluate."""
import math

from bristle_ros.physics.contact import Gutter, Profile, SINE, SPLINE, Surface, WAVES
from bristle_ros.scene import cross_section, gutter_friction, Scene, spline, waves
import numpy as np

KINDS = {'sine': SINE, 'iso8608': WAVES, 'file': SPLINE}
PLACES_A_WAVE = 40      # heights that are kept of the shortest wave
LANES = 8       # cosines that are evaluated together


def surface_of(scene: Scene) -> Surface | None:
    """Return the Surface, or None where it is the nominal plane alone."""
    gutter = _gutter(scene) if scene.gutter.enabled else None
    profile = _profile(scene) if scene.profile.kind != 'none' else None
    return Surface(gutter, profile) if gutter or profile else None


def _gutter(scene: Scene) -> Gutter:
    pieces = cross_section(scene.gutter)
    straight = [i for i, piece in enumerate(pieces) if piece.side == 0.0]
    return Gutter(np.array(pieces), straight[1], scene.gutter.approach, *gutter_friction(scene))


def _profile(scene: Scene) -> Profile:
    profile = scene.profile
    cosines = _waves(scene) if profile.kind == 'iso8608' else np.zeros(0)
    curve = np.array(spline(profile)) if profile.kind == 'file' else np.zeros((3, 0))
    spacing = profile.shortest / PLACES_A_WAVE
    amplitude, wave_number, _ = cosines.reshape(3, -1)
    steepest = np.sum(amplitude * (2.0 * math.pi * wave_number) ** 2)   # second derivative
    return Profile(KINDS[profile.kind], profile.amplitude, 1.0 / profile.wavelength,
                   profile.phase, cosines, curve, spacing, float(steepest * spacing ** 2 / 8.0))


def _waves(scene: Scene) -> np.ndarray:
    """Return amplitudes, wave numbers and phases in turns, one after the other, in full lanes."""
    amplitude, wave_number, phase = waves(scene.profile)
    rows = np.zeros((3, -(-len(amplitude) // LANES) * LANES))
    rows[:, :len(amplitude)] = amplitude, wave_number, phase / (2.0 * math.pi)
    return np.ascontiguousarray(rows.ravel())
