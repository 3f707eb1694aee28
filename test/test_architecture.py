"""Who may import whom: rooms in one order, and one owner for each outside thing."""
import ast
from fnmatch import fnmatch
from pathlib import Path
import sys

import pytest

PACKAGE = Path(__file__).resolve().parent.parent / 'bristle_ros'
FILES = {'.'.join(path.relative_to(PACKAGE).with_suffix('').parts).removesuffix('.__init__'): path
         for path in sorted(PACKAGE.rglob('*.py'))}

# From the bottom up: a room imports from the lines above its own, and from itself.
ORDER = """
    lazy              target
    physics.compiler
    physics.motion    scene
    physics.wire
    physics.contact
    physics.step
    simulation        command_line
    realtime          messages
    log
    node
    verbs             plot
    report            study             view
"""
LINE = {room: number for number, line in enumerate(ORDER.split('\n')) for room in line.split()}
# The package itself names what users call, and the command line every verb: at run time, by text.
TOP = ('__init__', '__main__')
ONLY = {'__main__': {'__init__', 'command_line', 'scene'}}
# Outside packages and the modules that may import them; `time` is the wall clock.
OWNERS = {
    'numba': ['physics.compiler.*'],
    'llvmlite': ['physics.compiler.*', 'target'],
    # scenes; the metadata.yaml of a bag; studies
    'yaml': ['scene.parameter_file', 'log.bag_metadata', 'study.plain_yaml'],
    'rclpy': ['node.*'],
    'mcap': ['log.file'],
    'matplotlib': ['report.*', 'plot.*', 'view.video'],
    'rich': ['verbs.simulate', 'study.progress'],
    'viser': ['view.main', 'view.page'],
    'dask': ['study.cluster'],
    'distributed': ['study.cluster'],
    'pyarrow': ['study.store'],
    'optuna': ['study.optimise'],
    'SALib': ['study.sensitivity'],
    'time': ['realtime.driver', 'realtime.pacing_thread', 'node.*', 'log.file', 'log.writer',
             'simulation.simulation', 'verbs.*', 'report.*', 'study.*', 'view.*'],
}


def room_of(name):
    """Return the room of a module, `physics.wire` or `log`; at the top of the package its name."""
    parts = name.split('.')
    depth = 2 if parts[0] == 'physics' else 1
    return '.'.join(parts[:depth]) if name != 'physics' else 'physics.compiler'


def imports(name):
    """Return what a module imports, anywhere in it: (our modules, names of outside packages)."""
    ours, outside = set(), set()
    parent = name.split('.') if FILES[name].name == '__init__.py' else name.split('.')[:-1]
    parent = [part for part in parent if part != '__init__']
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
    assert {'scene.error', 'scene.parameter_file'} <= imports('scene.scene')[0]
    assert 'math' in imports('scene.scene')[1]
    assert 'physics.wire' in imports('physics.contact.tip')[0]
    assert 'physics.contact.tip' in imports('physics.contact')[0]
    assert 'numba' in imports('physics.compiler.jit')[1]
    assert (room_of('physics.wire.chain'), room_of('log.file')) == ('physics.wire', 'log')


def test_every_room_has_its_line():
    rooms = {room_of(name) for name in FILES} - set(TOP) - {'physics'}
    assert rooms == set(LINE)


@pytest.mark.parametrize('name', sorted(set(FILES) - {'__init__'}))
def test_imports_go_down(name):
    ours = imports(name)[0]
    if name in ONLY:
        assert ours <= ONLY[name]
        return
    room = room_of(name)
    others = {other for other in ours if other != '__init__' and room_of(other) != room}
    above = {other for other in others if LINE[room_of(other)] >= LINE[room]}
    assert not above, f'{name} imports from its own line or above: {sorted(above)}'


@pytest.mark.parametrize('name', sorted(set(FILES) - {'__init__'}))
def test_others_import_what_a_room_gives_out(name):
    """Names of its __init__, or a module as a whole: no names from modules inside."""
    for node in ast.walk(ast.parse(FILES[name].read_text(encoding='utf-8'))):
        if isinstance(node, ast.ImportFrom) and not node.level:
            head, _, source = (node.module or '').partition('.')
            if head == 'bristle_ros' and source in FILES and room_of(source) != room_of(name):
                assert source == room_of(source), f'{name} reaches into {source}'


@pytest.mark.parametrize('package', OWNERS)
def test_outside_things_have_one_owner(package):
    users = {name for name in FILES if package in imports(name)[1]}
    assert not {name for name in users if not any(fnmatch(name, p) for p in OWNERS[package])}
    unused = {p for p in OWNERS[package] if not any(fnmatch(name, p) for name in users)}
    assert not unused, 'allowed, and not used'


def test_lazy_rooms_tell_readers_what_they_give_out():
    """What a type checker reads and what is imported when asked for are the same names."""
    checked = 0
    for name, path in FILES.items():
        code = path.read_text(encoding='utf-8')
        if path.name != '__init__.py' or 'lazily(' not in code:
            continue
        tree = ast.parse(code)
        typed = {(node.module, alias.name) for node in ast.walk(tree)
                 if isinstance(node, ast.ImportFrom) and node.level for alias in node.names}
        [places] = [ast.literal_eval(node.args[1]) for node in ast.walk(tree)
                    if isinstance(node, ast.Call) and getattr(node.func, 'id', '') == 'lazily']
        assert typed == {(module, given) for module, names in places.items() for given in names}
        modules = {part.rpartition('.')[2] for part in FILES if part.startswith(f'{name}.')}
        assert not modules & {given for _, given in typed}, 'a module would hide a name'
        checked += 1
    assert checked >= 6


def test_few_modules_stand_outside_rooms():
    assert len([path for path in FILES.values() if path.parent == PACKAGE]) <= 4


def test_no_module_is_a_drawer_or_hides_another():
    leaves = {name: name.rpartition('.')[2] for name in FILES}
    drawers = {'utils', 'util', 'base', 'common', 'manager', 'helpers', 'misc'}
    assert not {name for name, leaf in leaves.items() if leaf in drawers}
    assert not {name for name, leaf in leaves.items() if leaf in sys.stdlib_module_names}
    # but for the file of a folder's main class
    repeats = {name for name, leaf in leaves.items() if leaf == name.split('.')[-2:][0] != name}
    assert repeats == {'scene.scene', 'simulation.simulation'}
