"""Claim by claim: what the paper says, what came out here, and whether it holds."""
import math


def _row(claim, paper, ours, holds, why):
    return {'claim': claim, 'paper': paper, 'ours': ours, 'holds': holds, 'why': why}


def _peak(damping, time_step_ms, its_us, integrator='Newmark 0.005'):
    for row in damping:
        if row['TS_ms'] == time_step_ms and row['ITS_us'] == its_us:
            return row.get(f'peak N, {integrator}', math.nan)
    return math.nan


def _worst(sensitivity, what, values):
    found = [row for row in sensitivity if row['what'] == what and row['value'] in values]
    if not found:
        return math.nan, math.nan
    return (max(row['tip_error_percent'] for row in found),
            max(row['impulse_error_percent'] for row in found))


def _says(pair):
    return f'tip {pair[0]:.2g} %, impulse per 5 ms {pair[1]:.2g} %'


def judge(friction, damping, cases, sensitivity, ratio):
    """Return the rows of the table of claims from what paper_claims.py measured."""
    coarse, fine = _peak(damping, 1.0, 10.0), _peak(damping, 0.01, 10.0)
    calm = _peak(damping, 1.0, 10.0, 'spectral radius 0')
    inertia = next((row.get('peak N, Newmark 0.005', math.nan) for row in damping
                    if row['TS_ms'] == 'inertia load case'), math.nan)
    its = _worst(sensitivity, 'ITS', ('10 us', '5 us'))
    loose = _worst(sensitivity, 'ITS', ('100 us',))
    mesh, coarse_mesh = _worst(sensitivity, 'elements', ('12',)), _worst(
        sensitivity, 'elements', ('6',))
    inertia_ts = _worst(sensitivity, 'TS, inertia', ('1 ms',))
    deep = next(row for row in cases if row['penetration_mm'] > 1.0)
    printed = next(row for row in cases if row['penetration_mm'] < 1.0)
    return [
        _row('friction follows eq. (1) with 0.70, 0.27, 0.40 s/m', 'figure 3',
             f'law reproduced to {friction:.1g}', 'yes',
             'the three measured points themselves are only in the figure'),
        _row('damping force at the clamp is positive and below 0.05 N', '< 0.05 N',
             f'{inertia:.3g} N', _yes(inertia < 0.05), 'inertia load case, start-up peak'),
        _row('displacement load case, TS 1 ms: huge damping forces', 'about -140 N',
             f'{coarse:.3g} N with Newmark, {calm:.3g} N with spectral radius 0',
             _yes(30.0 < coarse < 300.0),
             'ringing of an undamped integrator on the true jump r w^2 TS at each corner; not a '
             'property of the load case'),
        _row('displacement load case converges for TS < 0.01 ms', 'TS < 0.01 ms',
             f'{fine:.3g} N at TS = ITS = 0.01 ms', _yes(fine < 0.05),
             'because TS is then the ITS: with a smaller ITS it rings again at the same TS'),
        _row('inertia load case: TS < 1 ms is enough', 'TS < 1 ms', _says(inertia_ts),
             _yes(inertia_ts[0] < 1.0 and inertia_ts[1] < 5.0), 'at TS = 1 ms'),
        _row('ITS of at most 5 to 10 us', '5 to 10 us', f'{_says(its)}; at 0.1 ms {_says(loose)}',
             _yes(its[0] < 1.0 and its[1] < 3.0),
             'needed by their contact; a passive contact step allows more'),
        _row('12 elements are appropriate', '12', f'{_says(mesh)}; with 6: {_says(coarse_mesh)}',
             _yes(mesh[0] < 1.0), 'quadratic elements in both'),
        _row('both load cases give practically the same results', 'figure 5',
             f'tip {deep["tip_until_touch_percent"]:.2g} % apart until the first touch; impulse '
             f'{deep["impulse_inertia_mNs"]:.4g} and {deep["impulse_displacement_mNs"]:.4g} mN s',
             _yes(deep['tip_until_touch_percent'] < 1.0
                  and abs(deep['impulse_displacement_mNs'] / deep['impulse_inertia_mNs'] - 1)
                  < 0.05), 'after some impacts an undamped path repeats only on average'),
        _row('penetration 0.04 mm', '0.04 mm, with a contact force in figure 5',
             f'normal impulse {printed["impulse_inertia_mNs"]:.3g} mN s at 0.04 mm, '
             f'{deep["impulse_inertia_mNs"]:.3g} mN s at 40 mm',
             _yes(printed['impulse_inertia_mNs'] > 0.1),
             'spin lifts the tip by about 10 mm: 40 mm must be meant'),
        _row('the inertia load case needs much less computing', 'much less',
             f'{ratio["ratio"]:.2g} times at {ratio["error_percent"]:.2g} % error',
             _yes(ratio['ratio'] > 1.5),
             'at equal error of the tip, free rotation at 150 rpm'),
    ]


def _yes(condition):
    return 'yes' if condition else 'no'
