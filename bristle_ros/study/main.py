"""The command line of `study`: many runs of a scene, and the page that shows them."""
from importlib.util import find_spec
import os
from pathlib import Path
import sys

from bristle_ros.command_line import INTERRUPTED, Parser
from bristle_ros.scene import SceneError, to_yaml


def _parse(arguments):
    parser = Parser('study', 'Runs the rows of a study file on the cores of this machine, or on a '
                    'cluster of Dask, and draws a page of what came out. Needs the extra [study].')
    parser.add_argument('study', metavar='STUDY.yaml|DIR', help='a study file; with --page the '
                        'directory of a study')
    parser.add_argument('--output', metavar='DIR', help="where rows, curves and page go; default: "
                        "the file's name without its ending")
    parser.add_argument('--workers', type=int, metavar='N', help='processes of this machine; '
                        'default: one for each core')
    parser.add_argument('--scheduler', metavar='ADDRESS', help='of a Dask scheduler that is '
                        'there, as tcp://host:8786, instead of workers of this machine')
    parser.add_argument('--resume', action='store_true', help='go on with what DIR has of this '
                        'study')
    parser.add_argument('--dry-run', action='store_true', help='check the study; say how many '
                        'runs it has and how long they will take; show a scene')
    parser.add_argument('--page', action='store_true', help='draw the page of a directory again')
    options = parser.parse_args(arguments)
    for name, other in (('workers', 'scheduler'), ('page', 'resume'), ('page', 'dry_run'),
                        ('page', 'workers'), ('page', 'scheduler'), ('page', 'output'),
                        ('dry_run', 'resume'), ('dry_run', 'scheduler')):
        if getattr(options, name) and getattr(options, other):
            raise SceneError('contradicts --' + other.replace('_', '-'),
                             key='--' + name.replace('_', '-'))
    if options.workers is not None and not 1 <= options.workers <= 1024:
        raise SceneError('must be a whole number from 1 to 1024', key='--workers',
                         value=options.workers)
    return options


def main(arguments):
    """Run the verb `study`; return its exit code."""
    options = _parse(arguments)
    if options.page:
        from .page import write_page
        print(f'written: {write_page(options.study)}')
        return 0
    from .study_file import read_study
    study = read_study(options.study)
    if options.dry_run:
        return _dry_run(study, options)
    folder = Path(options.output or Path(options.study).with_suffix('')).expanduser()
    return _run(study, folder, options)


def _run(study, folder, options):
    from . import store
    from .campaign import carry_out
    from .cluster import ClusterLost, open_cluster
    from .page import write_page
    store.check(study, folder, resume=options.resume)   # before a cluster is started
    resume = f'--resume goes on: study {options.study} --output {folder} --resume'
    try:
        with open_cluster(options.scheduler, options.workers or cores()) as client:
            if find_spec('bokeh'):
                print(f'dashboard: {client.dashboard_link}')
            complete = carry_out(study, folder, client, resume=options.resume)
    except ClusterLost as error:
        print(f'study: {error}; {resume}', file=sys.stderr)
        return 3
    rows = store.count(folder)
    if not complete:
        print(f'study: interrupted after {rows} of {study.runs} runs; {resume}', file=sys.stderr)
        return INTERRUPTED
    print(f'{rows} runs; written: {write_page(folder)}')
    return 0


def cores():
    """Return how many cores this process may use."""
    return len(os.sched_getaffinity(0))


def _dry_run(study, options):
    from . import design
    from .batch import seconds_of
    from .campaign import probed
    refused, example = 0, None
    numbers = probed(study) if study.design != 'optimise' else []
    for number in numbers:
        try:
            example = study.scene_of(design.rows(study, number, number + 1)[0])
        except SceneError as error:
            refused += 1
            print(f'row {number} will be refused: {error}')
    print(to_yaml(example or study.scene), end='')
    print(f'{study.runs} runs ({study.design} of {len(study.factors)} keys)')
    if numbers and example:
        timed = seconds_of(study, numbers)
        each = sum(seconds for _, seconds in timed) / len(timed)
        workers = options.workers or cores()
        print(f'{each:.3g} s a run, of {len(timed)} that were timed: about '
              f'{each * study.runs / workers:.3g} s on {workers} workers')
    return 0
