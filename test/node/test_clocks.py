"""The node and the clocks of others: /clock followed, /clock given, and stamps of commands."""
import json
import subprocess
import sys

from bristle_ros.log.recording import Recording
from bristle_ros.messages.encode import decode_event
from builtin_interfaces.msg import Time
from diagnostic_msgs.msg import DiagnosticArray
from geometry_msgs.msg import TwistStamped
from nodes import Brush, LIMIT, ROOT, run, seconds, User
import numpy as np
import pytest
from rcl_interfaces.msg import Parameter, ParameterType, ParameterValue
from rcl_interfaces.srv import SetParameters
from sensor_msgs.msg import JointState
from std_srvs.srv import SetBool, Trigger

CHUNK = 5_000_000   # [ns]
SCENE = """
/**:
  ros__parameters:
    contact: {enabled: false}
    drive: {profile: constant, mean_speed: 5.0}
    solver: {elements: 2, integration_time_step: 5.0e-4}
    run: {chunk: 0.005, sample: 0.005}
"""


class OutsideClock:
    """A /clock in a process of its own, turned from here."""

    def __init__(self, start):
        self.process = subprocess.Popen(
            [sys.executable, str(ROOT / 'test' / 'clock_master.py'), str(start)], text=True,
            stdin=subprocess.PIPE, stdout=subprocess.PIPE)

    def tell(self, command='time'):
        self.process.stdin.write(command + '\n')
        self.process.stdin.flush()
        line = self.process.stdout.readline()
        assert line, f'the clock has ended: {self.process.wait()}'
        return json.loads(line)

    def __enter__(self):
        return self

    def __exit__(self, *_):
        self.process.kill()
        self.process.communicate()


def test_lockstep_with_an_outside_clock(scene, user, tmp_path):
    """At several rates, held, and through jumps both ways; never ahead, no step left out."""
    log = tmp_path / 'run'
    with OutsideClock(1000.0) as clock, Brush(scene, 'use_sim_time:=true', log=log) as brush:
        states = user.listen(JointState, 'joint_states')
        reports = user.listen(DiagnosticArray, '/diagnostics')

        def caught_up():
            told = clock.tell()
            return told['count'] and 0 <= told['time'] - told['last'] < CHUNK

        def says(text):
            return any(text in report.status[0].message for report in reports)

        user.until(lambda: says('waiting for /clock'), 'what it waits for')
        for factor in (1, 0.2, 5):
            goal = clock.tell(f'run {factor}')['time'] + 0.4e9 * factor
            user.until(lambda goal=goal: clock.tell()['last'] > goal, f'a clock at {factor}')
        clock.tell('run 0')
        user.until(caught_up, 'the held clock')
        last = clock.tell()['last'] * 1e-9
        user.until(lambda: states and abs(seconds(states[-1]) - last) < 1e-6, 'the last message')
        assert user.came(states) == 0, 'held with the clock'
        assert not clock.tell('jump 0.3')['ahead'] > 0
        user.until(caught_up, 'a short jump ahead')
        clock.tell('jump 100')
        user.until(caught_up, 'a long jump ahead')
        user.until(lambda: says('/clock ran ahead'), 'a word of it')
        clock.tell('jump -1000')
        goal = clock.tell('run 1')['time'] + 0.5e9
        user.until(lambda: clock.tell()['time'] > goal, 'time going on')
        clock.tell('run 0')
        user.until(caught_up, 'a jump back')
        user.until(lambda: seconds(states[-1]) < 200.0, 'a state after it')
        told = clock.tell()
        refused = user.call(SetParameters, 'brush_node/set_parameters', parameters=[
            Parameter(name='use_sim_time', value=ParameterValue(
                type=ParameterType.PARAMETER_BOOL, bool_value=False))]).results[0]
        code, printed = brush.end()
    assert code == 0, printed
    assert 'Traceback' not in printed
    assert told['ahead'] <= 0, 'a stamp was ahead of the clock'
    assert 'fixed when the node starts' in refused.reason
    assert printed.count('went back by') == 1, printed
    stamps = np.array([seconds(state) for state in states])
    assert stamps[0] > 1000.0
    assert np.sum(np.diff(stamps) < 0) == 1
    assert stamps[-1] < 200.0
    assert np.any(np.diff(stamps) > 90.0)
    # Whatever the clock did, the brush turned on; of a burst some messages may be lost here.
    turned = np.diff([state.position[0] for state in states]) / 0.025
    assert np.all(turned > 0.5)
    np.testing.assert_allclose(turned, np.round(turned), rtol=1e-9)

    entries = list(Recording(log).entries())
    times = [entry.message.log_time for entry in entries if entry.name == 'joint_states']
    assert times == [CHUNK * (i + 1) for i in range(len(times))], 'the log keeps simulation time'
    events = [decode_event(entry.message.data) for entry in entries if entry.name == '~/events']
    origins = [event['origin_ns'] for event in events if event['event'] == 'clock']
    assert len(origins) >= 3, 'it says where that lies on /clock'
    assert any(stamps[0] == pytest.approx((origins[0] + step * CHUNK) * 1e-9, abs=1e-9)
               for step in range(1, 10**4))
    done = run('replay', log, '--verify')
    assert (done.returncode, 'identical' in done.stdout) == (0, True), done.stdout + done.stderr


def test_another_node_lives_by_our_clock(scene, user):
    """Exact while paused and at each single step, whatever the limited rate had left out."""
    other = User('-p', 'use_sim_time:=true')
    try:
        with Brush(scene, 'run.publish_clock:=true') as brush:
            states = user.listen(JointState, 'joint_states')

            def now():
                return other.node.get_clock().now().nanoseconds

            other.until(now, 'the time')
            assert not user.call(Trigger, 'brush_node/step').success, 'only while paused'
            for _ in range(3):
                held = round(user.pause(states) * 1e9)
                other.until(lambda held=held: now() == held, 'the same time')
                for step in (1, 2):
                    assert user.call(Trigger, 'brush_node/step').success
                    due = held + step * CHUNK
                    other.until(lambda due=due: now() == due, 'the time of a single step')
                assert user.call(SetBool, 'brush_node/pause', data=False).success
                other.until(lambda due=due: now() > due, 'going on')
            assert brush.end()[0] == 0
    finally:
        other.leave()


def test_a_stale_command_is_refused(scene, user):
    """As ros2_controllers do: by its stamp, where it has one, and not for lying in the future."""
    with Brush(scene, 'run.command_timeout:=30', 'run.publish_clock:=true',
               'run.real_time_factor:=50.0') as brush:
        states = user.listen(JointState, 'joint_states')
        reports = user.listen(DiagnosticArray, '/diagnostics')
        commands = user.publisher(TwistStamped, 'cmd_vel')
        user.until(lambda: states and seconds(states[-1]) > 40.0, '40 s of simulation time')

        def refused():
            return int({pair.key: pair.value for pair in reports[-1].status[0].values}[
                'refused commands']) if reports else 0

        for stamp, count in ((Time(sec=1), 1), (Time(), 1), (Time(sec=10**9), 1),
                             (Time(nanosec=1), 2)):
            message = TwistStamped()
            message.header.stamp = stamp
            commands.publish(message)
            if count > refused():
                user.until(lambda count=count: refused() == count, 'a refusal')
        before = len(reports)
        user.until(lambda: len(reports) > before + 1, 'another report')
        assert refused() == 2
        code, printed = brush.end()
    assert code == 0
    assert 'refused: cmd_vel: its stamp is' in printed
    assert 'run.command_timeout = 30 s' in printed


def test_qos_overrides_from_a_file(scene, user, tmp_path):
    """They take effect, also when the node is configured anew; useless and bad ones are named."""
    path = tmp_path / 'qos.yaml'
    path.write_text("""
/left/brush_node:
  ros__parameters:
    qos_overrides:
      /left/tip_pose: {publisher: {reliability: best_effort, depth: 3}}
      /left/cmd_vel: {subscription: {reliability: best_effort}}
      /left/tip_pse: {publisher: {depth: 3}}
""")
    with Brush(scene, '-r __ns:=/left', f'--params-file {path}') as brush:
        found, states = {}, user.listen(JointState, 'left/joint_states')

        def known():
            found.update(tip_pose=user.node.get_publishers_info_by_topic('/left/tip_pose'),
                         tip_wrench=user.node.get_publishers_info_by_topic('/left/tip_wrench'),
                         cmd_vel=user.node.get_subscriptions_info_by_topic('/left/cmd_vel'))
            return states and all(found.values())

        user.until(known, 'the topics')
        code, printed = brush.end()
    assert code == 0
    assert {name: info[0].qos_profile.reliability.name for name, info in found.items()} == {
        'tip_pose': 'BEST_EFFORT', 'tip_wrench': 'RELIABLE', 'cmd_vel': 'BEST_EFFORT'}
    assert 'qos_overrides./left/tip_pse.publisher.depth has no effect' in printed
    with Brush(scene, 'qos_overrides./tip_pose.publisher.reliability:=sometimes') as brush:
        code, printed = brush.wait()
    assert code == 2
    assert len(printed.strip().splitlines()) == 1, printed
    assert 'sometimes' in printed


def test_the_measuring_tool(scene, environment):
    done = subprocess.run(
        [sys.executable, 'tools/measure_node.py', 'follow', '--seconds', '1', '--scene',
         str(scene)], cwd=ROOT, capture_output=True, text=True, timeout=LIMIT)
    assert done.returncode == 0, done.stderr
    rows = [line.split('|')[1].strip() for line in done.stdout.splitlines()]
    assert rows == ['/clock at 1: stamps behind it', '/clock at 1: most ahead of it',
                    '/clock at 1: drift, last tenth to first', '/clock at 1: given up']
    assert float(done.stdout.splitlines()[1].split('|')[2].split()[0]) <= 0.0
