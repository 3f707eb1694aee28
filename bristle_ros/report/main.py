"""The command line of `report`: which parts, how many runs, and where the page goes."""
import os
from pathlib import Path
import shlex
import sys
import time

from bristle_ros.command_line import check_range, INTERRUPTED, Parser, StopSignals
from bristle_ros.log import measured_on
from bristle_ros.scene import SceneError

from .parts import PARTS

PEERS = ('exudyn', 'mujoco')


def _parse(arguments):
    parser = Parser('report', 'Measures error against run time, ours and of other programs, '
                    'stability, what each feature costs and what the paper claims; writes a page '
                    'with its figures, its tables (CSV) and results.json.')
    parser.add_argument('--quick', action='store_true', help='fewer and shorter runs: 2 minutes')
    parser.add_argument('--output', default='report', metavar='DIR',
                        help='where index.html and the rest go; default: report')
    parser.add_argument('--only', metavar='PART', action='append', choices=tuple(PARTS),
                        help=f'one of {", ".join(PARTS)}; may be given often')
    parser.add_argument('--compare', metavar='OLD.json',
                        help='a results.json: say what got faster, slower, better or worse')
    parser.add_argument('--peers', action='store_true',
                        help='it is an error when exudyn and MuJoCo are not there; with ./run.sh '
                        'they are installed first')
    parser.add_argument('--seed', type=int, metavar='N',
                        help='of the randomly drawn campaign cases; default: the clock')
    parser.add_argument('--drawn', type=int, metavar='N',
                        help='how many cases are drawn; default 1000, with --quick 24')
    parser.add_argument('--builds', type=int, metavar='N',
                        help='how many sets of compiled functions the drawn cases may need '
                        'together, each of which takes up to a minute; 0: any number; default '
                        '16, with --quick 4')
    parser.add_argument('--case-limit', type=float, default=20.0, metavar='S',
                        help='processor time of one campaign case; default 20, with --quick at '
                        'most 3')
    parser.add_argument('--repeats', type=int, metavar='N',
                        help='rounds of timing; default 7, with --quick 3')
    options = parser.parse_args(arguments)
    if options.drawn is None:
        options.drawn = 24 if options.quick else 1000
    if options.builds is None:
        options.builds = 4 if options.quick else 16
    if options.repeats is None:
        options.repeats = 3 if options.quick else 7
    if options.seed is None:
        options.seed = int(time.time())
    for name, low, high in (('repeats', 1, 1000), ('drawn', 0, 100_000), ('seed', 0, 2**63),
                            ('builds', 0, 1000), ('case-limit', 0.01, 86400.0)):
        check_range(options, name, low, high)
    if options.quick:
        options.case_limit = min(options.case_limit, 3.0)
    return options


def _check_peers():
    from importlib.util import find_spec
    absent = [name for name in PEERS if find_spec(name) is None]
    if absent:
        raise SceneError(f'{" and ".join(absent)} not installed here: ./run.sh report --peers '
                         'does that, or pip install -r requirements-report.txt', key='--peers')


def _about(arguments, options):
    """Return what the page says of how it was made."""
    return {'command': shlex.join(['python3', '-m', 'bristle_ros', 'report', *arguments]),
            'date': time.strftime('%Y-%m-%d %H:%M UTC', time.gmtime()), 'quick': options.quick,
            'repeats': options.repeats, 'drawn': options.drawn, 'seed': options.seed,
            'case_limit': options.case_limit, 'cores': os.cpu_count() or 1,
            'machine': measured_on()}


def _measure(results, names, options):
    """Measure the parts one by one; return whether they were interrupted."""
    from . import parts
    from .context import Context, Progress
    from .timing import timer
    from .workers import cores, crew
    progress = Progress({name: PARTS[name].quick if options.quick else PARTS[name].full
                         for name in names})
    began = time.monotonic()
    try:
        with StopSignals(), crew(len(cores())) as workers, timer(options.repeats,
                                                                 progress) as clock:
            context = Context(options.quick, options.drawn, options.seed, options.case_limit,
                              options.builds, workers, clock, progress)
            for name in names:
                progress.part(name)
                started = time.monotonic()
                results['parts'][name] = parts.measure(name, context)
                results['seconds'][name] = time.monotonic() - started
                results['about']['calibration'] = clock.best
    except KeyboardInterrupt:
        return True
    finally:
        results['about']['took'] = time.monotonic() - began
        progress.close()
    return False


def main(arguments):
    """Run the verb `report`; return its exit code: 1 where the campaign is not a pass."""
    options = _parse(arguments)
    folder = Path(options.output).expanduser()
    if options.peers:
        _check_peers()
    try:
        folder.mkdir(parents=True, exist_ok=True)   # before minutes are spent
    except OSError as error:
        raise SceneError(f'{(error.strerror or "unusable").lower()}: name another directory',
                         key='--output', value=str(folder)) from None
    from . import results as files
    old = files.read(Path(options.compare).expanduser()) if options.compare else None
    from .assemble import make_page, problems_of
    names = [name for name in PARTS if not options.only or name in options.only]
    results = {'format': files.FORMAT, 'about': _about(arguments, options), 'wanted': names,
               'parts': {}, 'seconds': {}}
    fault = None
    try:
        interrupted = _measure(results, names, options)
    except RuntimeError as error:   # of a part: what the others have measured is kept
        interrupted, fault = True, error
    results = files.clean(results)
    files.write(folder / 'results.json', results)
    page = make_page(results, old)
    path = page.write(folder)
    print(f'written: {path}, {len(page.tables)} tables and results.json beside it'
          + (f'; interrupted after {", ".join(results["parts"]) or "nothing"}' if interrupted
             else ''))
    if fault:
        raise fault
    if interrupted:
        return INTERRUPTED
    problems = problems_of(results)
    if problems:
        print(f'report: {"; ".join(problems)}: see {path}', file=sys.stderr)
    return 1 if problems else 0
