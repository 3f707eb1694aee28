"""What every test runs under: its own corner of the ROS network, and no silent skips."""
import itertools
import os
from pathlib import Path
import shutil
import sys

import numpy as np
import pytest

ROOT = Path(__file__).resolve().parent.parent
# Tests run from the checkout, in this process and in the ones that they start.
sys.path[:0] = [str(ROOT), str(ROOT / 'test')]  # the latter for what tests share
os.environ['PYTHONPATH'] = str(ROOT)
# Hundreds of programs are started: where Python may not keep what it compiles, each compiles it.
os.environ.pop('PYTHONDONTWRITEBYTECODE', None)
os.environ['BRISTLE_ROS_COMPILING_AHEAD'] = '1'  # both cores are busy: no process more to compile
# Nodes of other users of this machine's network must not be seen, nor ours by them.
os.environ['ROS_AUTOMATIC_DISCOVERY_RANGE'] = 'LOCALHOST'
# Processes that share the tests take turns with the numbers, so that their nodes never meet; the
# fault campaign takes two at a time.
_worker, _workers = (int(os.environ.get(name, default).removeprefix('gw'))
                     for name, default in (('PYTEST_XDIST_WORKER', '0'),
                                           ('PYTEST_XDIST_WORKER_COUNT', '1')))
_numbers = range(1 + 2 * _worker, 100, 2 * _workers)
_domains = itertools.islice(itertools.cycle(_numbers), os.getpid() % len(_numbers), None)
os.environ['ROS_DOMAIN_ID'] = str(next(_domains))
ABSENT = pytest.StashKey()     # tests left out -> the program that they need
# Rooms whose tests share something that takes long to make: one process runs them all; other tests
# stay together by their file.
TOGETHER = ('report', 'study')
# Rooms with long tests, which go first: what is short fills the end of both processes.
LONG = ('report', 'view', 'verbs', 'node', 'simulation', 'study', 'faults')
# Arithmetic that goes wrong in Python code is an error; compiled code answers with a status.
np.seterr(divide='raise', over='raise', invalid='raise')


def pytest_addoption(parser):
    parser.addoption('--fail-on-skip', action='store_true',
                     help='a test that is skipped fails the run')


@pytest.hookimpl(tryfirst=True)     # before pytest-xdist looks for groups
def pytest_collection_modifyitems(config, items):
    """Leave out what needs a program that is not here, and say so: it must not pass for done."""
    def room_of(item):
        return item.path.relative_to(ROOT / 'test').parts[0]
    items.sort(key=lambda item: (*LONG, room_of(item)).index(room_of(item)))
    for item in items:
        room, place = room_of(item), item.path.relative_to(ROOT / 'test')
        item.add_marker(pytest.mark.xdist_group(room if room in TOGETHER else str(place)))
    absent = {item.nodeid: mark.args[0] for item in items
              for mark in item.iter_markers('needs') if not mark.args[1]()}
    if not all(shutil.which(name) for name in ('chromium', 'chromedriver')):
        absent |= {item.nodeid: 'chromium' for item in items if item.get_closest_marker('browser')}
    if absent:
        config.stash[ABSENT] = absent
        config.hook.pytest_deselected(items=[item for item in items if item.nodeid in absent])
        items[:] = [item for item in items if item.nodeid not in absent]


def pytest_terminal_summary(terminalreporter, config):
    for nodeid, program in config.stash.get(ABSENT, {}).items():
        terminalreporter.write_line(f'not run, {program} is not here: {nodeid}', yellow=True)


@pytest.hookimpl(optionalhook=True)
def pytest_testnodedown(node, error):
    """Take over what another process has left out."""
    absent = node.config.stash.setdefault(ABSENT, {})
    absent.update(getattr(node, 'workeroutput', {}).get('absent', {}))


@pytest.hookimpl(trylast=True)
def pytest_sessionfinish(session, exitstatus):
    if hasattr(session.config, 'workeroutput'):
        session.config.workeroutput['absent'] = session.config.stash.get(ABSENT, {})
    reporter = session.config.pluginmanager.get_plugin('terminalreporter')
    skipped = reporter.stats.get('skipped', []) if reporter else []
    if skipped and session.config.getoption('--fail-on-skip') and exitstatus == 0:
        reporter.write_line(f'{len(skipped)} skipped, and --fail-on-skip is given', red=True)
        session.exitstatus = pytest.ExitCode.TESTS_FAILED


@pytest.fixture(scope='session')
def root():
    """Return the checkout."""
    return ROOT


@pytest.fixture(scope='module')
def environment():
    """Keep a module's graph apart from those of other modules, which may be still leaving."""
    before = os.environ['ROS_DOMAIN_ID']
    os.environ['ROS_DOMAIN_ID'] = str(next(_domains))
    yield
    os.environ['ROS_DOMAIN_ID'] = before


@pytest.fixture
def user(environment):
    """Another node, in this process."""
    import nodes  # here: most tests need no ROS
    made = nodes.User()
    yield made
    made.leave()


@pytest.fixture
def scene(request, tmp_path):
    """Return a scene file of the module's SCENE."""
    path = tmp_path / 'scene.yaml'
    path.write_text(request.module.SCENE)
    return path
