"""What the node publishes: bytes from `messages`, and only what somebody listens to."""
from bristle_ros.log import head_of
from bristle_ros.messages import (encode as messages, encode_transforms, SCENE,
                                  view as messages_view)
from bristle_ros.scene import follows_mount
from bristle_ros.simulation import wire_contacts
from diagnostic_msgs.msg import DiagnosticArray
from geometry_msgs.msg import PoseStamped, WrenchStamped
from rclpy.qos import DurabilityPolicy, QoSProfile, ReliabilityPolicy
from rclpy.qos_overriding_options import QoSOverridingOptions
from rosgraph_msgs.msg import Clock
from sensor_msgs.msg import JointState
from std_msgs.msg import String
from visualization_msgs.msg import MarkerArray

OVERRIDABLE = QoSOverridingOptions.with_default_policies()
_TYPES = {messages.WRENCH: WrenchStamped, messages.POSE: PoseStamped,
          messages.JOINT_STATE: JointState}
_CLOCK_PERIOD = 10_000_000   # [ns] of wall time: 100 Hz, which rclpy subscribers can follow


def reliable(depth=10):
    """
    Return a profile for one topic alone: rclpy writes the overrides into what it is given.

    Reliable publishers serve best-effort subscribers too; the reverse does not hold.
    """
    return QoSProfile(depth=depth, reliability=ReliabilityPolicy.RELIABLE)


def latched():
    """Return a profile whose last message also those get who come later."""
    return QoSProfile(depth=1, reliability=ReliabilityPolicy.RELIABLE,
                      durability=DurabilityPolicy.TRANSIENT_LOCAL)


class Outputs:
    """The node's publishers. `publish` is called by the pacing thread, at each chunk's end."""

    def __init__(self, node, scene, origin):
        self._its = scene.solver.integration_time_step
        self.origin = origin    # [ns] of simulation time 0 in stamps; a followed clock moves it
        self._frame_prefix, self._transforms = scene.run.frame_prefix, scene.run.publish_tf
        self._topics = [(self._publisher(node, _TYPES[topic.type], topic.name), topic.encode)
                        for topic in messages.topics(scene.run.frame_prefix)]
        self._markers = self._publisher(node, MarkerArray, 'bristle_markers', depth=1)
        self._marker_rate, self._markers_due = scene.run.marker_rate, 0
        self._layout = None     # of the markers, made when somebody subscribes
        self._scene = scene
        self._tf = None
        if self._transforms != 'none':
            self._tf = self._transform_publisher(node)
        self._mean = None
        if follows_mount(scene):
            self._mean = self._publisher(node, WrenchStamped, messages.MEAN_WRENCH)
        self._clock, self._clock_due = None, 0
        if scene.run.publish_clock:
            self._clock = self._publisher(node, Clock, '/clock')
        # Diagnostics tell of an inactive node too.
        self._diagnostics = node.create_publisher(
            DiagnosticArray, '/diagnostics', reliable(), qos_overriding_options=OVERRIDABLE)
        # With it a recorder's bag can be used as a log can.
        self._told_scene = node.create_publisher(String, SCENE, latched())
        self._told_scene.publish(head_of(scene, origin, node.resolve_topic_name).message)

    @staticmethod
    def _publisher(node, type_, name, depth=10):
        return node.create_lifecycle_publisher(
            type_, name, reliable(depth), qos_overriding_options=OVERRIDABLE)

    def _transform_publisher(self, node):
        try:
            from tf2_msgs.msg import TFMessage
        except ImportError:
            node.get_logger().info('no /tf: the package tf2_msgs is not installed')
            return None
        return self._publisher(node, TFMessage, '/tf')

    def destroy(self, node):
        """Take the publishers out of the graph."""
        for publisher in (*(publisher for publisher, _ in self._topics), self._markers,
                          self._tf, self._mean, self._clock, self._diagnostics,
                          self._told_scene):
            if publisher is not None:
                node.destroy_lifecycle_publisher(publisher)  # else the node would keep it

    def stamp(self, step):
        """Return the stamp [ns] of a total step."""
        return messages.stamp_ns(step, self._its, self.origin)

    def publish(self, snapshot, simulation, now, mount, *, clock=False, wrench=None):
        """
        Publish the state at a chunk's end, once for each chunk.

        simulation : Simulation    in that state; what only viewers want is asked of it when they
                                   are there
        mount : Pose               of the mount over the road in that state
        wrench : (6,)              mean over the chunk, where the mount may be carried
        now [ns] is steady wall time; `clock` sends /clock and markers whenever they were last
        sent, as single steps want it.
        """
        stamp = self.stamp(snapshot.step)
        if clock or now >= self._clock_due:
            self._clock_due = max(self._clock_due + _CLOCK_PERIOD, now)
            self.tell_time(snapshot.step)
        for publisher, encode in self._topics:
            if publisher.get_subscription_count():
                publisher.publish(encode(snapshot, stamp))
        if wrench is not None and self._mean is not None:
            topic = messages.mean_wrench_topic(self._frame_prefix, lambda: wrench)
            self._mean.publish(topic.encode(snapshot, stamp))
        # Transforms first: a viewer can place a marker when it has them.
        if self._tf is not None and self._tf.get_subscription_count():
            self._tf.publish(encode_transforms(
                stamp, self._frame_prefix, snapshot, mount, self._transforms))
        if self._marker_rate and (clock or now >= self._markers_due) and (
                self._markers.get_subscription_count()):
            period = 1e9 / self._marker_rate
            in_turn = self._markers_due + period
            self._markers_due = in_turn if in_turn > now else now + period
            self._layout = self._layout or messages_view.Markers(self._scene)
            line = simulation.centreline()
            self._markers.publish(self._layout.encode(
                stamp, snapshot, line, mount, wire_contacts(simulation, line)))

    def tell_time(self, step):
        """Publish /clock, if this node is its master."""
        if self._clock is not None:
            self._clock.publish(messages.encode_clock(self.stamp(step)))

    def diagnose(self, step, statuses):
        """Publish /diagnostics; return its bytes for the log."""
        payload = messages.encode_diagnostics(self.stamp(step), statuses)
        self._diagnostics.publish(payload)
        return payload
