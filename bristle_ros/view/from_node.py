"""A running node as a source: what it publishes, and its topics and services for commands."""
import time

from bristle_ros.log import scene_of
from bristle_ros.messages import (decode_diagnostics, decode_pose, encode as messages, TOPICS,
                                  view)
from bristle_ros.scene import bristle_count, SceneError
from bristle_ros.simulation import check_command
import numpy as np

from .frame import COLUMNS, Frame, resting_pose, rotation_of, Status, tracked, Update

SILENT = 0.5    # [s] without a message after which a node holds, or is gone
_DECODE = {topic.name: topic.decode for topic in TOPICS}


class NodeSource:
    """A brush_node, as source.SceneSource is a source. `scene` changes when it is started anew."""

    duration = None

    def __init__(self, name):
        """Begin to listen; raises SceneError where there is no ROS."""
        try:
            from bristle_ros.node import Watch
        except ImportError as error:
            raise SceneError(f'needs ROS 2 ({error}): install rclpy', key='--node',
                             value=name) from None
        self._watch, self.scene = Watch(name), None
        self._told = {}             # the watch's, from which `scene` comes
        self._values, self._last = {}, -np.inf      # of /diagnostics; [s] of the last row

    def _know(self):
        """Take the node's scene, where it is a new one."""
        self._told = told = self._watch.scene
        self._origin = int(told['run'].get('time_origin_ns', '0'))
        scene = scene_of(told['scene']['yaml'], self._watch.name)
        self._markers = view.Markers(scene)
        position, orientation = resting_pose(scene)
        self._pose, self._theta, self._wrench = (*position, *orientation), 0.0, np.zeros(3)
        self._omega = self._factor = 0.0
        self._tracked = tracked(bristle_count(scene))
        self.scene = scene

    def update(self):
        """Return the Update since the last call."""
        if self._watch.scene != self._told:
            self._know()
        if self.scene is None:
            return Update(None, np.empty((0, len(COLUMNS))), np.empty((0, 1, 3)), Status(
                'waiting', late=None, error=None, text=f'waiting for {self._watch.name}'))
        for payload in self._watch.take(messages.TRANSFORMS):
            self._pose = decode_pose(payload, self.scene.run.frame_prefix) or self._pose
        for payload in self._watch.take('contact_wrench'):
            self._wrench = np.array(_DECODE['contact_wrench'](payload)[:3])
        rows = np.array([self._row(payload) for payload in self._watch.take('joint_states')])
        rows = rows.reshape(-1, len(COLUMNS))
        afresh = bool(len(rows) and rows[0, 0] < self._last)
        self._last = rows[-1, 0] if len(rows) else self._last
        frame, trail = self._frame()
        return Update(frame, rows, trail, self._status(), afresh)

    def _row(self, payload):
        self._theta, self._omega, torque = _DECODE['joint_states'](payload)
        normal = rotation_of(self._pose[3:])[2] @ self._wrench
        t = (messages.decode_stamp(payload) - self._origin) * 1e-9
        return t, self._omega, normal, torque, torque * self._omega, np.nan

    def _frame(self):
        """Return (Frame or None, trail) of the newest markers."""
        frame, trail = None, []
        for payload in self._watch.take('bristle_markers'):
            try:
                line, force, kerb, beside = self._markers.decode(payload)
            except ValueError:
                continue    # of the scene before
            frame = Frame(self._last, self._theta, line.astype(np.float32), force,
                          np.array(self._pose[:3]), self._pose[3:], kerb=kerb, beside=beside)
            tips = frame.mount + line[self._tracked, -1] @ rotation_of(self._pose[3:]).T
            tips[~force[self._tracked].any(axis=1)] = np.nan
            trail.append(tips)
        return frame, np.array(trail).reshape(len(trail), len(self._tracked), 3)

    def _status(self):
        for payload in self._watch.take('/diagnostics'):
            for name, values in decode_diagnostics(payload):
                if name == f'{self._watch.name.lstrip("/")}: simulation':
                    self._values = values
        silent = time.monotonic() - self._watch.heard > SILENT
        gone = silent and not self._watch.present
        return Status(
            'gone' if gone else 'paused' if silent else 'running', max(self._last, 0.0),
            self._number('real-time factor asked', 1.0),
            0.0 if silent else self._number('real-time factor reached', 0.0),
            int(self._number('late chunks', 0)), self._number('estimated error', 0.0),
            float(self._omega),
            f'waiting for {self._watch.name} to come back' if gone else self._watch.answer,
            tuple(text for key, text in self._values.items() if key.startswith('warning: ')))

    def _number(self, key, default):
        try:
            return float(self._values[key])
        except (KeyError, ValueError):
            return default

    def command(self, topic, values):
        """Publish a command."""
        self._watch.command(topic, check_command(self.scene, topic, values),
                            self.scene.run.stamped_cmd_vel)

    def pause(self, hold):
        """Hold, or go on."""
        self._watch.pause(hold)

    def step(self):
        """Have it simulate one chunk, while paused."""
        self._watch.step()

    def reset(self):
        """Have it go back to its scene's start."""
        self._watch.reset()

    def set_factor(self, factor):
        """Take another real-time factor."""
        self._watch.set_factor(factor)

    def close(self):
        """Leave the graph."""
        self._watch.close()
