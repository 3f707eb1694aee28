"""A brush_node in a process of its own, and another node that uses it."""
from contextlib import contextmanager
import math
import os
from pathlib import Path
import signal
import subprocess
import sys
import time

import rclpy
from rclpy.executors import SingleThreadedExecutor
from rclpy.qos import DurabilityPolicy, QoSProfile
from std_srvs.srv import SetBool

ROOT = Path(__file__).resolve().parent.parent
LIMIT = 600.0   # [s] before a wait is a failure: compiling on a busy machine takes minutes
AGAIN = 20.0    # [s] without an answer before a service is asked again


@contextmanager
def example(name, *arguments):
    """Run a program of examples/ beside a node; yield its process, and end that hard."""
    process = subprocess.Popen([sys.executable, str(ROOT / 'examples' / name), *arguments],
                               env=os.environ)
    try:
        yield process
    finally:
        process.kill()
        process.wait()


_running = []   # brushes that a test has started


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
        _running.append(self)
        return self

    def __exit__(self, *_):
        _running.remove(self)
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
        self._clients = {}

    def leave(self):
        self.node.destroy_node()
        rclpy.shutdown(context=self.context)

    def until(self, condition, what):
        """Spin until it is so."""
        end = time.monotonic() + LIMIT
        while not condition():
            assert time.monotonic() < end, f'{what}: not within {LIMIT} s'
            for brush in _running:
                assert brush.process.poll() is None, f'{what}: {brush.wait()}'
            self._executor.spin_once(timeout_sec=0.05)

    def listen(self, type_, topic):
        """Return the list that its messages go to."""
        found = []
        self.node.create_subscription(type_, topic, found.append, QoSProfile(depth=1000))
        return found

    def listen_late(self, type_, topic):
        """Return the list that its messages go to, with the last one from before."""
        found = []
        self.node.create_subscription(type_, topic, found.append, QoSProfile(
            depth=1, durability=DurabilityPolicy.TRANSIENT_LOCAL))
        return found

    def came(self, found, wait=0.3):
        """Spin for a while; return how many messages came meanwhile."""
        before, end = len(found), time.monotonic() + wait
        while time.monotonic() < end:
            self._executor.spin_once(timeout_sec=0.05)
        return len(found) - before

    def pause(self, found):
        """Pause the brush; return its time [s] when the last message of it is in `found`."""
        answer = self.call(SetBool, 'brush_node/pause', data=True)
        assert answer.success
        held = float(answer.message.split()[-2])    # 'paused at 1.234500 s'
        self.until(lambda: found and abs(seconds(found[-1]) - held) < 1e-7, 'the last message')
        return held

    def publisher(self, type_, topic):
        publisher = self.node.create_publisher(type_, topic, 10)
        self.until(publisher.get_subscription_count, f'a subscriber of {topic}')
        return publisher

    def call(self, type_, name, **request):
        """
        Return the answer of a service.

        An answer is lost when the server has not found the client yet, which can only be the
        first one: so clients are kept, and asked again. What must happen once wants a harmless
        call before.
        """
        if name not in self._clients:
            self._clients[name] = self.node.create_client(type_, name)
        client = self._clients[name]
        self.until(client.service_is_ready, f'service {name}')
        futures, asked = [], -math.inf

        def answered():
            nonlocal asked
            if time.monotonic() > asked + AGAIN:
                futures.append(client.call_async(type_.Request(**request)))
                asked = time.monotonic()
            return any(future.done() for future in futures)

        self.until(answered, f'answer of {name}')
        return next(future.result() for future in futures if future.done())


def seconds(message):
    return message.header.stamp.sec + message.header.stamp.nanosec * 1e-9


def run(*arguments):
    return subprocess.run([sys.executable, '-m', 'bristle_ros', *map(str, arguments)], cwd=ROOT,
                          capture_output=True, text=True, timeout=LIMIT)
