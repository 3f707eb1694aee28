"""The controller that steers along a kerb, on a running node: how soon, how well, and its end."""
import json
import signal
import subprocess
import sys

from bristle_ros.log.recording import Recording
from bristle_ros.messages.encode import decode_event, EVENTS, TOPICS
from nodes import Brush, example, ROOT, seconds
import numpy as np
import pytest
from sensor_msgs.msg import JointState
from std_msgs.msg import String

# the brush's tips are about 1 cm from the kerb's face at the start
SCENE = """
/**:
  ros__parameters:
    brush: {bristle_count: 8, wires_per_bristle: 20}
    road: {penetration: 0.03, approach_time: 0.2}
    gutter: {enabled: true, kerb_distance: 0.213}
    contact: {points: tip}
    friction: {static: 0.3, kinetic: 0.3, decay: 0.0}
    damping: {mass: 1.0, stiffness: 0.002}
    drive: {profile: constant, mean_speed: 10.0}
    sweeper: {velocity: [0.5, 0.0]}
    solver: {elements: 3, integration_time_step: 5.0e-4}
    run: {chunk: 0.005, sample: 0.005, command_timeout: 0.3}
"""
WANTED = 1.5        # [N]
[FORCE] = [topic.decode for topic in TOPICS if topic.name == 'contact_wrench']


def side_force(log):
    """
    Return times [s], force to the right [N], time of the last command [s], delay of the stop [s].

    The delay is one of the wall clock, as run.command_timeout is.
    """
    its, times, forces, came, stops = Recording(log).integration_time_step, [], [], [], []
    for entry in Recording(log).entries():
        t, wall = entry.step * its, entry.message.publish_time * 1e-9
        if entry.name == 'contact_wrench':
            times.append(t)
            forces.append(-FORCE(entry.message.data)[1])
        elif entry.name == 'cmd_vel':
            came.append((t, wall))
        elif entry.name == EVENTS and decode_event(entry.message.data).get('event') == 'timeout':
            stops.append((t, wall))
    # the stop itself is logged as a command of zeros
    died, last = max(each for each in came if each[0] < stops[-1][0])
    return np.array(times), np.array(forces), died, stops[-1][1] - last


def test_the_kerb_is_found_and_followed(scene, user, tmp_path):
    log = tmp_path / 'run'
    with Brush(scene, log=log) as brush:
        events = user.listen(String, 'brush_node/events')
        joint = user.listen(JointState, 'joint_states')
        user.until(lambda: joint, 'the brush')
        with example('follow_kerb.py', str(WANTED), '0.5') as controller:
            user.until(lambda: seconds(joint[-1]) > 12.0, 'twelve seconds')
            controller.send_signal(signal.SIGKILL)
            # What came of it is told by the brush: this node may lag behind it.
            user.until(lambda: json.loads(events[-1].data)['event'] == 'timeout', 'the stop')
        assert brush.end()[0] == 0
    times, forces, died, delay = side_force(log)
    mean = np.convolve(forces, np.full(100, 0.01), 'valid')     # over 0.5 s
    ends = times[99:]
    reached = ends[mean > 0.9 * WANTED].min()
    kept = forces[(times > died - 3.0) & (times <= died)].mean()
    most = mean[ends <= died].max()     # wires catch on the face, and let go
    print(f'{kept:.3f} N, reached after {reached:.2f} s, at most {most:.3f} N, '
          f'stopped {delay:.3f} s after its last command')
    assert reached < 10.0
    assert kept == pytest.approx(WANTED, rel=0.15)
    assert most < 2.2 * WANTED
    assert died > 11.0
    assert 0.2 < delay < 0.8    # then the sweeper stops


@pytest.mark.parametrize('arguments', [[], ['3'], ['-3', '1'], ['nan', '1'], ['3', 'fast']])
def test_what_it_cannot_follow_is_told(arguments):
    done = subprocess.run([sys.executable, str(ROOT / 'examples/follow_kerb.py'), *arguments],
                          capture_output=True, text=True, timeout=600)
    assert done.returncode == 1
    assert done.stderr.startswith('Follow a kerb by the side force on the brush: ./run.sh')
