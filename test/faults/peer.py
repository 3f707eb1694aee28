"""Another ROS node as a process: `peer.py listen | flood | nonsense`. Ends on a signal."""
import itertools
import math
import sys
import time

from geometry_msgs.msg import PoseStamped, TwistStamped, WrenchStamped
import rclpy
from rclpy.executors import ExternalShutdownException
from std_msgs.msg import Float64

RATE = 10_000   # [Hz] of commands
NONSENSE = (math.nan, math.inf, -math.inf, 1e308, -1e308, 5e-324, 1e9)


def listen(node):
    """Subscribe reliably; print how many messages have come, five times a second."""
    counts = itertools.count(1)
    latest = [0]
    for type_, topic in ((PoseStamped, 'tip_pose'), (WrenchStamped, 'contact_wrench')):
        node.create_subscription(type_, topic, lambda _: latest.append(next(counts)), 1000)
    node.create_timer(0.2, lambda: print(latest[-1], flush=True))
    rclpy.spin(node)


def flood(node):
    """Command a speed RATE times a second; print how many were sent, once a second."""
    publisher = node.create_publisher(Float64, 'cmd_brush_speed', 10)
    while not publisher.get_subscription_count():
        time.sleep(0.01)
    start, message = time.monotonic(), Float64()
    for number in itertools.count():
        message.data = 5.0 + 5.0 * math.sin(number * 1e-3)
        publisher.publish(message)
        if number % RATE == RATE - 1:
            print(number + 1, flush=True)
        while number > (time.monotonic() - start) * RATE:
            time.sleep(1e-4)


def nonsense(node):
    """Send what no brush can do, everywhere; print how much."""
    speed = node.create_publisher(Float64, 'cmd_brush_speed', 10)
    depth = node.create_publisher(Float64, 'cmd_penetration', 10)
    velocity = node.create_publisher(TwistStamped, 'cmd_vel', 10)
    while not all(one.get_subscription_count() for one in (speed, depth, velocity)):
        time.sleep(0.01)
    for number in itertools.count():
        value = NONSENSE[number % len(NONSENSE)]
        speed.publish(Float64(data=value))
        depth.publish(Float64(data=value))
        twist = TwistStamped()
        twist.twist.linear.x = value
        twist.twist.angular.z = NONSENSE[number * 3 % len(NONSENSE)]
        velocity.publish(twist)
        print(number + 1, flush=True)
        time.sleep(0.01)


if __name__ == '__main__':
    rclpy.init()
    try:
        globals()[sys.argv[1]](rclpy.create_node(f'peer_{sys.argv[1]}'))
    except (KeyboardInterrupt, ExternalShutdownException):
        pass
