"""A brush_node in a process of its own, and another node that uses it."""
import os
from pathlib import Path
import signal
import subprocess
import sys
import time

import rclpy
from rclpy.executors import SingleThreadedExecutor
from rclpy.qos import QoSProfile

ROOT = Path(__file__).resolve().parent.parent
LIMIT = 90.0    # [s] before a wait is a failure: compiling on a busy machine is slow


class Brush:
    """A brush_node in its own process and group; ended hard when a test forgets it."""

    def __init__(self, scene, *arguments, log=None, path=()):
        given = ['--ros-args', '--params-file', str(scene)]
        for argument in (*arguments, *([f'log.path:={log}'] if log else [])):
            given += argument.split() if argument.startswith('-') else ['-p', argument]
        self.process = subprocess.Popen(
            [sys.executable, '-m', 'bristle_ros', 'brush_node', *given], cwd=ROOT, text=True,
            stdout=subprocess.PIPE, stderr=subprocess.PIPE, start_new_session=True,
            env={**os.environ, 'PYTHONPATH': os.pathsep.join(map(str, (*path, ROOT)))})

    def end(self, number=signal.SIGINT, times=1):
        """Send the signal; return (exit code, what it printed)."""
        for _ in range(times):
            self.process.send_signal(number)
        return self.wait()

    def wait(self):
        out, err = self.process.communicate(timeout=LIMIT)
        return self.process.returncode, out + err

    def __enter__(self):
        return self

    def __exit__(self, *_):
        if self.process.poll() is None:
            self.process.kill()
            self.process.communicate()


class User:
    """Another ROS node, in this process."""

    def __init__(self, *arguments):
        self.context = rclpy.Context()
        rclpy.init(args=['--ros-args', *arguments], context=self.context)
        self.node = rclpy.create_node('user', context=self.context)
        self._executor = SingleThreadedExecutor(context=self.context)
        self._executor.add_node(self.node)

    def leave(self):
        self.node.destroy_node()
        rclpy.shutdown(context=self.context)

    def until(self, condition, what):
        """Spin until it is so."""
        end = time.monotonic() + LIMIT
        while not condition():
            assert time.monotonic() < end, f'{what}: not within {LIMIT} s'
            self._executor.spin_once(timeout_sec=0.05)

    def listen(self, type_, topic):
        """Return the list that its messages go to."""
        found = []
        self.node.create_subscription(type_, topic, found.append, QoSProfile(depth=1000))
        return found

    def until_quiet(self, found):
        """Spin for a while; return how many messages came meanwhile."""
        before, end = len(found), time.monotonic() + 0.3
        while time.monotonic() < end:
            self._executor.spin_once(timeout_sec=0.05)
        return len(found) - before

    def publisher(self, type_, topic):
        publisher = self.node.create_publisher(type_, topic, 10)
        self.until(publisher.get_subscription_count, f'a subscriber of {topic}')
        return publisher

    def call(self, type_, name, **request):
        client = self.node.create_client(type_, name)
        self.until(client.service_is_ready, f'service {name}')
        future = client.call_async(type_.Request(**request))
        self.until(future.done, f'answer of {name}')
        self.node.destroy_client(client)
        return future.result()


def seconds(message):
    return message.header.stamp.sec + message.header.stamp.nanosec * 1e-9


def run(*arguments):
    return subprocess.run([sys.executable, '-m', 'bristle_ros', *map(str, arguments)], cwd=ROOT,
                          capture_output=True, text=True, timeout=LIMIT)
