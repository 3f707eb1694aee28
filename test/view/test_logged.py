"""Logs that are played: what was logged, wires simulated again, also of a log that was cut off."""
from bristle_ros.log.recording import Recording
from bristle_ros.messages.encode import TOPICS
from bristle_ros.scene.scene import SceneError
from bristle_ros.verbs.simulate import main as simulate
from bristle_ros.view.logged import LogSource
from bristle_ros.view.stage import tip_on_road
import numpy as np
import pytest
from view.test_source import Page

SCENE = """
/**:
  ros__parameters:
    brush: {bristle_count: 2}
    road: {attack_angle: 0.15, tilt_azimuth: 0.4}
    drive: {profile: constant, mean_speed: 5.0}
    solver: {elements: 3, integration_time_step: 5.0e-4}
    sweeper: {velocity: [0.8, 0.0]}
    run: {chunk: 0.005, sample: 0.001}
"""


@pytest.fixture(scope='module')
def log(tmp_path_factory):
    """Return a log of 0.3 s with a command and a reset in it."""
    folder = tmp_path_factory.mktemp('logged')
    (folder / 'scene.yaml').write_text(SCENE)
    (folder / 'commands.csv').write_text('0.1,cmd_brush_speed,8.0\n0.2,reset\n')
    simulate([str(folder / 'scene.yaml'), '--duration', '0.3', '--commands',
              str(folder / 'commands.csv'), '--output', str(folder / 'run.mcap')])
    return folder / 'run.mcap'


class Clock:
    """Seconds, turned by hand."""

    def __init__(self):
        self.now = 0.0

    def __call__(self):
        return self.now


def opened(path):
    """Return (Page, Clock) of a log once all of its wires have been simulated again."""
    clock = Clock()
    page = Page(LogSource(path, clock))
    page.until(lambda: page.status and page.status.state != 'reading', 'the log')
    page.until(lambda: not page.source._simulating, 'the wires')
    return page, clock


def poses(path):
    [decode] = [topic.decode for topic in TOPICS if topic.name == 'tip_pose']
    its = Recording(path).integration_time_step
    return {round(entry.step * its, 9): decode(entry.message.data)[:3]
            for entry in Recording(path).entries() if entry.name == 'tip_pose'}


def test_frames_are_those_of_the_log(log):
    page, _ = opened(log)
    logged = poses(log)
    page.source.pause(True)
    for t in (0.005, 0.15, 0.225, 0.3):     # at the start, after the command, after the reset
        page.source.seek(t)
        page.look()
        assert page.frame.t == pytest.approx(t)
        assert page.frame.exact
        np.testing.assert_allclose(page.frame.centreline[0, -1], logged[t], atol=1e-7)
        assert page.status.t == pytest.approx(t)
    page.source.close()


def test_playing_gives_each_chunk_once(log):
    page, clock = opened(log)
    page.source.seek(0.05)
    page.look()
    page.rows.clear()
    for _ in range(10):
        clock.now += 0.01
        page.look()
    np.testing.assert_allclose(page.column('t'), np.arange(0.055, 0.1501, 0.005), atol=1e-9)
    assert page.column('omega')[-1] == pytest.approx(5.0 + 50.0 * 0.05)     # max_acceleration
    page.source.pause(True)
    clock.now += 5.0
    assert page.look().status.t == pytest.approx(0.15)
    page.source.pause(False)
    clock.now += 5.0
    assert page.look().status.t == pytest.approx(0.3)
    clock.now += 0.01
    assert page.look().status.t < 0.02      # once more
    page.source.close()


def test_the_way_over_the_road_is_the_logged_one(log):
    page, _ = opened(log)
    page.source.seek(0.2)
    page.look()
    assert page.frame.mount[0] == pytest.approx(0.8 * 0.2, abs=1e-6)
    straight = page.source._logged
    np.testing.assert_allclose(straight.poses[straight.at(0.2), :3], page.frame.mount, atol=1e-9)
    assert np.isfinite(tip_on_road(page.frame)).all()
    page.source.close()


def test_a_log_that_was_cut_off_plays_as_far_as_it_goes(log, tmp_path):
    cut = tmp_path / 'cut.mcap'
    whole = log.read_bytes()
    cut.write_bytes(whole[:int(0.45 * len(whole))])
    page, _ = opened(cut)
    last = max(poses(cut))
    assert 0.05 < last < 0.3
    assert page.source.duration == pytest.approx(last, abs=0.005)
    page.source.pause(True)
    page.source.seek(page.source.duration)
    page.look()
    assert page.frame.exact
    assert 'cut' in page.status.text
    page.source.close()


def test_a_file_that_is_no_log_is_refused(tmp_path):
    path = tmp_path / 'run.mcap'
    path.write_bytes(b'no log')
    with pytest.raises(SceneError, match=r'run\.mcap'):
        LogSource(path)
