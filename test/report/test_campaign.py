"""The stability campaign in short, and that its checks see what they are there to see."""
from bristle_ros.report import workers
from bristle_ros.report.main import main
from bristle_ros.report.stability import campaign, cases as campaign_cases, draws, show
from bristle_ros.report.stability.checks import Watch
from bristle_ros.report.stability.contact_checks import spring_force
from bristle_ros.scene.scene import from_parameters, keys
from bristle_ros.simulation.simulation import Simulation
import numpy as np
import pytest


@pytest.fixture(scope='module')
def results():
    cases = campaign_cases.short()
    return {case.name: campaign.run_case(case, 600.0) for case in cases}


def test_short_campaign_ends_well(results):
    assert len(results) >= 25
    odd = {name: (result.kind, result.reason) for name, result in results.items()
           if result.kind != 'finished'}
    # a start inside the road is the one thing that is refused
    assert odd.pop('level: inside the road')[0] == 'refused'
    assert odd == {}


def test_measures_are_those_of_real_runs(results):
    level = results['level: as it is']
    assert level.steps == 1000
    assert level.newton >= level.steps
    assert level.measures['largest_force_n'] > 0.0
    assert 0.0 < level.measures['entered_m'] < 1e-3


def watched(changes=None):
    case = campaign_cases.make_case('', 'level', {'road.approach_time': 0.02, **(changes or {})},
                                    0.1)
    scene = from_parameters(case.parameters, 'test')
    simulation = Simulation(scene, energies=True)
    watch = Watch(scene, simulation)
    watch.look(simulation.snapshot())
    while simulation.step < 1000:
        simulation.advance(10)
        before = simulation.snapshot()
        simulation.advance(1)
        now = simulation.snapshot()
        if before.contact_force[0, 2] > 0.01 and now.contact_force[0, 2] > 0.01 and (
                now.substeps == before.substeps):
            break
    watch.before_step(before)
    return watch, now


def with_forces(snapshot, factor):
    """Return outputs whose forces are multiplied."""
    return snapshot._replace(contact_force=snapshot.contact_force * factor,
                             tip_force=snapshot.tip_force * factor)


@pytest.mark.parametrize(('spoil', 'word'), [
    (lambda s: s._replace(tip_position=np.full((1, 3), np.nan)), 'not finite'),
    (lambda s: s._replace(energy_kinetic=s.energy_kinetic + s.energy_elastic + 1.0),
     'energy from nowhere'),
    (lambda s: with_forces(s, (10.0, 10.0, 1.0)), 'outside its cone'),
    (lambda s: with_forces(s, -1.0), 'the road pulls'),
    (lambda s: with_forces(s, 1.1), 'the penetration explains'),
    (lambda s: s._replace(tip_position=s.tip_position * 1.2), 'lengths from its clamp')])
def test_a_spoilt_output_is_seen(spoil, word):
    watch, snapshot = watched()
    watch.look(snapshot, stepped=True)
    assert watch.wrong == []
    watch.look(spoil(snapshot), stepped=True)
    watch.look(spoil(snapshot), stepped=True)
    assert word in ' '.join(watch.wrong)


def test_energy_that_a_single_look_sees_is_an_overshoot():
    watch, snapshot = watched()
    watch.look(snapshot, stepped=True)
    watch.look(snapshot._replace(energy_kinetic=snapshot.energy_kinetic
                                 + snapshot.energy_elastic), stepped=True)
    watch.look(snapshot, stepped=True)
    assert watch.wrong == []


def test_a_rigid_road_entered_is_seen():
    watch, snapshot = watched({'contact.normal_stiffness': float('inf')})
    watch.look(snapshot, stepped=True)
    assert watch.wrong == []
    watch.look(snapshot._replace(tip_position_road=snapshot.tip_position_road - (0, 0, 1e-11)))
    assert 'inside a rigid road' in watch.wrong[0]


def test_spring_force_is_the_mean_that_does_the_springs_work():
    assert spring_force(1e4, 0.0, 1e-4, -1e-3, -3e-3) == pytest.approx(20.0)
    # from above to 2 mm inside: work Kn d^2 / 2 over the way of the tip
    assert spring_force(1e4, 0.0, 1e-4, 1e-3, -2e-3) == pytest.approx(1e4 * 2e-6 / 3e-3)
    assert spring_force(1e4, 0.0, 1e-4, 1e-3, 2e-3) == 0.0
    assert spring_force(1e4, 1.0, 1e-3, -1e-3, -3e-3) == pytest.approx(20.0 * 3.0)


def test_the_list_covers_what_was_promised():
    cases = campaign_cases.listed()
    assert len(cases) >= 300
    assert len({case.name for case in cases}) == len(cases)
    known = {key.name for key in keys()}
    seen = {}
    for case in cases:
        assert set(case.parameters) <= known
        assert 0.0 < case.duration <= 0.5 * (1 + 1e-9)
        for key, value in case.parameters.items():
            seen.setdefault(key, set()).add(value)
    for key, low, high in (
            ('damping.stiffness', 1e-6, 1.0), ('contact.normal_stiffness', 1e2, float('inf')),
            ('bristle.youngs_modulus', 2.07e8, 2.07e14), ('bristle.width', 5e-5, 5e-3),
            ('bristle.length', 0.02, 1.0), ('solver.elements', 1, 100),
            ('solver.integration_time_step', 1e-7, 1e-2), ('friction.static', 0.0, 5.0),
            ('friction.decay', 0.0, 100.0), ('road.penetration', -0.01, 0.19),
            ('road.attack_angle', 0.0, 1.39), ('drive.mean_speed', -314.0, 314.0)):
        assert min(seen[key]) <= low
        assert max(seen[key]) >= high


def test_draws_repeat_with_their_seed():
    assert draws.drawn(7, 20) == draws.drawn(7, 20)
    assert draws.drawn(7, 20) != draws.drawn(8, 20)
    assert len({draws.build_of(case.parameters) for case in draws.drawn(3, 200)}) > 20
    few = draws.drawn(3, 200, builds=5)
    assert len(few) == 200
    assert len({draws.build_of(case.parameters) for case in few}) == 5
    for case in draws.drawn(3, 200):
        from_parameters(case.parameters, case.name)     # none is out of range


def test_draws_have_commands_resets_polygons_and_every_scheme():
    cases = draws.drawn(5, 200, 0.1, 3.0)
    assert all(case.drawn for case in cases)
    assert {topic for case in cases for _, topic, _ in case.commands} == {
        'cmd_brush_speed', 'cmd_penetration', 'cmd_vel'}
    assert 20 < sum(bool(case.resets) for case in cases) < 80
    for key, values in (('solver.load_case', {'inertia', 'displacement'}),
                        ('solver.integrator', {'generalized_alpha', 'newmark', 'hht'})):
        assert {case.parameters.get(key) for case in cases} - {None} == values
    polygons = [case for case in cases if case.parameters.get('solver.time_step', 0.0) > 1.5
                * case.parameters['solver.integration_time_step']]
    assert len(polygons) > 30
    assert sum('brush.row_counts' in case.parameters for case in cases) > 15
    assert sum('drive.file' in case.parameters for case in cases) > 15
    assert sum('air.density' in case.parameters for case in cases) > 8
    # no more than what the limit lets any machine do
    for case in cases:
        steps = case.duration / case.parameters['solver.integration_time_step']
        work = steps * case.parameters.get('solver.elements', 12)
        assert work <= 3.0 * draws.PACE + 1e4


def test_a_reset_case_goes_on_from_its_start():
    case = campaign_cases.make_case('reset', 'level', {'solver.elements': 4}, 0.05)
    plain = campaign.run_case(case, 60.0)
    again = campaign.run_case(case._replace(resets=(0.02,)), 60.0)
    assert plain.kind == again.kind == 'finished'
    assert plain.steps == again.steps == 500
    assert plain.measures['largest_force_n'] >= again.measures['largest_force_n']


def drawn_11_196(**changes):
    """Return the start of the case in which a clamp on a polygon made energy, as checks saw it."""
    case = campaign_cases.make_case('polygon', 'tilted', {
        'damping.stiffness': 0.01, 'solver.spectral_radius': 0.4394, 'solver.time_step': 0.005,
        'solver.load_case': 'displacement', **changes}, 0.02)
    return campaign.run_case(case, 60.0)


def test_ringing_behind_a_corner_is_warned_of_and_no_energy_from_nowhere():
    # velocities alternate behind the corners, and the kinetic energy with them
    result = drawn_11_196()
    assert result.kind == 'finished'
    assert 'polygon corners' in result.warnings
    assert result.measures['energy_gain'] < 0.05
    inertia = drawn_11_196(**{'solver.load_case': 'inertia'})
    assert 'polygon corners' not in inertia.warnings
    assert inertia.kind == 'finished'


def test_between_corners_energy_from_nowhere_is_seen():
    case = campaign_cases.make_case('polygon', 'free', {
        'solver.spectral_radius': 0.2, 'solver.time_step': 0.005,
        'solver.load_case': 'displacement'}, 0.02)
    simulation = Simulation(from_parameters(case.parameters, 'test'), energies=True)
    watch = Watch(simulation.scene, simulation)
    for _ in range(3):
        simulation.advance(45)
        snapshot = simulation.snapshot()
        watch.look(snapshot)
        simulation.advance(5)
    assert watch.wrong == []
    stored = snapshot.energy_kinetic + snapshot.energy_elastic
    for _ in range(2):
        watch.look(snapshot._replace(work_external=snapshot.work_external - 3.0 * stored))
    assert 'energy from nowhere' in watch.wrong[0]


def test_a_step_takes_no_other_root_of_its_equations():
    """One element after an impact: another root is turned inside out, and has 3 J."""
    parameters = {
        'damping.stiffness': 1e-06, 'drive.profile': 'table',
        'drive.file': 'data:0.0721,-37.08;0.0802,28.39;0.1403,-38.48',
        'friction.static': 0.7076, 'gutter.approach': 0.007, 'gutter.channel_slope': 0.052,
        'gutter.channel_width': 0.168, 'gutter.edge_radius': 0.01549, 'gutter.enabled': True,
        'gutter.foot_radius': 0.001899, 'gutter.kerb_batter': 0.309, 'gutter.kerb_distance': 0.205,
        'gutter.kerb_height': 0.114, 'gutter.lip_radius': 0.09762, 'road.approach_time': 0.05,
        'road.penetration': 0.02, 'run.chunk': 1e-4, 'run.sample': 1e-4, 'solver.elements': 1,
        'solver.integrator': 'hht', 'solver.step': 'adaptive'}
    result = campaign.run_case(campaign_cases.Case('root', parameters, 0.3, (
        (0.0364, 'cmd_penetration', (-0.0047,)),
        (0.049, 'cmd_vel', (-4.918320202500772, -4.522110815547151, 0.6527215346980473)))))
    assert result.kind == 'finished', result.reason
    assert result.measures['energy_gain'] < 0.05


def test_a_case_whose_budget_ran_out_says_why():
    case = campaign_cases.make_case('fine', 'free', {'solver.integration_time_step': 1e-6}, 0.1)
    result = campaign.run_case(case, 0.0)
    assert result.kind == 'cut'
    assert f'{result.steps} of 100000 steps in' in result.reason
    assert 'Newton iterations' in result.reason


def test_a_worker_that_dies_is_a_wrong_answer():
    good = campaign_cases.make_case('good', 'free', {'solver.elements': 4}, 0.01)
    # parameters that no worker can even be asked about
    bad = good._replace(name='bad', parameters=Bomb())
    with workers.crew(1) as crew:
        found = crew.run([workers.Job(campaign.run_case, (case, 5.0)) for case in (bad, good)])
    assert found[0] == workers.Failed('its process died', True)
    assert found[1].kind == 'finished'


def test_patience_is_of_the_processor_not_of_the_clock():
    times = {'clock': 0.0, 'used': 5.0}
    patience = workers.Patience(0, 10.0, lambda: times['clock'], lambda process: times['used'])
    for _ in range(10):     # a busy machine: a thousandth of a processor, for hours
        times['clock'] += 200.0
        times['used'] += 0.2
        assert not patience.over()
    times['used'] += 9.0
    assert patience.over()
    still = workers.Patience(0, 10.0, lambda: times['clock'], lambda process: 5.0)
    times['clock'] += workers.STILL + 1.0
    assert still.over()
    unknown = workers.Patience(0, 10.0, lambda: times['clock'], lambda process: None)
    times['clock'] += 11.0
    assert unknown.over()


def test_the_processor_time_of_a_process_is_its_own():
    import os
    import time
    before = workers.processor_time(os.getpid())
    assert before == pytest.approx(time.process_time(), rel=0.2, abs=0.5)


class Bomb(dict):
    """Ends the process that unpickles it."""

    def __reduce__(self):
        import os
        return os._exit, (3,)


def judged(**counts):
    return show.problem_of({'cases': [{'kind': kind} for kind, count in counts.items()
                                      for _ in range(count)]})


def test_the_verdict_follows_from_the_counts():
    assert judged(finished=3, stopped=1, refused=1) == ''
    assert judged(finished=3, cut=2) == '2 of 5 cases were cut off by the limit'
    assert judged(finished=3, wrong=1) == '1 of 4 cases are wrong'
    assert judged(refused=2) == 'none of 2 cases ran to its end'
    assert judged() == 'none of 0 cases ran to its end'
    assert judged(cut=1) == ('1 of 1 cases were cut off by the limit, none of 1 cases ran to '
                             'its end')


def test_a_campaign_that_is_cut_is_no_pass(tmp_path, monkeypatch, capsys):
    monkeypatch.setattr(campaign_cases, 'short', lambda: [campaign_cases.make_case(
        'long', 'free', {'solver.integration_time_step': 1e-7}, 0.5)])
    code = main(['--quick', '--only', 'stability', '--drawn', '0', '--case-limit', '0.01',
                        '--output', str(tmp_path)])
    assert code == 1
    assert '1 of 1 cases were cut off by the limit' in capsys.readouterr().err
    assert 'Not a pass: 1 of 1 cases' in (tmp_path / 'index.html').read_text(encoding='utf-8')
