"""What the page is asked, and its answer: five lines and one picture, all from the results."""
from .figure import log_axes, MARKS, new_panel, plot, real_time, svg
from .lean import show as lean
from .paper import claims
from .peers import show as peers
from .precision import show as precision
from .road import show as road
from .stability import show as stability
from .timing import quartiles
from .verdict import WORDS

LEVEL = 1.0     # [%] error of the tip path that the first line is about
MISSING = 'not measured in this run'


def precision_line(results):
    """Return what an error costs, scene by scene."""
    data = results['parts'].get('precision')
    if not data:
        return f'Error against run time: {MISSING}.'
    said = []
    for entry in data['subjects']:
        found = precision.cost(entry, LEVEL)
        if found:
            # where the cheapest setting that was tried is better than asked
            more = 'at least ' if precision.coarsest(entry) < LEVEL else ''
            said.append(f'{entry["name"]} {more}{1.0 / found.value:.0f} ({1.0 / found.high:.0f} '
                        f'to {1.0 / found.low:.0f})')
        else:
            said.append(f'{entry["name"]} not reached')
    return (f'Error against run time: times real time at {LEVEL:g} % error of the tip path, one '
            f'bristle on one core: {", ".join(said)}{_road(results)}.')


def _road(results):
    """Return what the limits of the road's scenes cost, as the end of a sentence."""
    rows = [row for row in road.cost_rows(results['parts'].get('road', {'subjects': []}))
            if row.get('times')]
    if not rows:
        return ''
    return '; on the road, path and impulse within the limits of its table: ' + ', '.join(
        f'{row["scene"]} {row["times"]}' for row in rows)


def peers_line(results):
    """Return how much longer other programs take."""
    data = results['parts'].get('peers')
    if not data:
        return f'Beside other programs: {MISSING}.'
    if not data['scenes']:
        return (f'Beside other programs: nothing compared, {" and ".join(data["absent"])} '
                'not installed.')
    said = []
    for program in data['versions']:
        # of each scene the largest error level that both reach
        found = {}
        for row in peers.ratios(data):
            if row['program'] == program and row['ratio']:
                found.setdefault(row['scene'], f'{row["scene"]} {row["ratio"]} at '
                                 f'{row["level"]:g} %')
        said.append(f'{program}: {", ".join(found.values()) or "no common error"}')
    return f'Beside other programs, their run time over ours at equal error: {"; ".join(said)}.'


def stability_line(results):
    """Return what became of the campaign's cases."""
    data = results['parts'].get('stability')
    return f'Stability: {stability.summary(data) if data else MISSING}.'


def lean_line(results):
    """Return the dearest features."""
    data = results['parts'].get('cost')
    if not data:
        return f'What leaving out saves: {MISSING}.'
    rows = [row for row in lean.feature_rows(data) if row.get('present')
            and row['cost'] and row['cost'].low > 0.0][:5]
    return ('What leaving out saves, beyond the noise and largest first, in % of a step without '
            'it: ' + (', '.join(f'{row["feature"]} {row["cost"]}' for row in rows) or 'nothing')
            + '.')


def paper_line(results):
    """Return how many of the paper's claims have which verdict."""
    data = results['parts'].get('paper')
    if not data:
        return f"The paper's claims: {MISSING}."
    rows = claims.judge(data)
    counts = {word: sum(row['verdict'] == word for row in rows) for word in WORDS}
    ratios = [str(ratio) for _, ratio in claims.cost_ratios(
        data['rotation_cost'], claims.LEVELS['path']) if ratio]
    return (f"The paper's claims, {len(rows)} of them: " + ', '.join(
        f'{word}: {count}' for word, count in counts.items() if count)
        + '; run time of the displacement load case over the inertia one at equal error '
        + (', '.join(ratios) or 'not clear') + '.')


def lines(results):
    """Return the five lines."""
    return [part(results) for part in (precision_line, peers_line, stability_line, lean_line,
                                       paper_line)]


def _curves(results):
    """Return {scene: {program: [(wall, error)]}} of the picture."""
    found = {}
    for entry in results['parts'].get('precision', {}).get('subjects', ()):
        found[entry['name']] = {'bristle_ros': [
            (quartiles(row['timing']['walls']).value, row['tip']) for row in entry['rows']
            if row['family'] == 'step' and row.get('timing') and row.get('tip')]}
    for entry in results['parts'].get('road', {}).get('subjects', ()):
        found[entry['name']] = {'bristle_ros': [
            (quartiles(row['timing']['walls']).value, row['tip']) for row in entry['rows']
            if row['family'] == road.USUAL_FAMILY and row.get('timing') and row.get('tip')]}
    for scene in _compared(results):
        for program, entry in scene['programs'].items():
            points = [(quartiles(row['timing']['walls']).value, row['error'])
                      for row in entry['rows'] if row.get('timing') and row.get('error')]
            if points:      # with contact these are errors of the impulse, for all programs
                found.setdefault(scene['name'], {})[program] = points
    return found


def _compared(results):
    """Return the scenes that were compared with other programs."""
    parts = results['parts']
    beside = parts.get('peers', {}), (parts.get('road') or {}).get('peers') or {}
    return [scene for data in beside for scene in data.get('scenes', ())]


def picture(results):
    """Return the panels of the picture, one for each scene, all with the same axes."""
    curves = _curves(results)
    points = [point for programs in curves.values() for part in programs.values()
              for point in part]
    if not points:
        return [], []
    walls, errors = zip(*points)
    impulses = {scene['name'] for scene in _compared(results) if scene['contact']}
    panels = []
    for scene, programs in curves.items():
        figure, axes = new_panel(
            scene, 'wall seconds per simulated second',
            f'error of the {"impulse" if scene in impulses else "tip path"} [%]', (4.0, 2.9))
        for program, part in programs.items():
            if part:
                plot(axes, program, *zip(*part))
        axes.set(xlim=(min(min(walls), 0.5) / 2.0, max(max(walls), 1.0) * 2.0),
                 ylim=(min(errors) / 2.0, max(errors) * 2.0))
        real_time(axes)
        log_axes(axes)
        panels.append(svg(figure, f'{scene}: error against run time'))
    names = [name for name in ('bristle_ros', 'exudyn', 'mujoco')
             if any(name in programs for programs in curves.values())]
    return panels, [(name, MARKS[name][0], MARKS[name][2]) for name in names]


def show(page, results):
    """Put question, answer and picture on the page."""
    page.heading('What is asked, and the answer')
    page.explain('How large is the error for a given run time, beside other programs? Does '
                 'anything go wrong unnoticed on stiff and extreme scenes? What does it cost to '
                 'leave a feature in? And which claims of the paper that the scenes follow does '
                 'this run support?')
    page.answer(lines(results))
    panels, legend = picture(results)
    if panels:
        page.figure(panels, 'Error against run time in all scenes: lower left is better, left of '
                    'the black line is faster than real time.', legend)
