"""Logs of real runs, simulated again, published again, and made whole again."""
import itertools
import os
from pathlib import Path
import re
import shutil
import signal
import struct
import subprocess
import sys
import time

from bristle_ros.__main__ import main
from bristle_ros.log import file as mcap_file
from bristle_ros.log.file import McapFile
from bristle_ros.log.reader import McapReader, Message, Metadata
from bristle_ros.log.recording import logged_commands, Recording
from bristle_ros.log.writer import Log
from bristle_ros.messages import encode as messages
from bristle_ros.messages.transforms import decode_transforms
from bristle_ros.realtime.driver import Driver, Event
from bristle_ros.scene.error import SceneError
from bristle_ros.scene.scene import from_parameters, to_parameters
from bristle_ros.simulation.mount_path import MountPath
from bristle_ros.simulation.simulation import Simulation, StepFailure
from bristle_ros.verbs import replay, verify as verify_module
from bristle_ros.verbs.verify import verify
from hypothesis import given, settings, strategies as st
import pytest
import rclpy
from rclpy.executors import SingleThreadedExecutor
from rclpy.qos import DurabilityPolicy, QoSProfile
from rosbags.highlevel import AnyReader

SCENE = from_parameters({
    'brush.bristle_count': 2, 'solver.elements': 3, 'solver.integration_time_step': 5e-4,
    'damping.stiffness': 1e-3, 'road.penetration': 0.02, 'run.chunk': 0.0035,
    'run.sample': 0.001}, 'test')
LIMIT = 600.0   # [s] before a wait is a failure: compiling on a busy machine takes minutes
ITS = SCENE.solver.integration_time_step
COMMANDS = [Event(50, 'command', 'cmd_brush_speed', (14.0,)),
            Event(91, 'command', 'cmd_vel', (0.5, 0.0, 0.1)),
            Event(91, 'command', 'cmd_penetration', (0.022,)),
            Event(200, 'reset'),
            Event(260, 'command', 'cmd_brush_speed', (8.0,))]
DURATION = 301  # [steps]
WHOLE = 2 + 5 * 150 + 43    # messages compared: scene, description, samples, /tf of each chunk


def run(path, scene=SCENE, events=COMMANDS, duration=DURATION, simulation_of=Simulation, **more):
    """Simulate and log; returns the driver's failure."""
    driver = Driver(simulation_of(scene), sample=2, paced=False)
    driver.schedule(events)
    driver.mount = MountPath(scene)
    with Log(path, scene, **more) as log:
        while driver.total_step < duration:
            chunk = driver.run_chunk()
            log.write(chunk)
            if chunk.failure:
                break
    assert log.failed is None
    return chunk.failure


@pytest.fixture(scope='module')
def logged(tmp_path_factory):
    """Return the path of a log with commands and a reset, in many small chunks."""
    path = tmp_path_factory.mktemp('logged') / 'run1'
    size, mcap_file.CHUNK_SIZE = mcap_file.CHUNK_SIZE, 4000
    try:
        run(path)
    finally:
        mcap_file.CHUNK_SIZE = size
    return path


def rewrite(source, target, change):
    """
    Write the log again with valid checksums.

    `change`: list of Message -> the list to write, or a Metadata -> Metadata.
    """
    file = McapFile(target)
    records = list(Recording(source).records())
    for record in records:
        if isinstance(record, Metadata) and record.name != 'rosbag2':
            file.add_metadata(*(change(record) if callable(change) else record))
    channels = {}
    kept = [record for record in records if isinstance(record, Message)]
    for message in kept if callable(change) else change[0](kept):
        channel = message.channel
        if channel.topic not in channels:
            channels[channel.topic] = file.channel(
                channel.topic, channel.schema, channel.schema_text, channel.metadata)
        file.add(channels[channel.topic], message.log_time, message.publish_time, message.data)
    file.finish()
    return target


def with_value(message, field, change):
    """Return the message with one of its float64 values changed."""
    topic = next(one for one in messages.TOPICS if message.channel.topic == f'/{one.name}')
    wanted = list(topic.decode(message.data))
    number = topic.fields.index(field)
    old, wanted[number] = wanted[number], change(wanted[number])
    for at in range(12, len(message.data) - 7):
        data = message.data[:at] + struct.pack('<d', wanted[number]) + message.data[at + 8:]
        if message.data[at:at + 8] == struct.pack('<d', old) and [*topic.decode(data)] == wanted:
            return message._replace(data=data)
    raise AssertionError(f'{field} is not in the message')


def changed_at(number, topic, field, change):
    """Return what changes the `number`-th message of a topic."""
    def apply(kept):
        places = [at for at, one in enumerate(kept) if one.channel.topic == f'/{topic}']
        kept[places[number]] = with_value(kept[places[number]], field, change)
        return kept
    return [apply]


def next_float(value):
    (bits,) = struct.unpack('<q', struct.pack('<d', value))
    return struct.unpack('<d', struct.pack('<q', bits + 1))[0]


def test_the_log_of_a_run_is_identical(logged, capsys):
    verdict = verify(logged)
    assert verdict.difference == ''
    assert verdict.compared == WHOLE
    assert verdict.applied == len(COMMANDS)
    assert (verdict.end, verdict.elsewhere, verdict.cut) == (301 * ITS, [], '')
    for path in (logged, logged / 'run1_0.mcap'):
        assert main(['replay', str(path), '--verify']) == 0
        assert 'identical' in capsys.readouterr().out


def test_the_log_of_a_brush_of_rows_is_identical(tmp_path):
    scene = from_parameters({
        **to_parameters(SCENE), 'brush.bristle_count': 1, 'brush.row_counts': [2, 1],
        'brush.row_radii': [0.1, 0.11], 'brush.row_lengths': [0.24, 0.25]}, 'test')
    run(tmp_path / 'a.mcap', scene)
    assert verify(tmp_path / 'a.mcap')[:3] == ('', WHOLE, len(COMMANDS))


def test_the_wall_as_origin_of_time_changes_no_bit(tmp_path):
    run(tmp_path / 'a.mcap', origin=1_790_000_000_123_456_789)
    assert verify(tmp_path / 'a.mcap')[:3] == ('', WHOLE, len(COMMANDS))


@pytest.mark.parametrize(('topic', 'field'), [
    ('contact_wrench', 'wrench.torque.z'), ('tip_wrench', 'wrench.force.z'),
    ('mount_wrench', 'wrench.force.x'), ('tip_pose', 'pose.orientation.w'),
    ('joint_states', 'velocity[0]')])
def test_one_bit_of_one_value_is_found(logged, tmp_path, capsys, topic, field):
    changed = rewrite(logged, tmp_path / 'a.mcap', changed_at(70, topic, field, next_float))
    assert main(['replay', str(changed), '--verify']) == 1
    output = capsys.readouterr().out
    assert f'first difference: t = 0.071 s (step 142), {topic}.{field}: log ' in output
    assert 'identical' not in output


def test_a_frame_that_is_elsewhere_and_another_description_are_found(logged, tmp_path):
    def moved(kept):
        at = [at for at, one in enumerate(kept) if one.channel.topic == '/tf'][20]
        data = kept[at].data
        x, *_ = decode_transforms(data)
        place = data.index(struct.pack('<d', x))
        kept[at] = kept[at]._replace(
            data=data[:place] + struct.pack('<d', next_float(x)) + data[place + 8:])
        return kept
    difference = verify(rewrite(logged, tmp_path / 'a.mcap', [moved])).difference
    assert '/tf.transforms[0].transform.translation.x: log ' in difference

    def thicker(kept):
        return [one._replace(data=one.data.replace(b'0.24"', b'0.25"'))
                if one.channel.topic == '/robot_description' else one for one in kept]
    difference = verify(rewrite(logged, tmp_path / 'b.mcap', [thicker])).difference
    assert 'robot_description: not what the scene gives' in difference


def test_a_wrong_stamp_and_a_missing_command_are_found(logged, tmp_path):
    def stamp(kept):
        kept[-1] = kept[-1]._replace(data=kept[-1].data[:8] + b'\1' + kept[-1].data[9:])
        return kept
    assert 'beside' in verify(rewrite(logged, tmp_path / 'a.mcap', [stamp])).difference
    for number, topic in enumerate(('/cmd_penetration', '/cmd_brush_speed', '/cmd_vel',
                                    '/brush_node/events')):
        def without(kept, topic=topic):
            return [one for one in kept if one.channel.topic != topic]
        path = rewrite(logged, tmp_path / f'b{number}.mcap', [without])
        assert verify(path).difference, topic


def test_a_message_of_another_length_is_found(logged, tmp_path, monkeypatch):
    def cut(kept):
        kept[8] = kept[8]._replace(data=kept[8].data[:-8])
        return kept
    path = rewrite(logged, tmp_path / 'a.mcap', [cut])
    assert 'bytes' in verify(path).difference
    monkeypatch.setattr(verify_module, 'provenance', lambda: {'numba': '0.1'})
    assert 'bytes' in verify(path).difference


def test_another_scene_is_found(logged, tmp_path):
    def stiffer(record):
        return record._replace(entries={
            key: value.replace('youngs_modulus: 207000000000.0', 'youngs_modulus: 2.08e11')
            for key, value in record.entries.items()})
    verdict = verify(rewrite(logged, tmp_path / 'a.mcap', stiffer))
    assert '~/scene: not the scene that the log begins with' in verdict.difference


def test_elsewhere_it_says_so_and_compares_with_a_tolerance(
        logged, tmp_path, capsys, monkeypatch):
    here = verify_module.provenance()
    monkeypatch.setattr(
        verify_module, 'provenance', lambda: {**here, 'numba': '0.1', 'target': 'Z80'})
    slightly = changed_at(9, 'tip_pose', 'pose.position.x', lambda value: value * (1 + 1e-11))
    path = rewrite(logged, tmp_path / 'a.mcap', slightly)
    assert main(['replay', str(path), '--verify']) == 0
    output = capsys.readouterr().out
    assert f'numba: log {here["numba"]}, here 0.1' in output
    assert 'Z80' in output
    assert 'equal to 1e-09 relative' in output
    assert 'identical' not in output
    more = changed_at(9, 'tip_pose', 'pose.position.x', lambda value: value * (1 + 1e-8))
    assert 'tip_pose.pose.position.x' in verify(
        rewrite(logged, tmp_path / 'b.mcap', more)).difference


class Failing(Simulation):
    """Cannot go on after its 120th step."""

    def advance(self, steps):
        last = min(steps, max(0, 120 - self.step))
        super().advance(last)
        if last < steps:
            raise StepFailure(self.step * self.its, self.step, 'made to fail')


def test_a_run_that_failed_fails_again(tmp_path):
    path = tmp_path / 'a.mcap'
    assert run(path, events=COMMANDS[:3], simulation_of=Failing) is not None
    verdict = verify(path, Failing)
    assert verdict[:3] == ('', 2 + 5 * 60 + 18, 3)
    assert 'does not here' in verify(path).difference
    run(tmp_path / 'b.mcap', events=COMMANDS[:3])
    assert 'cannot go on' in verify(tmp_path / 'b.mcap', Failing).difference


def test_commands_are_read_at_their_steps(logged):
    its, commands = logged_commands(logged)
    assert its == ITS
    assert commands == [(step, topic or kind, values) for step, kind, topic, values in COMMANDS]


def test_what_is_left_of_a_cut_log_is_identical(logged, tmp_path, capsys):
    content = (logged / 'run1_0.mcap').read_bytes()
    path = tmp_path / 'a.mcap'
    path.write_bytes(content[:len(content) * 2 // 3])
    assert main(['replay', str(path), '--verify']) == 0
    output = capsys.readouterr().out
    assert 'cut off' in output
    assert 'identical' in output
    assert 100 < verify(path).compared < 5 * 150


@given(data=st.data())
@settings(max_examples=40, deadline=None)
def test_a_bit_turned_on_the_disk_is_found(logged, tmp_path_factory, data):
    content = bytearray((logged / 'run1_0.mcap').read_bytes())
    # What comes after DataEnd repeats what came before and is not read.
    reader = McapReader(logged / 'run1_0.mcap')
    list(reader.records())
    end = content.rindex(struct.pack('<BQ', 15, 4))
    at = data.draw(st.integers(0, 8 * end - 1))
    content[at // 8] ^= 1 << at % 8
    path = tmp_path_factory.mktemp('turned') / 'a.mcap'
    path.write_bytes(content)
    try:
        assert verify(path).difference
    except SceneError as error:  # it hit the scene, or the head of the file
        assert '\n' not in str(error)


def test_recover_makes_a_whole_log(logged, tmp_path, capsys):
    shutil.copytree(logged, tmp_path / 'run1')
    path = tmp_path / 'run1' / 'run1_0.mcap'
    (tmp_path / 'run1' / 'metadata.yaml').unlink()
    content = path.read_bytes()
    path.write_bytes(content[:len(content) // 2])
    assert main(['recover', str(tmp_path / 'run1')]) == 0
    output = capsys.readouterr().out
    saved = len(list(Recording(tmp_path / 'run1').entries()))
    assert f'saved {saved} messages into {tmp_path / "run1_recovered"}' in output
    assert 'cut off' in output
    with AnyReader([tmp_path / 'run1_recovered']) as reader:
        assert reader.message_count == saved
    assert main(['replay', str(tmp_path / 'run1_recovered'), '--verify']) == 0
    assert 'cut off' not in capsys.readouterr().out

    assert main(['recover', str(tmp_path / 'run1')]) == 2  # does not overwrite
    assert 'exists already' in capsys.readouterr().err
    assert main(['recover', str(logged), '--output', str(tmp_path / 'b.mcap')]) == 0
    assert 'the log was complete' in capsys.readouterr().out
    assert (tmp_path / 'b.mcap').is_file()


BAD = [
    (['replay', 'nothing.mcap'], 'no such file'),
    (['replay', 'nothing.mcap', '--verify'], 'no such file'),
    (['recover', 'empty'], 'no .mcap file'),
    (['replay', 'text.mcap', '--verify'], 'not an MCAP file'),
    (['recover', 'head.mcap'], 'no message'),
    (['replay', 'head.mcap', '--verify'], 'holds no scene'),
    (['replay', 'text.mcap', '--rate', '0'], 'above 0'),
    (['replay', 'text.mcap', '--rate', 'fast'], 'above 0'),
    (['replay'], 'log'),
]


@pytest.mark.parametrize(('arguments', 'reason'), BAD)
def test_bad_input_is_one_line(tmp_path, monkeypatch, capsys, arguments, reason):
    monkeypatch.chdir(tmp_path)
    (tmp_path / 'empty').mkdir()
    (tmp_path / 'text.mcap').write_text('hello')
    (tmp_path / 'head.mcap').write_bytes(b'\x89MCAP0\r\n')
    try:
        code = main(arguments)
    except SystemExit as end:
        code = end.code
    (line,) = capsys.readouterr().err.splitlines()
    assert code == 2
    assert reason in line


def test_without_ros_publishing_says_what_it_needs(logged):
    process = subprocess.run(
        [sys.executable, '-c', 'import sys; sys.modules["rclpy"] = None\n'
         'from bristle_ros.__main__ import main; sys.exit(main(sys.argv[1:]))',
         'replay', str(logged)], capture_output=True, text=True)
    assert process.returncode == 2
    (line,) = process.stderr.splitlines()
    assert 'needs ROS 2' in line
    assert '--verify' in line


# `tf2_msgs` below gives /tf another type.
LISTENED = {**{topic.name: topic.type for topic in messages.TOPICS},
            '/tf': 'std_msgs/msg/UInt8MultiArray', 'robot_description': messages.STRING,
            '~/scene': messages.STRING}


@pytest.fixture
def listener():
    """Yield what arrives on the topics of a log, as bytes, and how to wait for it."""
    from importlib import import_module
    context = rclpy.Context()
    rclpy.init(context=context)
    node = rclpy.create_node('listener', context=context)
    executor = SingleThreadedExecutor(context=context)
    executor.add_node(node)
    arrived = {}

    def keep(topic):
        found = arrived.setdefault(topic, [])
        # DDS fills what it carries up to whole words, with zeros.
        return lambda raw: found.append(raw.rstrip(b'\0') if LISTENED[topic] == messages.STRING
                                        else raw)

    for topic, type_name in LISTENED.items():
        package, _, name = type_name.split('/')
        latched = type_name == messages.STRING
        node.create_subscription(
            getattr(import_module(f'{package}.msg'), name), topic.replace('~', 'brush_node'),
            keep(topic), QoSProfile(
                depth=1000, durability=DurabilityPolicy.TRANSIENT_LOCAL if latched
                else DurabilityPolicy.VOLATILE), raw=True)

    def wait(until, limit=LIMIT):
        end = time.monotonic() + limit
        while not until(arrived) and time.monotonic() < end:
            executor.spin_once(0.1)
        return arrived

    yield wait
    node.destroy_node()
    rclpy.try_shutdown(context=context)


@pytest.fixture
def tf2_msgs(tmp_path):
    """Stand in for tf2_msgs, which is not on PyPI: another type carries the bytes as they are."""
    (tmp_path / 'tf2_msgs').mkdir()
    (tmp_path / 'tf2_msgs/__init__.py').touch()
    (tmp_path / 'tf2_msgs/msg.py').write_text(
        'from std_msgs.msg import UInt8MultiArray as TFMessage\n')
    return tmp_path


def start_replay(*arguments, path=()):
    return subprocess.Popen(
        [sys.executable, '-m', 'bristle_ros', 'replay', *map(str, arguments)],
        env={**os.environ, 'PYTHONPATH': os.pathsep.join(
            [*map(str, path), os.environ.get('PYTHONPATH', '')])},
        stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True,
        preexec_fn=lambda: signal.signal(signal.SIGINT, signal.default_int_handler))


def outputs_of(path):
    """Return topic -> the bytes of its messages."""
    found = {name: [] for name in LISTENED}
    for entry in Recording(path).entries():
        if entry.name in found:
            data = entry.message.data
            found[entry.name].append(
                data.rstrip(b'\0') if LISTENED[entry.name] == messages.STRING else data)
    return found


def test_replay_publishes_the_same_bytes_to_the_end(logged, listener, tf2_msgs):
    expected = outputs_of(logged)
    process = start_replay(logged, '--rate', 0.5, path=[tf2_msgs])
    arrived = listener(
        lambda got: all(expected[name][-1] in got[name] for name in got)
        or process.poll() is not None and all(got.values()))
    output, errors = process.communicate(timeout=LIMIT)
    assert (process.returncode, errors) == (0, '')
    for name, payloads in arrived.items():
        # A subscriber that was found late has missed the first ones, and a slow one others.
        places = [expected[name].index(payload) for payload in payloads]
        assert places == sorted(set(places)), name
    assert f'published {WHOLE} messages' in output


@pytest.mark.parametrize('number', [signal.SIGINT, signal.SIGTERM])
def test_replay_in_a_loop_ends_on_a_signal(logged, listener, number):
    expected = outputs_of(logged)['joint_states']
    process = start_replay(logged, '--loop', '--ros-args', '-r', '/tip_pose:=/elsewhere')
    arrived = listener(
        lambda got: len(got['joint_states']) > 2 * len(expected) or process.poll() is not None)
    process.send_signal(number)
    output, errors = process.communicate(timeout=LIMIT)
    places = [expected.index(payload) for payload in arrived['joint_states']]
    steps = [after - before for before, after in itertools.pairwise(places)]
    assert len(places) > 2 * len(expected)
    # A slow subscriber loses some; but each turn gives a message once, and in order.
    turns = int(re.search(r'published (\d+) messages', output)[1]) // (WHOLE - 43)    # no /tf
    assert 2 <= sum(step <= 0 for step in steps) <= turns
    assert arrived['tip_pose'] == []
    assert process.returncode == 0
    (line,) = errors.splitlines()
    assert 'no /tf: the package tf2_msgs is not installed' in line


def test_the_log_of_a_killed_run_is_identical(tmp_path):
    script = ('import sys; from verbs.test_replay import run; from pathlib import Path\n'
              "print('ready', flush=True); run(Path(sys.argv[1]), duration=10**9)")
    process = subprocess.Popen([sys.executable, '-c', script, str(tmp_path / 'run')],
                               cwd=Path(__file__).parents[1], env=os.environ,
                               stdout=subprocess.PIPE)
    process.stdout.readline()
    path = tmp_path / 'run' / 'run_0.mcap'
    end = time.monotonic() + LIMIT
    while not (path.exists() and path.stat().st_size > 100_000) and time.monotonic() < end:
        time.sleep(0.02)
    process.kill()
    process.communicate()
    verdict = verify(tmp_path / 'run')
    assert verdict.difference == ''
    assert 'cut off' in verdict.cut
    assert verdict.compared > 1000
    assert replay.main([str(tmp_path / 'run'), '--verify']) == 0
