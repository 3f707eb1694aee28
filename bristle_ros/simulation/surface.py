"""From a scene's gutter and profile to the Surface that the kernels evaluate."""
import math

from bristle_ros.physics.contact import Gutter, Sine, Surface
from bristle_ros.scene import cross_section, gutter_friction, Scene, spline, waves
import numpy as np

LANES = 8       # cosines that are evaluated together


def surface_of(scene: Scene) -> Surface | None:
    """Return the Surface, or None where it is the nominal plane alone."""
    profile = scene.profile
    gutter = _gutter(scene) if scene.gutter.enabled else None
    sine = (Sine(profile.amplitude, 1.0 / profile.wavelength, profile.phase)
            if profile.kind == 'sine' else None)
    cosines = _waves(scene) if profile.kind == 'iso8608' else None
    curve = np.array(spline(profile)) if profile.kind == 'file' else None
    if all(part is None for part in (gutter, sine, cosines, curve)):
        return None
    return Surface(gutter, sine, cosines, curve)


def _gutter(scene: Scene) -> Gutter:
    pieces = cross_section(scene.gutter)
    straight = [i for i, piece in enumerate(pieces) if piece.side == 0.0]
    return Gutter(np.array(pieces), straight[1], scene.gutter.approach, *gutter_friction(scene))


def _waves(scene: Scene) -> np.ndarray:
    """Return amplitudes, wave numbers and phases in turns, one after the other, in full lanes."""
    amplitude, wave_number, phase = waves(scene.profile)
    rows = np.zeros((3, -(-len(amplitude) // LANES) * LANES))
    rows[:, :len(amplitude)] = amplitude, wave_number, phase / (2.0 * math.pi)
    return np.ascontiguousarray(rows.ravel())
