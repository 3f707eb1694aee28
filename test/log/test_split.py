"""Logs of several files: each is whole in itself, together they are the run."""
from collections import Counter
import errno
import os
import shutil
import signal
import subprocess
import sys

from bristle_ros.log import output as mcap_output
from bristle_ros.log.bag_metadata import METADATA, PART
from bristle_ros.log.reader import McapReader, Message, Metadata
from bristle_ros.log.recording import Recording
from bristle_ros.log.writer import Log
from bristle_ros.messages import encode as messages
from bristle_ros.scene.error import SceneError
from bristle_ros.scene.scene import from_parameters
from bristle_ros.verbs.recover import recover
from examples import chunk_of, SCENE
import pytest
from rosbags.highlevel import AnyReader
from log.test_writer import read_with_mcap, read_with_mcap_ros2, read_with_rosbags, write_example
import yaml

PARAMETERS = {'brush.bristle_count': 2, 'contact.normal_stiffness': float('inf'),
              'log.max_size': 1.0}
SPLIT = from_parameters(PARAMETERS, 'test')
LIMIT = 1_000_000


def files_of(path):
    return sorted(path.glob('*.mcap'))


def counts_of(paths, read):
    return sum((Counter(read(path)) for path in paths), Counter())


@pytest.fixture(scope='module')
def run(tmp_path_factory):
    """Yield a closed log of three files, and its messages by topic."""
    path = tmp_path_factory.mktemp('split') / 'run'
    with Log(path, SPLIT, compression='none') as log:
        expected = write_example(log, 400)
    assert log.failed is None
    return path, {**expected, '/brush_node/scene': 3, '/robot_description': 3}    # one in each


def test_no_file_grows_beyond_the_size_and_each_is_nearly_full(run):
    path, _ = run
    assert [file.name for file in files_of(path)] == ['run_0.mcap', 'run_1.mcap', 'run_2.mcap']
    sizes = [file.stat().st_size for file in files_of(path)]
    assert max(sizes) <= LIMIT
    assert min(sizes[:-1]) > 0.9 * LIMIT


def test_readers_of_others_read_all_of_it(run):
    path, expected = run
    assert counts_of(files_of(path), read_with_mcap) == expected
    assert counts_of(files_of(path), read_with_mcap_ros2) == expected
    assert read_with_rosbags(path) == expected


def test_metadata_lists_every_file_with_its_times_and_messages(run):
    path, expected = run
    information = yaml.safe_load((path / 'metadata.yaml').read_text())[
        'rosbag2_bagfile_information']
    assert information['relative_file_paths'] == [file.name for file in files_of(path)]
    assert information['message_count'] == sum(expected.values())
    assert {topic['topic_metadata']['name']: topic['message_count']
            for topic in information['topics_with_message_count']} == expected
    for file, entry in zip(files_of(path), information['files']):
        times = [record.log_time for record in McapReader(file).records()
                 if isinstance(record, Message)]
        assert entry == {
            'path': file.name, 'message_count': len(times),
            'starting_time': {'nanoseconds_since_epoch': min(times)},
            'duration': {'nanoseconds': max(times) - min(times)}}
    assert information['duration']['nanoseconds'] == max(times)


def test_each_file_has_the_scene_and_all_it_needs(run):
    path, _ = run
    for number, file in enumerate(files_of(path)):
        recording = Recording(file)
        assert recording.scene == SPLIT
        assert recording.part == number
        assert list(recording.entries())
        assert not recording.damage
        with AnyReader([file]) as reader:
            connection, _, raw = next(reader.messages())
            assert reader.deserialize(raw, connection.msgtype)


def test_the_files_are_read_in_order(run):
    path, _ = run
    recording = Recording(path)
    steps = [entry.step for entry in recording.entries() if entry.name == 'tip_pose']
    assert steps == [*range(1, 4001), 4010]
    assert not recording.damage
    assert not recording.cut


def test_a_missing_part_is_told(run, tmp_path):
    path, _ = run
    for missing in (0, 1):
        copy = tmp_path / f'without_{missing}'
        copy.mkdir()
        for file in files_of(path):
            if not file.name.endswith(f'_{missing}.mcap'):
                os.link(file, copy / file.name)
        recording = Recording(copy)
        steps = [entry.step for entry in recording.entries()]
        assert steps == sorted(steps)
        if missing:
            assert 'part 2 of a log comes after part 0' in recording.damage[0]
        else:
            for log in (recording, Recording(recover(copy).output)):
                with pytest.raises(SceneError, match='part 1 of a log, without what came before'):
                    log.from_start()


def test_a_destroyed_part_does_not_hide_the_others(run, tmp_path):
    path, _ = run
    (tmp_path / 'run').mkdir()
    for file in files_of(path):
        content = file.read_bytes()
        if file.name == 'run_1.mcap':
            content = bytes(len(content))
        (tmp_path / 'run' / file.name).write_bytes(content)
    shutil.copy(path / METADATA, tmp_path / 'run')
    result = recover(tmp_path / 'run')
    assert 'run_1.mcap' in result.lost[0]
    left = counts_of([files_of(path)[0], files_of(path)[2]], read_with_mcap)
    assert read_with_rosbags(result.output) == left
    # A part that is cut off in the middle is a hole, no end.
    (tmp_path / 'run' / 'run_1.mcap').write_bytes(files_of(path)[1].read_bytes()[:500_000])
    recording = Recording(tmp_path / 'run')
    assert sum(1 for _ in recording.entries()) > sum(left.values())
    assert 'another file follows' in recording.damage[0]
    assert not recording.cut


WRITER = """
import sys
from bristle_ros.log import Log
from bristle_ros.scene import from_parameters
from examples import chunk_of
log = Log(sys.argv[1], from_parameters({PARAMETERS}, 'test'), compression='none')
for number in range(10**6):
    log.write(chunk_of(range(10 * number + 1, 10 * number + 11)))
    print(10 * number + 10, flush=True)
"""


def test_a_killed_one_is_recovered_file_by_file(tmp_path):
    text = WRITER.replace('{PARAMETERS}', repr(PARAMETERS).replace('inf', "float('inf')"))
    process = subprocess.Popen([sys.executable, '-c', text, tmp_path / 'run'],
                               cwd=os.path.dirname(os.path.dirname(__file__)), stdout=subprocess.PIPE, text=True)
    # What a file holds is on the disk when the next one is there.
    while not (tmp_path / 'run' / 'run_3.mcap').exists():
        assert process.stdout.readline()
    process.send_signal(signal.SIGKILL)
    process.communicate()
    recording = Recording(tmp_path / 'run')
    entries = list(recording.entries())
    assert len(files_of(tmp_path / 'run')) >= 4
    assert recording.cut
    assert not recording.damage
    result = recover(tmp_path / 'run')
    assert result.messages == len(entries)
    # The last file may hold no message yet; it then leaves none behind.
    names = [f'run_recovered_{file.name[4:]}' for file in files_of(tmp_path / 'run')]
    assert len(names) - 1 <= len(files_of(result.output)) <= len(names)
    assert [file.name for file in files_of(result.output)] == names[:len(files_of(result.output))]
    assert sum(read_with_rosbags(result.output).values()) == len(entries)
    again = Recording(result.output)
    assert [entry.message.data for entry in again.entries()] == [
        entry.message.data for entry in entries]
    assert not again.cut
    assert not again.damage
    merged = recover(tmp_path / 'run', tmp_path / 'one.mcap')
    assert sum(read_with_mcap(merged.output).values()) == len(entries)
    assert Recording(merged.output).scene == SPLIT


KILLED_BETWEEN = """
import os, signal
from bristle_ros.log import bag

class Last(bag.McapFile):
    def __init__(self, path, compression):
        if str(path).endswith('_2.mcap'):
            os.kill(os.getpid(), signal.SIGKILL)
        super().__init__(path, compression)

bag.McapFile = Last
"""


def test_one_that_was_killed_between_two_files_is_cut_off(tmp_path):
    text = WRITER.replace('{PARAMETERS}', repr(PARAMETERS).replace('inf', "float('inf')"))
    process = subprocess.run([sys.executable, '-c', KILLED_BETWEEN + text, tmp_path / 'run'],
                             cwd=os.path.dirname(os.path.dirname(__file__)),
                             stdout=subprocess.DEVNULL)
    assert process.returncode == -signal.SIGKILL
    assert sorted(os.listdir(tmp_path / 'run')) == ['run_0.mcap', 'run_1.mcap']
    recording = Recording(tmp_path / 'run')
    entries = list(recording.entries())
    assert 'without metadata.yaml' in recording.cut
    assert not recording.damage
    for file in files_of(tmp_path / 'run'):     # each by itself is whole
        part = Recording(file)
        assert list(part.entries())
        assert not part.cut
    result = recover(tmp_path / 'run')
    assert result.lost == [recording.cut]
    again = Recording(result.output)
    assert len(list(again.entries())) == result.messages == len(entries)
    assert not again.cut


def test_no_room_for_another_file_ends_the_log(tmp_path, monkeypatch):
    log = Log(tmp_path / 'run', SPLIT, compression='none')
    write, opened = os.write, os.open
    made = []

    def open_once(path, *arguments, **keywords):
        if str(path).endswith('_1.mcap'):
            made.append(opened(path, *arguments, **keywords))
            return made[0]
        return opened(path, *arguments, **keywords)

    def refuse(fd, data):
        if fd in made:
            raise OSError(errno.ENOSPC, 'No space left on device')
        return write(fd, data)

    monkeypatch.setattr(mcap_output.os, 'open', open_once)
    monkeypatch.setattr(mcap_output.os, 'write', refuse)
    for number in range(400):
        log.write(chunk_of(range(10 * number + 1, 10 * number + 11)))
    log.close()
    assert 'no space left on device' in log.failed
    assert sorted(os.listdir(tmp_path / 'run')) == ['metadata.yaml', 'run_0.mcap']
    assert read_with_rosbags(tmp_path / 'run') == read_with_mcap(tmp_path / 'run' / 'run_0.mcap')
    recording = Recording(tmp_path / 'run')
    assert sum(entry.name == 'tip_pose' for entry in recording.entries()) > 1000
    assert not recording.cut


@pytest.mark.parametrize(('given', 'text'), [
    ({'log.max_size': 0.05}, 'too small'), ({'log.max_size': -1.0}, 'log.max_size'),
    ({'log.max_size': 5.0, 'log.path': 'a.mcap'}, 'needs a directory')])
def test_a_size_that_can_do_nothing_is_refused(given, text):
    with pytest.raises(SceneError, match=text):
        from_parameters(given, 'test')


def test_without_a_size_there_is_one_file(tmp_path):
    with Log(tmp_path / 'run', SCENE, compression='none') as log:
        for number in range(100):
            log.write(chunk_of(range(50 * number + 1, 50 * number + 51)))
    (file,) = files_of(tmp_path / 'run')
    assert file.stat().st_size > LIMIT
    parts = [record.entries for record in McapReader(file).records()
             if isinstance(record, Metadata) and record.name == PART]
    assert parts == [{'number': '0'}]
    assert len(messages.TOPICS) * 5000 < sum(read_with_mcap(file).values())
