"""Cases of the campaign that are drawn at random, with commands, resets and every scheme."""
import math
import random

from .cases import applies, AXES, BASES, make_case, spell_changes, spell_value

PACE = 1.5e5   # steps of an element per second that any machine does


def drawn(seed, count, duration=0.5, limit=20.0):
    """
    Return `count` cases drawn at random: each changes two to six things of a base.

    On top of that, and each by itself: load case, integrator, load steps longer than ITS,
    commands within their limits, and a reset. What would last longer than its limit [s] is
    shorter: on most machines no case is cut off.
    """
    draw = random.Random(seed)
    cases = []
    for number in range(count):
        base = draw.choice(list(BASES))
        keys = [key for key in AXES if applies(base, key)]
        changes = {}
        for key in draw.sample(keys, draw.randint(2, 6)):
            changes[key] = _draw_value(draw, AXES[key])
        changes.update(_draw_scheme(draw))
        case = make_case(f'drawn {seed}.{number}, {spell_changes(changes)}', base, changes,
                         duration)
        its = case.parameters['solver.integration_time_step']
        most = max(100, int(PACE * limit / case.parameters.get('solver.elements', 12)))
        case = case._replace(duration=min(round(case.duration / its), most) * its)
        cases.append(_with_events(draw, case, base))
    return cases


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
