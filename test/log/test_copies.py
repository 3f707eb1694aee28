"""Logs that rosbag2's tools have copied, compressed or recorded: messages are all they keep."""
from dataclasses import replace
import itertools
import json
import math
from xml.etree import ElementTree

from bristle_ros.__main__ import main
from bristle_ros.log.command_file import read_commands as commands_of
from bristle_ros.log.file import McapFile
from bristle_ros.log.recording import logged_commands, Recording
from bristle_ros.messages.definitions import schema_text
from bristle_ros.messages.encode import decode_command, decode_event, decode_string, encode_string
from bristle_ros.plot.series import read as read_series
from bristle_ros.scene.error import SceneError
from bristle_ros.verbs.verify import verify
from mcap.reader import make_reader
from mcap.writer import Writer
import pytest
from rosbags.highlevel import AnyReader
from verbs.test_replay import COMMANDS, ITS, run, SCENE
import zstandard

KEPT = ('offered_qos_profiles', 'topic_type_hash')      # what rosbag2 knows of a channel
LEFT = '/left/brush_node'


def resolved(name):
    """Return a topic of a node in a namespace, one of them remapped."""
    name = {'cmd_vel': '/joystick', 'tip_pose': '/tip'}.get(name, name)
    return name if name.startswith('/') else f'{LEFT}{name[1:]}' if name[0] == '~' else (
        f'/left/{name}')


def files_of(log):
    return sorted(log.glob('*.mcap')) if log.is_dir() else [log]


def copy(sources, target, change=lambda topic, message: (message.log_time, message.data)):
    """
    Copy the messages as `ros2 bag convert` does: in order of time, and nothing beside them.

    change : topic and message to (log time, data), or None for one that is left out
    """
    with open(target, 'wb') as stream:
        writer = Writer(stream)
        writer.start(profile='ros2', library='copy')
        schemas, channels = {}, {}
        for source in sources:
            with open(source, 'rb') as content:
                for schema, channel, message in make_reader(content).iter_messages():
                    if schema.name not in schemas:
                        schemas[schema.name] = writer.register_schema(
                            schema.name, schema.encoding, schema.data)
                    if channel.topic not in channels:
                        channels[channel.topic] = writer.register_channel(
                            channel.topic, channel.message_encoding, schemas[schema.name],
                            {key: channel.metadata[key] for key in KEPT})
                    changed = change(channel.topic, message)
                    if changed:
                        writer.add_message(channels[channel.topic], *changed,
                                           message.publish_time)
        writer.finish()
    return target


@pytest.fixture(scope='module')
def logged(tmp_path_factory):
    """Return the log of a namespaced run with commands and a reset."""
    path = tmp_path_factory.mktemp('copies') / 'run1'
    run(path, resolve=resolved, origin=1_790_000_000_123_456_789)
    return path


def test_a_converted_log_is_identical(logged, tmp_path, capsys):
    converted = copy(files_of(logged), tmp_path / 'a.mcap')
    assert main(['replay', str(converted), '--verify']) == 0
    assert 'identical' in capsys.readouterr().out
    original, verdict = verify(logged), verify(converted)
    assert (verdict.compared, verdict.applied) == (original.compared, original.applied)
    assert verdict.applied == len(COMMANDS)
    recording = Recording(converted)
    assert recording.scene == SCENE
    assert recording.machine == Recording(logged).machine
    assert [entry.name for entry in recording.entries()] == [
        entry.name for entry in Recording(logged).entries()]
    assert logged_commands(converted) == logged_commands(logged)


def test_a_change_in_a_converted_log_is_found(logged, tmp_path):
    def without(topic, message):
        return None if topic == '/joystick' else (message.log_time, message.data)
    assert verify(copy(files_of(logged), tmp_path / 'a.mcap', without)).difference

    def older(topic, message):
        data = message.data
        if topic == f'{LEFT}/scene':
            data = data.replace(b'"numba": "', b'"numba": "0')
        return message.log_time, data
    def stiffer(topic, message):
        data = message.data
        if topic == f'{LEFT}/scene':
            data = encode_string(decode_string(data).replace(
                'youngs_modulus: 207', 'youngs_modulus: 208'))
        return message.log_time, data
    assert 'step 2' in verify(copy(files_of(logged), tmp_path / 'c.mcap', stiffer)).difference
    elsewhere = verify(copy(files_of(logged), tmp_path / 'b.mcap', older))
    assert any('numba' in text for text in elsewhere.elsewhere)
    assert elsewhere.difference == ''


def test_a_converted_log_is_drawn(logged, tmp_path):
    converted = copy(files_of(logged), tmp_path / 'a.mcap')
    drawn, original = read_series(converted), read_series(logged)
    for name in ('t', 'tip', 'normal_force', 'torque', 'commands'):
        assert (getattr(drawn, name) == getattr(original, name)).all(), name
    assert len(drawn.commands) == len(COMMANDS)


def test_a_split_log_converted_to_one_file_and_a_later_part_alone(tmp_path, capsys):
    scene = replace(SCENE, log=replace(SCENE.log, max_size=0.1))
    run(tmp_path / 'run', scene, compression='none')
    files = files_of(tmp_path / 'run')
    assert len(files) > 2
    assert verify(tmp_path / 'run').difference == ''
    assert verify(copy(files, tmp_path / 'one.mcap')).difference == ''
    part = copy(files[1:2], tmp_path / 'part.mcap')
    assert Recording(part).scene == scene
    assert 10 < len(read_series(part).t) < len(read_series(tmp_path / 'run').t)
    assert main(['replay', str(part), '--verify']) == 2
    (line,) = capsys.readouterr().err.splitlines()
    assert 'does not begin where its run did' in line


def recorded(source, target, whole=True):
    """
    Write a log again as `ros2 bag record` would have it of the node's topics.

    Times of arrival, the states at chunk ends alone, one topic well behind the others, the scene
    discovered late; commands as `~/events` tells them, beside those on their topics.
    """
    chunk, number = round(SCENE.run.chunk / ITS), itertools.count()
    messages = []   # (arrival, channel, data)
    arrival = 1_790_000_500_000_000_000
    for entry in Recording(source).entries():
        due = arrival + entry.step * 500_000
        data = entry.message.data
        if entry.name == '~/events' or entry.name.startswith('cmd_'):
            event = {'values': decode_command(entry.message.channel.schema, data),
                     'topic': entry.name, 'event': 'command'} if entry.name != '~/events' else (
                         decode_event(data))
            event |= {'step': entry.step, 'number': next(number)}
            if whole or event['number'] != 2:
                messages.append((due + 90_000_000, f'{LEFT}/events', 'std_msgs/msg/String',
                                 encode_string(json.dumps(event))))
        if entry.name != '~/events':
            if entry.step % chunk and entry.name in ('tip_pose', 'joint_states', 'tip_wrench',
                                                     'contact_wrench', 'mount_wrench'):
                continue
            late = {'~/scene': 30_000_000, 'tip_pose': 70_000_000}.get(entry.name, 0)
            channel = entry.message.channel
            messages.append((due + late, channel.topic, channel.schema, data))
    file = McapFile(target)
    channels = {}
    for arrived, topic, type_name, data in sorted(messages):
        if topic not in channels:
            channels[topic] = file.channel(topic, type_name, schema_text(type_name).encode(), {})
        file.add(channels[topic], arrived, arrived, data)
    file.finish()
    return target


def test_a_recorded_bag_is_drawn_and_verified(logged, tmp_path, capsys):
    bag = recorded(logged, tmp_path / 'a.mcap')
    recording = Recording(bag)
    assert recording.recorded
    assert not Recording(logged).recorded
    drawn, original = read_series(bag), read_series(logged)
    at = [list(original.t).index(time) for time in drawn.t]
    assert len(at) > 20
    assert (drawn.normal_force == original.normal_force[at]).all()
    assert main(['replay', str(bag), '--verify']) == 0
    assert 'identical' in capsys.readouterr().out
    verdict = verify(bag)
    assert verdict.compared == 1 + 5 * len(at)
    assert verdict.applied == len(COMMANDS)


def test_a_recorded_bag_that_lacks_an_event_is_not_verified(logged, tmp_path, capsys):
    bag = recorded(logged, tmp_path / 'a.mcap', whole=False)
    assert main(['replay', str(bag), '--verify']) == 2
    (line,) = capsys.readouterr().err.splitlines()
    assert 'made by a recorder, and events are missing' in line
    assert len(read_series(bag).t) > 20


def test_a_bag_without_a_scene_says_so(logged, tmp_path):
    def without(topic, message):
        return None if topic.endswith('/scene') else (message.log_time, message.data)
    bag = copy(files_of(logged), tmp_path / 'a.mcap', without)
    with pytest.raises(SceneError, match='holds no scene'):
        verify(bag)


def compressed(log, target):
    """Compress the files of a log as rosbag2 does with `compression_mode: FILE`."""
    target.mkdir()
    for file in files_of(log):
        (target / f'{file.name}.zstd').write_bytes(
            zstandard.ZstdCompressor().compress(file.read_bytes()))
    text = (log / 'metadata.yaml').read_text().replace('.mcap', '.mcap.zstd')
    text = text.replace("compression_format: ''", 'compression_format: zstd')
    (target / 'metadata.yaml').write_text(
        text.replace("compression_mode: ''", 'compression_mode: FILE'))
    return target


def test_every_verb_reads_compressed_files(logged, tmp_path, capsys):
    packed = compressed(logged, tmp_path / 'packed')
    (file,) = packed.glob('*.zstd')
    with AnyReader([packed]) as reader:     # what we made is what others take for it
        assert reader.message_count == sum(1 for _ in Recording(logged).entries())
    for log in (packed, file):
        assert main(['replay', str(log), '--verify']) == 0
        assert 'identical' in capsys.readouterr().out
        assert main(['plot', str(log)]) == 0
    assert sorted(path.name for path in tmp_path.glob('*.png')) == ['packed.png']
    assert (packed / 'run1_0.png').is_file()
    assert logged_commands(file) == logged_commands(logged)
    assert [event for _, event in commands_of(file, ITS)] == [
        event for _, event in commands_of(logged, ITS)]
    assert main(['recover', str(file)]) == 0
    recovered = Recording(packed / 'run1_0_recovered.mcap')
    assert [entry.message.data for entry in recovered.entries()] == [
        entry.message.data for entry in Recording(logged).entries()]


def test_a_compressed_file_that_was_cut_or_mangled(tmp_path):
    run(tmp_path / 'run', compression='none', duration=2000)
    packed = compressed(tmp_path / 'run', tmp_path / 'packed')
    (file,) = packed.glob('*.zstd')
    content = file.read_bytes()
    half = len(content) // 2
    file.write_bytes(content[:half])
    recording = Recording(packed)
    steps = [entry.step for entry in recording.entries()]
    assert len(steps) > 100
    assert recording.cut
    file.write_bytes(content[:half] + bytes(1000) + content[half + 1000:])
    recording = Recording(packed)
    list(recording.entries())
    assert recording.damage
    file.write_bytes(content[:4] + b'no frame at all')
    with pytest.raises(SceneError) as caught:
        verify(packed)
    assert '\n' not in str(caught.value)


def test_messages_that_were_compressed_are_read(logged, tmp_path):
    def packed(topic, message):
        return message.log_time, zstandard.ZstdCompressor().compress(message.data)
    copied = copy(files_of(logged), tmp_path / 'a.mcap', packed)
    assert verify(copied)[:3] == verify(logged)[:3]
    assert verify(copied).difference == ''

    def mangled(topic, message):
        _, data = packed(topic, message)
        return message.log_time, data[:-9] if topic == '/tip' else data
    damaged = copy(files_of(logged), tmp_path / 'b.mcap', mangled)
    assert 'the log is damaged' in verify(damaged).difference


def test_a_bag_of_sqlite_says_what_would_do(tmp_path):
    (tmp_path / 'bag_0.db3').touch()
    with pytest.raises(SceneError, match='ros2 bag convert'):
        Recording(tmp_path)


def test_a_log_has_the_frames_of_each_chunk(logged, tmp_path):
    with AnyReader([logged]) as reader:
        found = {one.topic: [] for one in reader.connections}
        for connection, time, raw in reader.messages():
            found[connection.topic].append(
                (time, reader.deserialize(raw, connection.msgtype)))
    chunk = round(SCENE.run.chunk * 1e9)
    times = [time for time, _ in found['/tf']]
    assert {after - before for before, after in itertools.pairwise(times)} == {chunk}
    angles = {time: state.position[0] for time, state in found['/left/joint_states']}
    compared = 0
    for time, message in found['/tf']:
        mount, turn = message.transforms
        frames = [(one.header.frame_id, one.child_frame_id) for one in (mount, turn)]
        assert frames == [('road', 'brush_mount'), ('brush_mount', 'brush')]
        if time in angles:
            spin = turn.transform.rotation
            off = 2.0 * math.atan2(spin.z, spin.w) - angles[time]
            assert math.sin(0.5 * off) == pytest.approx(0.0, abs=1e-9)   # whole turns apart
            compared += 1
    assert compared > 10
    ways = [message.transforms[0].transform.translation.x for _, message in found['/tf']]
    assert max(ways) > 0.002    # cmd_vel
    [(_, described)] = found['/left/robot_description']
    links = {link.get('name') for link in ElementTree.fromstring(described.data).iter('link')}
    assert links == {'brush_mount', 'brush'}

    run(tmp_path / 'bare', replace(SCENE, log=replace(SCENE.log, tf=False)))
    names = {entry.name for entry in Recording(tmp_path / 'bare').entries()}
    assert not names & {'/tf', 'robot_description'}
    assert verify(tmp_path / 'bare').difference == ''


@pytest.mark.parametrize('event', [
    {'topic': 'cmd_vel', 'values': 5}, {'values': [1.0]}, {'topic': [], 'values': [1.0]},
    {'topic': 'cmd_brush_speed', 'values': [None]}, {'topic': 'cmd_brush_speed', 'values': [1e9]}])
def test_events_that_make_no_sense_are_a_difference(logged, tmp_path, event):
    def senseless(topic, message):
        data = message.data
        if topic == f'{LEFT}/events' and decode_event(data)['event'] == 'reset':
            data = encode_string(json.dumps({'event': 'command', 'step': 200, **event}))
        return message.log_time, data
    difference = verify(copy(files_of(logged), tmp_path / 'a.mcap', senseless)).difference
    assert 'step 200' in difference
    assert '\n' not in difference
