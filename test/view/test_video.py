"""A log as pictures: as many as it lasts, of what was; and what cannot be made."""
import shutil
import subprocess

from bristle_ros.log import Log
from bristle_ros.realtime.driver import Driver
from bristle_ros.scene.scene import load
from bristle_ros.simulation import MountPath, Simulation
from bristle_ros.view import colours
import matplotlib.image
import numpy as np
import pytest
from view.test_verb import LIMIT, refusal, ROOT, view

CHUNKS, EVERY = 84, 8   # of 5 ms; 25 pictures a second


@pytest.fixture(scope='module')
def log(tmp_path_factory):
    """Return a log of two bristles that are pressed on the road all the time."""
    path = tmp_path_factory.mktemp('log') / 'run.mcap'
    scene = load(ROOT / 'test/small_brush.yaml', {'road.penetration': 0.04})
    driver = Driver(Simulation(scene), sample=2, paced=False)
    driver.mount = MountPath(scene)
    with Log(path, scene) as written:
        for _ in range(CHUNKS):
            written.write(driver.run_chunk())
    return path


def made(*arguments):
    process = view(*map(str, arguments))
    printed, said = process.communicate(timeout=LIMIT)
    assert (process.returncode, said) == (0, ''), printed + said
    return printed


def test_a_folder_of_pictures(log, tmp_path):
    printed = made(log, '--video', tmp_path / 'film')
    assert printed == f'view: {tmp_path / "film"}: 10 pictures, 25 a second\n'
    names = sorted(path.name for path in (tmp_path / 'film').iterdir())
    assert names == [f'{number:05d}.png' for number in range(1, CHUNKS // EVERY + 1)]
    first, last = (matplotlib.image.imread(tmp_path / 'film' / name)[..., :3]
                   for name in (names[0], names[-1]))
    assert first.shape == (720, 1280, 3)
    assert 0.001 < np.mean(np.abs(first - last).max(axis=2) > 0.1) < 0.2   # it has turned
    arrow = np.array(colours.ARROW) / 255.0
    # forces, in the brush's half
    assert np.count_nonzero(np.abs(last[:, :800] - arrow).max(axis=2) < 0.02) > 20
    assert 'exists already' in refusal(str(log), '--video', str(tmp_path / 'film'))


@pytest.mark.needs('ffmpeg', lambda: shutil.which('ffmpeg'))
def test_a_video(log, tmp_path):
    made(log, '--video', tmp_path / 'film.mp4')
    found = subprocess.run(
        ['ffprobe', '-v', 'error', '-count_frames', '-show_entries',
         'stream=width,height,nb_read_frames,avg_frame_rate', '-of', 'csv=p=0',
         str(tmp_path / 'film.mp4')], capture_output=True, text=True, check=True)
    assert found.stdout.strip() == '1280,720,25/1,10'
    assert [path.name for path in tmp_path.iterdir()] == ['film.mp4']


def test_what_cannot_be_made_is_one_line(log, tmp_path):
    scene = str(ROOT / 'test/small_brush.yaml')
    assert 'is no log' in refusal(scene, '--video', 'out')
    assert '--video = "out": shows a log as it is' in refusal('--video', 'out')
    assert 'no such file' in refusal('nothing.mcap', '--video', str(tmp_path / 'out'))
    without = ('import os; os.environ["PATH"] = "/nowhere"\n'
               'from bristle_ros.__main__ import main; raise SystemExit(main())')
    said = refusal(str(log), '--video', str(tmp_path / 'film.mp4'), code=without)
    assert 'needs ffmpeg, which is not installed: name a folder, for PNGs' in said
    assert not any(tmp_path.iterdir())
