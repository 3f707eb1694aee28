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
