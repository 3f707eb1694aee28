"""
What is in each ROS 2 message: snapshots, commands and events to CDR bytes and back, without ROS.

The node publishes the same bytes that the log stores, so both say the same to the last bit.
Layout: little-endian plain CDR (XCDR1), 4 bytes of header, values aligned to their size after it.
"""
from collections.abc import Callable, Mapping, Sequence
import json
import struct
from typing import Any, NamedTuple, TypeAlias

from bristle_ros.simulation import Snapshot
import numpy as np
from numpy.typing import NDArray

from .cdr import CdrReader

# Each after the prefix `run.frame_prefix`.
ROAD_FRAME = 'road'
MOUNT_FRAME = 'brush_mount'
BRUSH_FRAME = 'brush'
JOINT = 'brush_joint'

WRENCH = 'geometry_msgs/msg/WrenchStamped'
POSE = 'geometry_msgs/msg/PoseStamped'
JOINT_STATE = 'sensor_msgs/msg/JointState'
FLOAT = 'std_msgs/msg/Float64'
STRING = 'std_msgs/msg/String'
TWIST = 'geometry_msgs/msg/Twist'
TWIST_STAMPED = 'geometry_msgs/msg/TwistStamped'
ODOMETRY = 'nav_msgs/msg/Odometry'
DIAGNOSTICS = 'diagnostic_msgs/msg/DiagnosticArray'
CLOCK = 'rosgraph_msgs/msg/Clock'
MARKERS = 'visualization_msgs/msg/MarkerArray'
TF = 'tf2_msgs/msg/TFMessage'

EVENTS = '~/events'
MEAN_WRENCH = 'mount_wrench_mean'
TRANSFORMS = '/tf'
DESCRIPTION = 'robot_description'

Encoder: TypeAlias = Callable[[Snapshot, int], bytes]   # snapshot, stamp [ns]
Vector: TypeAlias = Callable[[Snapshot], NDArray[np.float64]]   # (3,) of a snapshot
# level 0 to 3, name, message, hardware_id, key -> value
Status: TypeAlias = tuple[int, str, str, str, Mapping[str, object]]

_HEADER = b'\x00\x01\x00\x00'  # CDR, little-endian


def stamp_ns(total_step: int, integration_time_step: float, origin: int = 0) -> int:
    """
    Return the stamp [ns] of a step counted from the run's start (not from the last reset).

    `origin` [ns] is the wall time of the start where `run.time_origin` is `wall`, else 0.
    """
    return origin + round(total_step * integration_time_step * 1e9)


def total_step(stamp: int, integration_time_step: float, origin: int = 0) -> int:
    """Return the step that `stamp_ns` made the stamp of: exact for steps longer than 2 ns."""
    return round((stamp - origin) * 1e-9 / integration_time_step)


def _string(text: str) -> bytes:
    raw = text.encode() + b'\x00'
    return struct.pack('<I', len(raw)) + raw


def _aligned(raw: bytes, size: int) -> bytes:
    return raw + bytes(-(len(raw) - 4) % size)


def _unpack(packer: struct.Struct, payload: bytes) -> tuple[Any, ...]:
    if len(payload) != packer.size:
        raise ValueError(f'{len(payload)} bytes, must be {packer.size}')
    return packer.unpack(payload)


class _Stamped:
    """Packs messages that are a std_msgs/Header, something constant, and then only float64."""

    def __init__(self, frame: str, n_values: int) -> None:
        head = _aligned(_HEADER + bytes(8) + _string(frame), 8)
        self._head = head[:4]
        self._tail = head[12:]
        self._packer = struct.Struct(f'<4siI{len(self._tail)}s{n_values}d')
        self._values = struct.Struct(f'<{n_values}d')

    def pack(self, stamp: int, *values: float) -> bytes:
        sec, nanosec = divmod(stamp, 1_000_000_000)
        return self._packer.pack(self._head, sec, nanosec, self._tail, *values)

    def unpack(self, payload: bytes) -> tuple[float, ...]:
        """Return the values, whatever the frame_id."""
        try:
            (length,) = struct.unpack_from('<I', payload, 12)
        except struct.error as error:
            raise ValueError(f'message is too short: {error}') from None
        head = len(payload) - self._values.size
        if head != 16 + length + -(12 + length) % 8:
            raise ValueError(f'{len(payload)} bytes do not fit a frame_id of {length}')
        return self._values.unpack_from(payload, head)


def _wrenches(packer: _Stamped, force: Vector, torque: Vector) -> Encoder:
    """Return the encoder of wrenches; force(snapshot) and torque(snapshot) are (3,) arrays."""
    def encode(snapshot: Snapshot, stamp: int) -> bytes:
        return packer.pack(stamp, *force(snapshot).tolist(), *torque(snapshot).tolist())
    return encode


_NO_TORQUE = np.zeros(3)


class _JointState:
    """`name`, then three sequences of one float64, each after its count and padding."""

    def __init__(self) -> None:
        head = _HEADER + bytes(8) + _string('')
        head = _aligned(head, 4) + struct.pack('<I', 1) + _string(JOINT)
        head = _aligned(head, 4) + struct.pack('<I', 1)
        head = _aligned(head, 8)
        self._head, self._tail = head[:4], head[12:]
        self._packer = struct.Struct(f'<4siI{len(self._tail)}sdI4xdI4xd')

    def pack(self, stamp: int, angle: float, speed: float, effort: float) -> bytes:
        sec, nanosec = divmod(stamp, 1_000_000_000)
        return self._packer.pack(self._head, sec, nanosec, self._tail, angle, 1, speed, 1, effort)

    def unpack(self, payload: bytes) -> tuple[float, ...]:
        return _unpack(self._packer, payload)[4::2]


_joint = _JointState()


def _joint_states(snapshot: Snapshot, stamp: int) -> bytes:
    return _joint.pack(stamp, snapshot.theta, snapshot.omega, snapshot.drive_torque)


class Topic(NamedTuple):
    """A published topic: how a snapshot becomes its message, and what its float64 values are."""

    name: str
    type: str  # noqa: A003
    encode: Encoder
    decode: Callable[[bytes], tuple[float, ...]]    # the values that `fields` names
    fields: tuple[str, ...]
    groups: tuple[int, ...]     # lengths of the vectors in it, which share a scale


_XYZ = ('x', 'y', 'z')
_WRENCH_FIELDS = tuple(f'wrench.{part}.{axis}' for part in ('force', 'torque') for axis in _XYZ)
_POSE_FIELDS = (*(f'pose.position.{axis}' for axis in _XYZ),
                *(f'pose.orientation.{axis}' for axis in (*_XYZ, 'w')))


def topics(prefix: str = '') -> tuple[Topic, ...]:
    """Return the published Topics; `prefix` goes before their frames (`run.frame_prefix`)."""
    mount, road = _Stamped(prefix + MOUNT_FRAME, 6), _Stamped(prefix + ROAD_FRAME, 6)
    pose = _Stamped(prefix + MOUNT_FRAME, 7)

    def tip_pose(snapshot: Snapshot, stamp: int) -> bytes:
        return pose.pack(stamp, *snapshot.tip_position_mount[0].tolist(),
                         *snapshot.tip_orientation_mount[0].tolist())

    def wrench(name: str, packer: _Stamped, force: Vector, torque: Vector) -> Topic:
        return Topic(name, WRENCH, _wrenches(packer, force, torque), packer.unpack,
                     _WRENCH_FIELDS, (3, 3))

    return (
        wrench('contact_wrench', mount, lambda snapshot: snapshot.contact_force_mount,
               lambda snapshot: snapshot.contact_torque_mount),
        wrench('tip_wrench', road, lambda snapshot: snapshot.tip_force[0],
               lambda snapshot: _NO_TORQUE),
        wrench('mount_wrench', mount, lambda snapshot: snapshot.brush_force,
               lambda snapshot: snapshot.brush_torque),
        Topic('tip_pose', POSE, tip_pose, pose.unpack, _POSE_FIELDS, (3, 4)),
        Topic('joint_states', JOINT_STATE, _joint_states, _joint.unpack,
              ('position[0]', 'velocity[0]', 'effort[0]'), (1, 1, 1)))


TOPICS = topics()   # for their names, types and values; their bytes are those without a prefix


def _nothing() -> NDArray[np.float64]:
    return np.zeros(6)


def mean_wrench_topic(prefix: str = '', mean_now: Callable[[], NDArray[np.float64]] = _nothing
                      ) -> Topic:
    """Return the Topic of the mean wrench, once a chunk; `mean_now()` is (6,) force, torque."""
    packer = _Stamped(prefix + MOUNT_FRAME, 6)
    return Topic(MEAN_WRENCH, WRENCH, lambda snapshot, stamp: packer.pack(
        stamp, *mean_now().tolist()), packer.unpack, _WRENCH_FIELDS, (3, 3))


def command_types(stamped: bool) -> dict[str, str]:
    """Return topic -> type of the commands; `stamped` is `run.stamped_cmd_vel`."""
    return {'cmd_brush_speed': FLOAT,
            'cmd_vel': TWIST_STAMPED if stamped else TWIST,
            'cmd_penetration': FLOAT, 'cmd_drive_torque': FLOAT, 'cmd_mount': ODOMETRY}


_twist_stamped = _Stamped('', 6)
_NO_COVARIANCE = (0.0,) * 36


def encode_command(type_name: str, values: Sequence[float], stamp: int = 0) -> bytes:
    """
    Return a command's bytes.

    `values` are (value,), (vx, vy, yaw rate) of a twist, or the 13 of an odometry; six for one
    that brakes, which has no orientation.
    """
    if type_name == FLOAT:
        return struct.pack('<4sd', _HEADER, *values)
    if type_name == ODOMETRY:
        head = _HEADER + struct.pack('<iI', *divmod(stamp, 1_000_000_000)) + _string(ROAD_FRAME)
        head = _aligned(_aligned(head, 4) + _string(MOUNT_FRAME), 8)
        pose, twist = ((0.0,) * 7, values) if len(values) == 6 else (values[:7], values[7:])
        return head + struct.pack('<85d', *pose, *_NO_COVARIANCE, *twist, *_NO_COVARIANCE)
    vx, vy, yaw_rate = values
    twist = vx, vy, 0.0, 0.0, 0.0, yaw_rate
    if type_name == TWIST:
        return struct.pack('<4s6d', _HEADER, *twist)
    return _twist_stamped.pack(stamp, *twist)


def decode_command(type_name: str, payload: bytes) -> tuple[float, ...]:
    """Return the values of a command that anybody encoded, with any frame_id."""
    if type_name == FLOAT:
        return CdrReader(payload).float64(1)
    cdr = CdrReader(payload)
    if type_name == ODOMETRY:
        cdr.skip(8)
        cdr.string()
        cdr.string()
        numbers = cdr.float64(49)
        pose, twist = numbers[:7], numbers[43:49]
        return (*pose, *twist) if any(pose[3:]) else twist
    if type_name == TWIST_STAMPED:
        cdr.skip(8)
        cdr.string()
    twist = cdr.float64(6)
    return twist[0], twist[1], twist[5]


def encode_string(text: str) -> bytes:
    """Return a std_msgs/String."""
    return _HEADER + _string(text)


def decode_string(payload: bytes) -> str:
    """Return the text of a std_msgs/String."""
    return CdrReader(payload).string()


def encode_event(event: str, step: int, **details: object) -> bytes:
    """Return an event of `~/events`: a JSON object, its `step` counted from the run's start."""
    return encode_string(json.dumps({'event': event, 'step': step, **details}))


def decode_event(payload: bytes) -> dict[str, Any]:
    """Return the dict of an event, or {} for a text that is none."""
    try:
        event = json.loads(decode_string(payload))
    except ValueError:
        return {}
    return event if isinstance(event, dict) else {}


def encode_clock(stamp: int) -> bytes:
    """Return a rosgraph_msgs/Clock."""
    return struct.pack('<4siI', _HEADER, *divmod(stamp, 1_000_000_000))


def encode_diagnostics(stamp: int, statuses: Sequence[Status]) -> bytes:
    """
    Return a DiagnosticArray.

    `statuses`: (level 0 to 3, name, message, hardware_id, dict of key -> value) each.
    """
    raw = struct.pack('<4siI', _HEADER, *divmod(stamp, 1_000_000_000)) + _string('')
    raw = _aligned(raw, 4) + struct.pack('<I', len(statuses))
    for level, name, message, hardware, values in statuses:
        raw += struct.pack('<B', level)
        for text in (name, message, hardware):
            raw = _aligned(raw, 4) + _string(text)
        raw = _aligned(raw, 4) + struct.pack('<I', len(values))
        for pair in values.items():
            for part in pair:
                raw = _aligned(raw, 4) + _string(str(part))
    return raw


def decode_diagnostics(payload: bytes) -> list[tuple[str, dict[str, str]]]:
    """Return [(name, dict of key -> text)] of a DiagnosticArray."""
    cdr = CdrReader(payload)
    cdr.skip(8)
    cdr.string()
    statuses = []
    for _ in range(cdr.count()):
        cdr.skip(1)     # level
        name, _, _ = (cdr.string() for _ in range(3))
        pairs = [(cdr.string(), cdr.string()) for _ in range(cdr.count())]
        statuses.append((name, dict(pairs)))
    return statuses


def decode_stamp(payload: bytes) -> int:
    """Return the stamp [ns] of the header that a message begins with."""
    return CdrReader(payload).stamp()
