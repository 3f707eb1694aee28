"""
Claim by claim: the paper's words, how they are read, what came out, and the verdict on it.

Quotations are from the paper's abstract and sections 3 to 5. Every verdict is an expression of
values, their intervals and the thresholds named here.
"""
import math

from bristle_ros.report.curves import Point, ratio_at
from bristle_ros.report.timing import group_slowness
from bristle_ros.report.verdict import (at_least, at_most, between, either, every, exact, Measured,
                                        spread, widen)

from .experiments import LIKE_PAPER
from .measure import DEEP

FORCE = 0.05            # [N] of the paper: damping forces are positive and less
ORDER = math.sqrt(10.0)     # 'of the order of': within this factor
HUGE = 140.0            # [N] of the paper
TIP, IMPULSE = 1.0, 5.0     # [%] of path and impulse: 'practically', 'appropriate', 'acceptable'
MUCH = 2.0              # times: 'much less'
LEVELS = {'path': (1.0, 0.3, 0.1), 'force': (20.0, 14.0, 8.0)}      # [%]


def _row(claim, reading, measured, verdict, cause=''):
    return {'claim': claim, 'reading': reading, 'measured': measured, 'verdict': verdict,
            'cause': cause}


def _of(rows, **wanted):
    return [row for row in rows if all(row[key] == value for key, value in wanted.items())]


def judge(data):
    """Return the rows of the table of claims from what measure.py found."""
    return [*_friction(data), *_forces(data['damping']), *_polygon(data['damping']),
            *_sensitive(data['sensitivities']), *_figure5(data['load_cases']),
            *_cost(data), _row('the modelling of damping may be more realistic', 'a judgement on '
                               'real bristles, which nothing here was measured on', '',
                               at_least(None, 0.0))]


def _friction(data):
    worst = max((each['worst'] for each in data['friction']), default=None)
    return [_row('The validation process yields: μk = 0.27, μs = 0.70, and cv = 0.40 s/m',
                 'a fit of three measured points, which the paper shows only in a figure',
                 'simulated tips deviate from eq. (1) with these numbers by at most '
                 + (f'{worst:.2g}' if worst is not None else 'an unknown amount'),
                 at_least(None, 0.0))]


def _forces(rows):
    found = _of(rows, load_case='inertia', TS=0.0)
    if not found:
        return []
    highest, lowest = spread([row['high'] for row in found]), spread([row['low'] for row in found])
    early = spread([row['early_low'] for row in found])
    early_high = spread([row['early_high'] for row in found])
    share = spread([100 * row['positive_share'] for row in found])
    return [
        _row('the damping forces should be positive and less than 0.05 N',
             'every value in the first 10 ms of the inertia load case (what time the figure shows '
             'is in the figure alone), all integrators and steps of this run',
             f'least {early} N, largest {early_high} N',
             every(at_least(early, 0.0), at_most(early_high, FORCE))),
        _row('the damping forces should be positive and less than 0.05 N: later',
             f'every value of {found[0]["duration"]:g} s',
             f'least {lowest} N, largest {highest} N; positive {share} % of the time',
             every(at_least(lowest, 0.0), at_most(highest, FORCE)))]


def _polygon(rows):
    like = [row for row in _of(rows, load_case='displacement')
            if row['integrator'] in LIKE_PAPER]
    coarse = [row for row in like if row['TS'] == 1e-3]
    damped = _of(rows, load_case='displacement', TS=1e-3, integrator='spectral radius 0')
    if not coarse or not damped:
        return []
    peaks = spread([abs(row['extreme']) for row in coarse])
    calm = spread([abs(row['extreme']) for row in damped])
    tip = spread([row['tip_error'] for row in coarse])
    whole = spread([row['whole_error'] for row in coarse])
    found = [
        _row('when δt = 1 ms, damping forces of the order of -140 N are generated',
             f'the largest magnitude within a factor {ORDER:.2g} of 140 N, for integrators as the '
             "paper's program has them and all steps of this run; signs depend on axes that the "
             'paper does not give', f'{peaks} N', between(peaks, HUGE / ORDER, HUGE * ORDER),
             f'with an integrator of spectral radius 0, on the same polygon: {calm} N'),
        _row('errors relatively small in the Degree of Freedom (DOF) results, but it may produce '
             'huge errors in the forces and moments, particularly the damping components',
             f'TS 1 ms: tip path off by at most {TIP:g} %, damping force by at least {FORCE:g} N',
             f'path {tip} %, damping force {peaks} N',
             every(at_most(tip, TIP), at_least(peaks, FORCE))),
        _row('The static and inertia components of the forces and moments are also affected ...; '
             'nevertheless, their values are much smaller than the damping components',
             'this program gives the clamp force as a whole, from the momentum of the wire, and '
             'does not part it', f'TS 1 ms: clamp force off by {whole} N, its damping component '
             f'by {peaks} N', at_least(None, 0.0))]
    fine = [row for row in like if 0.0 < row['TS'] < 1e-5]
    if fine:
        worst = max(fine, key=lambda row: abs(row['extreme']))
        largest = abs(worst['extreme'])
        equal = spread([abs(row['extreme']) for row in fine if row['TS'] == row['ITS']])
        found.append(_row(
            'convergence is achieved when δt < 0.01 ms',
            f'the damping force is below {FORCE:g} N for every TS below 0.01 ms and every ITS up '
            'to it that was run', f'largest {largest:.3g} N, at TS {1e6 * worst["TS"]:g} us and '
            f'ITS {1e6 * worst["ITS"]:g} us ({len(fine)} runs)', at_most(exact(largest), FORCE),
            f'with TS = ITS, where all points lie on the circle: {equal} N'))
    return found


def _errors(found, what, values):
    """Return the Measured worst errors of path and impulse of some values, or None."""
    rows = [row for row in found['rows'] if row['what'] == what and row['value'] in values]
    if not rows or not found['own']:
        return None, None
    return tuple(Measured(worst, max(0.0, worst - own), worst + own) for worst, own in zip(
        (max(row['tip'] for row in rows), max(row['impulse'] for row in rows)), found['own']))


def _good(pair):
    return every(at_most(pair[0], TIP), at_most(pair[1], IMPULSE))


def _text(pair):
    return f'path {pair[0]} %, impulse per 5 ms {pair[1]} %'


def _sensitive(found):
    limits = f'error of the path at most {TIP:g} %, of the impulse per 5 ms {IMPULSE:g} %'
    small, mesh = _errors(found, 'ITS', (1e-5, 5e-6)), _errors(found, 'elements', (12,))
    ts = _errors(found, 'TS, inertia', (1e-3, 5e-4))
    larger = [(value, _errors(found, 'ITS', (value,)))
              for value in sorted({row['value'] for row in found['rows'] if row['what'] == 'ITS'})
              if value > 1e-5]
    beyond = [either(at_least(errors[0], TIP), at_least(errors[1], IMPULSE))
              for _, errors in larger]
    return [
        _row('an appropriate maximum limit for the ITS is 5 to 10 μs: enough', limits,
             _text(small), _good(small)),
        _row('an appropriate maximum limit for the ITS is 5 to 10 μs: needed',
             'every longer ITS that was run exceeds one of these limits; sweeping run with 1 ms '
             'of damping', '; '.join(f'{1e6 * value:g} us: {_text(errors)}'
                                     for value, errors in larger), every(*beyond)),
        _row('12 beam elements is an appropriate number', limits, _text(mesh), _good(mesh)),
        _row('for the InerLC, convergence is practically achieved at least when δt < 1 ms',
             f'TS 1 ms and 0.5 ms: {limits}', _text(ts), _good(ts))]


def _figure5(rows):
    found = []
    for row in rows:
        impulses = row['impulses']
        if row['penetration'] == DEEP and row['first_touch'] is not None:
            path = spread(row['until_touch'])
            apart = spread([100 * abs(b / a - 1.0) for a, b in impulses])
            scatter = [100 * abs(a / impulses[0][0] - 1.0) for a, _ in impulses[1:]]
            found.append(_row(
                'When these values are used, both models provide practically the same results',
                f'TS 1 ms and 0.01 ms, figure 5: path until the first touch within {TIP:g} %, '
                f'normal impulse within {IMPULSE:g} %; start angles 1e-4 rad apart',
                f'path {path} %, impulse {apart} % apart',
                every(at_most(path, TIP), at_most(apart, IMPULSE)),
                f'the start angle alone changes the impulse by up to {max(scatter):.2g} %'
                if scatter else ''))
        elif row['penetration'] != DEEP:
            impulse = 1e3 * impulses[0][0]
            deep = [other for other in rows if other['penetration'] == DEEP]
            found.append(_row(
                'brush penetration ..., Δ = 0.04 mm',
                'with it the tip touches the road, as figure 5(a) shows: normal impulse above 0',
                f'{impulse:.3g} mN s',
                at_least(exact(impulse), 1e-9),
                f'at 40 mm: {1e3 * deep[0]["impulses"][0][0]:.3g} mN s' if deep else ''))
    return found


def cost_points(rows, load_case):
    """Return the Points of a load case's rows."""
    return [Point(row['error'], tuple(row['timing']['walls'])) for row in rows
            if row['load_case'] == load_case and row.get('timing')]


def cost_ratios(found, levels):
    """Return [(level, Measured displacement over inertia, or None)]."""
    wider = group_slowness(row.get('timing') for row in found['rows'])
    return [(level, widen(ratio_at(cost_points(found['rows'], 'displacement'),
                                   cost_points(found['rows'], 'inertia'), level,
                                   (found['own'], found['own'])), wider)) for level in levels]


def _cost(data):
    found = []
    for name, key, what in (('path', 'rotation_cost', 'tip path of the free rotation'),
                            ('force', 'force_cost', 'damping force at the clamp, figure 4')):
        ratios = cost_ratios(data[key], LEVELS[name])
        said = '; '.join(f'at {level:g} % error {ratio} times' if ratio else
                         f'{level:g} % error is not reached, or not clear'
                         for level, ratio in ratios)
        found.append(_row(
            'applying inertia loads may be more suitable ..., because much less computational '
            'resources are needed',
            f'run time on the polygon (TS = ITS and TS > ITS) over that of the inertia load case '
            f'at equal error of the {what}, each at its own best settings, at least {MUCH:g} '
            'times at each of three errors', said,
            every(*(at_least(ratio, MUCH) for _, ratio in ratios))))
    return found
