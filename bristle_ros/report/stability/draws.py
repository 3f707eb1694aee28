"""Cases drawn at random: commands, resets, every scheme, surfaces, tables, rows, air."""
import math
import random

from bristle_ros.scene import from_parameters, SceneError

from .cases import applies, AXES, BASES, make_case, spell_changes, spell_value
from .surfaces import put_on_surface, SHARE, starts_inside

PACE = 1.5e5    # steps of an element per second that any machine does, on a surface half of them
FREE = 0.2      # of the cases have no road
TABLE = 0.15    # of the cases have a table of speeds
ROWS = 0.15     # of the cases have rows of bristles
AIR = 0.1       # of the cases turn in air, or in what is denser


def build_of(parameters):
    """Return which compiled functions the scene of `parameters` needs, as a tuple."""
    touches = parameters.get('contact.enabled', True)
    return (touches, touches and parameters.get('contact.points', 'wire'),
            bool(touches and parameters.get('gutter.enabled')),
            bool(touches and parameters.get('profile.kind', 'none') != 'none'),
            bool(parameters.get('damping.stiffness')), bool(parameters.get('air.density')),
            parameters.get('drive.profile') == 'table', 'brush.row_counts' in parameters)


def drawn(seed, count, duration=0.5, limit=20.0, builds=0):
    """
    Return `count` cases drawn at random: each changes two to six things of a base.

    On top of that, and each by itself: a surface, a table of speeds, rows of bristles, air, load
    case, integrator, load steps longer than ITS, commands within their limits, and a reset. What
    would last longer than its limit [s] is shorter: on most machines no case is cut off.

    builds : int    sets of compiled functions that they need together, the first ones that come;
    0: any number. One takes longer to compile than its cases to run
    """
    draw = random.Random(seed)
    cases, seen = [], set()
    while len(cases) < count:
        base = 'free' if draw.random() < FREE else draw.choice([*BASES][:-1])
        changes = _draw_changes(draw, base)
        case = make_case(f'drawn {seed}.{len(cases)}, {spell_changes(changes)}', base, changes,
                         duration)
        try:
            scene = from_parameters(case.parameters, case.name)
        except SceneError:
            continue    # what is refused tells nothing
        if starts_inside(scene):
            continue
        case = _with_surface(draw, _with_table(draw, case), base)
        if builds:
            build = build_of(case.parameters)
            if len(seen) < builds:
                seen.add(build)
            if build not in seen:
                continue
        its = case.parameters['solver.integration_time_step']
        case = case._replace(duration=min(round(case.duration / its), _most(case, limit)) * its)
        cases.append(_with_events(draw, case, base))
    return cases


def _draw_changes(draw, base):
    keys = [key for key in AXES if applies(base, key)]
    changes = {key: _draw_value(draw, AXES[key])
               for key in draw.sample(keys, draw.randint(2, 6))}
    changes.update(_draw_scheme(draw))
    if draw.random() < ROWS:
        changes.update(_draw_rows(draw, changes.get('bristle.length', 0.24)))
    if draw.random() < AIR:
        changes['air.density'] = draw.choice((1.2, 10.0, 100.0))
    if base != 'free':
        if 'brush.row_counts' in changes:   # one row or the other starts inside the road
            changes['road.approach_time'] = 0.05
        changes.update(_draw_contact(draw))
    return changes


def _most(case, limit):
    """Return how many steps of a case fit into its limit [s], about."""
    uneven = 'gutter.enabled' in case.parameters or 'profile.kind' in case.parameters
    bristles = sum(case.parameters.get('brush.row_counts', (1,)))
    return max(100, int((0.5 if uneven else 1.0) * PACE * limit
                        / (bristles * case.parameters.get('solver.elements', 12))))


def _changed(case, changes):
    return case._replace(parameters={**case.parameters, **changes},
                         name=f'{case.name}, {spell_changes(changes)}')


def _with_surface(draw, case, base):
    if base == 'free' or draw.random() >= SHARE:
        return case
    changes = put_on_surface(draw, case.parameters)
    return _changed(case, changes) if changes else case


def _with_table(draw, case):
    """Return a case whose brush turns as a table says: then it has no other speed."""
    if draw.random() >= TABLE:
        return case
    most = draw.choice((15.0, 50.0, 300.0))
    t, points = draw.uniform(-0.1, 0.1), []
    for _ in range(draw.randint(2, 8)):
        points.append(f'{t:.4f},{draw.uniform(-1.0, 1.0) * most:.4g}')
        t += draw.uniform(0.005, 0.2)
    kept = {key: value for key, value in case.parameters.items()
            if key not in ('drive.mean_speed', 'drive.alternating_speed')}
    return _changed(case._replace(parameters=kept), {
        'drive.profile': 'table', 'drive.file': 'data:' + ';'.join(points)})


def _draw_rows(draw, length):
    """Return two or three rows of a few bristles, about as long as the one would be [m]."""
    count = draw.randint(2, 3)

    def each(low, high):
        return tuple(round(draw.uniform(low, high), 5) for _ in range(count))
    rows = {'brush.row_radii': each(0.05, 0.15), 'brush.row_angles': each(0.2, 0.8),
            'brush.row_lengths': each(0.7 * length, 1.1 * length),
            'brush.row_orientations': each(-1.6, 1.6),
            'brush.row_offsets': (0.0, *each(-3.0, 3.0)[1:])}
    kept = {key: values for key, values in rows.items() if draw.random() < 0.6}
    return {**kept, 'brush.row_counts': tuple(draw.randint(1, 3) for _ in range(count))}


def _draw_contact(draw):
    """Return what touches: all of the wire, which is the default, or its tip."""
    if draw.random() < 0.3:
        return {'contact.points': draw.choice(('wire', 'tip'))}
    return {}


def _draw_scheme(draw):
    """Return drawn keys of load case and integrator."""
    changes = {}
    if draw.random() < 0.4:
        changes['solver.load_case'] = draw.choice(('inertia', 'displacement'))
    if draw.random() < 0.4:
        changes['solver.integrator'] = draw.choice(('generalized_alpha', 'newmark', 'hht'))
    if draw.random() < 0.3:     # of ITS; make_case makes it a whole multiple
        changes['solver.time_step'] = draw.choice((1e-4, 2e-4, 1e-3, 2e-3, 5e-3))
    return changes


def _with_events(draw, case, base):
    """Return a case with drawn commands and resets."""
    commands, resets, words = [], [], []
    length = case.parameters.get('bristle.length', 0.24)
    moving = case.parameters.get('solver.load_case') == 'displacement'
    if draw.random() < 0.35:
        speed = _in_range(draw, case.parameters.get('drive.max_speed', 320.0))
        commands.append(('cmd_brush_speed', (speed,)))
    if base != 'free' and draw.random() < 0.35:
        commands.append(('cmd_penetration', (round(draw.uniform(-0.2, 0.25) * length, 4),)))
    if base != 'free' and not moving and draw.random() < 0.25:
        commands.append(('cmd_vel', (draw.uniform(-10.0, 10.0), draw.uniform(-10.0, 10.0),
                                     draw.uniform(-2.0, 2.0))))
    if draw.random() < 0.2:
        resets.append(draw.uniform(0.1, 0.9) * case.duration)
    timed = sorted((round(draw.uniform(0.05, 0.9) * case.duration, 6), topic, values)
                   for topic, values in commands)
    words += [f'{topic.removeprefix("cmd_")} {spell_value(values)} at {t:.3g} s'
              for t, topic, values in timed]
    words += [f'reset at {t:.3g} s' for t in resets]
    return case._replace(commands=tuple(timed), resets=tuple(resets), drawn=True,
                         name=', '.join([case.name, *words]))


def _in_range(draw, limit):
    return round(draw.choice((-1.0, 1.0)) * limit * draw.random() ** 2, 4)


def _draw_value(draw, values):
    numbers = [v for v in values if isinstance(v, float) and 0.0 < v < math.inf]
    if draw.random() < 0.5 or len(numbers) < 2 or max(numbers) == 0.8:
        return draw.choice(values)
    low, high = math.log(min(numbers)), math.log(max(numbers))
    return float(f'{math.exp(draw.uniform(low, high)):.4g}')
