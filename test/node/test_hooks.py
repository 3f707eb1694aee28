"""What the node takes of rclpy that rclpy does not promise: each hook by its name."""
import inspect
import re

import rclpy
import rclpy.executors
from rclpy.lifecycle import LifecycleNode
from rclpy.node import Node

TESTED = '7.1.6'    # of ros-jazzy-rclpy: what requirements.txt pins


def test_a_node_keeps_its_parameter_overrides(environment):
    # parameters.py: the names in qos_overrides that have no effect are told
    context = rclpy.Context()
    rclpy.init(context=context)
    try:
        node = Node('hooks', context=context, cli_args=[
            '--ros-args', '-p', 'qos_overrides./a.publisher.depth:=3'])
        assert hasattr(node, '_parameter_overrides'), (
            f'rclpy has no Node._parameter_overrides (tested with {TESTED}): parameters.py')
        assert list(node._parameter_overrides) == ['qos_overrides./a.publisher.depth']
        node.destroy_node()
    finally:
        rclpy.shutdown(context=context)


def test_a_lifecycle_node_answers_change_state_by_a_callback_that_can_be_wrapped(environment):
    # lifecycle.py: a transition that the state does not have would end the executor
    context = rclpy.Context()
    rclpy.init(context=context)
    try:
        node = LifecycleNode('hooks', context=context)
        assert hasattr(node, '_service_change_state'), (
            f'rclpy has no LifecycleNode._service_change_state (tested with {TESTED}): '
            'lifecycle.py')
        assert callable(node._service_change_state.callback), (
            f"rclpy's services have no callback (tested with {TESTED}): lifecycle.py")
        node.destroy_node()
    finally:
        rclpy.shutdown(context=context)
    assert re.search(r'\w+\.callback\b', inspect.getsource(rclpy.executors)), (
        'the executor no longer looks the callback of a service up when it calls it')


def test_the_pinned_version_is_the_tested_one(root):
    assert f'ros-jazzy-rclpy=={TESTED}\n' in (root / 'requirements.txt').read_text(), (
        'another rclpy is pinned: try the hooks above with it, then write it down as TESTED')
