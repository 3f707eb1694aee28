#!/usr/bin/env python3
"""
Measure a running node from a second process: tools/measure_node.py latency|cpu|follow|master.

latency  a command's publication to the first wrench that reflects it, and the jitter of arrivals
cpu      the share of a core that the node takes: held, paused, running, watched
follow   how far the node is behind a /clock that this process turns at --factor
master   how far another node's clock is behind the stamps of a node that publishes /clock

Prints lines of a Markdown table. It needs ROS 2 and a quiet machine; two at once need two
ROS_DOMAIN_IDs.
"""
import argparse
from pathlib import Path
import random
import subprocess
import sys
import tempfile
import time

ROOT = Path(__file__).resolve().parent.parent
sys.path.insert(0, str(ROOT))

from bristle_ros.log.recording import Recording  # noqa: E402
from geometry_msgs.msg import WrenchStamped  # noqa: E402
from lifecycle_msgs.msg import Transition  # noqa: E402
from lifecycle_msgs.srv import ChangeState  # noqa: E402
import numpy as np  # noqa: E402
import rclpy  # noqa: E402
from rclpy.qos import QoSProfile  # noqa: E402
from rosgraph_msgs.msg import Clock  # noqa: E402
from std_msgs.msg import Float64  # noqa: E402
from std_srvs.srv import SetBool  # noqa: E402
from visualization_msgs.msg import MarkerArray  # noqa: E402

TICKS = 100.0   # [1/s] of /proc's CPU times, and of the clock that is turned


class Brush:
    """A brush_node with a scene and overrides; ended with the block."""

    def __init__(self, options, *overrides):
        overrides = (*options.overrides, *overrides)
        arguments = [word for override in overrides for word in ('-p', override)]
        self.process = subprocess.Popen(
            [sys.executable, '-m', 'bristle_ros', 'brush_node', '--ros-args', '--params-file',
             str(options.scene), '--log-level', 'warn', *arguments], cwd=ROOT)

    def __enter__(self):
        """Return it."""
        return self

    def __exit__(self, *_):
        """End it."""
        self.process.terminate()
        self.process.wait()

    def cpu(self, seconds, spin=time.sleep):
        """Return the share of a core [%] over the next `seconds`."""
        before, wall = self._cpu_time(), time.monotonic()
        spin(seconds)
        return 100.0 * (self._cpu_time() - before) / (time.monotonic() - wall)

    def _cpu_time(self):
        fields = Path(f'/proc/{self.process.pid}/stat').read_text().rpartition(')')[2].split()
        return (int(fields[11]) + int(fields[12])) / TICKS


class Watcher:
    """A node that notes when each message came."""

    def __init__(self, **options):
        self.node = rclpy.create_node('measure', **options)
        self._executor = rclpy.executors.SingleThreadedExecutor()
        self._executor.add_node(self.node)

    def listen(self, type_, topic, note):
        """Have note(message) called."""
        return self.node.create_subscription(type_, topic, note, QoSProfile(depth=1000))

    def spin(self, seconds, until=lambda: False):
        """Take messages for `seconds`, or until it is so."""
        end = time.monotonic() + seconds
        while time.monotonic() < end and not until():
            self._executor.spin_once(timeout_sec=max(0.0, min(0.05, end - time.monotonic())))

    def expect(self, until, brush):
        """Take messages until it is so; leave when the node ends before, or nothing comes."""
        self.spin(120.0, lambda: until() or brush.process.poll() is not None)
        if not until():
            sys.exit(f'no messages of the node (its exit code: {brush.process.poll()})')

    def call(self, type_, name, **request):
        """Call a service."""
        client = self.node.create_client(type_, name)
        client.wait_for_service()
        future = client.call_async(type_.Request(**request))
        self.spin(60.0, future.done)


def stamp(message):
    """Return a header's stamp [ns]."""
    return message.header.stamp.sec * 10**9 + message.header.stamp.nanosec


def row(name, values, unit='ms'):
    """Print p50, p99 and the largest of values in a line of a table."""
    p50, p99 = np.percentile(values, [50, 99])
    print(f'| {name} | {p50:.3f} | {p99:.3f} | {np.max(values):.3f} | {unit} | {len(values)} |',
          flush=True)


def latency(options):
    """Find the step at which each command took effect in the log; that wrench reflects it."""
    for chunk in (0.005, 0.001):
        with tempfile.TemporaryDirectory() as folder:
            log, came, sent = Path(folder) / 'run.mcap', {}, {}
            watcher = Watcher()
            watcher.listen(WrenchStamped, 'contact_wrench',
                           lambda m, came=came: came.setdefault(stamp(m), time.monotonic_ns()))
            publisher = watcher.node.create_publisher(Float64, 'cmd_brush_speed', 10)
            with Brush(options, f'run.chunk:={chunk}', 'run.sample:=0.01',
                       f'log.path:={log}') as brush:
                watcher.expect(lambda came=came, n=1.0 / chunk: len(came) > n, brush)
                came.clear()
                watcher.spin(options.seconds)
                arrivals = np.array(list(came.values()))
                for i in range(int(options.seconds / 0.05)):
                    watcher.spin(random.uniform(0.02, 0.08))
                    speed = 10.0 + 1e-4 * i
                    sent[speed] = time.monotonic_ns()
                    publisher.publish(Float64(data=speed))
                watcher.spin(0.5)
            delays = [came[at + round(chunk * 1e9)] - sent[speed] for at, speed in effects(log)
                      if at + round(chunk * 1e9) in came]
        row(f'command to wrench, chunk {chunk * 1e3:g} ms', np.array(delays) * 1e-6)
        row(f'arrival less period, {1.0 / chunk:g} Hz',
            np.abs(np.diff(arrivals) * 1e-6 - chunk * 1e3))
        watcher.node.destroy_node()


def effects(log):
    """Return (simulation time [ns], speed) of each command in a log."""
    from bristle_ros.messages.encode import decode_command
    return [(entry.message.log_time, decode_command(entry.message.channel.schema,
                                                    entry.message.data)[0])
            for entry in Recording(log).entries() if entry.name == 'cmd_brush_speed']


def cpu(options):
    """Print the node's share of a core in each state."""
    def show(name, share):
        print(f'| CPU, {name} | {share:.1f} % |', flush=True)

    watcher, seconds = Watcher(), options.seconds
    for chunk in (0.005, 0.001):
        with Brush(options, 'run.autostart:=false', f'run.chunk:={chunk}') as brush:
            for transition in (Transition.TRANSITION_CONFIGURE, Transition.TRANSITION_ACTIVATE):
                watcher.call(ChangeState, 'brush_node/change_state',
                             transition=Transition(id=transition))
                if transition == Transition.TRANSITION_CONFIGURE and chunk == 0.005:
                    show('inactive', brush.cpu(seconds))
            if chunk == 0.005:
                watcher.call(SetBool, 'brush_node/pause', data=True)
                show('paused', brush.cpu(seconds))
                watcher.call(SetBool, 'brush_node/pause', data=False)
            rate = f'{1.0 / chunk:g} Hz'
            show(f'{rate}, nobody listens', brush.cpu(seconds))
            for type_, topic in ((WrenchStamped, 'contact_wrench'),
                                 (MarkerArray, 'bristle_markers')):
                heard = watcher.listen(type_, topic, lambda message: None)
                watcher.spin(1.0)
                show(f'{rate}, {topic} heard', brush.cpu(seconds, watcher.spin))
                watcher.node.destroy_subscription(heard)


def follow(options):
    """Turn a /clock and see how far the stamps are behind it when they come."""
    watcher, behind = Watcher(), []
    publisher = watcher.node.create_publisher(Clock, '/clock', 10)
    time_ns, began = [10**12], time.monotonic()

    def tick():
        time_ns[0] = 10**12 + round((time.monotonic() - began) * options.factor * 1e9)
        message = Clock()
        message.clock.sec, message.clock.nanosec = divmod(time_ns[0], 10**9)
        publisher.publish(message)

    def note(message):
        behind.append((stamp(message), time_ns[0]))

    watcher.node.create_timer(1.0 / TICKS, tick)
    watcher.listen(WrenchStamped, 'contact_wrench', note)
    with Brush(options, 'use_sim_time:=true') as brush:
        watcher.expect(lambda: len(behind) > 200, brush)
        behind.clear()
        watcher.spin(options.seconds)
        stamps, clock = np.array(behind).T
    name = f'/clock at {options.factor:g}'
    row(f'{name}: stamps behind it', (clock - stamps) * 1e-6)
    steps = np.diff(stamps)
    given_up = np.sum(steps - np.median(steps)) * 1e-6
    print(f'| {name}: most ahead of it | {np.max(stamps - clock) * 1e-6:.3f} ms |\n'
          f'| {name}: drift, last tenth to first | {drift(stamps - clock):.3f} ms |\n'
          f'| {name}: given up | {given_up:.1f} ms |', flush=True)


def drift(lead):
    """Return by how much [ms] the mean of the last tenth differs from the first tenth's."""
    tenth = max(1, len(lead) // 10)
    return (np.mean(lead[-tenth:]) - np.mean(lead[:tenth])) * 1e-6


def master(options):
    """Compare another node's clock with each stamp when it comes."""
    watcher, behind, clocks = Watcher(
        parameter_overrides=[rclpy.Parameter('use_sim_time', value=True)]), [], []
    watcher.listen(Clock, '/clock', clocks.append)
    watcher.listen(WrenchStamped, 'contact_wrench', lambda message: behind.append(
        stamp(message) - watcher.node.get_clock().now().nanoseconds))
    with Brush(options, 'run.publish_clock:=true',
               f'run.real_time_factor:={options.factor}') as brush:
        watcher.expect(lambda: len(behind) > 200, brush)
        behind.clear()
        clocks.clear()
        watcher.spin(options.seconds)
    row(f"other node's clock behind stamps, factor {options.factor:g}", np.array(behind) * 1e-6)
    print(f'| /clock rate | {len(clocks) / options.seconds:.1f} Hz |', flush=True)


def main():
    """Measure what is asked for."""
    parser = argparse.ArgumentParser(description=__doc__.strip().partition('\n')[0])
    parser.add_argument('what', choices=('latency', 'cpu', 'follow', 'master'))
    parser.add_argument('--seconds', type=float, default=20.0, help='of each measurement')
    parser.add_argument('--factor', type=float, default=1.0, help='of the clock')
    parser.add_argument('-p', action='append', default=[], metavar='KEY:=VALUE', dest='overrides',
                        help='of the scene')
    parser.add_argument('--scene', type=Path, default=ROOT / 'config' / 'cutting_brush.yaml')
    options = parser.parse_args()
    rclpy.init()
    globals()[options.what](options)
    rclpy.shutdown()


if __name__ == '__main__':
    main()
