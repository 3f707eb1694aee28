"""Independent theory beside the model: normal modes, resonance at odd fractions, spin."""
from bristle_ros.report.figure import legend, log_axes, new_panel, plot, svg
from bristle_ros.report.workers import Failed, Job

from . import modes

SPINS = (0.0, 50.0, 100.0, 150.0, 300.0)    # [rpm]
PROFILES = ('sine', 'vap')


def measure(context):
    """Return the part's data."""
    jobs = [Job(modes.against_modes, (profile,)) for profile in PROFILES]
    tried = [(profile, fraction) for profile in PROFILES
             for fraction in modes.fractions(context.quick)]
    jobs += [Job(modes.swing, each) for each in tried]
    jobs += [Job(modes.frequencies_at, (rpm,)) for rpm in SPINS]
    found = context.crew.run(jobs, show=lambda value, job, done, total: context.progress.count(
        done, total, job.function.__name__.replace('_', ' ')))
    good = [[value for value in part if not isinstance(value, Failed)] for part in (
        found[:2], found[2:2 + len(tried)], found[2 + len(tried):])]
    rows = [row for part in good[0] for row in part]
    series = [{key: row[key] for key in ('profile', 'plane')} | {'lines': row.pop('series')}
              for row in rows]
    return {'modes': rows, 'swing': good[1], 'spin': good[2], 'series': series,
            'at_rest': [modes.natural_frequencies(False, 1)[0],
                        modes.natural_frequencies(True, 1)[0]]}


def _mode_panels(series):
    for each in series:
        figure, axes = new_panel(f'{each["profile"]}, {each["plane"]} plane', 'time [s]',
                                 'tip deflection [um]')
        t, theory, mine = each['lines']
        axes.plot(t, theory, color='#444444', lw=3.0, alpha=0.4)
        axes.plot(t, mine, color='#1f77b4', lw=0.9)
        yield svg(figure, f'tip deflection against time, {each["profile"]}, {each["plane"]}')


def _swing_panel(rows):
    figure, axes = new_panel('Resonance', 'drive frequency over the first of the strong plane',
                             'tangential swing over quasi-static')
    for profile in PROFILES:
        points = [row for row in rows if row['profile'] == profile]
        plot(axes, profile, [row['f_over_f1'] for row in points],
             [row['swing_over_static'] for row in points])
    for n in range(1, 8):
        axes.axvline(1.0 / n, color='k', lw=0.7, ls='-' if n % 2 else ':')
    log_axes(axes, x=False)
    return svg(figure, 'swing against frequency; solid lines at odd fractions of the first '
               'frequency, dotted at even ones')


def _ratios(rows):
    return [{'fraction': f'1/{n}', **{profile: modes.on_and_off(rows, profile, n)
                                      for profile in PROFILES}} for n in (3, 5, 7)]


def show(page, data, results):
    """Put the part on the page."""
    page.heading('Independent theory')
    page.explain('Normal modes of the clamped bristle that turns freely, small deflections, '
                 '2 rpm +- 1 rpm at 9 Hz: equations and their exact integration are in the '
                 'source, paper/modes.py.')
    if data.get('series'):
        page.figure(list(_mode_panels(data['series'])), 'Normal modes (wide) and the model.', (
            ('normal modes', '#999999', '\u2014'), ('model', '#1f77b4', '\u2014')))
        page.data('normal_modes_histories', [
            {'profile': each['profile'], 'plane': each['plane'], 't': t, 'theory': theory,
             'model': model} for each in data['series']
            for t, theory, model in zip(*each['lines'])],
            {'profile': 'speed function', 'plane': 'plane', 't': 'time [s]',
             'theory': 'normal modes [um]', 'model': 'model [um]'}, 'What is drawn above.')
    page.table('normal_modes', data['modes'], {
        'profile': 'speed function', 'plane': 'plane', 'largest_um': 'largest deflection [um]',
        'deviation': 'largest deviation [% of it]'}, 'Model against normal modes.')
    page.heading('Resonance at fractions of the first frequency', 3)
    page.explain('VAP is the speed function whose acceleration is nearly a square wave, with odd '
                 'harmonics alone.')
    if data['swing']:
        page.figure([_swing_panel(data['swing'])], 'Swing over the quasi-static one; solid lines '
                    'at odd fractions, dotted at even ones.', legend(PROFILES))
        page.table('odd_fraction_resonance', _ratios(data['swing']), {
            'fraction': 'fraction', 'sine': 'sine, on over off', 'vap': 'VAP, on over off'},
            'Swing at odd fractions over that half-way to the even neighbours.')
        page.data('odd_fractions', data['swing'], {
            'profile': 'speed function', 'f_over_f1': 'drive frequency over the first',
            'frequency_hz': 'drive frequency [Hz]',
            'swing_over_static': 'swing over quasi-static'}, 'Every drive that was tried.')
    page.heading('Frequencies against spin', 3)
    page.says(f'Straight, at rest and without gravity: {data["at_rest"][0]:.4g} Hz and '
              f'{data["at_rest"][1]:.4g} Hz.')
    page.table('frequencies_with_spin', data['spin'], {
        'spin_rpm': 'spin [rpm]', 'weak_hz': 'weak plane [Hz]', 'strong_hz': 'strong plane [Hz]'},
        'First frequencies about the steady shape, gravity on.')
