"""Studies as a whole: through batches, parts and the analysis of the table."""
import math
import os

from bristle_ros import open_study
from bristle_ros.scene import SceneError
from bristle_ros.study import store
from bristle_ros.study.answer import answer
from bristle_ros.study.batch import run_batch, run_scene
from bristle_ros.study.campaign import carry_out
from bristle_ros.study.measure import MEASURES
from bristle_ros.study.page import write_page
from bristle_ros.study.sensitivity import indices
import numpy as np
import pytest

ANGLES = """
vary:
  brush.start_angle: {{from: -3.141592653589793, to: 3.141592653589793}}
  brush.mount_orientation: {{from: -3.141592653589793, to: 3.141592653589793}}
  road.tilt_azimuth: {{from: -3.141592653589793, to: 3.141592653589793}}
design: {}
samples: {}
duration: 1.0
"""


def ishigami(study, scene):
    """Ishigami and Homma (1990) with a = 7, b = 0.1, as if it were a torque."""
    a, b, c = scene.brush.start_angle, scene.brush.mount_orientation, scene.road.tilt_azimuth
    value = math.sin(a) + 7.0 * math.sin(b) ** 2 + 0.1 * c ** 4 * math.sin(a)
    return dict.fromkeys(MEASURES, 0.0) | {'drive_torque_mean': value, 'settled': 'yes'}, None


def table(folder):
    return store.table(folder).drop_columns(['wall_time']).to_pylist()


def test_indices_of_a_closed_form(study_of, client, tmp_path):
    study = study_of(ANGLES.format('saltelli', 512))
    assert carry_out(study, tmp_path / 'out', client, run=ishigami)
    found = indices(study, tmp_path / 'out')[0]['drive_torque_mean']
    first, third, sine = 0.5 * (1 + 0.1 * math.pi ** 4 / 5) ** 2, 8e-2 * math.pi ** 8 / 225, 49 / 8
    variance = first + third + sine
    exact = [(first, first + third), (sine, sine), (0.0, third)]
    for one, (alone, total) in zip(found, exact):
        assert one['S1'] == pytest.approx(alone / variance, abs=0.03)
        assert one['ST'] == pytest.approx(total / variance, abs=0.03)
    told = answer(study, tmp_path / 'out', store.table(tmp_path / 'out'))
    assert told.lines[0].startswith('drive_torque_mean follows brush.start_angle most')


def test_a_larger_sample_runs_no_row_again(study_of, client, tmp_path):
    folder = tmp_path / 'out'
    carry_out(study_of(ANGLES.format('sobol', 64)), folder, client, run=ishigami)
    before = {path.name: path.stat().st_mtime_ns for _, _, path in store.parts(folder)}
    larger = study_of(ANGLES.format('sobol', 256))
    with pytest.raises(SceneError, match='--resume'):
        carry_out(larger, folder, client, run=ishigami)
    assert carry_out(larger, folder, client, resume=True, run=ishigami)
    after = {path.name: path.stat().st_mtime_ns for _, _, path in store.parts(folder)}
    assert before.items() <= after.items()
    carry_out(larger, tmp_path / 'whole', client, run=ishigami)
    assert table(folder) == table(tmp_path / 'whole')
    assert [row['run'] for row in table(folder)] == list(range(256))
    with pytest.raises(SceneError, match=r'of another study: samples was 256, is 64'):
        carry_out(study_of(ANGLES.format('sobol', 64)), folder, client, resume=True, run=ishigami)


def test_what_is_missing_is_run_and_nothing_else(study_of, client, tmp_path):
    study, folder = study_of(ANGLES.format('latin_hypercube', 100)), tmp_path / 'out'
    carry_out(study, folder, client, run=ishigami)
    wanted = table(folder)
    for number in (0, 2, -1):
        os.unlink(store.parts(folder)[number][2])
    (folder / 'runs.parquet/.part-000000000-000000099.parquet.host.1').write_text('cut off')
    assert len(table(folder)) < 100
    assert carry_out(study, folder, client, resume=True, run=ishigami)
    assert table(folder) == wanted
    run_batch(study, folder, *store.parts(folder)[1][:2], run=ishigami)     # twice does no harm
    assert table(folder) == wanted


def test_another_version_does_not_go_on(study_of, client, tmp_path, monkeypatch):
    study = study_of(ANGLES.format('sobol', 4))
    carry_out(study, tmp_path / 'out', client, run=ishigami)
    monkeypatch.setattr(store, '__version__', '0.0.1')
    with pytest.raises(SceneError, match=r'begun by version \d.* and this is 0\.0\.1'):
        store.check(study, tmp_path / 'out', resume=True)


@pytest.mark.parametrize(('done', 'missing'), [
    ([], [(0, 4), (4, 8), (8, 10)]), ([(0, 4)], [(4, 8), (8, 10)]),
    ([(4, 8), (8, 9)], [(0, 4), (9, 10)]), ([(0, 10)], []), ([(5, 6)], [(0, 4), (4, 5), (6, 8),
                                                                      (8, 10)])])
def test_stretches_that_no_part_has(tmp_path, done, missing):
    (tmp_path / store.RUNS).mkdir()
    for first, end in done:
        (tmp_path / store.RUNS / f'part-{first:09d}-{end:09d}.parquet').touch()
    assert list(store.missing([(0, 4), (4, 8), (8, 10)], tmp_path)) == missing


def test_a_row_that_is_refused_is_a_row(study_of, client, tmp_path):
    study = study_of('duration: 1.0\ndesign: saltelli\nsamples: 4\nvary:\n'
                     '  friction.kinetic: {from: 0.1, to: 0.9}\n'
                     '  friction.static: {from: 0.1, to: 0.9}\n')
    assert carry_out(study, tmp_path / 'out', client, run=ishigami)
    rows = table(tmp_path / 'out')
    assert len(rows) == 4 * 6
    for row in rows:
        bad = row['friction.kinetic'] > row['friction.static']
        assert row['status'] == ('refused' if bad else 'finished')
        assert bad == ('kinetic friction above' in row['message'])
    found, why = indices(study, tmp_path / 'out')
    assert not found
    assert 'did not finish' in why


def bowl(study, scene):
    """Least on the constraint's edge: power (p - 0.01)^2 + v^2 / 100, force 100 p."""
    p, v = scene.road.penetration, scene.drive.mean_speed
    return dict.fromkeys(MEASURES, 0.0) | {
        'drive_power': 1e4 * (p - 0.01) ** 2 + v * v / 100.0, 'normal_force_mean': 100.0 * p}, None


def test_an_optimum_on_a_constraint_is_found_again_by_its_seed(study_of, client, tmp_path):
    text = """
vary: {road.penetration: {from: 0.0, to: 0.05}, drive.mean_speed: {from: -5.0, to: 5.0}}
design: optimise
samples: 128
duration: 1.0
minimise: [drive_power]
constraints: ["normal_force_mean > 2.0"]
"""
    study, folder = study_of(text), tmp_path / 'out'
    carry_out(study_of(text.replace('128', '64')), folder, client, run=bowl)
    assert carry_out(study, folder, client, resume=True, run=bowl)      # two generations more
    carry_out(study, tmp_path / 'again', client, run=bowl)
    assert table(folder) == table(tmp_path / 'again')
    best = answer(study, folder, store.table(folder)).best[0]
    assert best['road.penetration'] >= 0.02
    assert best['drive_power'] == pytest.approx(1.0, abs=0.25)


def test_a_run_goes_on_until_it_has_settled(study_of):
    """A free wire that starts to swing settles by its damping; without it is cut."""
    turns = []
    for damping in (20.0, 0.0):
        study = study_of(f"""
set: {{contact.enabled: false, damping.mass: {damping}, drive.mean_speed: 40.0}}
vary: {{gravity: [9.81]}}
turns: auto
most_turns: 10
sample: 2.0e-3
""")
        row, _ = run_scene(study, study.scene)
        turns.append(row['turns'])
        assert row['settled'] == ('yes' if damping else row['settled'])
    assert turns[0] == 5
    assert turns[0] <= turns[1] <= 10


def test_runs_measures_curves_and_page(study_of, client, tmp_path):
    """The brush itself: twice the same bits, curves beside the rows, a page without a network."""
    study = study_of("""
vary: {road.penetration: [0.002, 0.004, 1.0], drive.mean_speed: [5.0, 6.0]}
duration: 0.1
keep: [contact_force, theta]
""")
    for name in ('one', 'two'):
        assert carry_out(study, tmp_path / name, client)
    assert str(table(tmp_path / 'one')) == str(table(tmp_path / 'two'))     # NaN is NaN
    data = open_study(tmp_path / 'one')
    assert list(data['status'].values) == ['finished'] * 4 + ['refused'] * 2
    assert data['contact_force'].sizes == {'run': 6, 'sample': 201, 'bristle': 2, 'axis': 3}
    assert float(data['theta'][1, -1]) == pytest.approx(0.6)
    assert np.isnan(data['contact_force'][4]).all()
    halved = store.table(tmp_path / 'one', name=store.HALVED)
    assert halved.num_rows >= 1
    page = write_page(tmp_path / 'one').read_text(encoding='utf-8')
    assert 'src="http' not in page
    assert 'would bring a clamp to the road' in page
