"""
Run as a program: what rcl makes of node arguments, read by a real rclpy node called brush_node.

One JSON list of arguments per line in; per line out, the parameters as name to [type, repr] or the
text of rcl's refusal. A process of its own, so that its environment is that of a node.
"""
import json
import sys

import rclpy
from rclpy.node import Node


def read(arguments):
    context = rclpy.Context()
    try:
        rclpy.init(args=['--ros-args', *arguments], context=context)
    except Exception as error:
        return str(error)
    try:
        node = Node('brush_node', context=context)
        found = {name: [parameter.type_.name, repr(parameter.value)]
                 for name, parameter in node._parameter_overrides.items()}
        node.destroy_node()
        return found
    finally:
        rclpy.shutdown(context=context)


if __name__ == '__main__':
    for line in sys.stdin:
        print(json.dumps(read(json.loads(line))), flush=True)
