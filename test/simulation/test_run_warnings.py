"""Each warning has a scene that gives it and no other; the scenes of config/ what they deserve."""
from pathlib import Path
import warnings

import bristle_ros
from bristle_ros.log.recording import Recording
from bristle_ros.messages.encode import decode_event
from bristle_ros.simulation.run_warnings import RunWatch
from bristle_ros.simulation.simulation import Simulation
from bristle_ros.verbs.verify import verify
import numpy as np
import pytest

CONFIG = Path(__file__).resolve().parents[2] / 'config'
SIX = {'solver.elements': 6}
LONG_STEPS = {'solver.integration_time_step': 2e-3, 'run.chunk': 2e-3, 'run.sample': 2e-3}
# 0.1 s in steps down to 0.1 ms: too long for an undamped wire that hits a rigid road
HARD = {**SIX, 'solver.integration_time_step': 0.1, 'run.chunk': 0.1, 'run.sample': 0.1,
        'solver.step': 'adaptive', 'contact.normal_stiffness': float('inf')}


def warned(scene, duration, overrides=None, **arguments):
    """Return what a run of a scene of config/ warns of: kind -> text."""
    with warnings.catch_warnings(record=True) as caught:
        warnings.simplefilter('always')
        bristle_ros.simulate(CONFIG / f'{scene}.yaml', duration, overrides=overrides, **arguments)
    assert all(isinstance(one.message, bristle_ros.RunWarning) for one in caught)
    assert not any('\n' in str(one.message) for one in caught)
    return {one.message.kind: str(one.message) for one in caught}


@pytest.mark.parametrize(('kind', 'scene', 'duration', 'overrides', 'said'), [
    ('wire below the road', 'cutting_brush', 0.5, {
        **SIX, 'brush.mount_angle': 1.3, 'road.penetration': 0.05, 'drive.mean_speed': 0.0,
        'contact.points': 'tip'},
     'bristle 0 was 3.19 mm below'),
    ('tip deep in the road', 'cutting_brush', 0.6, {**SIX, 'contact.normal_stiffness': 10.0},
     '5.96 mm deep'),
    ('clamp stress', 'cutting_brush', 0.6, {**SIX, 'bristle.yield_stress': 1e8},
     'reached 157.8 MPa, at t = 0.26 s, above bristle.yield_stress = 100 MPa'),
    ('never touched', 'cutting_brush', 0.6, {**SIX, 'road.penetration': 0.0},
     'no tip touched the road in 0.6 s'),
    ('not settled', 'cutting_brush', 0.24, SIX, 'means of 0.2 to 0.24 s'),
    ('sub-stepped', 'cutting_brush', 0.6, {**SIX, **LONG_STEPS}, 'of 300 fixed steps'),
    ('finest sub-steps', 'tilted_sweep', 1.0, HARD, 'of 10 steps'),
    # an undamped midpoint rule on a nonlinear wire; in free flight, where no impact decides what
    # a processor's last bit makes of it
    ('energy from nowhere', 'free_rotation', 0.5, {
        **SIX, 'solver.spectral_radius': 1.0, 'drive.mean_speed': 150.0, 'solver.step': 'adaptive',
        'bristle.yield_stress': 0.0}, 'the energy accounts gained'),
    ('energy from nowhere', 'free_rotation', 0.5, {
        **SIX, 'solver.spectral_radius': 1.0, 'drive.mean_speed': 150.0, 'solver.step': 'adaptive',
        'bristle.yield_stress': 0.0, 'solver.load_case': 'displacement'},
     'the energy accounts gained'),
    ('few elements', 'cutting_brush', 0.6, {'solver.elements': 5}, 'solver.elements = 5'),
    ])
def test_each_warning_comes_alone(kind, scene, duration, overrides, said):
    found = warned(scene, duration, overrides)
    assert set(found) == {kind}
    assert said in found[kind]
    assert found[kind].endswith('would do')


@pytest.mark.parametrize(('scene', 'duration', 'deserved'), [
    ('cutting_brush', 1.0, set()), ('damping_study', 0.5, set()), ('free_rotation', 0.5, set()),
    ('tilted_sweep', 0.6, set()),
    # it meets the road after 0.11 s
    ('tilted_sweep', 0.1, {'never touched', 'not settled'}),
    # the road comes up until 0.2 s
    ('cutting_brush', 0.05, {'never touched'}), ('full_brush', 0.22, set())])
def test_scenes_of_config(scene, duration, deserved):
    assert set(warned(scene, duration)) == deserved


def test_the_yield_stress_can_be_left_out():
    assert not warned('cutting_brush', 0.6, {**SIX, 'bristle.yield_stress': 0.0})


def test_extremes_between_samples_count():
    """With one sample at the end, the stress that is told is the same."""
    overrides = {**SIX, 'bristle.yield_stress': 1e8}
    found = warned('cutting_brush', 0.6, overrides, sample=0.6)
    assert 'reached 157.8 MPa' in found['clamp stress']


def test_a_log_has_its_warnings_and_can_still_be_verified(tmp_path):
    log = tmp_path / 'run.mcap'
    found = warned('cutting_brush', 0.05, {'solver.elements': 5}, output=log)
    events = [decode_event(entry.message.data) for entry in Recording(log).entries()
              if entry.name == '~/events']
    told = {event['kind']: event['text'] for event in events if event['event'] == 'warning'}
    assert told == found
    assert len(found) == 2
    assert events[-1]['step'] == 500
    verdict = verify(log)
    assert verdict.difference == ''


def test_means_are_those_of_the_arrays():
    """Of the normal force that of all steps, from the impulse; of the others of the samples."""
    simulation = Simulation(bristle_ros.load(CONFIG / 'cutting_brush.yaml', SIX))
    watch, torques, powers = RunWatch(simulation), [], []
    impulse = {}
    for _ in range(400):
        simulation.advance(10)
        sample = simulation.snapshot()
        watch.take(sample)
        impulse[round(sample.t, 6)] = sample.contact_impulse[0, 2]
        if sample.t > 0.2005:
            torques.append(-sample.brush_torque[2])
            powers.append(-sample.brush_torque[2] * sample.omega)
    assert watch.window == pytest.approx((0.2, 0.4))
    normal, torque, power = watch.means
    assert normal.mean == pytest.approx((impulse[0.4] - impulse[0.2]) / 0.2, rel=1e-9)
    assert torque.mean == pytest.approx(np.mean(torques), rel=1e-9)
    assert power.mean == pytest.approx(np.mean(powers), rel=1e-9)


def test_a_reset_begins_anew():
    overrides = {**SIX, 'bristle.yield_stress': 1e8}
    commands = [(0.5, 'reset', ())]
    found = warned('cutting_brush', 0.55, overrides, commands=commands)
    assert set(found) == {'never touched'}
    assert 'in 0.05 s' in found['never touched']
