#!/usr/bin/env python3
"""Print what a running brush publishes, twice a second: ./run.sh examples/watch.py [LINES]."""
import sys

from geometry_msgs.msg import PoseStamped, WrenchStamped
import rclpy
from rclpy.executors import ExternalShutdownException
from sensor_msgs.msg import JointState

LATEST = {}     # topic: its last message


def main():
    """Subscribe, print a table line for each half second, end after LINES of them or Ctrl-C."""
    try:
        lines = int(sys.argv[1]) if len(sys.argv) > 1 else sys.maxsize
    except ValueError:
        lines = 0
    if lines < 1:
        print(f'watch.py: LINES = {sys.argv[1]!r}: must be a whole number above 0',
              file=sys.stderr)
        sys.exit(2)
    rclpy.init()
    node = rclpy.create_node('watch')
    for topic, type_ in (('contact_wrench', WrenchStamped), ('tip_pose', PoseStamped),
                         ('joint_states', JointState)):
        node.create_subscription(
            type_, topic, lambda message, topic=topic: LATEST.__setitem__(topic, message), 10)
    print('  time [s]  normal force [N]  torque [mN m]  tip x, y, z [mm]', flush=True)
    while lines:
        end = node.get_clock().now().nanoseconds + 500_000_000
        while node.get_clock().now().nanoseconds < end:
            rclpy.spin_once(node, timeout_sec=0.1)
        if len(LATEST) < 3:
            continue    # not found yet
        stamp = LATEST['tip_pose'].header.stamp
        force = LATEST['contact_wrench'].wrench.force.z     # the road is level: along its normal
        torque = LATEST['joint_states'].effort[0] * 1e3
        tip = LATEST['tip_pose'].pose.position
        place = ', '.join(f'{value * 1e3:.1f}' for value in (tip.x, tip.y, tip.z))
        print(f'{stamp.sec + stamp.nanosec * 1e-9:10.3f}{force:18.4f}{torque:15.2f}  {place}',
              flush=True)
        lines -= 1


if __name__ == '__main__':
    try:
        main()
    except (KeyboardInterrupt, ExternalShutdownException):
        pass
