"""The commands that the node subscribes to, and which of them it refuses."""
import re
import time

from bristle_ros.simulation import CommandRefused
from geometry_msgs.msg import Twist, TwistStamped
from std_msgs.msg import Float64

from . import clocks as node_time
from .topics import OVERRIDABLE, reliable

QUIET = 5.0     # [s] between two lines about refusals for the same reason


class Commands:
    """
    Hands commands on to a driver; the executor's thread calls.

    As ros2_controllers do, a stamped cmd_vel that is older than run.command_timeout is refused: it
    comes from a sender that hangs, and would keep the sweeper going. A stamp of zero has no age.
    """

    def __init__(self, node, run, driver, *, active, own_time):
        """
        Subscribe.

        run : the scene's section; active() -> bool: whether commands count; own_time() -> stamp
        [ns] of the step reached.
        """
        self._node, self._run, self._driver = node, run, driver
        self._active, self._own_time = active, own_time
        self._subscriptions, self._told = [], {}
        self.last_refusal = ''
        self._listen(Float64, 'cmd_brush_speed', lambda message: (message.data,))
        self._listen(Float64, 'cmd_penetration', lambda message: (message.data,))
        self._listen(Float64, 'cmd_drive_torque', lambda message: (message.data,))
        if run.stamped_cmd_vel:
            self._listen(TwistStamped, 'cmd_vel', self._stamped)
        else:
            self._listen(Twist, 'cmd_vel', _velocity)

    def destroy(self):
        """Leave the graph."""
        for subscription in self._subscriptions:
            self._node.destroy_subscription(subscription)

    def _listen(self, type_, topic, values):
        def take(message):
            if not self._active():
                return  # an inactive node would only keep it until it is stale
            try:
                self._driver.command(topic, values(message))
            except CommandRefused as refused:
                self._tell(str(refused))

        self._subscriptions.append(self._node.create_subscription(
            type_, topic, take, reliable(), qos_overriding_options=OVERRIDABLE))

    def _tell(self, refusal):
        self.last_refusal = refusal
        # rclpy throttles by place in the code: of several reasons one would be heard
        reason, now = re.sub(r'[-+.\w]*\d[-+.\w]*|nan|inf', '', refusal), time.monotonic()
        if now - self._told.get(reason, -QUIET) >= QUIET:
            self._told[reason] = now
            self._node.get_logger().warning(f'refused: {refusal}')

    def _stamped(self, message):
        limit = self._run.command_timeout
        if limit:
            own = self._own_time() if self._run.publish_clock else None
            age = node_time.age(self._node, message.header.stamp, own)
            if age is not None and age * 1e-9 >= limit:
                self._driver.count_refusal()
                raise CommandRefused(f'cmd_vel: its stamp is {age * 1e-9:.6g} s old, beyond '
                                     f'run.command_timeout = {limit:.6g} s')
        return _velocity(message.twist)


def _velocity(twist):
    return twist.linear.x, twist.linear.y, twist.angular.z
