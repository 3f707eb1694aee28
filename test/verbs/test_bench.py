"""The verb `bench`: what it prints, and that its numbers follow from the clock it is given."""
import json
import subprocess
import sys

from bristle_ros.scene.scene import Scene
from bristle_ros.scene.sections import Contact, Run, Solver
from bristle_ros.simulation.simulation import Simulation
from bristle_ros.verbs import bench
import pytest

LEAN = Scene(contact=Contact(enabled=False), solver=Solver(elements=4),
             run=Run(chunk=0.002, sample=0.002))


def run_verb(root, *arguments):
    return subprocess.run([sys.executable, '-m', 'bristle_ros', *arguments], cwd=root, text=True,
                          capture_output=True, timeout=600)


class HandTurned:
    """A clock whose readings come from a list of durations, one for each pair of readings."""

    def __init__(self, durations):
        self.durations = iter(durations)
        self.now, self.inside = 0.0, False

    def __call__(self):
        if self.inside:
            self.now += next(self.durations)
        self.inside = not self.inside
        return self.now


def test_percentiles_are_of_the_sample():
    ordered = [1.0, 2.0, 3.0, 4.0, 5.0, 6.0, 7.0, 8.0, 9.0, 10.0]
    assert bench.percentile(ordered, 0.5) == 5.0
    assert bench.percentile(ordered, 0.95) == 10.0
    assert bench.percentile(ordered, 0.01) == 1.0
    assert bench.percentile([3.0], 0.5) == 3.0


def test_best_of_keeps_the_least():
    least, result = bench.best_of(iter('abc').__next__, 3, HandTurned([3.0, 1.0, 2.0]))
    assert (least, result) == (1.0, 'c')


def test_numbers_follow_from_the_clock():
    # two repeats of 5 chunks of 20 steps; each repeat begins with the calibration loop
    slow = [0.7, 1.0, 1.0, 1.0, 1.0, 1.0]
    fast = [0.3, 0.1, 0.1, 0.4, 0.1, 0.1]
    simulation = Simulation(LEAN)
    found = bench.measure(simulation, 0.01, 2, HandTurned(slow + fast))
    assert found['calibration_s'] == pytest.approx(0.3)
    assert found['wall_per_simulated_second'] == pytest.approx(0.8 / 0.01)
    assert found['step_us'] == pytest.approx(0.8e6 / 100)
    assert found['chunk_time_s'] == pytest.approx({'p50': 0.1, 'p95': 0.4, 'p99': 0.4, 'max': 0.4})
    assert found['real_time_factor'] == pytest.approx(
        {'mean': 0.01 / 0.8, 'p50': 0.02, 'p5': 0.005, 'p1': 0.005})
    # counted over one repeat, not over all of them
    simulation.reset()
    simulation.advance(100)
    newton = simulation.snapshot().newton_iterations
    assert found['newton_per_step'] == newton / 100
    assert found['newton_us'] == pytest.approx(0.8e6 / newton)


def test_the_verb_prints_the_contracts_keys(root):
    done = run_verb(root, 'bench', 'config/free_rotation.yaml', '--duration', '0.02', '--repeats',
                    '2', '-p', 'solver.elements:=4')
    assert done.returncode == 0, done.stderr
    found = json.loads(done.stdout)
    assert {'wall_per_simulated_second', 'compile_time', 'step_us', 'newton_us', 'newton_per_step',
            'substeps', 'chunk_time_s', 'real_time_factor', 'calibration_s'} <= set(found)
    assert list(found['chunk_time_s']) == ['p50', 'p95', 'p99', 'max']
    assert list(found['real_time_factor']) == ['mean', 'p50', 'p5', 'p1']
    assert found['steps'] == 100
    assert found['newton_per_step'] >= 1.0


@pytest.mark.parametrize(('arguments', 'message'), [
    (('--duration', '-1'), 'bench: --duration = -1.0: must be a number from 1e-09 to 100000'),
    (('--repeats', '0'), 'bench: --repeats = 0: must be a number from 1 to 1000'),
    (('-p', 'drive.shape:=2'), 'bench: -p: drive.shape = 2: ')])
def test_unusable_input_is_one_line(root, arguments, message):
    done = run_verb(root, 'bench', 'config/free_rotation.yaml', *arguments)
    assert done.returncode == 2
    assert done.stderr.startswith(message)
    assert done.stderr.count('\n') == 1
