"""A node that watches a brush_node and commands it, for `view`: bytes in, bytes out."""
from collections import deque
import threading
import time

from bristle_ros.messages import decode_scene, encode as messages, SCENE
from diagnostic_msgs.msg import DiagnosticArray
from geometry_msgs.msg import Twist, TwistStamped, WrenchStamped
from rcl_interfaces.msg import Parameter, ParameterType, ParameterValue
from rcl_interfaces.srv import SetParameters
import rclpy
from rclpy.executors import ExternalShutdownException, SingleThreadedExecutor
from rclpy.qos import DurabilityPolicy, QoSProfile
from rclpy.signals import SignalHandlerOptions
from sensor_msgs.msg import JointState
from std_msgs.msg import Float64, String
from std_srvs.srv import SetBool, Trigger
from visualization_msgs.msg import MarkerArray

KEPT = 4000     # messages of a topic that whoever asks may miss
_COMMANDS = {messages.FLOAT: Float64, messages.TWIST: Twist, messages.TWIST_STAMPED: TwistStamped}


class Watch:
    """
    What a node has published since it was last asked; a thread of its own listens.

    name : fully qualified, `/left/brush_node`. `scene` is what the message `~/scene` says, or {};
    it is another one when the node has been started anew.
    """

    def __init__(self, name):
        """Begin to listen; whether the node is there shows later."""
        self.name = '/' + name.lstrip('/')
        self.scene = {}
        self.heard = 0.0            # [s] on the steady clock: when it last said something
        self.answer = ''            # why a service did not do what was asked
        self._context = rclpy.Context()
        rclpy.init(args=[], context=self._context, signal_handler_options=SignalHandlerOptions.NO)
        self._node = rclpy.create_node('brush_view', context=self._context)
        self._queues, self._topics = {}, {}
        self._publishers, self._clients, self._listening = {}, {}, set()
        self._node.create_subscription(
            String, self.name + SCENE[1:], self._take_scene,
            QoSProfile(depth=1, durability=DurabilityPolicy.TRANSIENT_LOCAL), raw=True)
        self._executor = SingleThreadedExecutor(context=self._context)
        self._executor.add_node(self._node)
        self._thread = threading.Thread(target=self._spin, name='watch', daemon=True)
        self._thread.start()

    def _spin(self):
        try:
            self._executor.spin()
        except ExternalShutdownException:
            pass

    def _take_scene(self, payload):
        scene = decode_scene(payload)
        if scene and scene != self.scene:
            self._topics = {name: full for full, name in scene['topics'].items()}
            self._listen()
            self.scene = scene

    def _listen(self):
        tf_message = _tf_type()
        for name, type_, depth in (
                ('joint_states', JointState, 100), ('contact_wrench', WrenchStamped, 100),
                ('bristle_markers', MarkerArray, 1), ('/diagnostics', DiagnosticArray, 10),
                (messages.TRANSFORMS, tf_message, 10)):
            full = self._topics.get(name) or self._relative(name)
            if type_ is not None and full not in self._listening:
                self._listening.add(full)
                self._queues[name] = deque(maxlen=KEPT)
                self._node.create_subscription(
                    type_, full, self._taker(name), depth, raw=True)

    def _relative(self, name):
        return name if name.startswith('/') else f'{self.name.rpartition("/")[0]}/{name}'

    def _taker(self, name):
        def take(payload):
            self._queues[name].append(payload)
            if name == 'joint_states':
                self.heard = time.monotonic()
        return take

    def take(self, name):
        """Yield the messages of a topic (its name before remapping) since the last call."""
        waiting = self._queues.get(name, ())
        while waiting:
            yield waiting.popleft()

    @property
    def present(self):
        """Whether the node is in the graph."""
        return bool(self._node.count_publishers(self.name + SCENE[1:]))

    def command(self, topic, values, stamped):
        """Publish a command; stamped: whether cmd_vel is a TwistStamped."""
        kind = messages.command_types(stamped)[topic]
        if (topic, kind) not in self._publishers:
            full = self._topics.get(topic) or self._relative(topic)
            self._publishers[topic, kind] = self._node.create_publisher(_COMMANDS[kind], full, 10)
        self._publishers[topic, kind].publish(messages.encode_command(kind, values))

    def pause(self, hold):
        """Hold the node, or let it go on."""
        self._call(SetBool, 'pause', SetBool.Request(data=hold))

    def step(self):
        """Have it do one chunk."""
        self._call(Trigger, 'step', Trigger.Request())

    def reset(self):
        """Have it go back to its scene's start."""
        self._call(Trigger, 'reset', Trigger.Request())

    def set_factor(self, factor):
        """Set its parameter run.real_time_factor."""
        value = ParameterValue(type=ParameterType.PARAMETER_DOUBLE, double_value=float(factor))
        self._call(SetParameters, 'set_parameters', SetParameters.Request(
            parameters=[Parameter(name='run.real_time_factor', value=value)]))

    def _call(self, type_, name, request):
        if name not in self._clients:
            self._clients[name] = self._node.create_client(type_, f'{self.name}/{name}')
        self.answer = ''
        future = self._clients[name].call_async(request)
        future.add_done_callback(lambda done: self._hear(done.result()))

    def _hear(self, answer):
        if isinstance(answer, SetParameters.Response):
            [result] = answer.results
            self.answer = '' if result.successful else result.reason
        else:
            self.answer = '' if answer.success else answer.message

    def close(self):
        """Leave the graph."""
        self._executor.shutdown(timeout_sec=1.0)
        rclpy.try_shutdown(context=self._context)
        self._thread.join(1.0)


def _tf_type():
    try:
        from tf2_msgs.msg import TFMessage
    except ImportError:
        return None
    return TFMessage

