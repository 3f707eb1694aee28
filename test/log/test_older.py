"""Logs of earlier versions say the same as ever."""
from pathlib import Path

from bristle_ros.log.recording import Recording
from bristle_ros.verbs.verify import verify

# made by version 0.3.0, which knew no solver.newton: 0.12 s of a sweep, four elements
LOG = Path(__file__).parent / 'logs' / 'version_0.3.mcap'


def test_a_log_of_version_0_3_is_replayed():
    solver = Recording(LOG).scene.solver
    assert (solver.newton, solver.tolerance) == ('tolerance', 1e-8)
    found = verify(LOG)
    assert found.difference == ''
    assert found.compared > 100
