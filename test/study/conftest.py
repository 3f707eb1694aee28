"""Tests of studies, where what they need is installed; and one cluster for all of them."""
from importlib.util import find_spec

import pytest

MISSING = [name for name in ('distributed', 'optuna', 'plotly', 'pyarrow', 'rainflow', 'SALib',
                             'scipy', 'xarray', 'zarr') if find_spec(name) is None]
collect_ignore_glob = ['test_*.py'] if MISSING else []


def pytest_terminal_summary(terminalreporter):
    if MISSING:
        terminalreporter.write_line(
            f'test/study is left out: no {", ".join(MISSING)} (./test.sh --all installs them)',
            yellow=True)


@pytest.fixture(scope='session')
def client():
    """A cluster in this process."""
    from distributed import Client
    with Client(processes=False, n_workers=1, threads_per_worker=1, dashboard_address=':0',
                memory_limit=0, set_as_default=False) as client:
        yield client


@pytest.fixture
def study_of(tmp_path, root):
    """Return a function that makes a Study of the lines of a study file."""
    from bristle_ros.study.study_file import read_study

    def make(text, name='study.yaml'):
        path = tmp_path / name
        path.write_text(f'scene: {root / "test/small_brush.yaml"}\n{text}', encoding='utf-8')
        return read_study(path)
    return make
