"""What the assumption that the tip alone touches costs: mean forces of one wire, both ways."""
import math

from bristle_ros.report.figure import legend, new_panel, plot, svg
from bristle_ros.report.workers import Failed, Job
from bristle_ros.scene import from_parameters
import numpy as np

from .subjects import BASE

POINTS = 'contact.points'
WAYS = {'wire': 'whole wire', 'tip': 'tip alone'}
TIP_CIRCLE = 0.1125 + 0.240 * math.sin(0.4537856)   # [m] radius that the tips go round on
TURN = 0.6              # [s] at 100 rpm
SETTLE = 0.5            # of a turn left out after the approach
STEP = 1e-4             # [s]
SAMPLE = 1e-3           # [s]
BESIDE_KERB = {
    'road.attack_angle': 0.139626, 'road.penetration': 0.06, 'brush.start_angle': -0.5 * math.pi,
    'gutter.enabled': True}
MEASURES = {'normal': 'mean normal force of a wire [N]', 'torque': 'mean drive torque [N m]'}


def _deg(angles):
    return [(angle, {'road.penetration': 0.12, 'road.attack_angle': math.radians(angle)})
            for angle in angles]


# What is swept: its axis, and (value, keys of the scene).
SWEEPS = {
    'penetration': ('penetration, level brush [mm]', [
        (depth, {'road.penetration': 1e-3 * depth})
        for depth in (20, 40, 60, 80, 100, 120, 130, 140, 150, 160, 170)]),
    'tilt': ('tilt, penetration 120 mm [deg]', _deg((0, 2, 4, 6, 8, 10, 14, 18, 22))),
    'kerb': ('kerb inside the circle of the tips [mm]', [
        (reach, {**BESIDE_KERB, 'gutter.kerb_distance': TIP_CIRCLE - 1e-3 * reach})
        for reach in (0, 20, 40, 60, 80, 100, 120, 140, 160)]),
}


def mean_forces(keys, ways):
    """
    Return the mean normal and side force [N] and drive torque [N m] of a wire; in a worker.

    Over a whole turn, after the approach and half a turn.  ways : 'wire' or 'tip'
    """
    from bristle_ros.simulation import Simulation
    scene = from_parameters({
        **BASE, 'road.approach_time': 0.1, **keys, POINTS: ways,
        'solver.integration_time_step': STEP, 'run.chunk': SAMPLE, 'run.sample': SAMPLE}, ways)
    simulation = Simulation(scene)
    begin = round((scene.road.approach_time + SETTLE * TURN) / STEP)
    simulation.advance(begin)
    first = last = simulation.snapshot()
    torques = []
    for _ in range(round(TURN / SAMPLE)):
        simulation.advance(round(SAMPLE / STEP))
        last = simulation.snapshot()
        torques.append(-float(last.brush_torque[2]))
    impulse = last.contact_impulse[0] - first.contact_impulse[0]
    return {'normal': float(impulse[2] / TURN), 'side': float(np.hypot(*impulse[:2]) / TURN),
            'torque': float(np.mean(torques))}


def measure(context):
    """Return {sweep: rows of a value and the forces both ways}."""
    wanted = [(sweep, value, keys, way) for sweep, (_, values) in SWEEPS.items()
              for value, keys in (values[::2] if context.quick else values) for way in WAYS]
    found = context.crew.run([Job(mean_forces, (keys, way), f'{sweep} {value:g}, {way}')
                              for sweep, value, keys, way in wanted])
    rows = {sweep: {} for sweep in SWEEPS}
    for (sweep, value, _, way), forces in zip(wanted, found):
        rows[sweep].setdefault(value, {})[way] = (
            {'failed': forces.reason} if isinstance(forces, Failed) else forces)
    return {sweep: [{'value': value, **ways} for value, ways in values.items()]
            for sweep, values in rows.items()}


def differences(data):
    """Return rows: what both ways give, and the tip's way against the whole wire's [%]."""
    rows = []
    for sweep, found in data.items():
        for row in found:
            wire, tip = row['wire'], row['tip']
            both = not ('failed' in wire or 'failed' in tip)
            rows.append({
                'sweep': SWEEPS[sweep][0], 'value': row['value'],
                **{f'{key}_{way}': row[way].get(key) for key in MEASURES for way in WAYS},
                **{f'{key}_off': 100.0 * (tip[key] / wire[key] - 1.0) if both and wire[key]
                   else None for key in MEASURES},
                'remark': '; '.join(part['failed'] for part in (wire, tip) if 'failed' in part)})
    return rows


def _panel(sweep, rows, key):
    figure, axes = new_panel('', SWEEPS[sweep][0], MEASURES[key])
    for way, label in WAYS.items():
        good = [row for row in rows if key in row[way]]
        plot(axes, label, [row['value'] for row in good], [row[way][key] for row in good])
    axes.set_ylim(bottom=min(0.0, axes.get_ylim()[0]))
    return svg(figure, f'{MEASURES[key]} against {SWEEPS[sweep][0]}, whole wire and tip alone')


def show(page, data):
    """Put it on the page, where it was measured."""
    if not data:
        return
    page.heading('What contact at the tip alone costs', 3)
    page.explain('One wire at 100 rpm, friction 0.5, mean of a turn: with contact anywhere along '
                 'it, and with contact at the tip alone.')
    for key, title in MEASURES.items():
        page.figure([_panel(sweep, rows, key) for sweep, rows in data.items()],
                    f'{title[0].upper()}{title[1:]} over penetration, tilt and kerb.',
                    legend(WAYS.values()))
    rows = [row for row in differences(data) if row['normal_off'] is not None]
    if rows:
        worst = max(rows, key=lambda row: abs(row['normal_off']))
        near = sum(abs(row['normal_off']) < 1.0 for row in rows)
        page.says(f'Largest difference of the mean normal force: {worst["normal_off"]:.3g} % at '
                  f'{worst["value"]:g}, {worst["sweep"]}; {near} of {len(rows)} differ by less '
                  'than 1 %.')
    page.table('road_assumption', differences(data), {
        'sweep': 'what changes', 'value': 'to', 'normal_wire': 'normal force, whole wire [N]',
        'normal_tip': 'normal force, tip alone [N]', 'normal_off': 'difference [%]',
        'torque_wire': 'torque, whole wire [N m]', 'torque_tip': 'torque, tip alone [N m]',
        'torque_off': 'difference of it [%]', 'remark': 'remark'},
        'Mean forces of one wire both ways; differences are of the tip alone.')
