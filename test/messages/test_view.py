"""What viewers draw: bytes against two other encoders, geometry against the simulation."""
from bristle_ros.messages import (encode as messages, encode_transforms, transforms_topic,
                                  view as messages_view)
from bristle_ros.physics.contact.tip import GAP
from bristle_ros.scene.error import SceneError
from bristle_ros.scene.scene import from_parameters
from bristle_ros.simulation import wire_contacts
from bristle_ros.simulation.mount_path import MountPath, Pose
from bristle_ros.simulation.simulation import Simulation
from examples import random_snapshot
import numpy as np
import pytest
from rclpy.serialization import deserialize_message, serialize_message
from rosbags.typesys import get_typestore, Stores
from visualization_msgs.msg import Marker, MarkerArray

STORE = get_typestore(Stores.ROS2_JAZZY)
STAMP = 1_790_000_000_123_456_789
QUARTER = np.array([[0.0, -1.0, 0.0], [1.0, 0.0, 0.0], [0.0, 0.0, 1.0]])   # a turn by 90 degrees
POSE = Pose(np.array([1.0, 2.0, 0.3]), QUARTER, (0.0, 0.0, 0.5 ** 0.5, 0.5 ** 0.5))


def scene_of(**more):
    return from_parameters({'brush.bristle_count': 3, 'solver.elements': 2, **more}, 'test')


def points(marker):
    return np.array([(point.x, point.y, point.z) for point in marker.points])


@pytest.mark.parametrize('prefix', ['', 'left/', 'längst'])
@pytest.mark.parametrize('road', [True, False])
@pytest.mark.parametrize('profile', ['none', 'sine'])
def test_marker_bytes_are_those_of_rosbags_and_rclpy(prefix, road, profile):
    scene = scene_of(**{'run.frame_prefix': prefix, 'contact.enabled': road,
                        'profile.kind': profile})
    payload = messages_view.Markers(scene).encode(
        STAMP, random_snapshot(1, 3), np.random.default_rng(2).normal(size=(3, 5, 3)), POSE)
    read = STORE.deserialize_cdr(payload, messages.MARKERS)
    assert bytes(STORE.serialize_cdr(read, messages.MARKERS)) == payload
    array = deserialize_message(payload, MarkerArray)
    assert len(serialize_message(array)) == len(payload)
    assert len(array.markers) == (5 if road else 1)
    for marker in array.markers:
        assert marker.header.stamp.sec * 10**9 + marker.header.stamp.nanosec == STAMP
        frame = 'road' if marker.ns == 'road' else 'brush_mount'
        assert marker.header.frame_id == prefix + frame
        assert marker.scale.x > 0.0
        assert marker.color.a > 0.0
        assert marker.pose.orientation.w == 1.0


def test_what_the_markers_show():
    snapshot = random_snapshot(3, 3)
    forces = np.array([[0.0, 0.0, 0.2], [0.0, 0.0, 0.0], [3.0, 0.0, 400.0]])
    snapshot = snapshot._replace(tip_force=forces)
    line = np.random.default_rng(4).normal(size=(3, 5, 3))
    scene = scene_of()
    layout = messages_view.Markers(scene)
    for snap in (random_snapshot(5, 3), snapshot):      # the second shows nothing of the first
        payload = layout.encode(STAMP, snap, line, POSE)
    bristles, road, *arrows = deserialize_message(payload, MarkerArray).markers
    assert bristles.type == Marker.LINE_LIST
    drawn = points(bristles).reshape(3, 4, 2, 3)
    assert (drawn[:, :, 0] == line[:, :-1]).all()
    assert (drawn[:, :, 1] == line[:, 1:]).all()

    assert road.type == Marker.CUBE
    assert (road.pose.position.x, road.pose.position.y) == (1.0, 2.0)
    assert road.pose.position.z + 0.5 * road.scale.z == pytest.approx(0.0, abs=1e-15)
    diameter = 2.0 * (0.1125 + 0.24 * np.sin(scene.brush.mount_angle))
    assert road.scale.x == road.scale.y == pytest.approx(2.0 * diameter)
    assert 0.0 < road.color.a < 1.0

    assert [arrow.type for arrow in arrows] == [Marker.ARROW] * 3
    assert [arrow.action for arrow in arrows] == [Marker.ADD, Marker.DELETE, Marker.ADD]
    tips = snapshot.tip_position_mount
    # Up stays up in a mount that is only turned about z; forward is to its right.
    np.testing.assert_allclose(points(arrows[0]),
                               [tips[0], tips[0] + [0, 0, 0.2 * messages_view.FORCE_SCALE]])
    start, end = points(arrows[2])
    assert np.linalg.norm(end - start) == pytest.approx(0.24)     # an impact, cut to a bristle
    np.testing.assert_allclose((end - start) / 0.24 * np.linalg.norm(forces[2]), [0, -3, 400])


def test_an_arrow_for_each_contact_beside_the_tips():
    """Where a wire lies: on the road, all of its force; a layout keeps as many as there were."""
    scene = scene_of(**{
        'solver.elements': 12, 'brush.bristle_count': 3, 'road.penetration': 0.16,
        'road.approach_time': 0.02, 'damping.stiffness': 1e-3})
    simulation, path, layout = Simulation(scene), MountPath(scene), messages_view.Markers(scene)
    counts, payloads = [], []
    for _ in range(12):
        simulation.advance(50)
        snapshot, pose = simulation.snapshot(), path.follow(simulation, 0)
        line = simulation.centreline()
        contacts = wire_contacts(simulation, line)
        counts.append(len(contacts.bristle))
        total = np.zeros((3, 3))
        np.add.at(total, contacts.bristle, contacts.force)
        np.testing.assert_allclose(total + snapshot.tip_force, snapshot.contact_force, atol=1e-12)
        heights = pose.position[2] + contacts.place @ pose.rotation[2]
        assert np.abs(heights).max(initial=0.0) < 5e-4      # the spring gives by N / Kn
        payloads.append(layout.encode(STAMP, snapshot, line, pose, contacts))
        arrows = [marker for marker in deserialize_message(payloads[-1], MarkerArray).markers
                  if marker.ns == 'wire_force']
        assert len(arrows) == max(counts)
        assert [arrow.action for arrow in arrows] == [Marker.ADD] * counts[-1] + [
            Marker.DELETE] * (max(counts) - counts[-1])
        for arrow, place, force in zip(arrows, contacts.place, contacts.force @ pose.rotation):
            start, end = points(arrow)
            np.testing.assert_array_equal(start, place)
            size = min(0.24, messages_view.FORCE_SCALE * np.linalg.norm(force))
            np.testing.assert_allclose(end - start, size * force / np.linalg.norm(force),
                                       atol=1e-15)
    assert counts[0] == 0
    assert max(counts) > 3
    reader = messages_view.Markers(scene)       # reads what has many, and then few of them
    for count, payload in zip(reversed(counts), reversed(payloads)):
        assert len(reader.decode(payload)[3][0]) == count
    with pytest.raises(ValueError, match='bytes, must be'):
        reader.decode(payloads[-1][:-60])


def test_markers_show_the_surface_where_the_tips_touch_it():
    """In the frame `road`, while the base moves along, a kerb approaches and the brush turns."""
    scene = scene_of(**{
        'gutter.enabled': True, 'gutter.kerb_distance': 0.27, 'gutter.approach': 0.1,
        'profile.kind': 'file',
        'profile.file': 'data:-1,-0.01;0.2,-0.012;0.4,-0.004;0.6,-0.012;2,-0.01',
        'road.approach_time': 0.1, 'road.penetration': 0.04,
        'sweeper.velocity': [1.5, 0.0], 'sweeper.mount_position': [0.3, 0.1],
        'damping.stiffness': 1e-6, 'solver.integration_time_step': 1e-3, 'brush.bristle_count': 8})
    # with the kernels of the campaign's sum of kerb and profile
    simulation = Simulation(scene, energies=True)
    path, layout = MountPath(scene), messages_view.Markers(scene)
    simulation.command('cmd_vel', (1.5, 0.0, 0.2))
    kerbs, touched, meshes = set(), 0, set()
    for step in range(1, 31):
        simulation.advance(10)
        snapshot, pose = simulation.snapshot(), path.follow(simulation, 0)
        payload = layout.encode(STAMP, snapshot, simulation.centreline(), pose)
        array = deserialize_message(payload, MarkerArray)
        assert layout.decode(payload)[2] == pose.kerb == simulation.kerb_offset()
        road = next(marker for marker in array.markers if marker.ns == 'road')
        assert (road.type, road.header.frame_id) == (Marker.TRIANGLE_LIST, 'road')
        place = road.pose.position
        corners = points(road) + (place.x, place.y, place.z)
        kerbs.add(place.y)
        meshes.add(corners[0, 0])
        tips = pose.position + snapshot.tip_position_road
        for tip in tips[np.abs(snapshot.tip_force).sum(axis=1) > 0.0]:
            touched += 1
            nearest = distance_to(corners.reshape(-1, 3, 3), tip)
            assert nearest < 5e-4, f'{step}: {tip}'     # chords between rows 50 mm apart
    assert touched > 20
    assert len(kerbs) > 5
    assert 1 < len(meshes) < 6      # not one for each message


def distance_to(triangles, point):
    """Return how far a point is from the plane of the triangle above or below it."""
    a, b, c = triangles.transpose(1, 0, 2)
    normal = np.cross(b - a, c - a)
    inside = np.full(len(a), True)
    for start, end in ((a, b), (b, c), (c, a)):
        edge, way = (end - start)[:, :2], point[:2] - start[:, :2]
        inside &= edge[:, 0] * way[:, 1] - edge[:, 1] * way[:, 0] >= -1e-12
    assert inside.any()
    normal /= np.linalg.norm(normal, axis=1, keepdims=True)
    return np.abs(np.einsum('ij,ij->i', normal, point - a))[inside].min()


@pytest.mark.parametrize(('mode', 'links'), [
    ('all', [('road', 'brush_mount'), ('brush_mount', 'brush')]),
    ('mount', [('road', 'brush_mount')])])
@pytest.mark.parametrize('prefix', ['', 'left/'])
def test_transform_bytes_are_those_of_rosbags(mode, links, prefix):
    snapshot = random_snapshot(6)
    payload = encode_transforms(STAMP, prefix, snapshot, POSE, mode)
    read = STORE.deserialize_cdr(payload, messages.TF)
    assert bytes(STORE.serialize_cdr(read, messages.TF)) == payload
    assert [(one.header.frame_id, one.child_frame_id) for one in read.transforms] == [
        (prefix + parent, prefix + child) for parent, child in links]
    for one in read.transforms:
        assert one.header.stamp.sec * 10**9 + one.header.stamp.nanosec == STAMP
    moved = read.transforms[0].transform
    assert (moved.translation.x, moved.translation.y, moved.translation.z) == (1.0, 2.0, 0.3)
    if mode == 'all':
        turn = read.transforms[1].transform.rotation
        assert 2.0 * np.arctan2(turn.z, turn.w) == pytest.approx(snapshot.theta)


def test_logged_transforms_come_back_and_mangled_ones_are_refused():
    topic = transforms_topic('left/', lambda: POSE)
    payload = topic.encode(random_snapshot(6), STAMP)
    message = STORE.deserialize_cdr(payload, messages.TF)
    values = topic.decode(payload)
    assert len(values) == len(topic.fields) == sum(topic.groups)
    for field, value in zip(topic.fields, values):
        assert eval(f'message.{field}', {'message': message}) == value
    for length in range(4, len(payload) - 4):
        with pytest.raises(ValueError):     # noqa: PT011
            topic.decode(payload[:length] + b'\xff' * 4)


def rotated(quaternion, vectors):
    """Return the quaternion as a matrix, from its definition: no other formula of ours."""
    x, y, z, w = quaternion
    axis = np.array([x, y, z])
    return (vectors + 2.0 * np.cross(axis, np.cross(axis, vectors) + w * vectors))


def test_the_mount_is_where_the_simulation_has_it():
    """Tip positions in both axes come from the compiled code, and so do the gaps to the road."""
    scene = scene_of(**{
        'road.attack_angle': 0.3, 'road.tilt_azimuth': 0.7, 'road.approach_time': 0.01,
        'sweeper.velocity': [1.0, 0.5], 'sweeper.mount_position': [0.8, -0.6],
        'solver.integration_time_step': 5e-4, 'solver.elements': 3})
    simulation, path = Simulation(scene), MountPath(scene)
    simulation.command('cmd_vel', (1.5, -0.2, 0.8))
    way, before = np.zeros(2), None
    for step in range(1, 601):
        if step == 300:
            simulation.command('cmd_penetration', (0.02,))
        simulation.advance(1)
        snapshot = simulation.snapshot()
        _, heading, *velocity = simulation.sweeper_motion()
        c, s = np.cos(heading), np.sin(heading)
        velocity = np.array([[c, -s], [s, c]]) @ velocity
        way += 5e-4 * (velocity if before is None else 0.5 * (velocity + before))
        before = velocity
        if step % 10 == 0:
            pose = path.follow(simulation, 0)
            tips = snapshot.tip_position_mount
            np.testing.assert_allclose(tips @ pose.rotation.T, snapshot.tip_position_road,
                                       atol=1e-13)
            np.testing.assert_allclose(rotated(pose.orientation, tips),
                                       snapshot.tip_position_road, atol=1e-13)
            np.testing.assert_allclose(snapshot.tip_position_road[:, 2] + pose.position[2],
                                       simulation.state.tip[:, GAP], atol=1e-12)
    assert heading > 0.05
    base = pose.position[:2] - np.array([[c, -s], [s, c]]) @ (0.8, -0.6)
    np.testing.assert_allclose(base, way, atol=1e-3 * np.hypot(*way))
    simulation.reset()
    simulation.advance(10)
    pose = path.follow(simulation, 1)
    np.testing.assert_allclose(pose.position[:2], [0.8 + 0.005, -0.6 + 0.0025], atol=1e-9)


def test_a_prefix_goes_before_every_frame_and_changes_no_value():
    snapshot = random_snapshot(7)
    for bare, topic in zip(messages.topics(), messages.topics('left/')):
        payload = topic.encode(snapshot, STAMP)
        read = STORE.deserialize_cdr(payload, topic.type)
        assert bytes(STORE.serialize_cdr(read, topic.type)) == payload
        other = STORE.deserialize_cdr(bare.encode(snapshot, STAMP), bare.type)
        prefix = 'left/' if other.header.frame_id else ''
        assert read.header.frame_id == prefix + other.header.frame_id
        assert bare.decode(payload) == topic.decode(payload) == bare.decode(
            bare.encode(snapshot, STAMP))
    with pytest.raises(ValueError, match='do not fit'):
        messages.topics()[0].decode(payload[:-8])


def test_a_prefix_that_tf2_would_refuse():
    with pytest.raises(SceneError, match=r'run\.frame_prefix = "/left": tf2 knows no frames'):
        scene_of(**{'run.frame_prefix': '/left'})


def test_diagnostics_come_back_and_mangled_ones_are_refused():
    statuses = [(1, 'left/brush_node: simulation', 'late', 'brush', {'late chunks': '3', 'a': ''}),
                (0, 'log', '', '', {})]
    payload = messages.encode_diagnostics(STAMP, statuses)
    assert messages.decode_diagnostics(payload) == [(name, values)
                                                    for _, name, _, _, values in statuses]
    for length in range(4, len(payload) - 4):
        with pytest.raises(ValueError):     # noqa: PT011
            messages.decode_diagnostics(payload[:length] + b'\xff' * 4)
