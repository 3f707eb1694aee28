#!/usr/bin/env python3
"""
Send one command to a running brush: ./run.sh examples/command.py TOPIC VALUE...

cmd_brush_speed W       speed of the brush [rad/s]
cmd_penetration D       depth of the undeformed tip below the road [m]
cmd_drive_torque T      torque on the brush [N m], with drive.mode: torque
cmd_vel VX VY W         velocity of the sweeper [m/s], [m/s], [rad/s]

Waits for the brush's answer: exit code 0 when the command took effect, 1 when it was refused. A
brush that is paused answers when it goes on.
"""
import json
import sys
import time

from diagnostic_msgs.msg import DiagnosticArray
from geometry_msgs.msg import TwistStamped
import rclpy
from rclpy.qos import DurabilityPolicy, QoSProfile
from std_msgs.msg import Float64, String

PATIENCE = 10.0     # [s] for the brush to be found, and for its answer
QUIET = 0.3         # [s] after which no more events of before come
NODE = 'brush_node'


def twist(vx, vy, yaw_rate):
    """Return the message of cmd_vel."""
    message = TwistStamped()
    message.twist.linear.x, message.twist.linear.y = vx, vy
    message.twist.angular.z = yaw_rate
    return message


def number(value):
    """Return the message of the others."""
    return Float64(data=value)


MESSAGES = {'cmd_brush_speed': number, 'cmd_penetration': number, 'cmd_drive_torque': number,
            'cmd_vel': twist}


class Answer:
    """What the brush says: `~/events` when a command takes effect, /diagnostics of refusals."""

    def __init__(self, node, topic, values):
        """Listen."""
        self._topic, self._values = topic, values
        self.heard = self.refused = None    # when the last event came; how many were refused
        self.asked = False
        self.effect = self.refusal = ''
        kept = QoSProfile(depth=1000, durability=DurabilityPolicy.TRANSIENT_LOCAL)
        node.create_subscription(String, f'{NODE}/events', self._event, kept)
        node.create_subscription(DiagnosticArray, '/diagnostics', self._diagnostics, 10)

    def ready(self):
        """Whether what was before is known, so that what comes is the answer."""
        return self.refused is not None and self.heard and time.monotonic() > self.heard + QUIET

    def _event(self, message):
        event, self.heard = json.loads(message.data), time.monotonic()
        if self.asked and event.get('topic') == self._topic and event['values'] == self._values:
            self.effect = f'from step {event["step"]} on'

    def _diagnostics(self, message):
        for status in message.status:
            values = {pair.key: pair.value for pair in status.values}
            if status.name.startswith(f'{NODE}:') and 'refused commands' in values:
                count = int(values['refused commands'])
                self.refused = self.refused if self.asked else count
                if count > self.refused:
                    self.refusal = values['last refusal']


def main():
    """Wait until the brush listens, publish, and wait for its answer."""
    try:
        topic, *words = sys.argv[1:]
        values = [float(word) for word in words]
        message = MESSAGES[topic](*values)
    except (KeyError, TypeError, ValueError):
        sys.exit(__doc__.strip())
    rclpy.init()
    node = rclpy.create_node('command')
    answer = Answer(node, topic, values)
    publisher = node.create_publisher(type(message), topic, 10)

    def wait(ready, otherwise):
        deadline = time.monotonic() + PATIENCE
        while not ready():
            if time.monotonic() > deadline:
                sys.exit(otherwise)
            rclpy.spin_once(node, timeout_sec=0.05)

    wait(lambda: publisher.get_subscription_count() and answer.ready(),
         f'nobody listens to {topic}: is the brush running?')
    answer.asked = True
    publisher.publish(message)
    wait(lambda: answer.effect or answer.refusal, f'{topic}: sent, and no answer: is it paused?')
    if answer.refusal:
        sys.exit(f'refused: {answer.refusal}')
    print(f'{topic} {" ".join(words)}: {answer.effect}')


if __name__ == '__main__':
    main()
