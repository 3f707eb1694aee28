"""What a page shows of an instant, against the geometry and the messages that say the same."""
import math
from types import SimpleNamespace

from bristle_ros.messages.view import Markers
from bristle_ros.realtime.driver import Driver
from bristle_ros.scene.scene import from_parameters, load, tip_depth
from bristle_ros.simulation import check_command, CommandRefused, MountPath, Simulation
from bristle_ros.view import colours
from bristle_ros.view.frame import (COLUMNS, frame_of, resting_pose, rotation_of, row_of, straight,
                                    tracked, trail_of)
from bristle_ros.view.ground import put_ground
from bristle_ros.view.panel import _SLIDERS, ranges_of
import numpy as np
import pytest

TILTED = {'brush.bristle_count': 8, 'brush.wires_per_bristle': 7, 'road.attack_angle': 0.2,
          'road.tilt_azimuth': 0.6, 'road.penetration': 0.05, 'solver.elements': 2,
          'solver.integration_time_step': 1e-3, 'sweeper.velocity': (1.2, -0.3),
          'sweeper.mount_position': (0.7, 0.4)}


@pytest.fixture(scope='module')
def scene():
    return from_parameters(TILTED, 'test')


@pytest.fixture(scope='module')
def shown(scene):
    """Return (chunk, its simulation) after 0.1 s, with wires on the road and wires in the air."""
    driver = Driver(Simulation(scene), paced=False)
    driver.mount = MountPath(scene)
    chunk = driver.run_chunk(100)
    assert 0 < np.count_nonzero(chunk.last.contact_force[:, 2]) < 8
    return chunk, driver.simulation


def test_a_frame_puts_wires_where_the_tips_are(scene, shown):
    chunk, simulation = shown
    frame = frame_of(simulation, chunk.last, chunk.mount)
    np.testing.assert_allclose(frame.centreline[:, -1], chunk.last.tip_position_mount, atol=1e-7)
    on_road = frame.mount + frame.centreline[:, -1] @ rotation_of(frame.orientation).T
    heights = on_road[chunk.last.contact_force[:, 2] > 0.0, 2]
    np.testing.assert_allclose(heights, 0.0, atol=1e-4)     # the road is the plane z = 0
    force = frame.force.sum(axis=0) * scene.brush.wires_per_bristle
    np.testing.assert_allclose(force, chunk.last.contact_force_mount, rtol=1e-6)


def test_power_is_what_the_drive_does(scene, shown):
    chunk, _ = shown
    row = dict(zip(COLUMNS, row_of(chunk.last, scene)))
    normal = rotation_of(chunk.mount.orientation)[2] @ chunk.last.contact_force_mount
    assert row['normal_force'] == pytest.approx(normal, rel=1e-9)
    assert row['power'] == pytest.approx(-chunk.last.brush_torque[2] * chunk.last.omega)


def test_trails_are_on_the_road_or_nowhere(scene, shown):
    chunk, _ = shown
    points = trail_of(chunk.last, chunk.mount, tracked(8))
    touching = chunk.last.contact_force[:, 2] > 0.0
    assert np.array_equal(np.isfinite(points).all(axis=1), touching)
    # 0.1 s at 1.2 m/s: the trail stays where it was on the road while the brush goes on
    assert np.linalg.norm(points[touching, :2] - chunk.mount.position[:2], axis=1).max() < 0.3
    assert chunk.mount.position[0] == pytest.approx(0.7 + 0.12, abs=1e-6)


def test_markers_say_the_same_again(scene, shown):
    chunk, simulation = shown
    line = simulation.centreline()
    markers = Markers(scene)
    payload = markers.encode(1, chunk.last, line, chunk.mount)
    again, force, *_ = markers.decode(payload + bytes(3))   # as some middlewares hand it on
    np.testing.assert_array_equal(again, line)
    drawn = chunk.last.contact_force @ chunk.mount.rotation
    longest = scene.bristle.length / 0.5        # [N] an arrow is no longer than a wire
    size = np.linalg.norm(drawn, axis=1, keepdims=True)
    np.testing.assert_allclose(force, drawn * np.minimum(1.0, longest / np.maximum(size, longest)),
                               atol=1e-12)
    with pytest.raises(ValueError, match='bytes, must be'):
        markers.decode(payload[:-8])


def test_straight_wires_end_at_the_depth_of_the_scene(scene):
    lines = straight(scene, 0.3)
    position, orientation = resting_pose(scene)
    around = np.concatenate([straight(scene, angle) for angle in np.linspace(0.0, 1.6, 2000)])
    lowest = (position + around[:, 1] @ rotation_of(orientation).T)[:, 2].min()
    assert lowest == pytest.approx(-scene.road.penetration, abs=1e-6)
    np.testing.assert_allclose(np.linalg.norm(lines[:, 1] - lines[:, 0], axis=1),
                               scene.bristle.length)
    assert math.atan2(lines[0, 0, 1], lines[0, 0, 0]) == pytest.approx(0.3)
    assert tip_depth(scene) - position[2] == pytest.approx(scene.road.penetration)


def test_straight_wires_of_rows_are_those_of_the_simulation():
    rows = from_parameters({
        'brush.row_radii': [0.1, 0.12], 'brush.row_angles': [0.4, 0.5], 'brush.start_angle': 0.3,
        'brush.row_lengths': [0.24, 0.22], 'brush.row_counts': [2, 3], 'solver.elements': 1,
        'brush.row_offsets': [0.0, 0.2], 'contact.enabled': False}, 'test')
    np.testing.assert_allclose(straight(rows, 0.3), Simulation(rows).centreline()[:, ::2],
                               atol=1e-12)


def test_the_resting_pose_is_that_of_the_mount(scene):
    driver = Driver(Simulation(scene), paced=False)
    pose = MountPath(scene).follow(driver.simulation, 0)
    position, orientation = resting_pose(scene)
    np.testing.assert_allclose(orientation, pose.orientation, atol=1e-15)
    np.testing.assert_allclose(rotation_of(orientation), pose.rotation, atol=1e-15)
    np.testing.assert_allclose(position[:2], pose.position[:2])


@pytest.mark.parametrize('name', ['cutting_brush', 'tilted_sweep', 'full_brush', 'free_rotation'])
def test_a_scene_takes_all_that_its_sliders_give(root, name):
    scene = load(root / f'config/{name}.yaml')
    ranges = ranges_of(scene)
    assert ('penetration [mm]' in ranges) == scene.contact.enabled
    for label, (low, high, value) in ranges.items():
        topic, part, scale, step = _SLIDERS[label]
        assert low <= value <= high
        assert (high - low) / step > 20.0
        for end in (low, high):
            values = [0.0] * (3 if topic == 'cmd_vel' else 1)
            values[part] = end / scale
            check_command(scene, topic, values)
    corner = [ranges['forward [m/s]'][1], ranges['to the left [m/s]'][1], 0.0]
    check_command(scene, 'cmd_vel', corner)
    with pytest.raises(CommandRefused, match='beyond drive.max_speed'):
        check_command(scene, 'cmd_brush_speed', [1e6])


def test_what_is_refused_has_no_slider():
    """With a torque the speed is a result; a mount that is carried goes where it is told."""
    drive = {'drive.profile': 'constant', 'drive.inertia': 0.05}
    torque = from_parameters({**drive, 'drive.mode': 'torque', 'drive.stall_torque': 8.0}, 'test')
    ranges = ranges_of(torque)
    assert 'brush speed [rad/s]' not in ranges
    assert ranges['drive torque [N m]'] == (-8.0, 8.0, 0.0)
    check_command(torque, 'cmd_drive_torque', [8.0])
    with pytest.raises(CommandRefused, match='speed is a result'):
        check_command(torque, 'cmd_brush_speed', [1.0])
    carried = from_parameters({**drive, 'run.carried': True}, 'test')
    assert list(ranges_of(carried)) == ['brush speed [rad/s]']


def test_trails_are_spread_evenly():
    assert tracked(5).tolist() == [0, 1, 2, 3, 4]
    assert set(np.diff(tracked(104))) == {8}
    assert len(tracked(1000)) == 13


def test_colours_go_from_steel_to_dark_red():
    shade = colours.shade(np.array([0.0, 0.5, 1.0, 9.0]), 1.0).astype(int)
    assert shade[0].tolist() == [96, 125, 150]
    assert shade[2].tolist() == shade[3].tolist() == [150, 10, 40]
    # sRGB to linear light: the ends stay, the middle is darker
    assert colours.of_lines([0, 128, 255]).tolist() == [0, 56, 255]


@pytest.mark.parametrize('given', [
    {'gutter.enabled': True}, {'profile.kind': 'iso8608'},
    {'gutter.enabled': True, 'profile.kind': 'sine'}])
def test_lines_on_the_road_are_on_it_and_stay_there(given):
    """What the page is sent for two places of the mount is the same road."""
    shown = []
    for x, y in ((0.3, 0.02), (0.31, 0.02), (3.13, 0.11)):
        stage = Recorder()
        ground = put_ground(stage, from_parameters(given, 'test'))
        ground.show(x, y, 0.04)
        mesh, lines = stage.made['/road'], stage.made['/road_lines']
        place = np.array((x, y, 0.0)) + mesh.position
        assert mesh.position == lines.position
        assert np.abs(lines.points[..., :2]).max() <= np.abs(mesh.vertices[:, :2]).max() + 1e-6
        nodes = mesh.vertices + place
        assert nodes[:, 0].min() < x - 0.7 < x + 0.7 < nodes[:, 0].max()
        shown.append({tuple(node.round(4)) for node in nodes})
    assert shown[0] == shown[1]
    ground.show(x + 0.3, y, 0.04)
    assert len(stage.made) == 2     # changed in place, not added again


class Recorder:
    """Takes the place of viser's scene, which needs a server: keeps what it is given."""

    def __init__(self):
        self.made = {}

    def add_mesh_simple(self, name, vertices, faces, **_):
        assert faces.max() == len(vertices) - 1
        return self.made.setdefault(name, SimpleNamespace(vertices=vertices))

    def add_line_segments(self, name, points, _, **__):
        return self.made.setdefault(name, SimpleNamespace(points=points))
