"""The commands that the node subscribes to, and which of them it refuses."""
import re
import time

from bristle_ros.messages import encode as messages
from bristle_ros.simulation import CommandRefused
from geometry_msgs.msg import Twist, TwistStamped
from nav_msgs.msg import Odometry
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

    def __init__(self, node, run, driver, *, active, own_time, origin, wake):
        """
        Subscribe.

        run : the scene's section; active() -> bool: whether commands count; own_time() -> stamp
        [ns] of the step reached; origin [ns] of stamps at first; wake(): a chunk may be due by
        what has come.
        """
        self._wake, self._origin = wake, origin
        self._node, self._run, self._driver = node, run, driver
        self._active, self._own_time = active, own_time
        self._subscriptions, self._told = [], {}
        self.last_refusal, self._told_halt = '', False
        self._listen(Float64, 'cmd_brush_speed', lambda message: (message.data,))
        self._listen(Float64, 'cmd_penetration', lambda message: (message.data,))
        self._listen(Float64, 'cmd_drive_torque', lambda message: (message.data,))
        if run.stamped_cmd_vel:
            self._listen(TwistStamped, 'cmd_vel', self._stamped)
        else:
            self._listen(Twist, 'cmd_vel', _velocity)
        self._listen(Odometry, 'cmd_mount', follow=self._carry if run.carried else self._mount)
        driver.on_refusal = self._tell

    def destroy(self):
        """Leave the graph."""
        for subscription in self._subscriptions:
            self._node.destroy_subscription(subscription)

    def _listen(self, type_, topic, values=None, follow=None):
        def take(message):
            if not self._active():
                return  # an inactive node would only keep it until it is stale
            try:
                if follow:
                    follow(message)
                else:
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
        self._check_age('cmd_vel', message)
        return _velocity(message.twist)

    def _check_age(self, topic, message):
        limit = self._run.command_timeout
        if limit:
            own = self._own_time() if self._run.publish_clock else None
            age = node_time.age(self._node, message.header.stamp, own)
            if age is not None and age * 1e-9 >= limit:
                self._driver.count_refusal()
                raise CommandRefused(f'{topic}: its stamp is {age * 1e-9:.6g} s old, beyond '
                                     f'run.command_timeout = {limit:.6g} s')

    def _mount(self, message):
        self._check_frames(message)
        self._check_age('cmd_mount', message)
        ready = self._driver.simulation.ready_to_carry
        self._driver.command('cmd_mount', _pose_and_twist(message))
        if not (ready or self._told_halt):
            self._told_halt = True
            self._node.get_logger().info(
                'the first cmd_mount: the brush halts until what it needs is compiled, or loaded; '
                'mount.enabled: true has that done before the start')

    def _carry(self, message):
        self._check_frames(message)
        stamp = message.header.stamp.sec * 1_000_000_000 + message.header.stamp.nanosec
        its, origin = self._driver.its, self._origin
        step = messages.total_step(stamp, its, origin)
        if messages.stamp_ns(step, its, origin) != stamp:
            self._driver.count_refusal()
            raise CommandRefused(f'cmd_mount: its stamp, {stamp * 1e-9:.9f} s, ends no step')
        try:
            self._driver.carry(step, _pose_and_twist(message))
        finally:
            self._wake()    # refused or not, the chunk may run

    def _check_frames(self, message):
        prefix = self._run.frame_prefix
        for given, wanted in ((message.header.frame_id, messages.ROAD_FRAME),
                              (message.child_frame_id, messages.MOUNT_FRAME)):
            if given not in ('', prefix + wanted):
                self._driver.count_refusal()
                raise CommandRefused(f'cmd_mount: frame {given!r}: must be {prefix + wanted}')


def _pose_and_twist(message):
    place, turn = message.pose.pose.position, message.pose.pose.orientation
    linear, angular = message.twist.twist.linear, message.twist.twist.angular
    return (place.x, place.y, place.z, turn.x, turn.y, turn.z, turn.w,
            linear.x, linear.y, linear.z, angular.x, angular.y, angular.z)


def _velocity(twist):
    return twist.linear.x, twist.linear.y, twist.angular.z
