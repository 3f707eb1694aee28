"""The sections of the report: each measures, and puts its tables and figures on the page."""
import os

from bristle_ros.report.paper import claims, experiments as paper_claims, modes
from bristle_ros.report.peers import comparison as others
from bristle_ros.report.stability import campaign, cases as campaign_cases, map as campaign_map
from bristle_ros.scene import from_parameters

from . import adaptive, estimate as single_steps, features, step_profile, work_precision
from .runs import one_core


def _compile(page, progress):
    """Build each kind of scene once, so that no timing contains a compiler."""
    from bristle_ros.simulation import Simulation
    rows = []
    for contact in (True, False):
        for beta in (1e-3, 0.0):
            progress(f'compiling: contact {contact}, beta_D {beta:g} s')
            scene = campaign_cases.make_case(
                '', 'level' if contact else 'free', {'damping.stiffness': beta}, 0.1)
            simulation = Simulation(from_parameters(scene.parameters, 'report'))
            simulation.advance(1)
            rows.append({'contact': contact, 'beta_D': beta > 0.0,
                         'ready_after_s': simulation.compile_time})
    page.heading('Start-up', 3)
    page.text('Building a scene compiles what it needs, or loads it from the cache of an earlier '
              'start. No timing below contains it.')
    page.table('startup', rows)


def precision(page, progress, options):
    """Error against run time of our own settings."""
    page.heading('Error against run time')
    _compile(page, progress)
    page.text('Every point is a run. Its error is that against a converged run of the same scene; '
              "the dotted line is the converged run's own error. Left of the black line is "
              'faster than real time. S1: cantilever dropped from the horizontal; S2: free '
              'rotation at 150 +- 4 rpm; S3: bouncing sweep at 100 rpm; S4: the tilted, deep, '
              'undamped sweep of the paper, up to 0.24 s; S5: S2 with beta_D = 21 ms.')
    with one_core():
        rows, references = work_precision.measure(progress, quick=options.quick,
                                                  repeats=options.repeats)
    for figure, title in work_precision.draw(rows, references):
        page.figure(figure, title)
    page.text('Undamped trains of impacts (S3, S4) do not repeat in detail; there the error of '
              'path and windows stays where the chaos of the scene puts it, at any step.', True)
    _adaptive(page, rows, references)
    page.heading('Converged runs', 3)
    page.table('converged_runs', references)
    page.heading('All runs', 3)
    page.table('work_precision', rows)


def _adaptive(page, rows, references):
    page.heading('Adaptive against fixed steps', 3)
    page.text('Lower left is better. Adaptive steps are halves of halves of the integration step, '
              'here the longest of the fixed ones, so that a loose tolerance gives that fixed '
              'run again; tolerances with the same result share a label. The tolerance bounds '
              "the local error of each step per length of the bristle, not the path's error. The "
              'table compares at equal error, between the fixed runs that none beats; no ratio '
              'stands where no fixed run is as good. In S4 chaos decides about single points: '
              'read the cloud.')
    compared = adaptive.compare(rows)
    page.figure(adaptive.draw(rows, references), 'adaptive against fixed steps')
    page.text(adaptive.verdict(compared))
    page.table('adaptive_against_fixed', compared)


def estimate(page, progress, options):
    """Local error: estimate against truth."""
    page.heading('Estimate of the local error')
    found, split = single_steps.measure(progress, quick=options.quick)
    rows = single_steps.summary(found)
    whole = rows[-1]
    page.text(
        f'{len(found)} single steps of {len({(s.scene, s.its, s.scheme) for s in found})} runs: '
        'the estimate that the stepper gives for the step, against its true error, that to the '
        f'same step from the same state in {single_steps.PARTS} parts. Both are local, root mean '
        'square over the mass that moved, per length of the bristle. Estimate over true error: '
        f'{whole["smallest_ratio"]:.2g} to {whole["largest_ratio"]:.2g}, median '
        f'{whole["median_ratio"]:.3g}; {whole[f"outside_a_factor_{single_steps.BAND:g}"]} steps '
        f'outside a factor {single_steps.BAND:g}. Left out, because a step done in sub-steps '
        f'estimates only its last one: {split}.')
    page.figure(single_steps.draw(found), 'estimate against true local error')
    page.table('local_error', rows)
    page.tables['local_error_steps'] = [{**s._asdict(), 'ratio': s.ratio} for s in found]


def peers_names(options):
    """Return the scenes that the peers are measured on."""
    return ('S2',) if options.quick else ('S1', 'S2', 'S5', 'S3', 'S4')


def peers(page, progress, options):
    """Beside other programs."""
    page.heading('Beside exudyn and MuJoCo')
    names = peers_names(options)
    found, absent = others.programs()
    for name in absent:
        page.text(f'{name} is not installed here, so its rows are left out: pip install '
                  '"bristle_ros[peers]" brings it.')
    versions = ', '.join(f'{name} {version}' for name, (_, version) in found.items() if version)
    page.text('The same scenes in the same run, on the same core. Each program against its own '
              'converged run; the fastest of the settings tried counts. Other programs solve the '
              'scenes the way that is fastest for them: in the rotating frame, clamp at rest. '
              f'Their versions: {versions or "none"}.'
              + (' Settings that take minutes are left out.' if options.quick else ''))
    with one_core():
        rows, equal, apart, _ = others.compare(progress, names, quick=options.quick,
                                               repeats=options.repeats)
    page.figure(others.draw(rows, names), 'error against run time of all programs')
    page.heading('At equal error', 3)
    page.table('peers_equal_error', equal)
    page.heading('How far the converged runs lie apart', 3)
    page.table('peers_converged', apart)
    page.heading('All runs', 3)
    page.table('peers', rows)


def paper(page, progress, options):
    """Measure what the paper claims."""
    page.heading('The paper, run again')
    figure, worst = paper_claims.friction_curve(progress)
    page.heading('Figure 3: friction', 3)
    page.figure(figure, 'friction curve')
    page.text(f'Simulated coefficients deviate from the law by at most {worst:.2g}.')
    page.heading('Figure 4: damping force at the clamp', 3)
    damping, figure = paper_claims.damping_force(progress, quick=options.quick)
    page.figure(figure, 'damping force at the clamp')
    page.table('paper_damping_force', damping)
    page.text("At a corner of the polygon the clamp's velocity jumps by r w^2 TS: a true jump, "
              'spread over one step. Newmark and HHT with an amplitude decay of 0.005 keep '
              'ringing on it, which beta_D K multiplies by about 100; an integrator that '
              'annihilates infinite frequencies (spectral radius 0) does not ring. With TS = ITS '
              "all points lie on the circle and there are no corners. The paper's threshold "
              'TS < 0.01 ms is its own ITS.')
    page.text('Beside ours stand the peaks of two independent planar models of the same wire. '
              f'{paper_claims.against_planar(damping)} Empty: no figure of theirs.'
              + (' The rows with ITS 1 us take a minute and are left out of the quick form.'
                 if options.quick else ''))
    page.heading('Figure 5: both load cases', 3)
    figure, cases = paper_claims.two_load_cases(progress, quick=options.quick)
    page.figure(figure, 'tip force and displacement of both load cases')
    page.table('paper_load_cases', cases)
    page.heading('Sensitivities', 3)
    sensitivity = paper_claims.sensitivities(progress, quick=options.quick)
    page.table('paper_sensitivities', sensitivity)
    with one_core():
        ratio = paper_claims.run_time_ratio(progress, options.repeats)
    page.heading('Run time of both load cases at equal error', 3)
    page.table('paper_run_time', [ratio])
    page.heading('Claim by claim', 3)
    page.table('paper_claims', claims.judge(worst, damping, cases, sensitivity, ratio))


def theory(page, progress, options):
    """Against independent theory."""
    page.heading('Independent theory')
    page.heading('Normal modes of the freely rotating bristle', 3)
    rows, figure = modes.compare(progress)
    page.figure(figure, 'normal-mode solution against the model')
    page.table('normal_modes', rows)
    page.heading('Resonance at odd fractions', 3)
    rows, figure = modes.odd_fractions(progress, quick=options.quick)
    page.figure(figure, 'resonance at fractions of the first frequency')
    page.text("VAP's acceleration is nearly a square wave, whose harmonics are odd: near-"
              'resonance in the strong plane at f1/3, f1/5, ... (solid lines), none at even '
              'fractions (dotted), and with the sine none at either.')
    page.table('odd_fraction_resonance', [
        {'fraction': f'1/{n}', 'VAP, on over off': modes.on_and_off(rows, 'vap', n),
         'sine, on over off': modes.on_and_off(rows, 'sine', n)} for n in (3, 5, 7)])
    page.tables['odd_fractions'] = rows
    page.heading('Frequencies against spin', 3)
    page.text('About the steady shape, gravity on. Straight, at rest and without gravity: '
              f'{modes.natural_frequencies(False, 1)[0]:.4g} Hz and '
              f'{modes.natural_frequencies(True, 1)[0]:.4g} Hz.')
    page.table('frequencies_with_spin', modes.frequencies_with_spin(progress))


def stability(page, progress, options):
    """Run the stability campaign; return why it is not a pass, or an empty text."""
    page.heading('Stability')
    cases = campaign_cases.short() if options.quick else campaign_cases.listed()
    cases += campaign_cases.drawn(options.seed, options.drawn, 0.1 if options.quick else 0.5)
    limit = min(options.wall_limit, 3.0) if options.quick else options.wall_limit

    def show(result, done, total):
        progress(f'campaign {done}/{total}: {result.kind} {result.name}')
    results = campaign.run_cases(cases, os.cpu_count() or 1, limit, show)
    kinds = campaign.count_kinds(results)
    problem = campaign.problem_of(kinds)
    worst = max(results, key=lambda result: result.worst_step_newton)
    page.text(
        f'{len(results)} cases ({options.drawn} of them drawn with seed {options.seed}), each '
        f'{cases[0].duration:g} s or {limit:g} s of wall time: ' + ', '.join(
            f'{count} {kind}' for kind, count in kinds.items())
        + f'. Most iterations in one step: {worst.worst_step_newton} ({worst.name}); longest call '
        f'{max(result.worst_step_s for result in results):.2g} s.')
    page.text(f'Not a pass: {problem}.' if problem else 'A pass: every case came to its end.')
    page.text('Checked from the outputs alone: finite values; energy balance; friction inside its '
              'cone and a road that never pulls; the contact force that the penetration explains; '
              'a rigid road never entered; the bristle no longer than its loads make it.')
    page.figure(campaign_map.draw(results), 'map of the stability campaign')
    odd = [result for result in results if result.kind in ('wrong', 'stopped', 'refused')]
    page.heading('Not finished', 3)
    page.table('campaign_not_finished', [
        {'case': r.name, 'kind': r.kind, 'reason': r.reason} for r in sorted(
            odd, key=lambda r: campaign.KINDS[::-1].index(r.kind))])
    page.heading('Worst of the others', 3)
    worst_rows = sorted((r for r in results if r not in odd),
                        key=lambda r: -r.newton / max(1, r.steps))[:15]
    page.table('campaign_worst', [
        {'case': r.name, 'kind': r.kind, 'reached_s': r.reached,
         'newton_per_step': r.newton / max(1, r.steps), 'worst_step': r.worst_step_newton,
         'wall_per_simulated_s': r.wall / max(r.reached, 1e-9),
         'energy_gain': r.measures.get('energy_gain')} for r in worst_rows])
    page.tables['campaign'] = [result.row() for result in results]
    return problem


def cost(page, progress, options):
    """Measure what each feature costs."""
    page.heading('What each feature costs')
    page.text('cutting_brush, ITS 0.1 ms, with one thing changed at a time.')
    with one_core():
        rows = features.costs(progress, quick=options.quick, repeats=options.repeats)
    page.figure(features.draw(rows), 'run time of a step with each feature changed')
    page.table('features', rows)
    page.heading('Where the time of a step goes', 3)
    page.text('One bristle, 12 elements, ITS 0.2 ms; each kernel timed by itself, less an empty '
              'call, times how often a step calls it.')
    with one_core():
        page.table('profile', step_profile.profile(progress, quick=options.quick,
                                                   repeats=options.repeats))
