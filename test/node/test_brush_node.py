"""The node as users meet it: its own process, real rclpy, messages over DDS, signals, logs."""
import os
from pathlib import Path
import re
import shutil
import signal
import subprocess
import sys
import time

from bristle_ros.log.file import McapFile
from bristle_ros.log.recording import Recording
from bristle_ros.messages.definitions import schema_text
from bristle_ros.messages.encode import decode_event, decode_string, TF
from bristle_ros.messages.scene import SCENE as SCENE_TOPIC
from diagnostic_msgs.msg import DiagnosticArray
from geometry_msgs.msg import PoseStamped, Twist, TwistStamped, WrenchStamped
from lifecycle_msgs.msg import Transition
from lifecycle_msgs.srv import ChangeState, GetState
from nodes import Brush, LIMIT, ROOT, run, seconds
import numpy as np
import pytest
from rcl_interfaces.msg import Parameter, ParameterType, ParameterValue
from rcl_interfaces.srv import DescribeParameters, GetParameters, SetParameters
from rclpy.qos import DurabilityPolicy, qos_profile_sensor_data, QoSProfile, ReliabilityPolicy
from rosbags.typesys import get_typestore, Stores
from rosgraph_msgs.msg import Clock
from sensor_msgs.msg import JointState
from std_msgs.msg import Float64, String, UInt8MultiArray
from std_srvs.srv import SetBool, Trigger
from visualization_msgs.msg import MarkerArray

SCENE = (ROOT / 'test/small_brush.yaml').read_text()


def samples(log, topic):
    """Return [(step, CDR bytes)] of one topic of a log."""
    return [(entry.step, entry.message.data) for entry in Recording(log).entries()
            if entry.name == topic]


def chunks(messages):
    """Check that messages come in order, whole chunks apart; a busy machine loses some."""
    steps = np.diff([seconds(message) for message in messages]) / 0.005
    np.testing.assert_allclose(steps, np.round(steps), atol=1e-5)
    return np.all(np.round(steps) >= 1)


def effects(log):
    """Return (step, name) of the commands that took effect, as far as the log goes."""
    return [(entry.step, entry.name) for entry in Recording(log).entries()
            if entry.name.startswith('cmd_')]


def told(report):
    """Return what a message of /diagnostics says."""
    return {pair.key: pair.value for pair in report.status[0].values}


def follow_each_other(log):
    """Whether a log holds the sample of each millisecond from the start on."""
    steps = [step for step, _ in samples(log, 'joint_states')]
    return len(steps) > 20 and steps == list(range(2, 2 * len(steps) + 2, 2))


def test_in_the_loop(scene, user, tmp_path):
    """Commands in, every topic out, and the same bits again from what the log holds."""
    log = tmp_path / 'run'
    with Brush(scene, log=log) as brush:
        heard = {topic: user.listen(type_, topic) for topic, type_ in {
            'contact_wrench': WrenchStamped, 'tip_wrench': WrenchStamped,
            'mount_wrench': WrenchStamped, 'tip_pose': PoseStamped, 'joint_states': JointState,
            'bristle_markers': MarkerArray}.items()}
        user.until(lambda: all(len(found) > 20 for found in heard.values()), 'every topic')
        user.publisher(Float64, 'cmd_brush_speed').publish(Float64(data=7.0))
        speeds = heard['joint_states']
        user.until(lambda: speeds[-1].velocity[0] == pytest.approx(7.0), 'the commanded speed')
        velocity = TwistStamped()
        velocity.twist.linear.x = 0.4
        user.publisher(TwistStamped, 'cmd_vel').publish(velocity)
        user.publisher(Float64, 'cmd_penetration').publish(Float64(data=0.004))
        bad = user.publisher(Float64, 'cmd_brush_speed')
        bad.publish(Float64(data=float('nan')))
        bad.publish(Float64(data=1e308))
        reports = user.listen(DiagnosticArray, '/diagnostics')
        user.until(lambda: reports and told(reports[-1])['refused commands'] == '2', 'refusals')
        scenes = user.listen_late(String, 'brush_node/scene')
        user.until(lambda: scenes, 'the scene, said before this subscriber came')
        user.until(lambda: user.came(speeds) and len(effects(log)) == 3, 'the other commands')
        after = len(speeds)
        user.until(lambda: len(speeds) > after + 100, 'the brush going on')
        code, printed = brush.end()
    assert code == 0, printed
    assert 'Traceback' not in printed
    assert re.search('refused: .* is not finite', printed)
    assert re.search('refused: .* beyond drive.max_speed', printed), 'each reason is told'
    assert heard['tip_wrench'][-1].header.frame_id == 'road'
    assert heard['contact_wrench'][-1].header.frame_id == 'brush_mount'
    assert [(marker.ns, marker.id) for marker in heard['bristle_markers'][-1].markers] == [
        ('bristles', 0), ('road', 0), ('contact_force', 0), ('contact_force', 1)]
    [(_, logged_scene)] = samples(log, SCENE_TOPIC)
    assert scenes[0].data == decode_string(logged_scene)
    assert chunks(speeds)
    assert follow_each_other(log)
    done = run('replay', log, '--verify')
    assert (done.returncode, 'identical' in done.stdout) == (0, True), done.stdout + done.stderr
    last = samples(log, 'tip_pose')[-1][0]
    again = tmp_path / 'again.mcap'
    done = run('simulate', scene, '--duration', last * 5e-4, '--commands', log, '--output', again)
    assert done.returncode == 0, done.stderr
    for topic in heard.keys() - {'bristle_markers'}:
        assert samples(log, topic) == samples(again, topic)
    # Topics keep no order among each other on their way.
    assert sorted(name for _, name in effects(log)) == [
        'cmd_brush_speed', 'cmd_penetration', 'cmd_vel']
    assert all(step % 10 == 0 for step, _ in effects(log)), 'commands take effect at chunk starts'


def test_markers_come_at_their_rate_and_with_each_single_step(scene, user):
    with Brush(scene) as brush:
        states = user.listen(JointState, 'joint_states')
        user.until(lambda: len(states) > 20, 'joint_states')
        began = time.monotonic()
        markers, looked = user.listen(MarkerArray, 'bristle_markers'), []
        user.node.create_subscription(
            MarkerArray, 'bristle_markers', looked.append, qos_profile_sensor_data)
        user.until(lambda: len(markers) > 20 and looked, 'markers, also for best effort')
        # However late they arrive: no more were sent than this.
        assert len(markers) <= 20.0 * (time.monotonic() - began) + 1.0
        user.pause(states)
        held = [seconds(states[-1])]
        for _ in range(3):
            assert user.call(Trigger, 'brush_node/step').success
            user.until(lambda: seconds(states[-1]) > held[-1], 'the step')
            held.append(seconds(states[-1]))
            user.until(lambda: seconds(markers[-1].markers[0]) == held[-1], 'its markers')
        assert brush.end()[0] == 0


@pytest.mark.parametrize(('rate', 'expected'), [('0', 0), ('.inf', 1)])
def test_markers_of_no_chunk_and_of_each(scene, user, rate, expected):
    with Brush(scene, f'run.marker_rate:={rate}') as brush:
        states = user.listen(JointState, 'joint_states')
        markers = user.listen(MarkerArray, 'bristle_markers')
        user.until(lambda: len(states) > 20 and (markers or not expected), 'messages')
        before = len(markers), len(states)
        user.until(lambda: len(states) > before[1] + 200, 'a second more')
        if expected:    # far more than at 20 Hz; some may be lost to a busy subscriber
            assert len(markers) - before[0] > 100
            assert {round(seconds(one.markers[0]) / 0.005, 6) % 1.0 for one in markers} == {0.0}
        else:
            assert not markers
        assert brush.end()[0] == 0


def test_what_a_recorder_hears_can_be_verified(scene, user, tmp_path):
    """Every topic as it comes, at the time at which it comes, as `ros2 bag record` stores it."""
    bag = McapFile(tmp_path / 'bag.mcap')
    kept = {'brush_node/scene', 'brush_node/events'}
    heard = []

    def record(topic, type_):
        latched = DurabilityPolicy.TRANSIENT_LOCAL if topic in kept else DurabilityPolicy.VOLATILE
        type_name = f'{type_.__module__.partition(".")[0]}/msg/{type_.__name__}'
        channel = bag.channel(f'/{topic}', type_name, schema_text(type_name).encode(), {})

        def keep(payload):
            now = time.time_ns()
            bag.add(channel, now, now, payload)
            heard.append(topic)
        user.node.create_subscription(
            type_, topic, keep, QoSProfile(depth=1000, durability=latched), raw=True)

    with Brush(scene) as brush:
        states = user.listen(JointState, 'joint_states')
        user.until(lambda: states, 'the brush, before anybody records')
        user.publisher(Float64, 'cmd_brush_speed').publish(Float64(data=7.0))
        user.until(lambda: states[-1].velocity[0] == pytest.approx(7.0), 'the commanded speed')
        for topic, type_ in {
                'contact_wrench': WrenchStamped, 'tip_wrench': WrenchStamped,
                'mount_wrench': WrenchStamped, 'tip_pose': PoseStamped, 'joint_states': JointState,
                'cmd_vel': TwistStamped, 'brush_node/scene': String,
                'brush_node/events': String}.items():
            record(topic, type_)
        user.until(lambda: kept | {'tip_pose'} <= {*heard}, 'what the recorder wants')
        velocity = TwistStamped()
        velocity.twist.linear.x = 0.4
        user.publisher(TwistStamped, 'cmd_vel').publish(velocity)
        user.until(lambda: heard.count('brush_node/events') == 3, 'start and two commands')
        assert user.call(Trigger, 'brush_node/reset').success
        user.until(lambda: heard.count('brush_node/events') == 4, 'the reset')
        after = len(heard)
        user.until(lambda: len(heard) > after + 100, 'the brush going on')
        assert brush.end()[0] == 0
    bag.finish()
    done = run('replay', tmp_path / 'bag.mcap', '--verify')
    assert (done.returncode, 'identical' in done.stdout) == (0, True), done.stdout + done.stderr
    assert '3 commands and resets' in done.stdout
    assert run('plot', tmp_path / 'bag.mcap').returncode == 0


def test_pause_step_reset(scene, user):
    with Brush(scene) as brush:
        states = user.listen(JointState, 'joint_states')
        user.until(lambda: len(states) > 20, 'joint_states')
        assert not user.call(Trigger, 'brush_node/step').success, 'only while paused'
        assert user.call(SetBool, 'brush_node/pause', data=True).success
        assert user.call(Trigger, 'brush_node/reset').success
        before = user.call(Trigger, 'brush_node/step')
        assert before.success
        user.until(lambda: states[-1].position[0] == pytest.approx(0.025), 'one chunk from start')
        held = seconds(states[-1])
        for chunk in (2, 3):
            assert user.call(Trigger, 'brush_node/step').success
            due = pytest.approx(held + (chunk - 1) * 0.005)
            user.until(lambda due=due: seconds(states[-1]) == due, 'one chunk more')
            assert states[-1].position[0] == pytest.approx(0.025 * chunk)
        assert np.all(np.diff([seconds(state) for state in states]) > 0.0), 'time never jumps back'
        assert user.call(SetBool, 'brush_node/pause', data=False).success
        user.until(lambda: seconds(states[-1]) > held + 0.1, 'going on')
        assert brush.end(signal.SIGTERM)[0] == 0


def test_parameters(scene, user):
    factor = 'run.real_time_factor'
    with Brush(scene, 'run.real_time_factor:=2', 'road.attack_angle:=0',
               'brush.row_offsets:=[0.0, 1.0]') as brush:
        states = user.listen(JointState, 'joint_states')
        user.until(lambda: states, 'joint_states')
        (described,) = user.call(DescribeParameters, 'brush_node/describe_parameters',
                                 names=['bristle.length']).descriptors
        assert described.floating_point_range[0].from_value > 0.0
        values = user.call(GetParameters, 'brush_node/get_parameters',
                           names=[factor, 'brush.bristle_count', 'sweeper.velocity',
                                  'brush.row_offsets']).values
        assert values[0].double_value == 2.0
        assert values[1].integer_value == 2
        assert list(values[2].double_array_value) == [0.0, 0.0]
        assert list(values[3].double_array_value) == [0.0, 1.0]

        def set_to(name, **value):
            parameter = Parameter(name=name, value=ParameterValue(**value))
            return user.call(SetParameters, 'brush_node/set_parameters',
                             parameters=[parameter]).results[0]

        whole = set_to(factor, type=ParameterType.PARAMETER_INTEGER, integer_value=3)
        assert whole.successful, whole.reason
        negative = set_to(factor, type=ParameterType.PARAMETER_DOUBLE, double_value=-1.0)
        assert not negative.successful
        assert not set_to(factor, type=ParameterType.PARAMETER_STRING, string_value='a').successful
        fixed = set_to('bristle.length', type=ParameterType.PARAMETER_DOUBLE, double_value=0.2)
        assert 'fixed while the node is configured' in fixed.reason
        none_yet = set_to('brush.row_radii', type=ParameterType.PARAMETER_DOUBLE_ARRAY,
                          double_array_value=[0.1, 0.12])
        assert 'fixed while the node is configured' in none_yet.reason
        assert brush.end()[0] == 0


def test_clock_origin_and_qos_overrides(scene, user):
    override = 'qos_overrides./tip_wrench.publisher.reliability:=best_effort'
    with Brush(scene, 'run.publish_clock:=true', 'run.time_origin:=wall', override) as brush:
        clocks, states = user.listen(Clock, '/clock'), user.listen(JointState, 'joint_states')
        reports = user.listen(DiagnosticArray, '/diagnostics')
        user.until(lambda: len(clocks) > 20 and len(states) > 20 and reports, 'clock, diagnostics')
        user.until(lambda: user.node.get_publishers_info_by_topic('/tip_wrench'), 'tip_wrench')
        assert abs(seconds(states[-1]) - time.time()) < LIMIT, 'stamps are near the time of day'
        # Either may have been found first, and messages are lost on a busy machine.
        stamp = states[0].header.stamp
        assert all(((one.clock.sec - stamp.sec) * 10**9 + one.clock.nanosec - stamp.nanosec)
                   % 5_000_000 == 0 for one in clocks), 'it tells the ends of chunks'
        (offered,) = user.node.get_publishers_info_by_topic('/tip_wrench')
        assert offered.qos_profile.reliability == ReliabilityPolicy.BEST_EFFORT
        (status,) = reports[0].status
        values = told(reports[0])
        assert status.name.startswith('brush_node')
        assert float(values['real-time factor asked']) == 1.0
        assert {'real-time factor reached', 'late chunks', 'estimated error', 'Newton failures',
                'log backlog', 'refused commands'} <= values.keys()
        assert brush.end()[0] == 0


def test_transforms(scene, user, tmp_path):
    """
    The transforms of a brush whose frames have a prefix, stamped with the time of day.

    tf2_msgs is not on PyPI: a type of another package stands in for its class, and carries the
    bytes as they are.
    """
    (tmp_path / 'tf2_msgs').mkdir()
    (tmp_path / 'tf2_msgs/__init__.py').touch()
    (tmp_path / 'tf2_msgs/msg.py').write_text(
        'from std_msgs.msg import UInt8MultiArray as TFMessage\n')
    store, heard = get_typestore(Stores.ROS2_JAZZY), []
    user.node.create_subscription(UInt8MultiArray, '/tf', heard.append, 100, raw=True)
    with Brush(scene, '-r __ns:=/left', 'run.frame_prefix:=left/', 'run.time_origin:=wall',
               'sweeper.velocity:=[1.0, 0.0]', path=[tmp_path]) as brush:
        states = user.listen(JointState, 'left/joint_states')
        poses = user.listen(PoseStamped, 'left/tip_pose')
        markers = user.listen(MarkerArray, 'left/bristle_markers')

        def together():
            """Return how many chunks have come on every topic."""
            stamps = [{seconds(store.deserialize_cdr(payload, TF).transforms[0])
                       for payload in heard[-1000:]}]
            stamps += [{seconds(state) for state in states},
                       {seconds(array.markers[0]) for array in markers}]
            return len(set.intersection(*stamps))

        user.until(lambda: poses and user.came(poses) and together() > 10, 'transforms')
        code, printed = brush.end()
    assert (code, 'no /tf' in printed) == (0, False), printed
    turned = {seconds(state): state.position[0] for state in states}
    drawn = {seconds(array.markers[0]): array for array in markers}
    both, ways = 0, {}
    for payload in heard:
        mount, turn = store.deserialize_cdr(payload, TF).transforms
        assert (mount.header.frame_id, mount.child_frame_id) == ('left/road', 'left/brush_mount')
        assert (turn.header.frame_id, turn.child_frame_id) == ('left/brush_mount', 'left/brush')
        stamp = seconds(turn)
        assert abs(stamp - time.time()) < LIMIT
        ways[stamp] = mount.transform.translation.x
        if stamp in turned and stamp in drawn:
            both += 1
            spin = turn.transform.rotation
            off = 2.0 * np.arctan2(spin.z, spin.w) - turned[stamp]
            assert np.sin(0.5 * off) == pytest.approx(0.0, abs=1e-9)    # whole turns apart
            _, road, *_ = drawn[stamp].markers
            assert (road.ns, road.header.frame_id) == ('road', 'left/road')
            assert road.pose.position.x == ways[stamp]
    assert both > 10, 'transforms, joint states and markers have the same stamps'
    assert poses[0].header.frame_id == 'left/brush_mount'
    first, last = min(ways), max(ways)
    assert ways[last] - ways[first] == pytest.approx(last - first, abs=1e-6), 'at 1 m/s'


@pytest.mark.parametrize('mode', ['all', 'none'])
def test_without_tf2_msgs(scene, user, tmp_path, mode):
    (tmp_path / 'tf2_msgs.py').write_text('raise ImportError\n')
    with Brush(scene, f'run.publish_tf:={mode}', path=[tmp_path]) as brush:
        states = user.listen(JointState, 'joint_states')
        user.until(lambda: len(states) > 20, 'joint_states')
        code, printed = brush.end()
    assert code == 0
    assert printed.count('tf2_msgs is not installed') == (mode == 'all'), 'said once, if wanted'


def test_a_status_line_on_a_terminal(scene, environment):
    master, terminal = os.openpty()
    with subprocess.Popen([sys.executable, '-m', 'bristle_ros', 'brush_node', '--ros-args',
                           '--params-file', str(scene)], cwd=ROOT, stderr=terminal) as process:
        os.close(terminal)
        seen, end = b'', time.monotonic() + LIMIT
        while b'late chunks' not in seen and time.monotonic() < end:
            seen += os.read(master, 4096)
        process.send_signal(signal.SIGINT)
        assert process.wait(LIMIT) == 0
    os.close(master)
    for word in (b'real-time factor', b'normal force', b'brush torque', b'late chunks'):
        assert word in seen


def test_lifecycle_by_hand(scene, user, tmp_path):
    log = tmp_path / 'run'

    def change(transition):
        return user.call(ChangeState, 'brush_node/change_state',
                         transition=Transition(id=transition)).success

    def state():
        return user.call(GetState, 'brush_node/get_state').current_state.label

    with Brush(scene, 'run.autostart:=false', log=log) as brush:
        states = user.listen(JointState, 'joint_states')
        assert state() == 'unconfigured'
        assert not change(Transition.TRANSITION_ACTIVATE), 'not before it is configured'

        def set_to(**values):
            return user.call(SetParameters, 'brush_node/set_parameters', parameters=[
                Parameter(name=name.replace('__', '.'), value=ParameterValue(
                    type=ParameterType.PARAMETER_DOUBLE, double_value=value))
                for name, value in values.items()]).results[0]

        refused = set_to(friction__kinetic=2.0)
        assert 'kinetic friction above friction.static' in refused.reason
        assert set_to(road__penetration=0.0123).successful, 'configure builds what is set by then'
        assert change(Transition.TRANSITION_CONFIGURE)
        assert not user.call(Trigger, 'brush_node/step').success, 'not before it is active'
        assert change(Transition.TRANSITION_ACTIVATE)
        user.until(lambda: len(states) > 20, 'joint_states')
        assert change(Transition.TRANSITION_DEACTIVATE)
        held = user.pause(states)   # that it is paused as well tells its time
        assert user.call(SetBool, 'brush_node/pause', data=False).success
        assert user.came(states) == 0, 'inactive'
        assert user.call(SetBool, 'brush_node/pause', data=True).success
        reports = user.listen(DiagnosticArray, '/diagnostics')
        user.until(lambda: reports, 'diagnostics while inactive')
        assert float(told(reports[-1])['real-time factor reached']) == 0.0
        assert change(Transition.TRANSITION_ACTIVATE)
        assert user.call(SetBool, 'brush_node/pause', data=False).success
        user.until(lambda: seconds(states[-1]) > held + 0.05, 'going on')
        assert change(Transition.TRANSITION_DEACTIVATE)
        user.pause(states)
        before = len(states)
        assert change(Transition.TRANSITION_CLEANUP)
        assert (log / 'metadata.yaml').exists(), 'cleanup completes the log'
        assert Recording(log).scene.road.penetration == 0.0123
        assert follow_each_other(log), 'it went on where it was held'
        assert not change(Transition.TRANSITION_CONFIGURE), 'that log exists already'
        assert state() == 'unconfigured'
        shutil.rmtree(log)
        assert change(Transition.TRANSITION_CONFIGURE), 'once that is mended'
        assert change(Transition.TRANSITION_ACTIVATE)
        user.until(lambda: len(states) > before + 20, 'a second run')
        user.until(lambda: len(user.node.get_publishers_info_by_topic('/joint_states')) == 1,
                   'the publisher of the first run had left')
        assert change(Transition.TRANSITION_ACTIVE_SHUTDOWN)
        assert state() == 'finalized'
        assert (log / 'metadata.yaml').exists(), 'shutdown completes the log'
        assert follow_each_other(log), 'from the start'
        assert chunks(states[:before])
        assert chunks(states[before:])
        code, printed = brush.end()
    assert code == 0, printed
    assert printed.count('exists already') == 1, printed
    assert printed.count('paused while it was inactive') == 1, printed
    assert 'Traceback' not in printed


def test_namespace_twist_and_timeout(scene, user, tmp_path):
    log = tmp_path / 'left.mcap'
    with Brush(scene, '-r __ns:=/left', 'run.stamped_cmd_vel:=false', 'run.command_timeout:=0.2',
               'bristle.yield_stress:=1e6', log=log) as brush:
        states = user.listen(JointState, 'left/joint_states')
        command = Twist()
        command.linear.x = 0.3
        user.publisher(Twist, 'left/cmd_vel').publish(command)
        user.until(lambda: states, 'left/joint_states')
        reports = user.listen(DiagnosticArray, '/diagnostics')

        def taken():
            """Whether the log has the command, and what came of its being the last one."""
            names = [entry.name if entry.name != '~/events' else decode_event(
                entry.message.data)['event'] for entry in Recording(log).entries()]
            return 'cmd_vel' in names and 'timeout' in names[names.index('cmd_vel'):]

        user.until(lambda: user.came(states) and reports and taken(), 'the timeout')
        code, printed = brush.end()
    assert code == 0, printed
    entries = list(Recording(log).entries())
    assert {entry.message.channel.topic for entry in entries} >= {
        '/left/tip_pose', '/left/cmd_vel', '/left/brush_node/events', '/diagnostics'}
    doubts = {event['kind']: event['text'] for entry in entries if entry.name == '~/events'
              and (event := decode_event(entry.message.data))['event'] == 'warning'}
    assert {'clamp stress', 'few elements'} <= set(doubts), printed
    assert 'above bristle.yield_stress = 1 MPa' in doubts['clamp stress']
    assert printed.count('above bristle.yield_stress') == 1, 'a line when it is first found'
    assert 'warning: clamp stress' in told(reports[-1])
    assert reports[-1].status[0].level == b'\x01'
    done = run('replay', log, '--verify')
    assert done.returncode == 0, done.stdout + done.stderr


@pytest.mark.parametrize(('number', 'times'), [(signal.SIGINT, 2), (signal.SIGTERM, 1),
                                               (signal.SIGKILL, 1)])
def test_a_log_survives(scene, user, tmp_path, number, times):
    log = tmp_path / 'run'
    with Brush(scene, log=log) as brush:
        states = user.listen(JointState, 'joint_states')
        user.until(lambda: states and seconds(states[-1]) > 1.5, '1.5 s of the run')
        code, printed = brush.end(number, times)
    lost = seconds(states[-1]) - samples(log, 'tip_pose')[-1][0] * 5e-4
    if number == signal.SIGKILL:
        assert code == -number
        assert lost < 1.0, 'a kill costs a second at most'
    else:
        assert code == 0, printed
        assert lost <= 1e-9
        assert (log / 'metadata.yaml').exists()
    assert 'Traceback' not in printed
    done = run('replay', log, '--verify')
    assert (done.returncode, 'identical' in done.stdout) == (0, True), done.stdout + done.stderr


def wait_for_handlers(process):
    """Wait until a process has a handler for SIGTERM, for which Python has none of its own."""
    end = time.monotonic() + LIMIT
    while True:
        status = Path(f'/proc/{process.pid}/status').read_text()
        caught = int(re.search(r'^SigCgt:\s*(\w+)', status, re.MULTILINE)[1], 16)
        if caught >> (signal.SIGTERM - 1) & 1:
            return
        assert time.monotonic() < end
        assert process.poll() is None
        time.sleep(0.01)


def test_a_signal_while_it_starts(scene, environment):
    with Brush(scene) as brush:
        wait_for_handlers(brush.process)
        code, printed = brush.end()
    assert (code, 'Traceback' in printed) == (0, False), printed


@pytest.mark.parametrize(('argument', 'said'), [
    ('bristle.lenght:=0.2', 'did you mean bristle.length?'),
    ('friction.kinetic:=0.9', 'friction.kinetic = 0.9'),
    ('run.chunk:=0.00512', 'the nearest'),
    ('log.path:=/proc/no/such', 'log.path = "/proc/no/such"'),
    ('-p use_sim_time:=true -p run.publish_clock:=true', 'run.publish_clock = true'),
    ('-p use_sim_time:=true -p run.real_time_factor:=2', 'run.real_time_factor = 2'),
    ('use_sim_time:=1', 'use_sim_time = 1: must be true or false'),
    ('--foo', '--foo')])
def test_unusable_input_is_one_line(scene, environment, argument, said):
    with Brush(scene, argument) as brush:
        code, printed = brush.wait()
    assert code == 2
    assert said in printed
    assert len(printed.strip().splitlines()) == 1, printed


def test_nothing_is_lost_when_the_simulation_cannot_go_on(scene, user, tmp_path):
    log = tmp_path / 'run'
    # Ten metres of foil as soft as jelly at 3000 rpm: no sub-step is short enough.
    hopeless = ['bristle.youngs_modulus:=1000', 'bristle.length:=10', 'bristle.width:=1e-6',
                'bristle.density:=1e5', 'brush.mount_radius:=1', 'drive.mean_speed:=320',
                'solver.integration_time_step:=0.005', 'run.sample:=0.005']
    with Brush(scene, *hopeless, log=log) as brush:
        code, printed = brush.wait()
    assert code == 3, printed
    (line,) = [line for line in printed.splitlines() if line.startswith('brush_node:')]
    assert 'step' in line
    assert 'Traceback' not in printed
    assert (log / 'metadata.yaml').exists()
    events = [decode_event(entry.message.data) for entry in Recording(log).entries()
              if entry.name == '~/events']
    ended = [event['event'] for event in events if event['event'] != 'warning']
    assert ended[-1] == 'failure', 'the log says why it ends'
    assert samples(log, 'tip_pose'), 'and holds what came before'
