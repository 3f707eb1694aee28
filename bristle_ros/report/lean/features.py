"""What each feature of a scene costs: run times of one scene with each of them changed."""
from dataclasses import replace
import math

from bristle_ros.verbs import measure

from .page import new_figure
from .work_precision import scene_of


def _set(section, **values):
    return lambda scene: replace(scene, **{section: replace(getattr(scene, section), **values)})


CHANGES = {
    'as it is': lambda scene: scene,
    'no contact': _set('contact', enabled=False),
    'rigid road': _set('contact', normal_stiffness=math.inf),
    'no friction': _set('friction', static=0.0, kinetic=0.0),
    'constant friction': _set('friction', static=0.5, kinetic=0.5),
    'no damping at all': _set('damping', mass=0.0, stiffness=0.0),
    'no beta_D': _set('damping', stiffness=0.0),
    'no alpha_D': _set('damping', mass=0.0),
    'no gravity': lambda scene: replace(scene, gravity=0.0),
    'tilted 10 deg': _set('road', attack_angle=math.radians(10.0)),
    'sweeper at 1.5 m/s': _set('sweeper', velocity=(1.5, 0.0)),
    'constant speed': _set('drive', profile='constant'),
    'sine 4 rpm': _set('drive', alternating_speed=0.42),
    'VAP 4 rpm': _set('drive', profile='vap', alternating_speed=0.42),
    'TS 1 ms': _set('solver', time_step=1e-3),
    'displacement load case': _set('solver', load_case='displacement'),
    'adaptive steps': _set('solver', step='adaptive'),
    '6 elements': _set('solver', elements=6),
    '24 elements': _set('solver', elements=24),
    '2 bristles': _set('brush', bristle_count=2),
    '8 bristles': _set('brush', bristle_count=8),
}


def costs(progress, *, quick=False, repeats=5):
    """Return rows: run times of cutting_brush with each feature changed."""
    from bristle_ros.simulation import Simulation, StepFailure
    scene = scene_of('cutting_brush', 1e-4)
    rows = []
    for name, change in CHANGES.items():
        progress(f'cost of features: {name}')
        simulation = Simulation(change(scene))
        try:
            found = measure(simulation, 0.15 if quick else 0.3, 3 if quick else repeats)
        except StepFailure as failure:
            rows.append({'scene': name, 'note': str(failure)})
            continue
        rows.append({
            'scene': name, 'step_us': found['step_us'], 'newton_us': found['newton_us'],
            'newton_per_step': found['newton_per_step'], 'substeps': found['substeps'],
            'times_real_time': found['real_time_factor']['mean'],
            'chunk_p50_us': 1e6 * found['chunk_time_s']['p50'],
            'chunk_p99_us': 1e6 * found['chunk_time_s']['p99'],
            'ready_after_s': found['compile_time'], 'note': ''})
    return rows


def draw(rows):
    """Return a bar figure of step times."""
    # several bristles have a scale of their own: the table tells
    rows = [row for row in rows if 'step_us' in row and 'bristles' not in row['scene']]
    figure, axes = new_figure(1, 1, 9.0, 0.6 + 0.22 * len(rows))
    panel = axes[0, 0]
    names = [row['scene'] for row in rows][::-1]
    panel.barh(names, [row['step_us'] for row in rows][::-1], color='#7aa6d1', height=0.65)
    for i, row in enumerate(rows[::-1]):
        panel.annotate(f'{row["step_us"]:.3g}', (row['step_us'], i), xytext=(3, -3),
                       textcoords='offset points', fontsize=8,
                       bbox={'fc': 'w', 'ec': 'none', 'pad': 0.8})
    panel.axvline(rows[0]['step_us'], color='k', lw=0.8)
    panel.set_xlabel('wall time of a step of 0.1 ms [us], the whole scene')
    panel.margins(x=0.12, y=0.02)
    return figure
