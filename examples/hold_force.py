#!/usr/bin/env python3
"""
Hold the force of the road on the brush: ./run.sh examples/hold_force.py NEWTON.

Reads contact_wrench, commands cmd_penetration: an integral controller, since the force grows with
the depth and follows it within a turn. A brush in the air goes down to HIGHEST and no further;
one whose controller has died stays where it is. The force is that along the brush axis.
"""
import math
import sys

from geometry_msgs.msg import WrenchStamped
import rclpy
from rclpy.executors import ExternalShutdownException
from rclpy.node import Node
from std_msgs.msg import Float64

AVERAGE = 0.1           # [s] time constant of the mean: impacts are no signal
SETTLING = 1.0          # [s] in which a deviation falls to 1/e, some times AVERAGE,
DEPTH = 0.05            # [m] where each metre of depth adds 1 / DEPTH of the force asked for
LOWEST, HIGHEST = -0.02, 0.06   # [m] of penetration: lifted, and as deep as it may go
PERIOD = 0.02           # [s] of simulation time between commands


class HoldForce(Node):
    """Moves the brush until the mean force is what was asked for."""

    def __init__(self, wanted):
        super().__init__('hold_force')
        self.wanted, self.gain = wanted, DEPTH / (wanted * SETTLING)    # [N], [m/(N s)]
        self.mean, self.depth, self.before, self.due = None, 0.0, None, -math.inf
        self.command = self.create_publisher(Float64, 'cmd_penetration', 10)
        self.create_subscription(WrenchStamped, 'contact_wrench', self.hear, 10)

    def hear(self, message):
        """Take the force of a chunk; command when it is time."""
        now = message.header.stamp.sec + message.header.stamp.nanosec * 1e-9
        force, step = message.wrench.force.z, now - (self.before or now)
        self.before = now
        if not 0.0 < step < 1.0:    # the first message, or the clock has jumped
            self.mean = force if self.mean is None else self.mean
            return
        self.mean += (force - self.mean) * min(1.0, step / AVERAGE)
        error = self.wanted - self.mean
        self.depth = min(max(self.depth + self.gain * error * step, LOWEST), HIGHEST)
        if now >= self.due:
            self.due = now + PERIOD
            self.command.publish(Float64(data=self.depth))


def main():
    """Control until Ctrl-C; the brush stays where it is then."""
    try:
        wanted = float(sys.argv[1])
        if not 0.0 < wanted < math.inf:
            raise ValueError
    except (IndexError, ValueError):
        sys.exit(__doc__.strip())
    rclpy.init()
    try:
        rclpy.spin(HoldForce(wanted))
    except (KeyboardInterrupt, ExternalShutdownException):
        pass


if __name__ == '__main__':
    main()
