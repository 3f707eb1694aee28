#!/usr/bin/env python3
"""
Carry the brush by a sweeper of MuJoCo's, in lockstep: ./run.sh examples/sweeper/sweep.py.

Simulates sweeper.xml, and brush.yaml in a brush_node that it starts. The sweeper steps over a
chunk with the mean wrench of the chunk before, tells where the mount is at its end (cmd_mount),
and waits for the mean wrench of this one (mount_wrench_mean). The cylinder lets the arm down in
the second second, and wires that come down on the kerb drop off it; then the brush runs along its
face, and climbs the edge of a driveway, as the wheels do after it.

Wants the package mujoco: .venv/bin/python -m pip install mujoco
"""
import argparse
import math
import subprocess
import sys
import time
from typing import NamedTuple

from bristle_ros import load
from geometry_msgs.msg import WrenchStamped
from nav_msgs.msg import Odometry
import numpy as np
import rclpy
from rclpy.executors import SingleThreadedExecutor
from rclpy.node import Node
try:
    from sweeper import HERE, Sweeper, WORKS
except ModuleNotFoundError as missing:
    sys.exit(f'no package {missing.name}\n{__doc__.strip()}')

PATIENCE = 600.0        # [s] for the brush to compile, which takes minutes, and for its answer
SMOOTH = 0.2            # [s] over which the picture's bold lines are means


class Ride(NamedTuple):
    """What was, at n chunk ends."""

    t: np.ndarray       # [s] (n,)
    place: np.ndarray   # [m] (n, 3) of the mount over the road
    hinge: np.ndarray   # [rad] (n,) of the arm, front down positive
    wrench: np.ndarray  # [N, N m] (n, 6) of the brush on the arm, mean over the chunk, mount axes
    force: np.ndarray   # [N] (n, 3) the same force in road axes
    stored: np.ndarray  # [J] (n,) energy of the sweeper, see Sweeper
    work: np.ndarray    # [J] (n, 5) done on it, in the order of WORKS
    added: np.ndarray   # [J] (n,) what the exchange has added: it applies a wrench a chunk late
    wall: float         # [s] that it took from the first answer on

    def left_over(self):
        """Return what the balance of energy leaves over [J] (n,): 0 but for discretisation."""
        return self.stored - self.stored[0] - (self.work - self.work[0]).sum(axis=1)


class Exchange(Node):
    """Sends where the mount is, and waits for what the brush did to it."""

    def __init__(self, brush):
        super().__init__('sweeper')
        self.brush, self.answers = brush, {}    # its process; stamp [ns] to the mean wrench
        self.way = self.create_publisher(Odometry, 'cmd_mount', 10)
        self.create_subscription(WrenchStamped, 'mount_wrench_mean', self.hear, 10)
        self.spinner = SingleThreadedExecutor()
        self.spinner.add_node(self)

    def hear(self, message):
        """Keep an answer."""
        force, torque, stamp = message.wrench.force, message.wrench.torque, message.header.stamp
        self.answers[stamp.sec * 1_000_000_000 + stamp.nanosec] = np.array(
            (force.x, force.y, force.z, torque.x, torque.y, torque.z))

    def ask(self, stamp, sweeper):
        """Send a chunk's way until the answer is there: the first may find nobody listening."""
        message = odometry(sweeper, stamp)
        end, again = time.monotonic() + PATIENCE, 0.0
        while stamp not in self.answers:
            now = time.monotonic()
            if now > end or self.brush.poll() is not None:
                sys.exit('sweep: the brush has ended' if now <= end else
                         f'sweep: no answer of the brush within {PATIENCE:g} s')
            if now > again:
                self.way.publish(message)
                again = now + 0.5
            self.spinner.spin_once(timeout_sec=0.1)
        return self.answers.pop(stamp)


def odometry(sweeper, stamp):
    """Return the message of the mount now, stamped `stamp` [ns]."""
    message = Odometry()
    message.header.frame_id, message.child_frame_id = 'road', 'brush_mount'
    message.header.stamp.sec, message.header.stamp.nanosec = divmod(stamp, 1_000_000_000)
    pose, twist = message.pose.pose, message.twist.twist
    pose.position.x, pose.position.y, pose.position.z = sweeper.place.tolist()
    (pose.orientation.w, pose.orientation.x, pose.orientation.y,
     pose.orientation.z) = sweeper.quaternion().tolist()
    (twist.linear.x, twist.linear.y, twist.linear.z, twist.angular.x, twist.angular.y,
     twist.angular.z) = sweeper.velocity().tolist()
    return message


def drive(sweeper, exchange, chunk, duration):
    """Run both, chunk by chunk [ns], for `duration` [s]; return the Ride."""
    wrench, added, rows, began = np.zeros(6), 0.0, [], 0.0
    for end in range(chunk, round(duration * 1e9) + 1, chunk):
        way, before = sweeper.go_on(end * 1e-9, wrench), wrench
        wrench = exchange.ask(end, sweeper)
        began = began or time.monotonic()
        added += (before - wrench) @ way
        rows.append((end * 1e-9, sweeper.place, sweeper.data.joint('hinge').qpos[0], wrench,
                     sweeper.turn @ wrench[:3], sweeper.stored, sweeper.work, added))
    return Ride(*map(np.array, zip(*rows)), wall=time.monotonic() - began)


def sweep(duration, log='', view=False, **changes):
    """
    Start the brush, and run both for `duration` [s]; return the Ride.

    log : the brush's log, or '' for none; view : whether to show it on a page, too
    changes : other values of the brush's keys, dots as __
    """
    changes = {key.replace('__', '.'): value for key, value in changes.items()}
    scene = load(HERE / 'brush.yaml', changes)
    verb = [sys.executable, '-m', 'bristle_ros']
    command = [*verb, 'brush_node', '--ros-args', '--params-file', str(HERE / 'brush.yaml'),
               *(('-p', f'log.path:={log}') if log else ())]
    for key, value in changes.items():
        command += '-p', f'{key}:={value}'
    started = [subprocess.Popen(command)]
    if view:
        started.append(subprocess.Popen([*verb, 'view', '--node', '/brush_node']))
    rclpy.init()
    try:
        return drive(Sweeper(scene), Exchange(started[0]), round(scene.run.chunk * 1e9), duration)
    finally:
        for process in started:
            process.terminate()
            process.wait()
        rclpy.try_shutdown()


def draw(ride, path):
    """Draw the force on the arm, its angle, and the road's height, along the way."""
    import matplotlib
    matplotlib.use('Agg')
    from matplotlib import pyplot
    from bristle_ros.scene import spline
    figure, (upper, lower) = pyplot.subplots(
        2, figsize=(9.0, 5.5), sharex=True, height_ratios=(2, 1), layout='constrained')
    x, window = ride.place[:, 0], max(1, round(SMOOTH / ride.t[0]))
    means = np.ones(window) / window
    for part, name in enumerate(('forward', 'to the left, away from the kerb if negative', 'up')):
        faint, = upper.plot(x, ride.force[:, part], linewidth=0.4, alpha=0.4)
        if len(x) > window:
            upper.plot(np.convolve(x, means, 'valid'),
                       np.convolve(ride.force[:, part], means, 'valid'),
                       color=faint.get_color(), label=name)
    # single wires, each for 20, hit the kerb's top: what they do for a chunk is cut off
    upper.set(ylabel='force on the arm [N]', ylim=np.percentile(ride.force, (0.5, 99.5)))
    upper.legend(frameon=False)
    lower.plot(x, np.degrees(ride.hinge), color='black')
    lower.set_ylabel('angle of the arm [deg]')
    profile = spline(load(HERE / 'brush.yaml').profile)
    height = lower.twinx()
    height.fill_between(x, 1e3 * np.interp(x, profile.x, profile.z), color='grey', alpha=0.4)
    height.set(ylabel='road [mm]', ylim=(0.0, 120.0))
    lower.set_xlabel('way of the mount along the road [m]')
    figure.savefig(path, dpi=130)


def report(ride):
    """Print how fast it was, where the arm is, and where the energy went."""
    last = ride.t > 0.8 * ride.t[-1]
    force, hinge = ride.force[last].mean(axis=0), math.degrees(ride.hinge[last].mean())
    print(f'{ride.t[-1]:g} s in {ride.wall:.3g} s, {ride.t[-1] / ride.wall:.3g} times real time; '
          f'{ride.place[-1, 0]:.3f} m along the kerb\n'
          f'last fifth: arm {hinge:.3f} degrees, force on it {force[0]:.2f} N forward, '
          f'{force[1]:.2f} N to the left, {force[2]:.2f} N up')
    done = ', '.join(f'{name} {work:.3f}' for name, work in zip(WORKS, ride.work[-1]))
    print(f'work on the sweeper [J]: {done}; stored {ride.stored[-1] - ride.stored[0]:.3f} more, '
          f'left over at most {np.abs(ride.left_over()).max():.3g}; the exchange added '
          f'{ride.added[-1]:.3g}')


def main():
    """Run, and say what came of it."""
    parser = argparse.ArgumentParser(
        description=__doc__.strip(), formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument('duration', type=float, nargs='?', default=10.0, help='[s], default: 10')
    parser.add_argument('log', nargs='?', default='', help="where the brush's log goes")
    parser.add_argument('--plot', metavar='FILE.png', help='draw the force on the arm')
    parser.add_argument('--view', action='store_true', help='show the brush on a page, too')
    options = parser.parse_args()
    if not 0.01 <= options.duration <= 1e4:
        parser.error('duration: must be 0.01 to 10000 s')
    ride = sweep(options.duration, options.log, options.view)
    report(ride)
    if options.plot:
        draw(ride, options.plot)


if __name__ == '__main__':
    main()
