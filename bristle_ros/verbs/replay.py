"""The `replay` verb: publishes the outputs of a log again, or has them verified."""
import argparse
import math
import sys

from bristle_ros.command_line import Parser
from bristle_ros.scene import SceneError

from .verify import TOLERANCE, verify


def _rate(text):
    try:
        rate = float(text)
    except ValueError:
        rate = math.nan
    if not 1e-6 <= rate <= 1e6:
        raise argparse.ArgumentTypeError(f'{text!r}: must be a number above 0, 1e-6 to 1e6')
    return rate


def main(argv=None):
    """Run the verb; returns its exit code."""
    argv = list(sys.argv[1:] if argv is None else argv)
    split = argv.index('--ros-args') if '--ros-args' in argv else len(argv)
    parser = Parser('replay', 'Publish the outputs of a log again, or check it.')
    parser.add_argument('log', help='an .mcap file or a bag directory, also one that was cut off')
    parser.add_argument('--rate', type=_rate, default=1.0, help='times the speed of the run')
    parser.add_argument('--loop', action='store_true', help='start again at the end')
    parser.add_argument('--verify', action='store_true',
                        help='simulate again and compare, without ROS')
    options = parser.parse_args(argv[:split])
    if options.verify:
        return _report(options.log, verify(options.log))
    from bristle_ros.node import publish_log
    try:
        publish_log.check()
    except ImportError as error:
        raise SceneError(f'publishing needs ROS 2 ({error}): use --verify, or install rclpy',
                         source='replay') from None
    count = publish_log.play(options.log, options.rate, options.loop, argv[split + 1:])
    print(f'{options.log}: published {count} messages')
    return 0


def _report(path, verdict):
    for text in verdict.elsewhere:
        print(f'{path}: not the same machine: {text}')
    if verdict.elsewhere:
        print(f'{path}: so values are compared to {TOLERANCE:g} relative')
    if verdict.cut:
        print(f'{verdict.cut}; compared is what is there')
    if verdict.difference:
        print(f'{path}: first difference: {verdict.difference}')
        return 1
    result = f'equal to {TOLERANCE:g} relative' if verdict.elsewhere else 'identical'
    print(f'{path}: {result}: {verdict.compared} messages, {verdict.applied} commands and resets, '
          f'{verdict.end:.9g} s')
    return 0
