#!/usr/bin/env python3
"""
Follow a kerb by the side force on the brush: ./run.sh examples/follow_kerb.py NEWTON SPEED.

Reads contact_wrench, commands cmd_vel: SPEED [m/s] forwards, and sideways what the force asks for.
The kerb is to the left and pushes to the right; while it does so by less than NEWTON the sweeper
goes left, at most at APPROACH, else right. When this dies, run.command_timeout stops the sweeper.
"""
import math
import sys

from geometry_msgs.msg import TwistStamped, WrenchStamped
import rclpy
from rclpy.executors import ExternalShutdownException
from rclpy.node import Node

AVERAGE = 0.15      # [s] time constant of the mean: impacts are no signal
APPROACH = 0.01     # [m/s] sideways where there is no force
RETREAT = 0.03      # [m/s] at most
PERIOD = 0.02       # [s] of simulation time between commands


class FollowKerb(Node):
    """Steers until the mean side force is what was asked for."""

    def __init__(self, wanted, speed):
        super().__init__('follow_kerb')
        self.wanted, self.speed = wanted, speed     # [N], [m/s]
        self.mean, self.before, self.due = 0.0, None, -math.inf
        self.command = self.create_publisher(TwistStamped, 'cmd_vel', 10)
        self.create_subscription(WrenchStamped, 'contact_wrench', self.hear, 10)

    def hear(self, message):
        """Take the force of a chunk; steer when it is time."""
        now = message.header.stamp.sec + message.header.stamp.nanosec * 1e-9
        step, self.before = now - (self.before or now), now
        if 0.0 < step < 1.0:    # else it is the first message, or the clock has jumped
            self.mean += (-message.wrench.force.y - self.mean) * min(1.0, step / AVERAGE)
        if now < self.due < now + 1.0:
            return
        self.due = now + PERIOD
        steer = TwistStamped()
        steer.header.stamp = message.header.stamp
        steer.twist.linear.x = self.speed
        steer.twist.linear.y = max(APPROACH * (1.0 - self.mean / self.wanted), -RETREAT)
        self.command.publish(steer)


def main():
    """Control until Ctrl-C."""
    try:
        wanted, speed = (float(word) for word in sys.argv[1:])
        if not (0.0 < wanted < math.inf and abs(speed) < math.inf):
            raise ValueError
    except ValueError:
        sys.exit(__doc__.strip())
    rclpy.init()
    try:
        rclpy.spin(FollowKerb(wanted, speed))
    except (KeyboardInterrupt, ExternalShutdownException):
        pass


if __name__ == '__main__':
    main()
