"""What is on disk, by the readers that others use; and what is left after things went wrong."""
from collections import Counter
import errno
import json
import os
from pathlib import Path
import shutil
import signal
import subprocess
import sys
import threading
import time

from bristle_ros.log import file as mcap_file, output as mcap_output, writer as log_module
from bristle_ros.log.machine import provenance
from bristle_ros.log.recording import Recording
from bristle_ros.log.writer import Log
from bristle_ros.messages import encode as messages
from bristle_ros.realtime.driver import Event
from bristle_ros.scene.error import SceneError
from bristle_ros.scene.scene import from_parameters, load
from bristle_ros.verbs.recover import recover
from examples import chunk_of, ITS, SCENE, SNAPSHOT, waits_in
from hypothesis import given, Phase, settings, strategies as st
from mcap.reader import make_reader
from mcap_ros2.decoder import DecoderFactory
import numpy as np
import pytest
from rosbags.highlevel import AnyReader
from rosbags.interfaces import QosReliability
import yaml


def write_example(log, chunks=30):
    """Write something of everything; return topic -> messages."""
    for number in range(chunks):
        log.write(chunk_of(range(10 * number + 1, 10 * number + 11)))
    end = 10 * chunks
    log.write(chunk_of([], [Event(end, 'command', 'cmd_brush_speed', (9.5,)),
                            Event(end, 'command', 'cmd_vel', (1.5, 0.25, -0.5)),
                            Event(end, 'command', 'cmd_penetration', (0.02,)),
                            Event(end, 'reset')]))
    log.write(chunk_of([end + 10], [Event(end + 10, 'timeout', 'cmd_vel', (0.0, 0.0, 0.0))]))
    log.event(end + 10, 'load', factor=0.5)
    log.message(end + 10, '/diagnostics', messages.DIAGNOSTICS, messages.encode_diagnostics(
        5, [(0, 'brush_node: log', 'well', '', {'backlog': 0})]))
    log.message(end + 10, '/clock', messages.CLOCK, messages.encode_clock(5))
    return {**{f'/{topic.name}': end + 1 for topic in messages.TOPICS},
            '/cmd_brush_speed': 1, '/cmd_vel': 2, '/cmd_penetration': 1, '/diagnostics': 1,
            '/clock': 1, '/brush_node/scene': 1,
            '/robot_description': 1, '/tf': chunks + 1,
            '/brush_node/events': 4}  # start, reset, timeout, load


def mcap_of(path):
    return next(path.glob('*.mcap')) if path.is_dir() else path


def read_with_mcap(path):
    with open(mcap_of(path), 'rb') as stream:
        reader = make_reader(stream, validate_crcs=True)
        counts = Counter(channel.topic for _, channel, _ in reader.iter_messages())
        statistics = reader.get_summary().statistics
        assert statistics.message_count == sum(counts.values())
    return counts


def read_with_mcap_ros2(path):
    counts = Counter()
    with open(mcap_of(path), 'rb') as stream:
        reader = make_reader(stream, decoder_factories=[DecoderFactory()])
        for _, channel, _, message in reader.iter_decoded_messages():
            counts[channel.topic] += 1
            if channel.topic == '/mount_wrench':
                assert message.wrench.force.x == SNAPSHOT.brush_force[0]
    return counts


def read_with_rosbags(path):
    counts = Counter()
    with AnyReader([path]) as reader:
        for connection, _, raw in reader.messages():
            counts[connection.topic] += 1
            message = reader.deserialize(raw, connection.msgtype)
            if connection.topic == '/tip_pose':
                assert message.pose.position.z == SNAPSHOT.tip_position_mount[0, 2]
        # where the disk filled up behind a channel's record, it has no message
        assert Counter({one.topic: one.msgcount for one in reader.connections}) == counts
    return counts


READERS = [read_with_mcap, read_with_mcap_ros2, read_with_rosbags]


@pytest.mark.parametrize('compression', ['zstd', 'lz4', 'none'])
@pytest.mark.parametrize('name', ['run1', 'run1.mcap'])
def test_readers_of_others_read_every_message(tmp_path, name, compression):
    with Log(tmp_path / name, SCENE, compression=compression) as log:
        expected = write_example(log)
    assert log.failed is None
    for reader in READERS:
        assert reader(tmp_path / name) == expected, reader.__name__


def test_twist_without_stamp_where_the_scene_says_so(tmp_path):
    scene = from_parameters({'run.stamped_cmd_vel': False}, 'test')
    with Log(tmp_path / 'a', scene) as log:
        expected = write_example(log, 1)
    assert read_with_mcap_ros2(tmp_path / 'a') == expected
    with AnyReader([tmp_path / 'a']) as reader:
        types = {one.topic: one.msgtype for one in reader.connections}
    assert types['/cmd_vel'] == messages.TWIST


def test_layout_is_that_of_rosbag2(tmp_path):
    with Log(tmp_path / 'run1', SCENE, origin=10**18) as log:
        expected = write_example(log)
    assert sorted(os.listdir(tmp_path / 'run1')) == ['metadata.yaml', 'run1_0.mcap']
    information = yaml.safe_load((tmp_path / 'run1' / 'metadata.yaml').read_text())[
        'rosbag2_bagfile_information']
    assert information['message_count'] == sum(expected.values())
    assert information['relative_file_paths'] == ['run1_0.mcap']
    assert information['starting_time']['nanoseconds_since_epoch'] == 10**18
    assert information['duration']['nanoseconds'] == round(310 * ITS * 1e9)
    with open(tmp_path / 'run1' / 'run1_0.mcap', 'rb') as stream:
        reader = make_reader(stream)
        assert reader.get_header().profile == 'ros2'
        records = [(one.name, one.metadata) for one in reader.iter_metadata()]
        assert [name for name, _ in records] == [
            'rosbag2', 'bristle_ros.part', 'bristle_ros.scene', 'bristle_ros.machine',
            'bristle_ros.run', 'rosbag2']
        assert yaml.safe_load(records[-1][1]['serialized_metadata']) == information
        assert dict(records)['bristle_ros.machine'] == provenance()
        summary = reader.get_summary()
        for channel in summary.channels.values():
            assert channel.message_encoding == 'cdr'
            assert summary.schemas[channel.schema_id].encoding == 'ros2msg'
            assert channel.metadata['topic_type_hash'].startswith('RIHS01_')
            (qos,) = yaml.safe_load(channel.metadata['offered_qos_profiles'])
            assert qos['reliability'] == 'reliable'
            assert (qos['durability'] == 'transient_local') == (
                channel.topic in ('/brush_node/scene', '/robot_description'))
        (attachment,) = reader.iter_attachments()
        (tmp_path / 'scene.yaml').write_bytes(attachment.data)
        assert load(tmp_path / 'scene.yaml') == SCENE
    with AnyReader([tmp_path / 'run1']) as reader:
        (qos,) = reader.connections[0].ext.offered_qos_profiles
    assert qos.reliability == QosReliability.RELIABLE


def test_times_names_and_order(tmp_path):
    before = time.time_ns()
    with Log(tmp_path / 'a.mcap', SCENE, origin=77,
             resolve=lambda name: '/left/' + name.replace('~', 'brush_node')) as log:
        log.write(chunk_of([5, 10], [Event(5, 'command', 'cmd_penetration', (0.03,))]))
    entries = list(Recording(tmp_path / 'a.mcap').entries())
    assert entries[0].message.channel.topic == '/left/brush_node/events'
    assert entries[1].message.channel.topic == '/left/brush_node/scene'
    named = [(entry.step, entry.name) for entry in entries[3:]]
    outputs = [topic.name for topic in messages.TOPICS]
    # The sample at a step is the state that a command at that step found.
    assert named == [*[(5, name) for name in outputs], (5, 'cmd_penetration'),
                     *[(10, name) for name in outputs], (10, '/tf')]
    for entry in entries:
        assert entry.message.log_time == 77 + round(entry.step * ITS * 1e9)
        assert before <= entry.message.publish_time <= time.time_ns()
        if entry.name == 'tip_pose':
            sec, nanosec = (int.from_bytes(entry.message.data[at:at + 4], 'little')
                            for at in (4, 8))
            assert sec * 10**9 + nanosec == entry.message.log_time


def test_a_failure_is_the_last_event(tmp_path):
    with Log(tmp_path / 'a.mcap', SCENE) as log:
        log.write(chunk_of([5], failure=RuntimeError('t = 1, step 5: diverged')))
    last = list(Recording(tmp_path / 'a.mcap').entries())[-1]
    assert messages.decode_event(last.message.data) == {
        'event': 'failure', 'step': 5, 'reason': 't = 1, step 5: diverged'}


def test_what_exists_is_refused_and_kept(tmp_path):
    (tmp_path / 'run1').mkdir()
    (tmp_path / 'a.mcap').write_bytes(b'precious')
    for name in ('run1', 'a.mcap', 'a.mcap/b', 'a.mcap/b.mcap'):
        with pytest.raises(SceneError) as caught:
            Log(tmp_path / name, SCENE)
        line = str(caught.value)
        assert '\n' not in line
        assert name in line
        assert 'log.path' in line
    assert (tmp_path / 'a.mcap').read_bytes() == b'precious'
    with pytest.raises(SceneError, match='--output'):
        Log('/proc/nothing/run', SCENE, key='--output')
    assert sorted(os.listdir(tmp_path)) == ['a.mcap', 'run1']


@pytest.mark.parametrize('name', ['one', 'one.mcap'])
def test_the_second_of_two_logs_with_one_path_is_refused(tmp_path, name):
    with Log(tmp_path / name, SCENE) as log:
        with pytest.raises(SceneError, match='exists already'):
            Log(tmp_path / name, SCENE)
        expected = write_example(log, 2)
    assert read_with_mcap(tmp_path / name) == expected


def run_python(text, *arguments, **options):
    """Start a Python process in the directory of this file."""
    return subprocess.Popen([sys.executable, '-c', text, *map(str, arguments)],
                            cwd=Path(__file__).parents[1], stdout=subprocess.PIPE, text=True,
                            **options)


def test_a_node_without_a_log_imports_no_mcap():
    process = run_python('import sys, bristle_ros.log; print("mcap" in sys.modules)')
    assert process.communicate()[0].strip() == 'False'


WRITER = """
import sys, time
from bristle_ros.log import Log
from examples import chunk_of, SCENE
log = Log(sys.argv[1], SCENE)
print(0, time.time_ns(), flush=True)
for number in range(int(sys.argv[2])):
    log.write(chunk_of(range(50 * number + 10, 50 * number + 60, 10)))
    print(50 * number + 50, time.time_ns(), flush=True)
    time.sleep(0.005)
"""


def test_kill_costs_a_second_at_most(tmp_path):
    process = run_python(WRITER, tmp_path / 'run', 100000)
    lines = [process.stdout.readline() for _ in range(400)]
    process.send_signal(signal.SIGKILL)
    lines += process.communicate()[0].splitlines()
    _, killed = map(int, [line for line in lines if line.count(' ') == 1][-1].split())
    recording = Recording(tmp_path / 'run')
    entries = list(recording.entries())
    assert 'cut off' in recording.cut
    assert not recording.damage
    assert killed - entries[-1].message.publish_time <= 1_000_000_000
    steps = [entry.step for entry in entries if entry.name == 'tip_pose']
    assert steps == list(range(10, steps[-1] + 10, 10))
    result = recover(tmp_path / 'run')
    assert result.messages == len(entries) == sum(
        read_with_rosbags(tmp_path / 'run_recovered').values())


def test_killed_at_once_it_is_readable(tmp_path):
    process = run_python(WRITER, tmp_path / 'a.mcap', 100000)
    process.stdout.readline()
    process.kill()
    process.communicate()
    (entry, *_) = Recording(tmp_path / 'a.mcap').entries()
    assert messages.decode_event(entry.message.data)['event'] == 'start'
    assert Recording(tmp_path / 'a.mcap').scene == SCENE


FULL = """
import json, resource, sys
from bristle_ros.log import Log
from examples import chunk_of, SCENE
log = Log(sys.argv[1], SCENE, compression='none')
resource.setrlimit(resource.RLIMIT_FSIZE, (300_000, 300_000))
for number in range(2000):
    log.write(chunk_of([10 * number + 10]))
log.close()
print(json.dumps(log.failed))
"""


@pytest.mark.parametrize('name', ['run', 'run.mcap'])
def test_a_full_disk_ends_the_log_and_nothing_else(tmp_path, name):
    process = run_python(FULL, tmp_path / name)
    output, _ = process.communicate()
    assert process.returncode == 0
    assert 'too large' in json.loads(output)
    recording = Recording(tmp_path / name)
    entries = list(recording.entries())
    assert not recording.damage
    assert not recording.cut
    steps = [entry.step for entry in entries if entry.name == 'joint_states']
    assert len(steps) > 100
    assert steps == list(range(10, steps[-1] + 10, 10))
    assert mcap_of(tmp_path / name).stat().st_size <= 300_000
    for reader in READERS:
        assert sum(reader(tmp_path / name).values()) == len(entries), reader.__name__
    if name == 'run':
        information = yaml.safe_load((tmp_path / name / 'metadata.yaml').read_text())
        assert information['rosbag2_bagfile_information']['message_count'] == len(entries)
    assert recover(tmp_path / name, tmp_path / 'new.mcap').messages == len(entries)
    assert sum(read_with_mcap(tmp_path / 'new.mcap').values()) == len(entries)


@given(limit=st.integers(60_000, 600_000), size=st.integers(0, 2_000),
       compression=st.sampled_from(['zstd', 'none']), seed=st.integers(0, 9))
@settings(max_examples=12, deadline=None, phases=[Phase.explicit, Phase.generate])
def test_wherever_the_disk_is_full_the_log_is_complete(tmp_path_factory, limit, size, compression,
                                                       seed):
    path = tmp_path_factory.mktemp('full') / 'run'
    noise = np.random.default_rng(seed)
    asked = []

    def allocate(fd, offset, length):
        asked.append(offset + length)
        return 0 if offset + length <= limit else errno.ENOSPC

    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(mcap_output, '_allocate', allocate)
        log = Log(path, SCENE, compression=compression)
        for number in range(200):
            text = noise.bytes(size).hex()
            log.event(number, 'load', text=text)
            log.write(chunk_of([number + 1]))
        log.close()
    entries = list(Recording(path).entries())
    assert mcap_of(path).stat().st_size <= limit
    assert (log.failed is not None) == (len(entries) < 3 + 200 * (2 + len(messages.TOPICS)))
    assert sum(read_with_rosbags(path).values()) == len(entries)
    assert asked


def test_where_no_room_can_be_kept_the_log_is_cut_at_what_is_whole(tmp_path, monkeypatch):
    write, left = os.write, [200_000]

    def write_some(fd, data):
        taken = min(len(data), left[0])
        left[0] -= taken
        if not taken:
            raise OSError(errno.ENOSPC, 'No space left on device')
        return write(fd, data[:taken])

    monkeypatch.setattr(mcap_output, '_allocate', lambda *_: errno.EOPNOTSUPP)
    log = Log(tmp_path / 'run', SCENE, compression='none')
    monkeypatch.setattr(mcap_output.os, 'write', write_some)
    for number in range(1000):
        log.write(chunk_of([number + 1]))
    log.close()
    monkeypatch.undo()
    assert 'no space left on device' in log.failed
    recording = Recording(tmp_path / 'run')
    entries = list(recording.entries())
    assert len(entries) > 500
    assert recording.cut
    assert not recording.damage
    assert recover(tmp_path / 'run').messages == len(entries)
    assert sum(read_with_rosbags(tmp_path / 'run_recovered').values()) == len(entries)


def test_a_disk_too_full_to_begin_leaves_nothing(tmp_path, monkeypatch):
    def refuse(fd, data):
        raise OSError(28, 'No space left on device')
    for name in ('run', 'run.mcap'):
        with monkeypatch.context() as patch:
            patch.setattr(mcap_output.os, 'write', refuse)
            with pytest.raises(SceneError, match='no space left on device'):
                Log(tmp_path / name, SCENE)
        assert os.listdir(tmp_path) == []


def test_a_deleted_directory_ends_the_log(tmp_path, monkeypatch):
    monkeypatch.setattr(mcap_file, 'SYNC_PERIOD', 0.0)
    log = Log(tmp_path / 'run', SCENE)
    shutil.rmtree(tmp_path / 'run')
    log.write(chunk_of([10]))
    log.close()
    assert 'deleted' in log.failed
    assert str(tmp_path / 'run') in log.failed
    assert log.write(chunk_of([20])) is False
    log.close()


class Gate:
    """Stands in for a disk that takes nothing until it is opened."""

    def __init__(self, monkeypatch):
        self.open = threading.Event()
        write = os.write
        monkeypatch.setattr(
            mcap_output.os, 'write', lambda fd, data: self.open.wait() and write(fd, data))


def test_a_full_queue_makes_the_caller_wait_and_loses_nothing(tmp_path, monkeypatch):
    monkeypatch.setattr(mcap_file, 'FLUSH_PERIOD', 0.0)
    log = Log(tmp_path / 'run', SCENE, capacity=8)
    gate = Gate(monkeypatch)
    waited = []

    def run():
        waited.extend(log.write(chunk_of([step])) for step in range(1, 41))

    caller = threading.Thread(target=run)
    caller.start()
    while not (log.backlog == 8 and waits_in(caller, 'wait')):
        time.sleep(1e-3)
    assert log.backlog == 8
    gate.open.set()
    caller.join(600.0)
    assert any(waited)
    assert log.waited == sum(waited)
    log.close()
    assert log.failed is None
    assert read_with_mcap(tmp_path / 'run')['/tip_pose'] == 40


def test_a_chunk_larger_than_the_queue_goes_in(tmp_path):
    with Log(tmp_path / 'run', SCENE, capacity=8) as log:
        for number in range(5):
            log.write(chunk_of(range(100 * number + 1, 100 * number + 101)))
    assert read_with_mcap(tmp_path / 'run')['/tip_pose'] == 500


def test_a_disk_that_hangs_holds_nobody_at_the_end(tmp_path, monkeypatch):
    monkeypatch.setattr(mcap_file, 'FLUSH_PERIOD', 0.0)
    monkeypatch.setattr(log_module, 'CLOSE_TIMEOUT', 0.2)
    log = Log(tmp_path / 'run', SCENE, capacity=2)
    gate = Gate(monkeypatch)
    caller = threading.Thread(
        target=lambda: [log.write(chunk_of([step])) for step in range(1, 11)])
    caller.start()
    caller.join(0.2)
    log.close()
    caller.join(600.0)
    assert not caller.is_alive()
    assert 'did not take the rest' in log.failed
    gate.open.set()
    log._worker.join()


@pytest.fixture(scope='module')
def example(tmp_path_factory):
    """Yield a closed log of many small chunks as bytes, and its entries."""
    path = tmp_path_factory.mktemp('example') / 'a.mcap'
    size, mcap_file.CHUNK_SIZE = mcap_file.CHUNK_SIZE, 2000
    try:
        with Log(path, SCENE) as log:
            write_example(log)
    finally:
        mcap_file.CHUNK_SIZE = size
    return path.read_bytes(), list(Recording(path).entries())


def chunk_ends(content):
    """Return (byte after it, messages up to there) for each chunk, by walking the records."""
    at, total, found = 8, 0, []
    while content[at] != 15:  # DataEnd
        length = int.from_bytes(content[at + 1:at + 9], 'little')
        opcode, body = content[at], content[at + 9:at + 9 + length]
        at += 9 + length
        if opcode == 6:
            found.append((at, total))
        elif opcode == 7:  # its message index: channel, then 16 bytes a message
            total += int.from_bytes(body[2:6], 'little') // 16
            found[-1] = found[-1][0], total
    return found


@given(data=st.data())
@settings(max_examples=150, deadline=None)
def test_a_log_cut_anywhere_is_its_beginning(example, tmp_path_factory, data):
    content, entries = example
    length = data.draw(st.integers(0, len(content) - 1))
    path = tmp_path_factory.mktemp('cut') / 'a.mcap'
    path.write_bytes(content[:length])
    recording, left = None, []
    try:
        recording = Recording(path)
        left = list(recording.entries())
    except SceneError as error:
        assert '\n' not in str(error)
        assert length <= content.index(b'time_origin_ns') + 30
    assert left == entries[:len(left)]
    assert len(left) >= max([count for end, count in chunk_ends(content) if end <= length],
                            default=0)
    if left:
        assert recording.cut
        assert not recording.damage
        assert recover(path).messages == len(left)
        recovered = path.with_name('a_recovered.mcap')
        assert sum(read_with_mcap(recovered).values()) == len(left)
        again = Recording(recovered)
        assert list(again.entries()) == left
        assert again.scene == SCENE
        assert not again.cut


@given(data=st.data())
@settings(max_examples=200, deadline=None)
def test_a_mangled_log_is_read_as_far_as_it_goes(example, tmp_path_factory, data):
    content, entries = example
    mangled = bytearray(content)
    for _ in range(data.draw(st.integers(1, 4))):
        at = data.draw(st.integers(0, len(content) - 1))
        mangled[at] = data.draw(st.integers(0, 255))
    cut = data.draw(st.integers(len(content) // 2, len(content)))
    path = tmp_path_factory.mktemp('mangled') / 'a.mcap'
    path.write_bytes(mangled[:cut])
    try:
        recording = Recording(path)
        left = list(recording.entries())
        # A message that is read is one that was written, since chunks have checksums.
        assert {entry.message.data for entry in left} <= {
            entry.message.data for entry in entries}
        if left:
            assert recover(path).messages == len(left)
    except SceneError as error:
        assert '\n' not in str(error)


@given(content=st.binary(max_size=200))
@settings(max_examples=100, deadline=None)
def test_garbage_is_no_log(tmp_path_factory, content):
    path = tmp_path_factory.mktemp('garbage') / 'a.mcap'
    for head in (b'', b'\x89MCAP0\r\n', b'\x89MCAP0\r\n\x06'):
        path.write_bytes(head + content)
        with pytest.raises(SceneError):
            recover(path)


def test_with_a_chunk_destroyed_the_others_are_saved(example, tmp_path):
    content, entries = example
    ends = chunk_ends(content)
    end, _ = ends[4]
    path = tmp_path / 'a.mcap'
    at = content.rindex(b'\x28\xb5\x2f\xfd', 0, end)  # the chunk's compressed data
    path.write_bytes(content[:at + 20] + b'\xff' * 30 + content[at + 50:])
    result = recover(path)
    assert result.messages == len(entries) - (ends[4][1] - ends[3][1])
    assert any('chunk' in text for text in result.lost)
