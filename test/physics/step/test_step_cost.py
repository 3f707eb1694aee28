"""What a step costs in instructions, which no busy machine changes."""
import subprocess
import sys

import pytest

# Of a default step of cutting_brush, code for x86-64-v3. A change that makes it more has a reason
# that CHANGELOG tells; one that makes it less is written down here, or it would be lost again.
INSTRUCTIONS = 19860
# libm chooses its functions by processor
TOLERANCE = 0.05


def traceable():
    """Whether a process may ask to be traced: some containers forbid it."""
    return subprocess.run([sys.executable, '-c', 'import ctypes\n'
                           'raise SystemExit(ctypes.CDLL(None).ptrace(0, 0, 0, 0) != 0)'],
                          check=False).returncode == 0


@pytest.mark.needs('ptrace', traceable)
def test_a_default_step_costs_what_it_did(root):
    done = subprocess.run([sys.executable, 'tools/count_instructions.py', '--step'], cwd=root,
                          capture_output=True, text=True, timeout=900)
    assert done.returncode == 0, done.stderr
    counted = float(done.stdout.splitlines()[-1].split('|')[2])
    assert counted == pytest.approx(INSTRUCTIONS, rel=TOLERANCE)
