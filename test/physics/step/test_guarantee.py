"""What a step promises when it cannot be done: a status, and nothing changed. Interpreted."""
import json
import os
import subprocess
import sys

import pytest

# Kernels as plain Python, so that attempts can be made to fail; prints what `advance(1)` left.
CODE = """
import json, sys
sys.path[:0] = sys.argv[2:]
from bristle_ros.physics.step import stepping
from bristle_ros.physics.step.newton import NO_CONVERGENCE
from bristle_ros.physics.contact.tip import LEVEL
from bristle_ros.simulation import Simulation, StepFailure
from physics.scenes import bouncing_sweep

simulation = Simulation(bouncing_sweep(its=2e-4, elements=2), energies=True)
simulation.advance(3)
simulation.state.tip[0, LEVEL] = 1     # two sub-steps
before = [array.copy() for array in (simulation.state.audit, simulation.centreline())]
if sys.argv[1] == 'attempts':
    stepping.MAX_ATTEMPTS = 1
else:
    whole, calls = stepping.try_step, []

    def fail_after_one(*arguments):
        calls.append(1)
        return whole(*arguments) if len(calls) == 1 else NO_CONVERGENCE

    stepping.try_step = fail_after_one
try:
    simulation.advance(1)
    text = ''
except StepFailure as failure:
    text = str(failure)
print(json.dumps({'text': text, 'step': simulation.step,
                  'account': (simulation.state.audit == before[0]).all().item(),
                  'accounted': abs(before[0]).max().item(),
                  'place': (simulation.centreline() == before[1]).all().item()}))
"""


@pytest.mark.parametrize(('way', 'says'), [
    ('attempts', 'not done after as many sub-steps'), ('failure', 'did not shrink')])
def test_a_step_that_is_not_done_leaves_all_as_it_was(way, says):
    folders = [folder for folder in sys.path if folder]
    run = subprocess.run([sys.executable, '-c', CODE, way, *folders], check=True, text=True,
                         stdout=subprocess.PIPE, env={**os.environ, 'NUMBA_DISABLE_JIT': '1'})
    found = json.loads(run.stdout)
    assert says in found['text']
    assert found['step'] == 3
    assert found['accounted'] > 0.0
    assert found['account']
    assert found['place']
