"""The `scene` verb: what a scene may say, and whether a file says it."""
from bristle_ros.command_line import add_scene, load_scene, Parser
from bristle_ros.scene import describe_keys, to_yaml


def main(arguments):
    """List the keys, or print the complete scene that a file makes; return the exit code."""
    parser = Parser('scene', 'Lists the keys of a scene, or checks a scene file.')
    parser.add_argument('--keys', action='store_true',
                        help='list every key with unit, default, range and meaning')
    add_scene(parser, optional=True)
    options = parser.parse_args(arguments)
    if options.keys == (options.scene is not None):
        parser.error('give either --keys or a scene file')
    print(describe_keys() if options.keys else to_yaml(load_scene(options)).rstrip('\n'))
    return 0
