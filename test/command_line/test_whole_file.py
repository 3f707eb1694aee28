"""Outputs of `simulate`: nothing that exists is damaged, nothing that came is lost."""
import csv
import os
from pathlib import Path
import resource
import signal
import subprocess
import sys
import time

import bristle_ros
from bristle_ros.command_line.whole_file import WholeFile
from bristle_ros.log.recording import Recording
from bristle_ros.scene.error import SceneError
from bristle_ros.verbs import simulate as offline
import numpy as np
import pytest

SCENE = (Path(__file__).resolve().parents[1] / 'small_brush.yaml').read_text()
ENDLESS = 1e4       # [s]
BEFORE = b'what stood there before'


def start(scene, output, *more, limit=None):
    """Start `simulate` on an endless run, with signals as in a terminal."""
    def prepare():
        signal.signal(signal.SIGINT, signal.default_int_handler)
        if limit:
            signal.signal(signal.SIGXFSZ, signal.SIG_IGN)   # a write then fails with an errno
            resource.setrlimit(resource.RLIMIT_FSIZE, (limit, limit))
    return subprocess.Popen(
        [sys.executable, '-m', 'bristle_ros', 'simulate', str(scene), '--duration', str(ENDLESS),
         '--output', str(output), *more],
        stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True, preexec_fn=prepare)


def wait_until(condition, process, limit=120.0):
    end = time.monotonic() + limit
    while not condition():
        assert process.poll() is None, process.communicate()
        assert time.monotonic() < end
        time.sleep(0.02)


def stepping(folder, name):
    """Whether the file in the making is there: the run has been built and begins."""
    return any(entry.name != name for entry in folder.iterdir())


def rows_of(path):
    if path.suffix == '.npz':
        with np.load(path) as found:
            return found['t']
    with open(path, newline='') as file:
        rows = list(csv.reader(file))
    assert {len(row) for row in rows} == {len(rows[0])}
    return np.array([float(row[0]) for row in rows[1:]])


@pytest.mark.parametrize('suffix', ['.npz', '.csv'])
@pytest.mark.parametrize(('numbers', 'code'), [
    ([signal.SIGINT], 130), ([signal.SIGINT, signal.SIGINT], 130), ([signal.SIGTERM], 143),
    ([signal.SIGHUP], 129)])
def test_an_interrupt_keeps_what_came_and_what_was_there(scene, tmp_path, numbers, code, suffix):
    folder = tmp_path / 'outputs'
    folder.mkdir()
    output = folder / f'run{suffix}'
    output.write_bytes(BEFORE)
    process = start(scene, output, '--overwrite')
    wait_until(lambda: stepping(folder, output.name), process)
    time.sleep(0.5)
    for number in numbers:
        process.send_signal(number)
        time.sleep(0.02)
    said = process.communicate(timeout=60)[1]
    assert process.returncode == code
    kept = folder / f'run.partial{suffix}'
    assert said == f'simulate: interrupted; {kept} has what came before\n'
    assert output.read_bytes() == BEFORE
    assert set(folder.iterdir()) == {kept, output}
    t = rows_of(kept)
    assert len(t) >= 1
    np.testing.assert_allclose(t, 1e-3 * np.arange(1, len(t) + 1), rtol=1e-12)


@pytest.mark.parametrize('suffix', ['.npz', '.csv', '.mcap'])
def test_nothing_is_overwritten_unasked(scene, tmp_path, suffix):
    output = tmp_path / f'run{suffix}'
    output.write_bytes(BEFORE)
    with pytest.raises(SceneError, match='exists already.*--overwrite') as refused:
        bristle_ros.simulate(scene, 0.01, output=output)
    assert str(output) in str(refused.value)
    assert output.read_bytes() == BEFORE
    bristle_ros.simulate(scene, 0.01, output=output, overwrite=True)
    if suffix == '.mcap':
        assert Recording(output).cut == ''
        assert any(entry.name == 'tip_pose' for entry in Recording(output).entries())
    else:
        assert len(rows_of(output)) == 10
    assert set(tmp_path.iterdir()) == {output, scene}
    assert output.stat().st_mode & 0o777 == scene.stat().st_mode & 0o777


@pytest.mark.parametrize('suffix', ['.npz', '.csv'])
def test_a_full_disk_costs_no_file(scene, tmp_path, suffix):
    folder = tmp_path / 'outputs'
    folder.mkdir()
    output = folder / f'run{suffix}'
    output.write_bytes(BEFORE)
    process = start(scene, output, '--overwrite', limit=100_000)
    if suffix == '.npz':    # is written at the end
        wait_until(lambda: stepping(folder, output.name), process)
        time.sleep(1.5)
        process.send_signal(signal.SIGINT)
    said = process.communicate(timeout=120)[1]
    assert process.returncode == 2, said
    assert str(output) in said
    assert 'too large' in said
    assert len(said.splitlines()) == 1
    assert output.read_bytes() == BEFORE


def test_the_call_raises_what_interrupts_it(scene, tmp_path, monkeypatch):
    output = tmp_path / 'run.npz'
    whole = offline.SampleArrays.write

    def write(self, chunk):
        whole(self, chunk)
        if chunk.end >= 100:
            raise KeyboardInterrupt

    monkeypatch.setattr(offline.SampleArrays, 'write', write)
    with pytest.raises(KeyboardInterrupt):
        bristle_ros.simulate(scene, 10.0, output=output)
    assert not output.exists()
    assert len(rows_of(tmp_path / 'run.partial.npz')) == 50


def test_an_error_leaves_nothing(tmp_path):
    def fail():
        with WholeFile(tmp_path / 'a.txt', text=True) as file:
            file.write('half')
            raise ZeroDivisionError

    with pytest.raises(ZeroDivisionError):
        fail()
    assert list(tmp_path.iterdir()) == []


def test_memory_grows_no_faster_than_the_output(scene, tmp_path):
    """Peak memory of a long run over that of a short one, against what the file has more."""
    peaks, sizes = [], []
    for duration in (2.0, 50.0):
        output = tmp_path / f'{duration}.npz'
        code = ('import resource, sys; from bristle_ros.__main__ import main\n'
                'assert main(sys.argv[1:]) == 0\n'
                'print(resource.getrusage(resource.RUSAGE_SELF).ru_maxrss * 1024)')
        done = subprocess.run(
            [sys.executable, '-c', code, 'simulate', str(scene), '--duration', str(duration),
             '--output', str(output)], check=True, text=True, stdout=subprocess.PIPE)
        peaks.append(int(done.stdout.split()[-1]))
        sizes.append(os.path.getsize(output))
    assert sizes[1] - sizes[0] > 2e7
    assert peaks[1] - peaks[0] < 1.25 * (sizes[1] - sizes[0])
