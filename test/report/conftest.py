"""The kept report and its page, made once for all tests of the report."""
from pathlib import Path

from bristle_ros.report import results as files
from bristle_ros.report.assemble import make_page
import pytest

KEPT = Path(__file__).resolve().parent.parent.parent / 'docs' / 'report.json'


@pytest.fixture(scope='session')
def kept():
    """Return the results that are kept with the source."""
    return files.read(KEPT)


@pytest.fixture(scope='session')
def page(kept):
    """Return the Page of the kept results."""
    return make_page(kept)


class Alone:
    """A crew and a timer in this process."""

    best = 1.0

    def run(self, jobs, *, limit=None, show=None):
        found = []
        for job in jobs:
            found.append(job.function(*job.arguments))
            if show:
                show(found[-1], job, len(found), len(jobs))
        return found

    def group(self, timed, repeats=None):
        return {each.key: {'walls': [each.prepare(*each.arguments)() / each.per], 'disturbed': 0,
                           'slowest': 1.0} for each in timed}


@pytest.fixture
def alone():
    """Return a crew and timer that work in this process."""
    return Alone()
