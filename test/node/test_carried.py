"""A brush that another simulator carries in lockstep; one that follows cmd_mount as it comes."""
from bristle_ros.log.recording import Recording
from bristle_ros.verbs.verify import verify
from geometry_msgs.msg import WrenchStamped
from nav_msgs.msg import Odometry
from nodes import Brush, seconds
import numpy as np
import pytest
from sensor_msgs.msg import JointState

SCENE = """
/**:
  ros__parameters:
    brush: {bristle_count: 2}
    contact: {points: tip}
    road: {penetration: -1.0, approach_time: 0.0}
    damping: {mass: 0.0, stiffness: 1.0e-7}
    drive: {profile: constant, mean_speed: 5.0}
    solver: {elements: 4}
    mount: {enabled: true}
    run: {chunk: 0.01, sample: 0.005}
"""
CHUNK, HEIGHT = 0.01, 1.2157
CHUNKS = 30


def odometry(stamp, t, **changes):
    """Return a mount that heaves from where the scene's is; stamp [s]."""
    message = Odometry()
    message.header.frame_id, message.child_frame_id = 'road', 'brush_mount'
    message.header.stamp.nanosec = round(stamp * 1e9)
    message.pose.pose.position.z = HEIGHT + 0.01 * (1.0 - np.cos(20.0 * t))
    message.twist.twist.linear.z = 0.2 * np.sin(20.0 * t)
    for name, value in changes.items():
        setattr(message.pose.pose.position, name, value)
    return message


def carried(user, scene, log, spoilt=()):
    """Run a brush in lockstep; return means of its wrench, and what it printed."""
    with Brush(scene, 'run.carried:=true', log=log) as brush:
        means = user.listen(WrenchStamped, 'mount_wrench_mean')
        way = user.publisher(Odometry, 'cmd_mount')
        for chunk in range(1, CHUNKS + 1):
            stamp = chunk * CHUNK
            while chunk == 1 and not user.came(means, 0.1):     # it may not be active yet
                way.publish(odometry(stamp, stamp))
            if chunk in spoilt:
                way.publish(odometry(stamp + 0.001, 0.0))       # another chunk's
                way.publish(odometry(stamp, stamp, x=float('nan')))
            elif chunk > 1:
                way.publish(odometry(stamp, stamp))
            user.until(lambda chunk=chunk: len(means) == chunk, f'chunk {chunk}')
            assert seconds(means[-1]) == pytest.approx(stamp, abs=1e-9)
        assert not user.came(means)     # it waits
        code, printed = brush.end()
        assert code == 0, printed
    return means, printed


def outputs(log):
    return [(entry.name, entry.step, entry.message.data) for entry in Recording(log).entries()
            if entry.name not in ('/diagnostics', '~/scene') and '/events' not in entry.name]


def test_in_lockstep_runs_are_equal_bit_for_bit(scene, user, tmp_path):
    means, _ = carried(user, scene, tmp_path / 'one')
    carried(user, scene, tmp_path / 'two')
    assert outputs(tmp_path / 'one') == outputs(tmp_path / 'two')
    assert len(outputs(tmp_path / 'one')) > CHUNKS * 10
    verdict = verify(tmp_path / 'one')
    assert (verdict.difference, verdict.applied) == ('', CHUNKS)
    # two wires of 1.87 g: their weight, and in the mean no more while the mount heaves
    force = np.mean([mean.wrench.force.z for mean in means])
    assert force == pytest.approx(-9.81 * 2 * 0.001872, rel=0.2)


def test_what_it_cannot_follow_is_told_and_holds_nobody(scene, user, tmp_path):
    means, printed = carried(user, scene, tmp_path / 'run', spoilt=(7,))
    assert len(means) == CHUNKS
    assert 'refused: cmd_mount: stamped 0.071 s, and the next chunk is the chunk' in printed
    assert 'is not finite' in printed
    assert verify(tmp_path / 'run').applied == CHUNKS - 1


def test_out_of_lockstep_it_follows_what_comes(scene, user, tmp_path):
    """Of two senders at once too; a node that was not told beforehand halts to get ready."""
    with Brush(scene, 'run.command_timeout:=0.3', 'mount.enabled:=false',
               log=tmp_path / 'run') as brush:
        joints = user.listen(JointState, 'joint_states')
        way, other = user.publisher(Odometry, 'cmd_mount'), user.publisher(Odometry, 'cmd_mount')
        user.until(lambda: joints, 'the brush')
        wrong = odometry(0.0, 0.0)
        wrong.header.frame_id = 'map'
        way.publish(wrong)
        way.publish(odometry(0.0, 0.0, x=1.0))      # a metre in a chunk
        user.came(joints)
        for _ in range(200):
            way.publish(odometry(0.0, 0.0))         # a burst
            other.publish(odometry(0.0, 0.0, x=2.0))
        before = seconds(joints[-1])
        user.until(lambda: seconds(joints[-1]) > before + 1.0, 'a second')
        code, printed = brush.end()
    assert code == 0, printed
    assert "refused: cmd_mount: frame 'map': must be road" in printed
    assert 'beyond mount.max_' in printed
    assert printed.count('the first cmd_mount: the brush halts') == 1
    verdict = verify(tmp_path / 'run')
    assert verdict.difference == ''
    assert verdict.applied >= 2     # it was carried, and has braked since
