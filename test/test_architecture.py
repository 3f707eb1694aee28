"""Who may import whom: layers of our own modules, and one owner for each outside thing."""
import ast
from fnmatch import fnmatch
from graphlib import TopologicalSorter
from pathlib import Path

import pytest

PACKAGE = Path(__file__).resolve().parent.parent / 'bristle_ros'
FILES = {'.'.join(path.relative_to(PACKAGE).with_suffix('').parts): path
         for path in sorted(PACKAGE.rglob('*.py'))}

# From the bottom up: a module imports from its own layer and from those below, never upwards.
LAYERS = [
    ['__init__', 'physics.*', 'snapshot'],
    ['interrupt', 'scene_error', 'scene_keys', 'scene_sections', 'scene_names', 'scene_yaml',
     'scene', 'machine'],
    ['model*', 'cli'],
    ['stepper', 'simulation*'],
    ['budget', 'pace'],
    ['driver'],
    ['message_cdr', 'message_types', 'messages*'],
    ['bag_metadata', 'command_file', 'log', 'log_head', 'mcap_*', 'recorded', 'recording',
     'recover', 'replay', 'verify', 'offline*', 'sample_file', 'statics*', 'urdf', 'whole_file'],
    ['bench*'],
    ['report*', 'plot*'],
    ['node*', 'pacing', 'scene_verb', '__main__'],
]
# What a module may import of ours at all, where that is less than its layer would allow.
ONLY = {
    'physics.*': ['physics.*'],
    'snapshot': [],
    'messages': ['snapshot', 'message_cdr', 'message_types'],
    'messages_*': ['snapshot', 'message_cdr', 'messages'],
    'scene*': ['scene*', 'cli'],
    '__main__': ['__init__', 'interrupt', 'scene_error'],
}
# Outside packages and the modules that may import them; `time` is the wall clock.
OWNERS = {
    'numba': ['physics.jit', 'physics.lanes', 'physics.work_queue'],
    'llvmlite': ['physics.lanes', 'physics.work_queue'],
    'yaml': ['scene_yaml', 'bag_metadata'],  # scenes, and the metadata.yaml of a bag
    'rclpy': ['node*', 'replay*'],
    'mcap': ['mcap_*'],
    'matplotlib': ['report*', 'plot*'],
    'time': ['driver', 'node*', 'pacing', 'offline*', 'log', 'mcap_*', 'recording', 'replay*',
             'verify', 'simulation', 'statics*', 'bench*', 'report*'],
}


def matches(name, patterns):
    return any(fnmatch(name, pattern) for pattern in patterns)


def layer_of(name):
    return next((i for i, patterns in enumerate(LAYERS) if matches(name, patterns)), None)


def imports(name):
    """Return what a module imports, anywhere in it: (our modules, names of outside packages)."""
    ours, outside = set(), set()
    parent = name.split('.')[:-1]
    for node in ast.walk(ast.parse(FILES[name].read_text(encoding='utf-8'))):
        if isinstance(node, ast.Import):
            found = [alias.name for alias in node.names]
        elif isinstance(node, ast.ImportFrom) and node.level:
            stem = parent[:len(parent) - node.level + 1] + (node.module or '').split('.')
            stem = '.'.join(['bristle_ros', *filter(None, stem)])
            found = [f'{stem}.{alias.name}' for alias in node.names]
        elif isinstance(node, ast.ImportFrom):
            found = [f'{node.module}.{alias.name}' for alias in node.names]
        else:
            continue
        for full in found:
            head, _, rest = full.partition('.')
            if head != 'bristle_ros':
                outside.add(head)
            else:
                owner = [part for part in (rest, rest.rpartition('.')[0]) if part in FILES]
                ours.add(owner[0] if owner else '__init__')
    return ours - {name}, outside


def test_the_test_sees_imports():
    ours, outside = imports('scene')
    assert {'scene_error', 'scene_yaml'} <= ours
    assert 'math' in outside
    assert 'physics.jit' in imports('physics.contact')[0]
    assert 'numba' in imports('physics.jit')[1]


@pytest.mark.parametrize('name', FILES)
def test_imports_go_down(name):
    layer = layer_of(name)
    assert layer is not None, f'{name} is in no layer: place it in LAYERS'
    above = {other for other in imports(name)[0]
             if layer_of(other) is None or layer_of(other) > layer}
    assert not above, f'{name} imports from above: {sorted(above)}'
    for pattern, allowed in ONLY.items():
        if fnmatch(name, pattern):
            extra = {other for other in imports(name)[0] if not matches(other, allowed)}
            assert not extra, f'{name} may import only {allowed} of ours, not {sorted(extra)}'


@pytest.mark.parametrize('package', OWNERS)
def test_outside_things_have_one_owner(package):
    users = {name for name in FILES if package in imports(name)[1]}
    assert not {name for name in users if not matches(name, OWNERS[package])}


def test_no_cycles():
    list(TopologicalSorter({name: imports(name)[0] for name in FILES}).static_order())


def test_no_module_is_a_drawer():
    drawers = {'utils', 'util', 'base', 'common', 'manager', 'helpers', 'misc'}
    assert not {name for name in FILES if name.rpartition('.')[2] in drawers}
