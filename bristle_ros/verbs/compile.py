"""Compiles what scenes need, so that whatever runs them later starts at once: `compile`."""
from itertools import product
import os
from pathlib import Path

from bristle_ros.command_line import Parser, scene_files
from bristle_ros.scene import load, SceneError
from bristle_ros.target import CHOSEN, LEVELS, target


def main(argv):
    """Run the verb `compile`; return its exit code."""
    options = _parse(argv)
    paths = options.scenes or scene_files()
    if not paths:
        raise SceneError('none given, and none installed: name scene files', key='SCENE.yaml')
    scenes = {str(path): load(path) for path in paths}
    _choose(options.target)
    from bristle_ros.simulation import Simulation   # the compiler reads its target when loaded
    for path, energies in product(scenes, (False, True)):
        took = Simulation(scenes[path], energies=energies).compile_time
        print(f'{Path(path).stem}{", energy accounts" if energies else ""}: {took:.3g} s',
              flush=True)
    return 0


def _parse(argv):
    parser = Parser('compile', 'Compiles what scenes need into the cache of compiled kernels, or '
                    'loads it where it is there already: brush_node, view (without energy '
                    'accounts) and simulate (with them) then start at once.')
    parser.add_argument('scenes', nargs='*', metavar='SCENE.yaml',
                        help='default: all that come with the package')
    parser.add_argument('--target', choices=tuple(LEVELS),
                        help='level of x86-64 to compile for; default: the highest one that this '
                        'processor has, which is what all verbs run')
    return parser.parse_args(argv)


def _choose(level):
    """Have kernels compiled for a level, which the processor must have: they are run once."""
    own, order = target(), [*reversed(LEVELS)]
    if level in (None, own):
        return
    if own not in LEVELS or order.index(level) > order.index(own):
        raise SceneError(f'this processor has {own}: take that, or a lower level', key='--target',
                         value=level)
    os.environ[CHOSEN] = level
    target.cache_clear()
