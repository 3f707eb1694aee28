#!/usr/bin/env python3
"""
Send one command to a running brush: ./run.sh examples/command.py TOPIC VALUE...

cmd_brush_speed W       speed of the brush [rad/s]
cmd_penetration D       depth of the undeformed tip below the road [m]
cmd_vel VX VY W         velocity of the sweeper [m/s], [m/s], [rad/s]
"""
import sys
import time

from geometry_msgs.msg import TwistStamped
import rclpy
from rclpy.duration import Duration
from std_msgs.msg import Float64

PATIENCE = 10.0     # [s] for the brush to be found


def twist(vx, vy, yaw_rate):
    """Return the message of cmd_vel."""
    message = TwistStamped()
    message.twist.linear.x, message.twist.linear.y = vx, vy
    message.twist.angular.z = yaw_rate
    return message


def number(value):
    """Return the message of the other two."""
    return Float64(data=value)


MESSAGES = {'cmd_brush_speed': number, 'cmd_penetration': number, 'cmd_vel': twist}


def main():
    """Wait until the brush listens, publish, and see that it arrives."""
    try:
        topic, *values = sys.argv[1:]
        message = MESSAGES[topic](*map(float, values))
    except (KeyError, TypeError, ValueError):
        sys.exit(__doc__.strip())
    rclpy.init()
    publisher = rclpy.create_node('command').create_publisher(type(message), topic, 10)
    deadline = time.monotonic() + PATIENCE
    while not publisher.get_subscription_count():
        if time.monotonic() > deadline:
            sys.exit(f'nobody listens to {topic}: is the brush running?')
        time.sleep(0.05)
    publisher.publish(message)
    publisher.wait_for_all_acked(Duration(seconds=2.0))
    print(f'sent {topic}: {" ".join(values)}')


if __name__ == '__main__':
    main()
