"""Our bytes against those of two other encoders: rosbags' typestore and rclpy."""
import importlib
import json
from pathlib import Path
import sys

from bristle_ros.messages import definitions as message_types, encode as messages
from examples import random_snapshot
from hypothesis import given, settings, strategies as st
import numpy as np
import pytest
from rclpy.serialization import deserialize_message, serialize_message
from rosbags.typesys import get_typestore, Stores

STORE = get_typestore(Stores.ROS2_JAZZY)


def ros_class(type_name):
    package, _, name = type_name.split('/')
    return getattr(importlib.import_module(f'{package}.msg'), name)


def set_header(message, stamp, frame):
    message.header.stamp.sec, message.header.stamp.nanosec = divmod(stamp, 10**9)
    message.header.frame_id = frame


def set_vector(vector, values):
    for axis, value in zip('xyzw', values):
        setattr(vector, axis, float(value))


def assert_same_bytes(payload, message, type_name):
    """
    Compare with both encoders.

    rclpy leaves what memory held in the alignment gaps, so a byte may differ from its bytes where
    it means nothing: where changing it changes nothing of what is read.
    """
    read = STORE.deserialize_cdr(payload, type_name)
    assert bytes(STORE.serialize_cdr(read, type_name)) == payload
    theirs = serialize_message(message)
    assert len(theirs) == len(payload)
    for at, (our, their) in enumerate(zip(payload, theirs)):
        if our != their:
            other = payload[:at] + bytes([their]) + payload[at + 1:]
            read = STORE.deserialize_cdr(other, type_name)
            assert bytes(STORE.serialize_cdr(read, type_name)) == payload, f'byte {at}'


def by_hand(topic, snapshot, stamp):
    """Return the same message filled field by field with ROS's own class."""
    message = ros_class(topic.type)()
    if topic.type == messages.WRENCH:
        frame, force, torque = {
            'contact_wrench':
                ('brush_mount', snapshot.contact_force_mount, snapshot.contact_torque_mount),
            'tip_wrench': ('road', snapshot.tip_force[0], (0.0, 0.0, 0.0)),
            'mount_wrench': ('brush_mount', snapshot.brush_force, snapshot.brush_torque),
        }[topic.name]
        set_header(message, stamp, frame)
        set_vector(message.wrench.force, force)
        set_vector(message.wrench.torque, torque)
    elif topic.type == messages.POSE:
        set_header(message, stamp, 'brush_mount')
        set_vector(message.pose.position, snapshot.tip_position_mount[0])
        set_vector(message.pose.orientation, snapshot.tip_orientation_mount[0])
    else:
        set_header(message, stamp, '')
        message.name = ['brush_joint']
        message.position = [snapshot.theta]
        message.velocity = [snapshot.omega]
        message.effort = [snapshot.drive_torque]
    return message


@pytest.mark.parametrize('topic', messages.TOPICS, ids=lambda topic: topic.name)
@pytest.mark.parametrize('stamp', [0, 250_000_000, 1_790_000_000_123_456_789])
def test_snapshot_bytes_are_those_of_rclpy_and_rosbags(topic, stamp):
    snapshot = random_snapshot(stamp % 97)
    payload = topic.encode(snapshot, stamp)
    assert_same_bytes(payload, by_hand(topic, snapshot, stamp), topic.type)
    decoded = STORE.deserialize_cdr(payload, topic.type)
    assert decoded.header.stamp.sec * 10**9 + decoded.header.stamp.nanosec == stamp


@pytest.mark.parametrize('topic', messages.TOPICS, ids=lambda topic: topic.name)
def test_decoded_values_are_what_their_field_names_say(topic):
    snapshot = random_snapshot(3)
    values = topic.decode(topic.encode(snapshot, 5))
    message = by_hand(topic, snapshot, 5)
    assert len(values) == len(topic.fields) == sum(topic.groups)
    for field, value in zip(topic.fields, values):
        assert eval(f'message.{field}', {'message': message}) == value


def test_not_a_number_and_negative_zero_keep_their_bits():
    snapshot = random_snapshot(0)._replace(
        brush_force=np.array([np.nan, -0.0, np.inf]), brush_torque=np.zeros(3))
    topic = next(topic for topic in messages.TOPICS if topic.name == 'mount_wrench')
    values = np.array(topic.decode(topic.encode(snapshot, 0))[:3])
    assert values.tobytes() == snapshot.brush_force.tobytes()


FINITE = st.floats(allow_nan=False)


@given(value=FINITE, twist=st.tuples(FINITE, FINITE, FINITE),
       stamp=st.integers(0, 2**31 * 10**9 - 1))
@settings(max_examples=50, deadline=None)
def test_commands_come_back_as_they_went(value, twist, stamp):
    payload = messages.encode_command(messages.FLOAT, (value,))
    assert_same_bytes(payload, ros_class(messages.FLOAT)(data=value), messages.FLOAT)
    assert messages.decode_command(messages.FLOAT, payload) == (value,)
    for type_name in (messages.TWIST, messages.TWIST_STAMPED):
        payload = messages.encode_command(type_name, twist, stamp)
        message = deserialize_message(payload, ros_class(type_name))
        assert_same_bytes(payload, message, type_name)
        inner = message.twist if type_name == messages.TWIST_STAMPED else message
        assert (inner.linear.x, inner.linear.y, inner.angular.z) == twist
        assert messages.decode_command(type_name, payload) == twist


@given(frame=st.text(
    st.characters(blacklist_characters='\0', blacklist_categories=['Cs']), max_size=9))
@settings(max_examples=30, deadline=None)
def test_a_stamped_command_with_any_frame_id_is_read(frame):
    message = ros_class(messages.TWIST_STAMPED)()
    set_header(message, 12, frame)
    message.twist.linear.x, message.twist.angular.z = 1.5, -0.25
    values = messages.decode_command(messages.TWIST_STAMPED, serialize_message(message))
    assert values == (1.5, 0.0, -0.25)


@given(payload=st.binary(max_size=80))
@settings(max_examples=200, deadline=None)
def test_garbage_is_a_value_error_at_worst(payload):
    for decode in (
            lambda: messages.decode_command(messages.TWIST_STAMPED, payload),
            lambda: messages.decode_command(messages.FLOAT, b'\x00\x01\x00\x00' + payload),
            lambda: messages.decode_string(b'\x00\x01\x00\x00' + payload)):
        try:
            decode()
        except ValueError:
            continue
    assert isinstance(messages.decode_event(b'\x00\x01\x00\x00' + payload), dict)


def test_events_clock_and_diagnostics_are_those_of_rclpy():
    payload = messages.encode_event('reset', 700, reason='asked "so"')
    text = deserialize_message(payload, ros_class(messages.STRING)).data
    assert json.loads(text) == {'event': 'reset', 'step': 700, 'reason': 'asked "so"'}
    assert_same_bytes(payload, ros_class(messages.STRING)(data=text), messages.STRING)
    assert messages.decode_event(payload) == json.loads(text)

    clock = ros_class(messages.CLOCK)()
    clock.clock.sec, clock.clock.nanosec = 3, 141
    assert_same_bytes(messages.encode_clock(3_000_000_141), clock, messages.CLOCK)

    array = ros_class(messages.DIAGNOSTICS)()
    set_header(array, 8, '')
    status_class, pair_class = (ros_class(f'diagnostic_msgs/msg/{name}')
                                for name in ('DiagnosticStatus', 'KeyValue'))
    statuses = [(1, 'brush_node: pacing', 'late', '', {'late chunks': '3', 'factor': '0.5'}),
                (0, 'brush_node: log', 'well', 'disk', {})]
    for level, name, text, hardware, values in statuses:
        array.status.append(status_class(
            level=bytes([level]), name=name, message=text, hardware_id=hardware,
            values=[pair_class(key=key, value=value) for key, value in values.items()]))
    payload = messages.encode_diagnostics(8, statuses)
    assert_same_bytes(payload, array, messages.DIAGNOSTICS)


@pytest.mark.parametrize('type_name', message_types.TYPE_HASHES)
def test_schemas_and_hashes_are_those_of_ros(type_name):
    text = message_types.schema_text(type_name)
    expected, _ = STORE.generate_msgdef(type_name, ros_version=2)
    rule = '=' * 80 + '\n'
    ours, theirs = text.split(rule), expected.split(rule)
    assert ours[0] == theirs[0]
    assert sorted(ours[1:]) == sorted(theirs[1:])
    assert message_types.TYPE_HASHES[type_name] == STORE.hash_rihs01(type_name)
    if type_name == messages.TF:    # tf2_msgs is not on PyPI
        return
    package, _, name = type_name.split('/')
    installed = Path(sys.prefix) / 'share' / package / 'msg' / f'{name}.json'
    hashes = {entry['type_name']: entry['hash_string']
              for entry in json.loads(installed.read_text())['type_hashes']}
    assert message_types.TYPE_HASHES[type_name] == hashes[type_name]


def test_every_topic_has_a_type_that_logs_know():
    types = {topic.type for topic in messages.TOPICS}
    for stamped in (True, False):
        types |= set(messages.command_types(stamped).values())
    types |= {messages.STRING, messages.DIAGNOSTICS, messages.CLOCK, messages.TF}
    assert types == set(message_types.TYPE_HASHES)


@given(step=st.integers(0, 10**10), exponent=st.floats(-7, -2), origin=st.sampled_from(
    [0, 1_790_000_000_123_456_789]))
@settings(max_examples=200, deadline=None)
def test_steps_come_back_from_their_stamps(step, exponent, origin):
    its = 10.0 ** exponent
    stamp = messages.stamp_ns(step, its, origin)
    assert messages.total_step(stamp, its, origin) == step
