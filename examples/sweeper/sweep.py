#!/usr/bin/env python3
"""
Carry the brush by a sweeper of MuJoCo's, in lockstep: ./run.sh examples/sweeper/sweep.py S LOG.

Simulates S seconds (10) of sweeper.xml, and of brush.yaml in a brush_node that it starts; LOG, if
given, is the brush's log. The sweeper steps over a chunk with the mean wrench of the chunk before,
tells where the mount is at its end (cmd_mount), and waits for the mean wrench of this one
(mount_wrench_mean). The cylinder lets the arm down in the second second.

Wants the package mujoco: .venv/bin/python -m pip install mujoco
"""
import math
from pathlib import Path
import subprocess
import sys
import time

from bristle_ros import load
from bristle_ros.scene import tip_depth
from geometry_msgs.msg import WrenchStamped
try:
    import mujoco
except ImportError:
    sys.exit(__doc__.strip())
from nav_msgs.msg import Odometry
import numpy as np
import rclpy
from rclpy.node import Node

HERE = Path(__file__).resolve().parent
SPEED = 0.8             # [m/s] of the sweeper, reached in the first second
LIFT = 20.0             # [N m] of the cylinder, on the lowered arm, upwards: carries part of it
PATIENCE = 120.0        # [s] for the brush to compile, and for its answer


class Sweeper:
    """The model, its mount put where the brush's scene has it."""

    def __init__(self, scene):
        spec = mujoco.MjSpec.from_file(str(HERE / 'sweeper.xml'))
        height = tip_depth(scene) - scene.road.penetration
        below = height - 0.45       # from the arm, which is 0.2 + 0.25 m high
        spec.site('mount').pos = (0.0, 0.0, below)
        half = 0.5 * scene.road.attack_angle
        spec.site('mount').quat = (math.cos(half), 0.0, math.sin(half), 0.0)
        self.model = spec.compile()
        self.data = mujoco.MjData(self.model)
        self.brush = self.model.body('brush').id
        # the wheels have sunk in by then, and the arm hangs in its spring
        self.holding = self._settle()
        self.start = self.data.site('mount').xpos.copy() - (0.0, 0.0, height)

    def _settle(self):
        """Let the cylinder hold the arm level; return its moment [N m]."""
        hinge, moment = self.data.joint('hinge'), 0.0
        for _ in range(3000):
            moment -= 20.0 * hinge.qpos[0] + 5.0 * hinge.qvel[0]
            self.data.actuator('lift').ctrl = moment
            mujoco.mj_step(self.model, self.data)
        self.data.time, self.data.qvel[:] = 0.0, 0.0
        mujoco.mj_forward(self.model, self.data)
        return moment

    def go_on(self, until, wrench):
        """Step to `until` [s] with a wrench (6,) on the mount, mount axes."""
        site, count = self.data.site('mount'), round(
            (until - self.data.time) / self.model.opt.timestep)
        for _ in range(count):
            t = self.data.time
            turning = SPEED / 0.2 * min(t, 1.0)
            self.data.actuator('drive_left').ctrl = turning
            self.data.actuator('drive_right').ctrl = turning
            down = min(max(t - 1.0, 0.0), 1.0)
            self.data.actuator('lift').ctrl = self.holding + (-LIFT - self.holding) * down
            turn = site.xmat.reshape(3, 3)
            self.data.qfrc_applied[:] = 0.0
            mujoco.mj_applyFT(self.model, self.data, turn @ wrench[:3], turn @ wrench[3:],
                              site.xpos, self.brush, self.data.qfrc_applied)
            mujoco.mj_step(self.model, self.data)
        mujoco.mj_kinematics(self.model, self.data)
        mujoco.mj_comPos(self.model, self.data)

    def odometry(self, stamp):
        """Return the message of the mount now, stamped `stamp` [ns]."""
        site, velocity = self.data.site('mount'), np.zeros(6)
        mujoco.mj_objectVelocity(
            self.model, self.data, mujoco.mjtObj.mjOBJ_SITE, site.id, velocity, 1)
        quaternion = np.zeros(4)
        mujoco.mju_mat2Quat(quaternion, site.xmat)
        message = Odometry()
        message.header.frame_id, message.child_frame_id = 'road', 'brush_mount'
        message.header.stamp.sec, message.header.stamp.nanosec = divmod(stamp, 1_000_000_000)
        pose, twist = message.pose.pose, message.twist.twist
        pose.position.x, pose.position.y, pose.position.z = (site.xpos - self.start).tolist()
        (pose.orientation.w, pose.orientation.x, pose.orientation.y,
         pose.orientation.z) = quaternion.tolist()
        twist.angular.x, twist.angular.y, twist.angular.z = velocity[:3].tolist()
        twist.linear.x, twist.linear.y, twist.linear.z = velocity[3:].tolist()
        return message


class Exchange(Node):
    """Sends where the mount is, and waits for what the brush did to it."""

    def __init__(self, brush):
        super().__init__('sweeper')
        self.brush, self.answers = brush, {}    # its process; stamp [ns] to the mean wrench
        self.way = self.create_publisher(Odometry, 'cmd_mount', 10)
        self.create_subscription(WrenchStamped, 'mount_wrench_mean', self.hear, 10)

    def hear(self, message):
        """Keep an answer."""
        force, torque, stamp = message.wrench.force, message.wrench.torque, message.header.stamp
        self.answers[stamp.sec * 1_000_000_000 + stamp.nanosec] = np.array(
            (force.x, force.y, force.z, torque.x, torque.y, torque.z))

    def ask(self, stamp, message):
        """Send a chunk's way until the answer is there: the first may find nobody listening."""
        end, again = time.monotonic() + PATIENCE, 0.0
        while stamp not in self.answers:
            now = time.monotonic()
            if now > end or self.brush.poll() is not None:
                sys.exit('sweep: the brush has ended' if now <= end else
                         f'sweep: no answer of the brush within {PATIENCE:g} s')
            if now > again:
                self.way.publish(message)
                again = now + 0.5
            rclpy.spin_once(self, timeout_sec=0.1)
        return self.answers.pop(stamp)


def sweep(duration, log='', **changes):
    """
    Run both; return t [s], hinge angle [rad], wrench on the mount, each chunk: (n, 8).

    changes : other values of the brush's keys, dots as __
    """
    changes = {key.replace('__', '.'): value for key, value in changes.items()}
    scene = load(HERE / 'brush.yaml', changes)
    sweeper, chunk, wrench, rows = Sweeper(scene), round(scene.run.chunk * 1e9), np.zeros(6), []
    command = [sys.executable, '-m', 'bristle_ros', 'brush_node', '--ros-args', '--params-file',
               str(HERE / 'brush.yaml'), *(('-p', f'log.path:={log}') if log else ())]
    for key, value in changes.items():
        command += '-p', f'{key}:={value}'
    brush = subprocess.Popen(command)
    rclpy.init()
    try:
        exchange = Exchange(brush)
        for end in range(chunk, round(duration * 1e9) + 1, chunk):
            sweeper.go_on(end * 1e-9, wrench)
            wrench = exchange.ask(end, sweeper.odometry(end))
            rows.append((end * 1e-9, sweeper.data.joint('hinge').qpos[0], *wrench))
    finally:
        brush.terminate()
        brush.wait()
        rclpy.try_shutdown()
    return np.array(rows)


def main():
    """Run, and say where the arm has settled."""
    try:
        duration, log = float(sys.argv[1]) if sys.argv[1:] else 10.0, ''.join(sys.argv[2:3])
    except ValueError:
        sys.exit(__doc__.strip())
    began = time.monotonic()
    rows = sweep(duration, log)
    last = rows[rows[:, 0] > 0.7 * duration]
    print(f'{duration:g} s in {time.monotonic() - began:.3g} s; in the last 30 %: arm '
          f'{math.degrees(last[:, 1].mean()):.3f} degrees, road on brush '
          f'{last[:, 4].mean():.3f} N along its axis, torque {last[:, 7].mean():.4f} N m')


if __name__ == '__main__':
    main()
