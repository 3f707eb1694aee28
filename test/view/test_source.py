"""A scene that is simulated for a page: the bits of any other run, and it obeys."""
import time

from bristle_ros import simulate
from bristle_ros.scene.scene import from_parameters, SceneError
from bristle_ros.simulation import CommandRefused
from bristle_ros.view.frame import COLUMNS
from bristle_ros.view.source import SceneSource
import numpy as np
import pytest

LIMIT = 600.0   # [s] before a wait is a failure: compiling on a busy machine takes minutes
SCENE = {'brush.bristle_count': 2, 'drive.mean_speed': 5.0, 'drive.profile': 'constant',
         'solver.elements': 3, 'solver.integration_time_step': 5e-4, 'run.chunk': 0.005}


class Page:
    """Asks a source as the page does, and keeps what comes."""

    def __init__(self, source):
        self.source, self.frame, self.rows = source, None, []
        self.status, self.trail = None, []

    def look(self):
        update = self.source.update()
        self.status, self.frame = update.status, update.frame or self.frame
        self.rows += update.rows.tolist()
        self.trail += list(update.trail)
        return update

    def until(self, condition, what):
        end = time.monotonic() + LIMIT
        while not condition():
            self.look()
            assert self.status.state != 'ended' or condition(), f'{what}: {self.status}'
            assert time.monotonic() < end, f'{what}: not within {LIMIT} s: {self.status}'
            time.sleep(0.01)

    def column(self, name):
        return np.array(self.rows)[:, COLUMNS.index(name)]


@pytest.fixture
def page():
    made = Page(SceneSource(from_parameters(SCENE, 'test')))
    yield made
    made.source.close()


def test_a_scene_obeys_and_keeps_its_bits(page):
    source = page.source
    page.until(lambda: page.frame is not None and len(page.rows) > 20, 'frames')
    source.pause(True)
    page.until(lambda: page.status.state == 'paused', 'a pause')
    page.until(lambda: abs(page.rows[-1][0] - page.status.t) < 1e-9, 'its last chunk')
    held = page.status.t
    source.step()
    page.until(lambda: page.status.t > held, 'one chunk')
    page.until(lambda: len(page.rows) * 0.005 > held, 'its row')
    assert page.status.t == pytest.approx(held + 0.005)
    # every chunk from the start on, none twice, with the bits of simulate
    arrays = simulate(source.scene, page.rows[-1][0], sample=0.005)
    np.testing.assert_array_equal(page.column('t'), arrays['t'])
    np.testing.assert_array_equal(page.column('torque'), -arrays['brush_torque'][:, 2])
    np.testing.assert_array_equal(page.column('normal_force'),
                                  arrays['contact_force'][:, :, 2].sum(axis=1))
    with pytest.raises(CommandRefused, match=r'cmd_brush_speed: 1000 rad/s is beyond drive.max_'):
        source.command('cmd_brush_speed', [1000.0])
    source.command('cmd_brush_speed', [-4.0])
    source.pause(False)
    page.until(lambda: page.status.speed == -4.0, 'the commanded speed')
    source.set_factor(0.25)
    page.until(lambda: page.status.asked == 0.25, 'the factor')
    source.pause(True)
    page.until(lambda: page.status.state == 'paused', 'a pause')
    source.reset()
    page.until(lambda: page.status.speed == 5.0, 'the start, shown while paused')
    assert page.frame.centreline.shape == (2, 7, 3)
    assert len(page.trail) == len(page.rows)


def test_a_scene_that_cannot_start_says_so():
    scene = from_parameters({**SCENE, 'road.approach_time': 0.0, 'road.penetration': 0.01}, 'test')
    page = Page(SceneSource(scene))
    page.until(lambda: page.status and page.status.state == 'ended', 'the reason')
    page.source.close()
    assert 'would start 0.01 m inside the road' in page.status.text


def test_a_view_keeps_no_log(tmp_path):
    scene = from_parameters({**SCENE, 'log.path': str(tmp_path / 'run')}, 'test')
    with pytest.raises(SceneError, match='log.path = .*: a view keeps no log'):
        SceneSource(scene)
