"""What the node publishes: bytes from messages.py, and only what somebody listens to."""
from bristle_ros import messages
from diagnostic_msgs.msg import DiagnosticArray
from geometry_msgs.msg import Point, PoseStamped, WrenchStamped
from rclpy.qos import QoSProfile, ReliabilityPolicy
from rclpy.qos_overriding_options import QoSOverridingOptions
from rosgraph_msgs.msg import Clock
from sensor_msgs.msg import JointState
from visualization_msgs.msg import Marker, MarkerArray

OVERRIDABLE = QoSOverridingOptions.with_default_policies()
_TYPES = {messages.WRENCH: WrenchStamped, messages.POSE: PoseStamped,
          messages.JOINT_STATE: JointState}
_CLOCK_PERIOD = 10_000_000   # [ns] of wall time: 100 Hz, which rclpy subscribers can follow


def reliable():
    """Return a profile for one topic alone: rclpy writes the overrides into what it is given."""
    return QoSProfile(depth=10, reliability=ReliabilityPolicy.RELIABLE)


class Outputs:
    """The node's publishers. `publish` is called by the pacing thread, at each chunk's end."""

    def __init__(self, node, scene, origin):
        self._its = scene.solver.integration_time_step
        self._origin = origin
        self._wire_width = max(scene.bristle.breadth, 1e-3)
        self._topics = [(self._publisher(node, _TYPES[topic.type], topic.name), topic.encode)
                        for topic in messages.TOPICS]
        self._markers = self._publisher(node, MarkerArray, 'bristle_markers')
        self._clock, self._clock_last = None, 0
        if scene.run.publish_clock:
            self._clock = self._publisher(node, Clock, '/clock')
        # Diagnostics tell of an inactive node too.
        self._diagnostics = node.create_publisher(
            DiagnosticArray, '/diagnostics', reliable(), qos_overriding_options=OVERRIDABLE)

    @staticmethod
    def _publisher(node, type_, name):
        return node.create_lifecycle_publisher(
            type_, name, reliable(), qos_overriding_options=OVERRIDABLE)

    def destroy(self, node):
        """Take the publishers out of the graph."""
        for publisher in (*(publisher for publisher, _ in self._topics), self._markers,
                          self._clock, self._diagnostics):
            if publisher is not None:
                node.destroy_publisher(publisher)

    def stamp(self, step):
        """Return the stamp [ns] of a total step."""
        return messages.stamp_ns(step, self._its, self._origin)

    def publish(self, snapshot, centreline, now, *, clock=False):
        """
        Publish the state at a chunk's end; centreline() -> (B, nodes, 3) [m] is called if needed.

        now [ns] is steady wall time; `clock` sends /clock whenever it was last sent, as single
        steps want it.
        """
        stamp = self.stamp(snapshot.step)
        if self._clock is not None and (clock or now - self._clock_last >= _CLOCK_PERIOD):
            self._clock_last = now
            self._clock.publish(messages.encode_clock(stamp))
        for publisher, encode in self._topics:
            if publisher.get_subscription_count():
                publisher.publish(encode(snapshot, stamp))
        if self._markers.get_subscription_count():
            self._markers.publish(_lines(centreline(), stamp, self._wire_width))

    def diagnose(self, step, statuses):
        """Publish /diagnostics; return its bytes for the log."""
        payload = messages.encode_diagnostics(self.stamp(step), statuses)
        self._diagnostics.publish(payload)
        return payload


def _lines(centreline, stamp, width):
    """Return one line strip for each bristle; width [m] is what the line is drawn with."""
    array = MarkerArray()
    for i, nodes in enumerate(centreline.tolist()):
        marker = Marker(ns='bristles', id=i, type=Marker.LINE_STRIP, action=Marker.ADD)
        marker.header.frame_id = messages.MOUNT_FRAME
        marker.header.stamp.sec, marker.header.stamp.nanosec = divmod(stamp, 1_000_000_000)
        marker.pose.orientation.w = 1.0
        marker.scale.x = width
        marker.color.r, marker.color.g, marker.color.b, marker.color.a = 0.2, 0.5, 0.9, 1.0
        marker.points = [Point(x=x, y=y, z=z) for x, y, z in nodes]
        array.markers.append(marker)
    return array
