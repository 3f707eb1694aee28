"""The ROS 2 types of our messages as text and hash, so that a log needs no ROS to be written."""
import re

# Definitions without their comments, as the type hash sees them. ROS 2 Jazzy.
_DEFINITIONS = {
    'builtin_interfaces/Time': 'int32 sec\nuint32 nanosec\n',
    'std_msgs/Header': 'builtin_interfaces/Time stamp\nstring frame_id\n',
    'std_msgs/Float64': 'float64 data\n',
    'std_msgs/String': 'string data\n',
    'geometry_msgs/Vector3': 'float64 x\nfloat64 y\nfloat64 z\n',
    'geometry_msgs/Point': 'float64 x\nfloat64 y\nfloat64 z\n',
    'geometry_msgs/Quaternion': 'float64 x\nfloat64 y\nfloat64 z\nfloat64 w\n',
    'geometry_msgs/Pose':
        'geometry_msgs/Point position\ngeometry_msgs/Quaternion orientation\n',
    'geometry_msgs/PoseStamped': 'std_msgs/Header header\ngeometry_msgs/Pose pose\n',
    'geometry_msgs/Twist': 'geometry_msgs/Vector3 linear\ngeometry_msgs/Vector3 angular\n',
    'geometry_msgs/TwistStamped': 'std_msgs/Header header\ngeometry_msgs/Twist twist\n',
    'geometry_msgs/PoseWithCovariance': 'geometry_msgs/Pose pose\nfloat64[36] covariance\n',
    'geometry_msgs/TwistWithCovariance': 'geometry_msgs/Twist twist\nfloat64[36] covariance\n',
    'nav_msgs/Odometry':
        'std_msgs/Header header\nstring child_frame_id\n'
        'geometry_msgs/PoseWithCovariance pose\ngeometry_msgs/TwistWithCovariance twist\n',
    'geometry_msgs/Wrench': 'geometry_msgs/Vector3 force\ngeometry_msgs/Vector3 torque\n',
    'geometry_msgs/WrenchStamped': 'std_msgs/Header header\ngeometry_msgs/Wrench wrench\n',
    'geometry_msgs/Transform':
        'geometry_msgs/Vector3 translation\ngeometry_msgs/Quaternion rotation\n',
    'geometry_msgs/TransformStamped':
        'std_msgs/Header header\nstring child_frame_id\ngeometry_msgs/Transform transform\n',
    'tf2_msgs/TFMessage': 'geometry_msgs/TransformStamped[] transforms\n',
    'sensor_msgs/JointState':
        'std_msgs/Header header\nstring[] name\nfloat64[] position\nfloat64[] velocity\n'
        'float64[] effort\n',
    'diagnostic_msgs/KeyValue': 'string key\nstring value\n',
    'diagnostic_msgs/DiagnosticStatus':
        'byte OK=0\nbyte WARN=1\nbyte ERROR=2\nbyte STALE=3\nbyte level\nstring name\n'
        'string message\nstring hardware_id\ndiagnostic_msgs/KeyValue[] values\n',
    'diagnostic_msgs/DiagnosticArray':
        'std_msgs/Header header\ndiagnostic_msgs/DiagnosticStatus[] status\n',
    'rosgraph_msgs/Clock': 'builtin_interfaces/Time clock\n',
}

# REP-2016 hashes, from the JSON files that the packages install.
TYPE_HASHES = {
    'std_msgs/msg/Float64':
        'RIHS01_705ba9c3d1a09df43737eb67095534de36fd426c0587779bda2bc51fe790182a',
    'std_msgs/msg/String':
        'RIHS01_df668c740482bbd48fb39d76a70dfd4bd59db1288021743503259e948f6b1a18',
    'geometry_msgs/msg/Twist':
        'RIHS01_9c45bf16fe0983d80e3cfe750d6835843d265a9a6c46bd2e609fcddde6fb8d2a',
    'geometry_msgs/msg/TwistStamped':
        'RIHS01_5f0fcd4f81d5d06ad9b4c4c63e3ea51b82d6ae4d0558f1d475229b1121db6f64',
    'geometry_msgs/msg/WrenchStamped':
        'RIHS01_8dc3deaf06b2ab281f9f9a742a8961c328ca7cec16e3fd6586d3a5c83fa78f77',
    'geometry_msgs/msg/PoseStamped':
        'RIHS01_10f3786d7d40fd2b54367835614bff85d4ad3b5dab62bf8bca0cc232d73b4cd8',
    'nav_msgs/msg/Odometry':
        'RIHS01_3cc97dc7fb7502f8714462c526d369e35b603cfc34d946e3f2eda2766dfec6e0',
    'sensor_msgs/msg/JointState':
        'RIHS01_a13ee3a330e346c9d87b5aa18d24e11690752bd33a0350f11c5882bc9179260e',
    'diagnostic_msgs/msg/DiagnosticArray':
        'RIHS01_5a8a36efb05fb25070fa0fb3810290c0e6cd4862b54a8fb975a1ee8dc55a333e',
    'tf2_msgs/msg/TFMessage':
        'RIHS01_e369d0f05a23ae52508854b66f6aa0437f3449d652e8cbf22d5abe85d020f087',
    'rosgraph_msgs/msg/Clock':
        'RIHS01_692f7a66e93a3c83e71765d033b60349ba68023a8c689a79e48078bcb5c58564',
}


def schema_text(type_name: str) -> str:
    """
    Return the `ros2msg` schema of `pkg/msg/Type`: its definition and those it is made of.

    Layout: https://mcap.dev/spec/registry#ros2msg.
    """
    names = [type_name.replace('/msg/', '/')]
    for name in names:  # grows while it is walked
        for field_type in re.findall(r'^([a-z_0-9]+/\w+)', _DEFINITIONS[name], re.MULTILINE):
            if field_type not in names:
                names.append(field_type)
    head, *parts = names
    rule = '=' * 80
    return _DEFINITIONS[head] + ''.join(
        f'{rule}\nMSG: {name}\n{_DEFINITIONS[name]}' for name in parts)
