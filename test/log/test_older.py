"""Logs of earlier versions say the same as ever."""
import os
from pathlib import Path
import subprocess
import sys

from bristle_ros.log.recording import Recording

# made by version 0.3.0, which knew no solver.newton: 0.12 s of a sweep, four elements
LOG = Path(__file__).parent / 'logs' / 'version_0.3.mcap'


def test_a_log_of_version_0_3_is_replayed():
    solver = Recording(LOG).scene.solver
    assert (solver.newton, solver.tolerance) == ('tolerance', 1e-8)
    # whatever this processor is: on what the log was made for
    done = subprocess.run(
        [sys.executable, '-m', 'bristle_ros', 'replay', '--verify', str(LOG)], text=True,
        capture_output=True, env={**os.environ, 'NUMBA_CPU_NAME': 'x86-64-v3'})
    assert done.returncode == 0, done.stderr
    assert 'identical: 146 messages' in done.stdout
