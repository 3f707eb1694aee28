"""The controllers of examples/ on a running node: how soon, how far beyond, and when they die."""
import signal
import subprocess
import sys

from bristle_ros.log.recording import Recording
from bristle_ros.messages.encode import decode_command, FLOAT, TOPICS
from nodes import Brush, example, ROOT, seconds
import numpy as np
import pytest
from sensor_msgs.msg import JointState

# lifted at the start, so that the controller has to find the road
SCENE = """
/**:
  ros__parameters:
    brush: {bristle_count: 4}
    road: {penetration: -0.01, max_rate: 0.1}
    damping: {mass: 1.0, stiffness: 0.002}
    drive: {profile: constant, mean_speed: 10.0}
    solver: {elements: 3, integration_time_step: 5.0e-4}
    run: {chunk: 0.005, sample: 0.005}
"""
WANTED = 0.4            # [N] of four wires
[FORCE] = [topic.decode for topic in TOPICS if topic.name == 'contact_wrench']


def force_of(log):
    """Return times [s], force along the axis [N] and (time, depth) of the commands."""
    its = Recording(log).integration_time_step
    times, forces, commands = [], [], []
    for entry in Recording(log).entries():
        if entry.name == 'contact_wrench':
            times.append(entry.step * its)
            forces.append(FORCE(entry.message.data)[2])
        elif entry.name == 'cmd_penetration':
            commands.append((entry.step * its, *decode_command(FLOAT, entry.message.data)))
    return np.array(times), np.array(forces), np.array(commands)


def test_the_force_is_found_and_held(scene, user, tmp_path):
    log = tmp_path / 'run'
    with Brush(scene, log=log) as brush:
        joint = user.listen(JointState, 'joint_states')
        user.until(lambda: joint, 'the brush')
        with example('hold_force.py', str(WANTED)) as controller:
            user.until(lambda: len(force_of(log)[2]), 'the first command')
            begun = force_of(log)[2][0, 0]
            user.until(lambda: seconds(joint[-1]) > begun + 6.0, 'six seconds')
            controller.send_signal(signal.SIGKILL)
            user.until(lambda: user.came(joint), 'messages from after it')
            died = seconds(joint[-1])
            user.until(lambda: seconds(joint[-1]) > died + 1.0, 'one second more')
        assert brush.end()[0] == 0
    times, forces, commands = force_of(log)
    mean = np.convolve(forces, np.full(40, 1.0 / 40.0), 'valid')    # over 0.2 s
    ends = times[39:] - begun
    outside = ends[np.abs(mean / WANTED - 1.0) > 0.05]
    settled, overshoot = outside[outside < died - begun].max(), mean.max() / WANTED - 1.0
    print(f'settled to 5 % after {settled:.2f} s, overshoot {overshoot:.1%}')
    assert settled < 4.0
    assert overshoot < 0.15
    assert forces[times < begun].max() == 0.0   # it was lifted
    held = forces[(times > died - 1.0) & (times <= died)].mean()
    after = forces[times > died + 0.2].mean()
    assert held == pytest.approx(WANTED, rel=0.02)
    assert after == pytest.approx(WANTED, rel=0.05)     # nobody commands, and it stays
    assert commands[-1, 0] < died + 0.1


@pytest.mark.parametrize('arguments', [[], ['-3'], ['nan'], ['much']])
def test_what_it_cannot_hold_is_told(arguments):
    done = subprocess.run([sys.executable, str(ROOT / 'examples/hold_force.py'), *arguments],
                          capture_output=True, text=True, timeout=600)
    assert done.returncode == 1
    assert done.stderr.startswith('Hold the force of the road on the brush: ./run.sh')
