"""The command line of `report`: which sections, how many runs, and where the page goes."""
import os
from pathlib import Path
import shlex
import sys
import time

from bristle_ros.command_line import check_range, Parser
from bristle_ros.log import provenance

SECTIONS = ('precision', 'estimate', 'peers', 'paper', 'theory', 'stability', 'cost')


def _parse(arguments):
    parser = Parser('report', 'Measures error against run time, the findings of the paper, '
                    'stability and what each feature costs; writes a page with its figures and '
                    'tables (CSV).')
    parser.add_argument('--quick', action='store_true', help='fewer and shorter runs: minutes')
    parser.add_argument('--output', default='report', metavar='DIR',
                        help='where index.html and the CSV files go; default: report')
    parser.add_argument('--only', metavar='SECTION', action='append', choices=SECTIONS,
                        help=f'one of {", ".join(SECTIONS)}; may be given often')
    parser.add_argument('--seed', type=int, metavar='N',
                        help='of the randomly drawn campaign cases; default: the clock')
    parser.add_argument('--drawn', type=int, metavar='N',
                        help='how many cases are drawn; default 100, with --quick 8')
    parser.add_argument('--wall-limit', type=float, default=20.0, metavar='S',
                        help='of one campaign case; default 20')
    parser.add_argument('--repeats', type=int, metavar='N',
                        help='timings are the best of so many; default 5, with --quick 2')
    options = parser.parse_args(arguments)
    if options.drawn is None:
        options.drawn = 8 if options.quick else 100
    if options.repeats is None:
        options.repeats = 2 if options.quick else 5
    if options.seed is None:
        options.seed = int(time.time())
    for name, low, high in (('repeats', 1, 1000), ('drawn', 0, 100_000), ('seed', 0, 2**63),
                            ('wall-limit', 0.01, 86400.0)):
        check_range(options, name, low, high)
    return options


def main(arguments):
    """Run the verb `report`; return its exit code: 1 where the campaign is not a pass."""
    options = _parse(arguments)
    folder = Path(options.output).expanduser()
    folder.mkdir(parents=True, exist_ok=True)   # before minutes are spent
    from . import sections  # from here on numpy and the compiler are needed
    from .page import Page, Progress
    page = Page('bristle_ros: error against run time, stability, and what the paper claims')
    progress = Progress()
    began = time.monotonic()
    command = shlex.join(['python3', '-m', 'bristle_ros', 'report', *arguments])
    machine = provenance()
    page.code('\n'.join([
        command, f'made {time.strftime("%Y-%m-%d %H:%M UTC", time.gmtime())}, '
        f'{"quick form" if options.quick else "full form"}; campaign seed {options.seed}',
        f'{os.cpu_count()} cores; timings on one of them, best of {options.repeats}',
        *(f'{name}: {value}' for name, value in machine.items())]))
    problems = []
    for name in options.only or SECTIONS:
        problem = getattr(sections, name)(page, progress, options)
        if problem:
            problems.append(f'{name}: {problem}')
    page.text(f'The whole page took {time.monotonic() - began:.0f} s.', note=True)
    path = page.write(folder)
    progress.close()
    print(f'written: {path} and {len(page.tables)} tables beside it')
    if problems:
        print(f'report: {"; ".join(problems)}: see {path}', file=sys.stderr)
    return 1 if problems else 0
