"""What the verbs' command lines share: errors on one line, and the scene with its overrides."""
import argparse

from bristle_ros.scene import load, SceneError


class Parser(argparse.ArgumentParser):
    """An argument parser whose errors are one line; options must be written out in full."""

    def __init__(self, verb, description):
        """Name the verb as the user calls it."""
        super().__init__(prog=f'bristle_ros {verb}', description=description, allow_abbrev=False)

    def error(self, message):
        """Leave with exit code 2."""
        line = ' '.join(message.split())
        self.exit(2, f'{self.prog}: {line} (--help tells the arguments)\n')


def check_range(options, name, low, high):
    """Raise SceneError where the number of option --`name` is none of low to high, or NaN."""
    value = getattr(options, name.replace('-', '_'))
    if not low <= value <= high:
        raise SceneError(f'must be a number from {low:g} to {high:g}', key=f'--{name}',
                         value=value)


def add_scene(parser, *, optional=False):
    """Add the arguments SCENE.yaml and -p key:=value."""
    parser.add_argument('scene', metavar='SCENE.yaml', nargs='?' if optional else None,
                        help='a scene file, which is a ROS 2 parameter file')
    parser.add_argument('-p', '--param', metavar='KEY:=VALUE', action='append', default=[],
                        dest='overrides', help='override a key of the scene; may be given often')
    parser.add_argument('--node', metavar='NAME', help='take the sections that are for this node, '
                        'such as /left/brush_node; default: all that end in brush_node')


def load_scene(options):
    """Return the Scene that arguments parsed after `add_scene` ask for; raise SceneError."""
    overrides = {}
    for rule in options.overrides:
        key, assigned, value = rule.partition(':=')
        if not assigned or not key or not value:
            raise SceneError(f'{rule!r} is not an override: write key:=value', source='-p')
        overrides[key] = value
    return load(options.scene, overrides, options.node)
