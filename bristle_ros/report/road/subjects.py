"""The scenes in which a wire meets more than a level road with its tip; settings to try."""
import math
from typing import NamedTuple

from bristle_ros.scene import from_parameters

BASE = {
    'friction.static': 0.5, 'friction.kinetic': 0.5, 'friction.decay': 0.0, 'damping.mass': 0.1,
    'damping.stiffness': 1e-3, 'drive.profile': 'constant', 'drive.mean_speed': 10.471976}
SAMPLE = 5e-4   # [s]


class RoadSubject(NamedTuple):
    """A scene of the road, and the errors [%] that its cost is told at."""

    name: str
    what: str
    duration: float     # [s]
    keys: dict          # beside BASE
    tip: float          # of the path
    impulse: float      # of the impulse per 5 ms, three components, whole wire


SUBJECTS = (
    RoadSubject('lying', 'level brush, so deep that the wire lies down', 0.5, {
        'road.penetration': 0.15, 'road.approach_time': 0.15, 'drive.mean_speed': 7.330383},
        0.5, 2.0),
    RoadSubject('kerb', 'tilted brush in a channel, beside a kerb', 0.6, {
        'brush.start_angle': math.pi, 'road.attack_angle': 0.139626, 'road.penetration': 0.06,
        'road.approach_time': 0.0, 'gutter.enabled': True, 'gutter.kerb_distance': 0.185,
        'sweeper.velocity': (1.1, 0.0)}, 1.0, 3.0),
    # the phase lets the wire, which starts at the rear, begin above the road
    RoadSubject('sine', 'level brush over a sine of 80 mm', 0.6, {
        'brush.start_angle': math.pi, 'road.penetration': 0.02, 'road.approach_time': 0.05,
        'profile.kind': 'sine', 'profile.amplitude': 0.0025, 'profile.wavelength': 0.08,
        'profile.phase': math.pi, 'sweeper.velocity': (1.2, 0.0)}, 1.0, 3.0),
    RoadSubject('rough', 'tilted brush on ISO 8608 class C, 20 mm and longer', 0.6, {
        'brush.start_angle': math.pi, 'road.attack_angle': 0.087266, 'road.penetration': 0.03,
        'road.approach_time': 0.0, 'profile.kind': 'iso8608', 'profile.roughness_class': 'C',
        'profile.shortest': 0.02, 'profile.longest': 1.0, 'profile.seed': 7,
        'sweeper.velocity': (1.2, 0.0)}, 1.0, 3.0),
    RoadSubject('edge', 'level brush over an edge that falls away', 0.65, {
        'brush.start_angle': -0.5 * math.pi, 'road.penetration': 0.05, 'road.approach_time': 0.1,
        'gutter.enabled': True, 'gutter.kerb_distance': 0.14, 'gutter.channel_slope': 0.0,
        'gutter.kerb_height': -0.08, 'sweeper.velocity': (0.6, 0.0)}, 1.0, 4.0),
)
NAMES = tuple(subject.name for subject in SUBJECTS)
STEPS = (1e-3, 5e-4, 2e-4, 1e-4, 5e-5, 2e-5)
MESHES = (6, 8, 12, 16)
USUAL = (12, 1e-4)      # elements and ITS [s] at which the other things are varied
CONVERGED = (24, 2e-6)
SECOND = (20, 2e-6)     # with another integrator
FINE_STEP = 1e-5        # [s] at which meshes are refined alone
FINE_MESH = 32
TOLERANCES = (1e-4, 1e-5, 1e-6)


def subject_of(name):
    """Return the RoadSubject of a name."""
    return next(subject for subject in SUBJECTS if subject.name == name)


def road_duration(name):
    """Return how long a subject is simulated [s]."""
    return subject_of(name).duration


def road_scene(name, its, **solver):
    """Return the Scene of a subject with this step [s]; solver: keys of its solver section."""
    every = max(1, round(SAMPLE / its)) * its
    keys = {**BASE, **subject_of(name).keys, 'solver.integration_time_step': its,
            'run.chunk': every, 'run.sample': every,
            **{f'solver.{key}': value for key, value in solver.items()}}
    return from_parameters(keys, name)
