"""The topic `~/events`: what happened to the run and at which step, for recorders and others."""
from bristle_ros.messages import encode as messages
from rclpy.qos import DurabilityPolicy, QoSProfile, ReliabilityPolicy
from std_msgs.msg import String

_KEPT = 1000    # events for those who come late


class Events:
    """
    Publishes JSON: `event`, `step` (since the run's start), `number` (from 0, without gaps).

    With `topic` and `values` for commands as they took effect, which a recorder cannot see.
    """

    def __init__(self, node):
        self._publisher = node.create_publisher(String, messages.EVENTS, QoSProfile(
            depth=_KEPT, reliability=ReliabilityPolicy.RELIABLE,
            durability=DurabilityPolicy.TRANSIENT_LOCAL))
        self._number = 0
        self.tell('start', 0)

    def tell(self, kind, step, **details):
        """Publish one event."""
        self._publisher.publish(
            messages.encode_event(kind, step, number=self._number, **details))
        self._number += 1

    def tell_all(self, chunk):
        """Publish the events of a chunk and its failure."""
        for step, kind, topic, values in chunk.events:
            if topic:
                self.tell(kind, step, topic=topic, values=list(values))
            elif kind == 'load':
                self.tell(kind, step, error_tolerance=values[0])
            else:
                self.tell(kind, step)
        if chunk.failure is not None:
            self.tell('failure', chunk.end, reason=str(chunk.failure))

    def destroy(self, node):
        """Take it out of the graph."""
        node.destroy_publisher(self._publisher)
