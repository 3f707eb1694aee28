"""What `replay` publishes with: the outputs of a log on their topics, at their times."""
from importlib import import_module
import signal
import time

from bristle_ros.log import Message, Recording
from bristle_ros.messages import encode as messages, SCENE
from bristle_ros.scene import SceneError

_DISCOVERY = 3.5        # [s] that a first subscriber gets to find us; DDS takes 3 s at times,
_SETTLING = 0.5         # [s] and that others then get
_NAP = 0.05             # [s] longest sleep between looks at whether to stop
_SOON = 1_000_000_000   # [ns] in which a log has shown what else it holds beside the outputs
_BESIDE = {messages.TRANSFORMS: messages.TF, messages.DESCRIPTION: messages.STRING,
           SCENE: messages.STRING}
_LATCHED = (messages.DESCRIPTION, SCENE)


def check():
    """Raise ImportError where there is no ROS: before anything is done."""
    import_module('rclpy')


def play(path, rate=1.0, loop=False, ros_arguments=()):
    """
    Publish a log's outputs on their topics at their times; returns how many messages.

    Absolute deadlines on a steady clock, so no delay adds up. Ends on SIGINT and SIGTERM.
    """
    recording = Recording(path)
    stopped = []
    handlers = {number: signal.signal(number, lambda *_: stopped.append(True))
                for number in (signal.SIGINT, signal.SIGTERM)}
    import rclpy
    from rclpy.signals import SignalHandlerOptions
    rclpy.init(args=['--ros-args', *ros_arguments] if ros_arguments else [],
               signal_handler_options=SignalHandlerOptions.NO)
    try:
        player = _Player(rclpy.create_node('brush_replay'), recording, stopped)
        player.wait_for_subscribers()
        player.play(rate)
        while loop and player.published and not stopped:
            player.play(rate)
        player.finish()
        return player.published
    finally:
        rclpy.try_shutdown()
        for number, handler in handlers.items():
            signal.signal(number, handler)


class _Player:
    """The publishers of a log's topics."""

    def __init__(self, node, recording, stopped):
        self.published = 0
        self._recording, self._stopped = recording, stopped
        self._publishers = {}
        outputs = {topic.name: topic.type for topic in messages.TOPICS}
        found, first = set(), None
        for message in self._messages():
            channel = message.channel
            first = message.log_time if first is None else first
            if channel.topic not in self._publishers:
                name = recording.name_of(channel)
                found.add(name)
                known = (outputs | _BESIDE).get(name) == channel.schema
                self._publishers[channel.topic] = (
                    _publisher(node, channel, name) if known else None)
            if found >= {*outputs, *_BESIDE} or (
                    found >= {*outputs} and message.log_time > first + _SOON):
                break
        self._publishers = {topic: one for topic, one in self._publishers.items() if one}
        if not self._publishers:
            raise SceneError('holds no outputs to publish', source=str(recording.path))

    def _messages(self):
        return (record for record in self._recording.records() if isinstance(record, Message))

    def wait_for_subscribers(self):
        """Give those that are there the time to find us: what is sent before is lost to them."""
        found, end = 0, time.monotonic() + _DISCOVERY
        while time.monotonic() < end and not self._stopped:
            now = sum(one.get_subscription_count() for one in self._publishers.values())
            if now > found:
                found, end = now, time.monotonic() + _SETTLING
            time.sleep(_NAP)

    def play(self, rate):
        """Publish everything once."""
        start, first = time.monotonic(), None
        for message in self._messages():
            publisher = self._publishers.get(message.channel.topic)
            if publisher is None:
                continue
            first = message.log_time if first is None else first
            self._sleep_until(start + (message.log_time - first) * 1e-9 / rate)
            if self._stopped:
                return
            publisher.publish(message.data)
            self.published += 1

    def finish(self):
        """Wait until reliable subscribers have all of it, but not for one that hangs."""
        from rclpy.duration import Duration
        for publisher in self._publishers.values():
            publisher.wait_for_all_acked(Duration(seconds=0.0 if self._stopped else 1.0))

    def _sleep_until(self, deadline):
        # Short naps: a signal handler that runs during a sleep does not end it.
        while not self._stopped and (left := deadline - time.monotonic()) > 0.0:
            time.sleep(min(left, _NAP))


def _publisher(node, channel, name):
    """Return a publisher of a log's channel, or None where its type is not installed."""
    from rclpy.qos import DurabilityPolicy, QoSProfile
    package, _, type_name = channel.schema.split('/')
    try:
        type_ = getattr(import_module(f'{package}.msg'), type_name)
    except ImportError:
        node.get_logger().info(f'no {channel.topic}: the package {package} is not installed')
        return None
    profile = QoSProfile(depth=1, durability=DurabilityPolicy.TRANSIENT_LOCAL)
    return node.create_publisher(type_, channel.topic, profile if name in _LATCHED else 100)
