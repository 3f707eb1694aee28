"""
The scenes of the stability campaign: what a user could ask for, up to the ends of the ranges.

`listed()` takes three scenes of the brush through every parameter one at a time, and then through
pairs of extremes; draws.py adds scenes drawn at random from the same ranges. A case names only
what differs from its base scene.
"""
import math
from typing import NamedTuple

from .surfaces import EXTREMES, LISTED as SURFACES

RPM = math.pi / 30.0
DEGREE = math.pi / 180.0
STEEL = 2.07e11

BASES = {
    # level brush, damped, road rising: long contact with slip
    'level': {
        'road.penetration': 0.02, 'road.approach_time': 0.05, 'damping.stiffness': 1e-3,
        'drive.mean_speed': 100 * RPM, 'friction.static': 0.7, 'friction.kinetic': 0.27},
    # the paper's sweeping run, undamped: a train of hard impacts from 0.11 s on
    'tilted': {
        'road.penetration': 0.04, 'road.approach_time': 0.0, 'road.attack_angle': 10 * DEGREE,
        'brush.start_angle': math.pi, 'damping.mass': 0.0, 'friction.static': 0.5,
        'friction.kinetic': 0.5, 'drive.mean_speed': 150 * RPM, 'drive.alternating_speed': 4 * RPM,
        'contact.normal_stiffness': 1e4, 'sweeper.velocity': (1.5, 0.0)},
    # no road, no damping: nothing hides what the integrator does
    'free': {
        'contact.enabled': False, 'damping.mass': 0.0, 'drive.mean_speed': 150 * RPM,
        'drive.alternating_speed': 4 * RPM},
}
STEPS = 1_500_000    # of one case: what its limit lets it do on most machines
OF_CONTACT = ('contact.', 'friction.', 'road.', 'sweeper.')

# Parameter: the values it takes, in scene units; the first is the mildest.
AXES = {
    'damping.stiffness': (0.0, 1e-6, 1e-5, 1e-4, 1e-3, 1e-2, 0.021, 0.1, 1.0),
    'contact.normal_stiffness': (1e2, 1e3, 1e4, 1e6, 1e7, 1e8, 1e9, math.inf),
    'drive.mean_speed': tuple(rpm * RPM for rpm in (0, 1, 10, 300, 1000, 3000, -100, -3000)),
    'bristle.youngs_modulus': tuple(STEEL * f for f in (1e-3, 1e-2, 1e-1, 10.0, 1e2, 1e3)),
    'bristle.width': (5e-5, 1e-4, 2.5e-4, 1e-3, 2e-3, 5e-3),
    'bristle.length': (0.02, 0.05, 0.1, 0.5, 1.0),
    'solver.elements': (1, 2, 3, 4, 5, 6, 8, 16, 24, 48, 100),
    'solver.integration_time_step': (1e-7, 1e-6, 5e-6, 1e-5, 5e-5, 2e-4, 5e-4, 1e-3, 2e-3, 5e-3,
                                     1e-2),
    'solver.time_step': (1e-4, 1e-3, 5e-3, 1e-2, 5e-2),
    'friction.static': (0.0, 0.1, 1.0, 2.0, 5.0),
    'friction.decay': (0.0, 1.0, 10.0, 100.0),
    'road.penetration': (-0.01, 0.0, 0.001, 0.01, 0.08, 0.8),    # the last: 80 % of the bristle
    'road.attack_angle': tuple(b * DEGREE for b in (0, 5, 20, 40, 60, 80)),
    'brush.mount_orientation': tuple(g * DEGREE for g in (45, 90, 128, 180, -90)),
    'sweeper.velocity': ((0.0, 0.0), (5.0, 0.0), (-10.0, 0.0), (20.0, 0.0), (0.0, 20.0)),
    'solver.spectral_radius': (0.0, 0.3, 0.6, 0.9, 1.0),
    'solver.integrator': ('newmark', 'hht'),
    'gravity': (0.0,),
    'solver.start': ('steady',),
    'solver.load_case': ('displacement',),
    'solver.step': ('adaptive',),
}
# What goes together badly, on each base: pairs and triples of extremes.
CORNERS = (
    {'damping.stiffness': 1.0, 'solver.spectral_radius': 1.0},
    {'damping.stiffness': 1.0, 'contact.normal_stiffness': 1e9},
    {'damping.stiffness': 1.0, 'contact.normal_stiffness': math.inf},
    {'damping.stiffness': 1e-5, 'contact.normal_stiffness': 1e9},
    {'damping.stiffness': 0.0, 'contact.normal_stiffness': math.inf},
    {'damping.stiffness': 0.0, 'contact.normal_stiffness': 1e9, 'friction.static': 5.0},
    {'damping.stiffness': 0.0, 'solver.integration_time_step': 1e-2},
    {'damping.stiffness': 0.021, 'solver.integration_time_step': 1e-2},
    {'contact.normal_stiffness': math.inf, 'solver.integration_time_step': 1e-2},
    {'contact.normal_stiffness': 1e9, 'solver.integration_time_step': 1e-3},
    {'drive.mean_speed': 3000 * RPM, 'solver.integration_time_step': 1e-3},
    {'drive.mean_speed': 3000 * RPM, 'bristle.youngs_modulus': STEEL * 1e-3},
    {'drive.mean_speed': 3000 * RPM, 'bristle.length': 1.0},
    {'drive.mean_speed': 3000 * RPM, 'contact.normal_stiffness': math.inf},
    {'drive.mean_speed': -3000 * RPM, 'friction.static': 5.0},
    {'drive.mean_speed': 1000 * RPM, 'damping.stiffness': 1.0},
    {'drive.mean_speed': 1000 * RPM, 'solver.integration_time_step': 1e-2},
    {'bristle.youngs_modulus': STEEL * 1e-3, 'bristle.length': 1.0},
    {'bristle.youngs_modulus': STEEL * 1e-3, 'bristle.width': 5e-5},
    {'bristle.youngs_modulus': STEEL * 1e3, 'bristle.width': 5e-3},
    {'bristle.youngs_modulus': STEEL * 1e3, 'contact.normal_stiffness': 1e9},
    {'bristle.length': 0.02, 'bristle.width': 5e-3},
    {'bristle.length': 1.0, 'bristle.width': 5e-5},
    {'bristle.length': 0.02, 'solver.elements': 100},
    {'solver.elements': 100, 'solver.integration_time_step': 1e-2},
    {'solver.elements': 100, 'damping.stiffness': 1.0},
    {'solver.elements': 1, 'solver.integration_time_step': 1e-2},
    {'solver.elements': 1, 'contact.normal_stiffness': 1e9},
    {'solver.time_step': 5e-2, 'solver.integration_time_step': 1e-2},
    {'solver.time_step': 5e-2, 'damping.stiffness': 1.0},
    {'friction.static': 5.0, 'friction.kinetic': 0.0, 'friction.decay': 100.0},
    {'friction.static': 5.0, 'friction.kinetic': 5.0, 'contact.normal_stiffness': math.inf},
    {'friction.static': 0.0, 'contact.normal_stiffness': math.inf},
    {'friction.static': 5.0, 'road.penetration': 0.8},
    {'road.penetration': 0.8, 'contact.normal_stiffness': math.inf},
    {'road.penetration': 0.8, 'contact.normal_stiffness': 1e9, 'damping.stiffness': 0.0},
    {'road.penetration': 0.8, 'drive.mean_speed': 1000 * RPM},
    {'road.attack_angle': 80 * DEGREE, 'road.penetration': 0.8},
    {'road.attack_angle': 80 * DEGREE, 'contact.normal_stiffness': math.inf},
    {'brush.mount_orientation': 90 * DEGREE, 'drive.mean_speed': 3000 * RPM},
    {'brush.mount_orientation': 90 * DEGREE, 'road.penetration': 0.8},
    {'sweeper.velocity': (20.0, 0.0), 'friction.static': 5.0},
    {'sweeper.velocity': (20.0, 0.0), 'contact.normal_stiffness': math.inf},
    {'solver.load_case': 'displacement', 'solver.time_step': 1e-3, 'damping.stiffness': 0.021},
    {'solver.load_case': 'displacement', 'solver.time_step': 5e-2},
    {'solver.load_case': 'displacement', 'solver.integration_time_step': 1e-2},
    {'solver.load_case': 'displacement', 'drive.mean_speed': 3000 * RPM},
    {'solver.load_case': 'displacement', 'solver.integrator': 'newmark', 'solver.time_step': 1e-3},
    {'solver.step': 'adaptive', 'solver.integration_time_step': 1e-2},
    {'solver.step': 'adaptive', 'solver.error_tolerance': 1e-9},
    {'solver.step': 'adaptive', 'contact.normal_stiffness': math.inf},
)
# Speeds commanded while it runs; with an unlimited acceleration these are jumps.
COMMANDS = {
    'stop': (1e9, ((0.1, 'cmd_brush_speed', (0.0,)),)),
    'jump to 3000 rpm': (1e9, ((0.1, 'cmd_brush_speed', (3000 * RPM,)),)),
    'jump to -3000 rpm': (1e9, ((0.1, 'cmd_brush_speed', (-3000 * RPM,)),)),
    'reversal': (50.0, ((0.05, 'cmd_brush_speed', (-100 * RPM,)),
                        (0.15, 'cmd_brush_speed', (100 * RPM,)))),
    'road up and down': (50.0, ((0.1, 'cmd_penetration', (0.06,)),
                                (0.2, 'cmd_penetration', (-0.01,)))),
    'sweeper turns': (50.0, ((0.1, 'cmd_vel', (20.0, 0.0, 2.0)),
                             (0.2, 'cmd_vel', (0.0, 0.0, 0.0)))),
}
# Starts that touch the road, or nearly.
TOUCHING = (
    {'road.penetration': 0.0}, {'road.penetration': -1e-6},
    {'road.penetration': 0.0, 'contact.normal_stiffness': math.inf},
    {'road.penetration': 0.0, 'contact.normal_stiffness': 1e9, 'damping.stiffness': 0.0},
    {'road.penetration': 0.0, 'solver.start': 'steady'},
    {'road.penetration': 0.02, 'solver.start': 'steady', 'drive.mean_speed': 1.0},
    {'road.penetration': 0.02},     # inside: the one start that is refused
)


class Case(NamedTuple):
    """One scene of the campaign."""

    name: str
    parameters: dict        # dotted key to value
    duration: float         # [s] simulated
    commands: tuple = ()    # (t [s], topic, values)
    resets: tuple = ()      # t [s]
    drawn: bool = False     # at random


def make_case(name, base, changes, duration, commands=()):
    """Return the Case of a base scene with changes that fit together."""
    parameters = {**BASES[base], **changes}
    length = parameters.get('bristle.length', 0.24)
    depth = parameters.get('road.penetration')
    if depth is not None:
        # deep strokes and shorter bristles: the same part of the length
        parameters['road.penetration'] = depth * length if depth == 0.8 else depth * min(
            1.0, length / 0.24)
    if base == 'tilted' and (parameters['road.penetration'] > 0.04 * length / 0.24
                             or parameters['road.attack_angle'] < 9 * DEGREE):
        parameters['road.approach_time'] = 0.05     # it would start inside the road
    if parameters.get('friction.kinetic', 0.0) > parameters.get('friction.static', 0.7):
        parameters['friction.kinetic'] = parameters['friction.static']
    its = parameters.setdefault('solver.integration_time_step', 1e-4)
    for key in ('run.chunk', 'run.sample'):
        parameters[key] = its
    for key in ('solver.time_step', 'damping.stiffness'):
        if parameters.get(key) == 0.0:
            del parameters[key]     # the default
    if 'solver.time_step' in parameters:
        parameters['solver.time_step'] = max(1, round(parameters['solver.time_step'] / its)) * its
    duration = max(1, min(STEPS, round(duration / its))) * its
    commands = tuple((round(t / its) * its, topic, values) for t, topic, values in commands)
    return Case(f'{base}: {name}', parameters, duration, commands)


def spell_changes(changes):
    """Return what a case changes as a text."""
    return ', '.join(f'{spell_key(key)} {spell_value(value)}' for key, value in changes.items())


def spell_key(key):
    """Return a key's last part, or the paper's name where that part says too little."""
    return {'damping.stiffness': 'beta_D'}.get(key, key.rpartition('.')[2])


def spell_value(value):
    """Return a value as a short text."""
    if isinstance(value, tuple):
        return '/'.join(f'{part:g}' for part in value)
    if isinstance(value, str) and value.startswith('data:'):
        return f'{value.count(";") + 1} points'
    return value if isinstance(value, str) else f'{value:.3g}'


def applies(base, key):
    """Whether a key means anything in a base scene."""
    return base != 'free' or not key.startswith(OF_CONTACT)


def listed(duration=0.5):
    """Return the listed cases."""
    cases = []
    for base in BASES:
        for key, values in AXES.items():
            if applies(base, key):
                cases.extend(make_case(spell_changes({key: value}), base, {key: value}, duration)
                             for value in values)
        cases.extend(make_case(spell_changes(corner), base, corner, duration) for corner in CORNERS
                     if all(applies(base, key) for key in corner))
        for name, (limit, commands) in COMMANDS.items():
            if base != 'free' or commands[0][1] == 'cmd_brush_speed':
                cases.append(make_case(name, base, {'drive.max_acceleration': limit}, duration,
                                       commands))
    cases.extend(make_case('touching, ' + spell_changes(start), 'level',
                           {'road.approach_time': 0.0, **start}, duration) for start in TOUCHING)
    cases.extend(on_surfaces(duration))
    return cases


def on_surfaces(duration):
    """Return the cases of each listed surface with each extreme that goes badly with it."""
    return [make_case('on a surface, ' + spell_changes({**surface, **extreme}), 'level',
                      {'road.penetration': 0.05, 'sweeper.velocity': (1.0, 0.0), **surface,
                       **extreme}, duration)
            for surface in SURFACES for extreme in EXTREMES]


def short(duration=0.1):
    """Return a few cases that between them reach every branch of the stepper, for a quick look."""
    wanted = (
        ('level', {}), ('tilted', {}), ('free', {}),
        ('level', {'contact.normal_stiffness': math.inf}),
        ('level', {'contact.normal_stiffness': 1e9, 'damping.stiffness': 0.0}),
        ('level', {'damping.stiffness': 1.0}),
        ('level', {'friction.static': 5.0, 'friction.kinetic': 0.0, 'friction.decay': 100.0}),
        ('level', {'solver.integration_time_step': 1e-2}),
        ('level', {'solver.integration_time_step': 1e-3, 'contact.normal_stiffness': 1e7}),
        ('level', {'road.penetration': 0.8}),
        ('level', {'bristle.length': 0.02}), ('level', {'bristle.width': 5e-5}),
        ('level', {'bristle.youngs_modulus': STEEL * 1e-3}),
        ('level', {'solver.elements': 1}), ('level', {'solver.spectral_radius': 1.0}),
        ('level', {'solver.integrator': 'newmark'}), ('level', {'gravity': 0.0}),
        ('level', {'drive.mean_speed': -3000 * RPM}),
        ('level', {'brush.mount_orientation': 90 * DEGREE}),
        ('level', {'sweeper.velocity': (20.0, 0.0)}),
        ('tilted', {'road.attack_angle': 80 * DEGREE}),
        ('free', {'drive.mean_speed': 3000 * RPM}), ('free', {'damping.stiffness': 0.021}),
        ('free', {'solver.integration_time_step': 1e-2}),
    )
    cases = [make_case(spell_changes(changes) or 'as it is', base, changes, duration)
             for base, changes in wanted]
    cases.extend(on_surfaces(duration)[::13])
    cases.append(make_case('reversal', 'level', {'drive.max_acceleration': 1e9}, duration,
                           ((0.05, 'cmd_brush_speed', (-3000 * RPM,)),)))
    cases.append(make_case('inside the road', 'level', {'road.approach_time': 0.0}, duration))
    return cases
