"""A running node on a page: what it publishes, commands through its topics and services."""
import time

from bristle_ros.simulation import CommandRefused
from bristle_ros.view.from_node import NodeSource
from bristle_ros.view.stage import tip_on_road
from nodes import Brush, ROOT
import numpy as np
import pytest
from std_msgs.msg import Float64
from view.test_source import Page

SCENE = (ROOT / 'test/small_brush.yaml').read_text()


def test_a_node_is_shown_and_obeys(scene, environment):
    page = Page(NodeSource('brush_node'))
    source = page.source
    page.look()
    assert (page.status.state, page.status.text) == ('waiting', 'waiting for /brush_node')
    with Brush(scene) as brush:
        page.until(lambda: page.frame is not None and len(page.rows) > 20, 'frames')
        assert source.scene.brush.bristle_count == 2
        assert page.frame.centreline.shape == (2, 7, 3)
        assert page.status.state == 'running'
        page.until(lambda: page.status.asked == 1.0 and page.status.reached > 0.0, 'diagnostics')
        source.command('cmd_brush_speed', [7.0])
        page.until(lambda: page.status.speed == 7.0, 'the commanded speed')
        with pytest.raises(CommandRefused, match=r'beyond sweeper.max_speed'):
            source.command('cmd_vel', [100.0, 0.0, 0.0])
        source.command('cmd_vel', [0.3, 0.0, 0.0])
        source.pause(True)
        page.until(lambda: page.status.state == 'paused', 'a pause')
        held = page.rows[-1][0]
        source.step()
        page.until(lambda: page.rows[-1][0] > held + 1e-9, 'one chunk')
        assert page.rows[-1][0] == pytest.approx(held + 0.005)
        source.pause(False)
        page.until(lambda: page.rows[-1][0] > held + 0.1, 'going on')
        source.step()
        page.until(lambda: 'not paused' in page.status.text, 'why it does not step')
        source.set_factor(0.5)
        page.until(lambda: page.status.asked == 0.5, 'the factor')
        source.reset()
        page.until(lambda: page.status.speed == 5.0, 'the start')
        page.until(lambda: page.look().frame is not None, 'one more frame')
        reach = source.scene.brush.mount_radius + source.scene.bristle.length
        assert np.linalg.norm(page.frame.centreline[:, -1], axis=1).max() < reach
        assert tip_on_road(page.frame)[2] < 0.05
        brush.end()
    page.until(lambda: page.status.state == 'gone', 'its end')
    with Brush(scene):
        page.until(lambda: page.status.state == 'running', 'its return')
        page.until(lambda: page.look().frame is not None, 'its wires')
    source.close()


def test_of_two_senders_the_newest_wins(scene, user):
    """Page and another node command in turn, then both at once; neither is left out for good."""
    page = Page(NodeSource('brush_node'))
    with Brush(scene, 'drive.max_acceleration:=1.0e9') as brush:
        page.until(lambda: page.frame is not None and len(page.rows) > 20, 'frames')
        other = user.publisher(Float64, 'cmd_brush_speed')
        for own, theirs in ((7.0, 3.0), (6.5, -2.5)):
            page.source.command('cmd_brush_speed', [own])
            page.until(lambda own=own: page.status.speed == own, "the page's")
            other.publish(Float64(data=theirs))
            page.until(lambda theirs=theirs: page.status.speed == theirs, "the other's")
        page.rows.clear()
        for number in range(200):
            page.source.command('cmd_brush_speed', [7.0 + 0.001 * number])
            time.sleep(0.003)   # so that some chunks begin with each of them as the newest
            other.publish(Float64(data=-7.0 - 0.001 * number))
            time.sleep(0.003)
        page.until(lambda: page.status.speed == pytest.approx(-7.199), 'the last of a burst')
        speeds = page.column('omega')
        assert (speeds > 6.9).any()
        assert (speeds < -6.9).any()
        other.publish(Float64(data=1.0))
        page.until(lambda: page.status.speed == 1.0, 'the newest')
        assert brush.end()[0] == 0
    page.source.close()
