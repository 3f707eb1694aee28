"""The reader of scene files against the one that ROS 2 has, spelling by spelling."""
import json
from pathlib import Path
import subprocess
import sys

from bristle_ros.scene.error import SceneError
from bristle_ros.scene.names import full_name, matches
from bristle_ros.scene.parameter_file import read_file, read_text
from bristle_ros.scene.scene import from_arguments, load
import pytest

SCALARS = """
2.07e11 1e5 2e-05 1.0e5 1e+5 1E5 1.e5 .5 5. -.5 +.5 +5 -5 0 -0 -0.0 00.5 1e05 0.0000000001 1e0
.inf .Inf .INF .iNF -.inf +.inf -.Inf inf Inf INF infinity Infinity -Infinity INFINITY +inf -inf
iNfInItY nan NaN .nan .NaN .NAN NAN -nan +nan nan(1) nan() -.nan in infin inf5 .infx
0x10 0X1F -0x10 0xfffffffff 0x 0xg 0x1p3 0x1.8p1 0x.8 0x1p-2000 0xffffffffffffffffffff
0o17 017 010 08 09.5 0b11 1_000 1_000.5 1:30 1:30.5 1,5 1.0f 1d5 1e5x e5 1e 1.5e+ . + +- --1 .e5
true True TRUE tRUE yes Yes YES yES on On ON y Y t no No NO off Off OFF n N false False FALSE f
null Null ~ "1.0" '1.0' "true" "" '' "a" !!float !!str !!int
9223372036854775807 9223372036854775808 -9223372036854775808 -9223372036854775809
1e308 1e309 1e400 -1e400 1e-307 1e-308 1e-310 1e-400 0e-400 0.0e999 4.9e-324
hello a/b run1.mcap 2026-01-01 2001-12-14t21:59:43.10-05:00 12:30 1.2.3 \u0661\u0662 \u00bd \u221e
""".split()
VALUES = [*SCALARS, '!!float 1', '!!int 5', '!!str 5', '!!str 1.5', '!!float "1"', '!!bool "yes"',
          '!!null x', '&x 5', '1.0 # comment', '1e 5', '"\\t1.0"', '|\n      1.5', '>-\n      1.5',
          '|-\n      2', '>-\n      yes', '[1, 0]', '[1.5, 0]', '[1.0, 0.0]', '[1.0, .inf]',
          '[1, a]', '[]', '[true, no]', '[1.0, true]', '["1", "2"]', '["x", 1.5]',
          '[[1.0], [2.0]]',
          '[1.5, 2e5, inf]', '[1.5,\n      2.5]', '\n      - 1.5\n      - 2.5', '[1, 2', '{}',
          '{b: 1}',
          '{b: {c: 1.5}, d: 2}', '*x', '', '"unfinished', '%a', '@a', '- 1', 'a: b', '9' * 30,
          '0.' + '1' * 60, '<<', '{<<: {b: 1}}', '{"b": 1, \'c\': 2}', '{1: 2, true: 3, 1.5: 4}',
          '{"": 1}', '[1, 2]]', '{? b : 1}']
TOP = '/**:\n  ros__parameters:\n'
DOCUMENTS = {
    'json': '{"/**": {"ros__parameters": {"a": {"b": 1e-5, "c": true, "d": "x", "e": [2.5]}}}}',
    'empty': '', 'comment': '# nothing\n', 'no keys': '/**:\n  ros__parameters: {}\n',
    'null parameters': '/**:\n  ros__parameters:\n', 'plain YAML': 'a: 1\n', 'a list': '- 1\n',
    'no node': 'ros__parameters:\n  a: 1\n', 'tab': f'{TOP}\ta: 1\n',
    'by name': 'brush_node:\n  ros__parameters:\n    a: 1\n',
    'by full name': '/brush_node:\n  ros__parameters:\n    a: 1\n',
    'any namespace': '/**/brush_node:\n  ros__parameters:\n    a: 1\n',
    'one level': '/*:\n  ros__parameters:\n    a: 1\n',
    'nested names': '/:\n  brush_node:\n    ros__parameters:\n      a: 1\n',
    'nested wildcard': '/**:\n  brush_node:\n    ros__parameters:\n      a: 1\n',
    'other nodes': 'talker:\n  ros__parameters:\n    a: 7\n/x/y:\n  ros__parameters:\n    b: 8\n'
                   f'{TOP}    a: 1\n',
    'an empty other node': f'talker: {{}}\n{TOP}    a: 1\n',
    'name then all': f'brush_node:\n  ros__parameters:\n    a: 0.5\n{TOP}    a: 0.6\n    b: 1\n',
    'all then name': f'{TOP}    a: 5\n    c: 1\nbrush_node:\n  ros__parameters:\n    a: 0.6\n',
    'two documents': f'{TOP}    a: 1\n---\n{TOP}    b: 2\n',
    'dotted': f'{TOP}    a.b: 1\n    a: {{c: 2}}\n    a.d.e: 3\n',
    'byte order mark': f'\ufeff{TOP}    a: 1\n',
    'deep': f'{TOP}    a: {{b: {{c: {{d: 1}}}}, e: 2}}\n    f: 3\n',
    'beside parameters': f'{TOP}    a: 1\n  c: 2\n', 'alias': f'{TOP}    a: &x 1\n    b: *x\n',
    'anchored map': f'{TOP}    a: &x {{c: 1}}\n', 'directives': f'%YAML 1.1\n---\n{TOP}    a: 1\n',
    'windows lines': '/**:\r\n  ros__parameters:\r\n    a: 1.5\r\n',
    'latin-1': b'/**: {\xe9: 1}\n',
    'utf-16': f'{TOP}    a: 1\n'.encode('utf-16'), 'nul': f'{TOP}    a: "\0"\n',
}
OVERRIDES = ['1', '1e5', '0.5', 'yes', '[1, 0]', '[1.5, 0]', '""', '"x"', 'a: b', '#x', '  1e5',
             'inf',
             "'1'", '[1', '{a: 1}', '- 1', '*x', '!!str 1', 'a b', '[a, b]', '[]', '1 # one', '~']

SECTIONS = """
/** /* ** * /**/** /*/* /**/* /*/** brush_node /brush_node /*/brush_node /**/brush_node
**/brush_node */brush_node */left/brush_node /left/brush_node left/brush_node /right/brush_node
/left/* /left/** left/** /**/left/brush_node /a/*/brush_node /*/*/brush_node /a/**/brush_node
/a/b/brush_node /a/** /left /**/left /left/brush xbrush_node /left/xbrush_node other /left/other
/**/other talker
""".split()
REMAPS = ['', '__ns:=/left', '__ns:=/a/b', '__node:=other', '__name:=other',
          '__ns:=/left __node:=other', '__ns:=/ __node:=other __node:=third',
          '__ns:=/left __ns:=/right', 'brush_node:__ns:=/left', 'talker:__ns:=/left',
          'brush_node:__node:=other other:__ns:=/left', '__node:=other brush_node:__ns:=/left',
          'x:__node:=other __node:=x', 'tip_pose:=pose __ns:=/left']


@pytest.fixture(scope='module')
def rcl():
    """Return a function from lists of node arguments to what rcl makes of them, all at once."""
    def ask(cases):
        done = subprocess.run(
            [sys.executable, str(Path(__file__).with_name('rcl_reader.py'))], text=True,
            timeout=600, capture_output=True,
            input=''.join(json.dumps(case) + '\n' for case in cases))
        answers = [json.loads(line) for line in done.stdout.splitlines()]
        assert len(answers) == len(cases), done.stderr
        return answers
    return ask


def typed(value):
    """Name a value as rclpy does: type and repr."""
    if value is None:
        return ['NOT_SET', 'None']
    item = value[0] if isinstance(value, list) else value
    name = {bool: 'BOOL', int: 'INTEGER', float: 'DOUBLE', str: 'STRING'}[type(item)]
    return [name + '_ARRAY' * isinstance(value, list), repr(value)]


def ours(path):
    try:
        entries = read_file(path.read_bytes(), str(path))
    except SceneError as error:
        return str(error)
    return {entry.key: typed(entry.value) for entry in entries
            if entry.section.endswith('brush_node') or set(entry.section) <= set('/*')}


def compare(names, theirs, mine):
    wrong = []
    for name, their, our in zip(names, theirs, mine, strict=True):
        if isinstance(their, dict):
            # rcl keeps a name for a map without keys; it holds nothing.
            their = {key: value for key, value in their.items()
                     if value[0] != 'NOT_SET' or (isinstance(our, dict) and key in our)}
        same = their == our if isinstance(their, dict) else isinstance(our, str)
        if not same:
            wrong.append((name, their, our))
    assert not wrong, '\n'.join(f'{name!r}: rcl {their}, ours {our}' for name, their, our in wrong)


def test_files_mean_what_rcl_makes_of_them(rcl, tmp_path):
    texts = {f'a: {value}': f'{TOP}    a: {value}\n' for value in VALUES} | DOCUMENTS
    paths = []
    for number, text in enumerate(texts.values()):
        paths.append(tmp_path / f'{number}.yaml')
        paths[-1].write_bytes(text if isinstance(text, bytes) else text.encode())
    theirs = rcl([['--params-file', str(path)] for path in paths])
    assert sum(isinstance(answer, dict) for answer in theirs) > 100  # and not one long refusal
    compare(texts, theirs, [ours(path) for path in paths])


def test_overrides_mean_what_rcl_makes_of_them(rcl):
    def our(text):
        try:
            return {'a': typed(read_text(text, '-p'))}
        except SceneError as error:
            return str(error)
    theirs = rcl([['-p', f'a:={text}'] for text in OVERRIDES])
    assert sum(isinstance(answer, dict) for answer in theirs) > 10
    compare(OVERRIDES, theirs, [our(text) for text in OVERRIDES])


@pytest.mark.parametrize('rules', REMAPS)
def test_sections_are_for_the_nodes_that_rcl_gives_them_to(rcl, tmp_path, rules):
    """Of one parameter for each section, named by its number, the node gets what rcl gives it."""
    path = tmp_path / 'nodes.yaml'
    path.write_text(''.join(f'"{section}":\n  ros__parameters:\n    p{number}: 1\n'
                            for number, section in enumerate(SECTIONS)), encoding='utf-8')
    arguments = ['--params-file', str(path)]
    for rule in rules.split():
        arguments += ['-r', rule]
    [theirs] = rcl([arguments])
    node = full_name(['--ros-args', *arguments], 'brush_node')
    assert {SECTIONS[int(name[1:])] for name in theirs} == {
        section for section in SECTIONS if matches(section, node)}
    assert theirs, 'at least /** is for every node'


def test_each_of_two_nodes_takes_its_own_section(tmp_path):
    path = tmp_path / 'two.yaml'
    path.write_text("""
/**: {ros__parameters: {gravity: 1.0, road: {penetration: 0.01}}}
/left/brush_node: {ros__parameters: {road: {penetration: 0.02}, log: {path: left}}}
/right/brush_node: {ros__parameters: {road: {penetration: 0.03}, nonsense: 1}}
""", encoding='utf-8')

    def node(namespace, notes=None):
        return from_arguments(['--ros-args', '--params-file', str(path), '-r',
                               f'__ns:={namespace}'], notes=notes)
    left = node('/left')
    assert (left.gravity, left.road.penetration, left.log.path) == (1.0, 0.02, 'left')
    assert left == load(path, node='/left/brush_node') == load(path, node='left/brush_node')
    with pytest.raises(SceneError, match='two.yaml:4: nonsense = 1: unknown key'):
        node('/right')
    with pytest.raises(SceneError, match='two.yaml:4: nonsense'):
        load(path)  # offline, every brush_node counts
    assert node('/middle').road.penetration == 0.01
    path.write_text('/left/brush_node: {ros__parameters: {gravity: 1.0}}\n', encoding='utf-8')
    notes = []
    assert node('/middle', notes).gravity == 9.81
    assert notes == [f'{path}: has no section for /middle/brush_node, only for /left/brush_node']
    with pytest.raises(SceneError, match='no section for /middle/brush_node, only for /left/'):
        load(path, node='/middle/brush_node')


def test_node_and_offline_make_the_same_scene(root, rcl):
    """The shipped scenes hold the same values for rcl as for us."""
    paths = sorted((root / 'config').glob('*.yaml'))
    assert paths
    for path in paths:
        [theirs] = rcl([['--params-file', str(path)]])
        assert theirs == ours(path)
        assert from_arguments(['--ros-args', '--params-file', str(path)]) == load(path)


def test_an_override_wins_where_rcl_forgets_it(rcl, tmp_path):
    """Why the node does not take rcl's word: an integer in the file beats a double given by -p."""
    path = tmp_path / 'scene.yaml'
    path.write_text(f'{TOP}    gravity: 1\n', encoding='utf-8')
    arguments = ['--params-file', str(path), '-p', 'gravity:=0.5']
    assert rcl([arguments]) == [{'gravity': ['INTEGER', '1']}]  # the day this fails, rcl is mended
    assert from_arguments(['--ros-args', *arguments]).gravity == 0.5
