"""The page from the results: the answer first, the parts in their order, the method last."""
from . import answer, compare, parts, timing
from .page import Page

TITLE = 'bristle_ros: error against run time, stability, and what the paper claims'


def make_page(results, old=None):
    """Return the Page of results; old: earlier ones to compare with."""
    page = Page(TITLE)
    about, done = results['about'], results['parts']
    page.says(f'{"Quick" if about["quick"] else "Full"} form of {about["date"]}, on '
              f'{about["machine"].get("cpu", "an unknown processor").split(",")[0]}, '
              f'{about["cores"]} cores; it took {about.get("took", 0.0):.0f} s.')
    absent = [name for name in results['wanted'] if name not in done]
    if absent:
        page.says(f'Interrupted: {", ".join(absent)} not measured.', marked=True)
    answer.show(page, results)
    if old is not None:
        compare.show(page, old, results)
    for name in parts.PARTS:
        if name in done:
            parts.show(name, page, done[name], results)
    _method(page, results)
    return page


def problems_of(results):
    """Return why the results are not a pass, as texts."""
    from bristle_ros.report.stability.show import problem_of
    problem = problem_of(results['parts'].get('stability'))
    return [f'stability: {problem}'] if problem else []


def _method(page, results):
    about = results['about']
    page.heading('Method and machine')
    page.fold('How it was measured, and where')
    page.explain('Errors and run times are measured apart. Errors do not depend on the machine; '
                 'all cores work on them. Times are taken on one core, in rounds: in each round '
                 'every setting of a group is timed once, each program in a process of its own. '
                 'Medians are drawn with their quartiles. Ratios are those of pairs from the same '
                 'round; their interval is that of all rounds. A calibration loop runs before and '
                 'after each timing: a timing beside which it took more than '
                 f'{timing.SLOW:g} of its best, or which waited for its core more than '
                 f'{100 * timing.WAITED:g} % of its time, is done again up to {timing.AGAIN} '
                 'times; where that does not help it is marked, and widens intervals by what the '
                 'loop took longer. A verdict whose interval crosses its threshold is left open.')
    lines = [about['command'], f'campaign seed {about["seed"]}',
             f'{about["repeats"]} rounds of timing',
             f'calibration loop, at best: {1e3 * (about.get("calibration") or 0.0):.3g} ms',
             *(f'{name}: {value}' for name, value in about['machine'].items()),
             *(f'part {name}: {seconds:.0f} s' for name, seconds in results['seconds'].items())]
    page.code('\n'.join(lines))
    page.unfold()
