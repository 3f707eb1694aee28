"""
Run as a program: a /clock of its own, and a look at whether anybody runs ahead of it.

Commands, one per line on stdin: `run FACTOR`, `jump SECONDS`, `zero`, `rate HERTZ`, `time`. Each
is answered by a line of JSON: the clock's time [ns], the last stamp of joint_states [ns], how many
came, the most that one was ahead of the clock [ns], and how often the clock has ticked. It starts
with the first `run`; `run 0` holds it.
"""
import json
import sys
import threading
import time

import rclpy
from rclpy.qos import QoSProfile
from rosgraph_msgs.msg import Clock
from sensor_msgs.msg import JointState

RATE = 100.0        # [Hz] of ticks, in wall time
BURST = 100         # ticks at once, to make up for being late


class Master:
    def __init__(self, start):
        rclpy.init()
        self.node = rclpy.create_node('clock_master')
        self.publisher = self.node.create_publisher(Clock, '/clock', 10)
        self.node.create_subscription(
            JointState, 'joint_states', self.hear, QoSProfile(depth=1000))
        self.time, self.factor = round(start * 1e9), None
        self.period, self.ticks = 1.0 / RATE, 0
        self.lock = threading.Lock()    # commands come from another thread than messages
        self.last, self.count, self.ahead, self.blind = 0, 0, -10**18, False

    def hear(self, message):
        with self.lock:
            self.last = message.header.stamp.sec * 10**9 + message.header.stamp.nanosec
            self.count += 1
            if self.last <= self.time:
                self.blind = False  # messages of one publisher come in order
            if not self.blind:
                self.ahead = max(self.ahead, self.last - self.time)

    def spin(self):
        wall = time.monotonic()
        while rclpy.ok():
            now = time.monotonic()
            if self.factor is None:
                wall = now
            elif now - wall >= self.period:
                count = min(BURST, int((now - wall) / self.period))
                for _ in range(count):
                    self.tick((now - wall) / count)
                wall = now
            rclpy.spin_once(self.node, timeout_sec=self.period / 4)

    def tick(self, elapsed):
        with self.lock:
            self.time += round(elapsed * self.factor * 1e9)
            self.ticks += 1
            seconds, nanoseconds = divmod(self.time, 10**9)
        message = Clock()
        message.clock.sec, message.clock.nanosec = seconds, nanoseconds
        self.publisher.publish(message)

    def obey(self, line):
        word, _, value = line.strip().partition(' ')
        with self.lock:
            if word == 'run':
                self.factor = float(value)
            elif word == 'rate':
                self.period = 1.0 / float(value)
            elif word in ('jump', 'zero'):
                by = round(float(value) * 1e9) if value else -self.time
                self.blind = by < 0     # messages from before may still come
                self.time += by
            return json.dumps({'time': self.time, 'last': self.last, 'count': self.count,
                               'ahead': self.ahead, 'ticks': self.ticks})


if __name__ == '__main__':
    master = Master(float(sys.argv[1]))
    threading.Thread(target=master.spin, daemon=True).start()
    for command in sys.stdin:
        print(master.obey(command), flush=True)
