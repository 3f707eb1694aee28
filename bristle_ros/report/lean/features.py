"""The features of a scene that can be left out: what each changes, and how it is left out."""
from dataclasses import replace
import math
from types import MappingProxyType
from typing import NamedTuple

STEP = 1e-4         # [s] integration step of all timings here


class Feature(NamedTuple):
    """A feature, as the keys of a scene with it and without it, and what is built around it."""

    name: str
    how: str                    # it is left out
    present: dict = MappingProxyType({})    # section.key: value
    absent: dict = MappingProxyType({})
    around: str = ''            # 'energies', 'commands', 'log': what is on with it
    bristles: int = 1           # over which the time with it is shared


FEATURES = (
    Feature('contact', 'contact.enabled: false; its kernels are not compiled',
            absent={'contact.enabled': False}),
    Feature('friction', 'friction.static: 0 and friction.kinetic: 0',
            absent={'friction.static': 0.0, 'friction.kinetic': 0.0}),
    Feature('stiffness damping', 'damping.stiffness: 0; its kernels are not compiled',
            absent={'damping.stiffness': 0.0}),
    Feature('mass damping', 'damping.mass: 0', absent={'damping.mass': 0.0}),
    Feature('commands, one in each chunk', 'send none', around='commands'),
    Feature('several bristles (8), per bristle', 'brush.bristle_count: 1',
            present={'brush.bristle_count': 8}, bristles=8),
    Feature('log at 1 kHz', 'log.path: "" (node), no --output FILE.mcap (simulate)',
            around='log'),
    Feature('transforms in the log', 'log.tf: false', absent={'log.tf': False}, around='log both'),
    Feature('energy accounts', 'the node and bench never keep them; simulate does',
            around='energies'),
    Feature('adaptive steps', 'solver.step: fixed', present={'solver.step': 'adaptive'}),
    Feature('displacement load case', 'solver.load_case: inertia',
            present={'solver.load_case': 'displacement'}),
    Feature('load steps of 1 ms', 'solver.time_step: 0', present={'solver.time_step': 1e-3}),
    Feature('tilted brush axis', 'road.attack_angle: 0',
            present={'road.attack_angle': math.radians(10.0)}),
    Feature('VAP speed function', 'drive.profile: constant',
            present={'drive.profile': 'vap', 'drive.alternating_speed': 0.42},
            absent={'drive.profile': 'constant'}),
)


def changed(scene, keys):
    """Return a Scene with keys changed; keys : section.key to value."""
    sections = {}
    for key, value in keys.items():
        section, _, name = key.partition('.')
        sections.setdefault(section, {})[name] = value
    return replace(scene, **{section: replace(getattr(scene, section), **values)
                             for section, values in sections.items()})
