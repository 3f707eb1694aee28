"""Layouts, URDF and launch files: every name in them is one that the node has."""
import ast
import json
import math
from pathlib import Path
import re
from xml.etree import ElementTree

from bristle_ros.messages import encode as messages
from bristle_ros.messages import robot_description
from bristle_ros.scene.scene import from_parameters, keys, load
from examples import random_snapshot
import numpy as np
import pytest
from rosbags.typesys import get_typestore, Stores
import yaml

ROOT = Path(__file__).resolve().parent.parent
STORE = get_typestore(Stores.ROS2_JAZZY)
PUBLISHED = {f'/{topic.name}': topic.type for topic in messages.TOPICS} | {
    '/bristle_markers': messages.MARKERS, '/tf': messages.TF,
    '/diagnostics': messages.DIAGNOSTICS, '/clock': messages.CLOCK}
OF_OTHERS = {'/robot_description': messages.STRING}      # robot_state_publisher's
# What the displays of RViz take; source: rviz_default_plugins.
DISPLAYS = {'MarkerArray': messages.MARKERS, 'Wrench': messages.WRENCH, 'Pose': messages.POSE,
            'RobotModel': messages.STRING}


def value_at(topic, path):
    """Return the number at a path such as `wrench.force[0]` of a message of the topic."""
    [found] = [one for one in messages.TOPICS if f'/{one.name}' == topic]
    value = STORE.deserialize_cdr(found.encode(random_snapshot(1), 5), found.type)
    for name, index in re.findall(r'(\w+)(?:\[(\d+)\])?', path):
        value = getattr(value, name)
        value = value[int(index)] if index else value
    return float(value)


def test_rviz():
    manager = yaml.safe_load((ROOT / 'config/brush.rviz').read_text())['Visualization Manager']
    assert manager['Global Options']['Fixed Frame'] == messages.ROAD_FRAME
    assert manager['Views']['Current']['Target Frame'] == messages.MOUNT_FRAME
    seen = set()
    for display in manager['Displays']:
        topic = (display.get('Topic') or display.get('Description Topic') or {}).get('Value')
        if topic:
            seen.add(topic)
            assert DISPLAYS[display['Class'].rpartition('/')[2]] == (PUBLISHED | OF_OTHERS)[topic]
    assert '/bristle_markers' in seen


def test_foxglove():
    layout = json.loads((ROOT / 'config/brush_foxglove.json').read_text())
    panels = layout['configById']
    placed = re.findall(r"'(\w+!\w+)'", str(layout['layout']))
    assert sorted(placed) == sorted(panels), 'every panel has its place, once'
    for kind in ('Publish', 'Diagnostic'):
        assert any(name.startswith(kind) for name in panels)
    for name, panel in panels.items():
        for topic in panel.get('topics', {}):
            assert topic in PUBLISHED
        for path in panel.get('paths', []):
            assert math.isfinite(value_at(*path['value'].split('.', 1))), name
        if name.startswith('Publish'):
            commands = messages.command_types(True)
            assert commands[panel['topicName'].lstrip('/')] == panel['datatype']
            assert json.loads(panel['value']).keys() == {'data'}
        if name.startswith('Diagnostic'):
            assert PUBLISHED[panel['topicToRender']] == messages.DIAGNOSTICS


def test_plotjuggler():
    root = ElementTree.parse(ROOT / 'config/brush_plotjuggler.xml').getroot()
    subscribed = {topic.get('name') for topic in root.iter('topic')}
    curves = {curve.get('name') for curve in root.iter('curve')}
    assert subscribed == {f'/{name.split("/")[1]}' for name in curves}
    for name in curves:
        _, topic, *path = name.split('/')
        if topic == 'joint_states':     # it names the values of joints by their names
            joint, kind = path
            assert joint == messages.JOINT
            path = [f'{kind}[0]']
        assert math.isfinite(value_at(f'/{topic}', '.'.join(path)))


def test_urdf():
    text = (ROOT / 'urdf/brush.urdf').read_text()
    default = load(ROOT / 'config/cutting_brush.yaml')
    assert text == robot_description(default), 'made of the default scene'
    scene = from_parameters({'brush.mount_radius': 0.0, 'brush.mount_angle': 0.6,
                             'bristle.length': 0.3}, 'test')
    for robot in (ElementTree.fromstring(text), ElementTree.fromstring(robot_description(scene))):
        [joint] = robot.findall('joint')
        assert (joint.get('name'), joint.get('type')) == (messages.JOINT, 'continuous')
        assert joint.find('parent').get('link') == messages.MOUNT_FRAME
        assert joint.find('child').get('link') == messages.BRUSH_FRAME
        assert joint.find('axis').get('xyz') == '0 0 1'
        assert joint.find('origin') is None, 'the angle of joint_states is all'
        assert {link.get('name') for link in robot.findall('link')} == {
            messages.MOUNT_FRAME, messages.BRUSH_FRAME}
        for cylinder in robot.iter('cylinder'):
            assert min(float(cylinder.get('radius')), float(cylinder.get('length'))) > 0.0
    # The first wire goes from its clamp to its tip; rpy turns about fixed axes.
    visual = next(v for v in robot.iter('visual') if v.find('.//box') is not None)
    middle, (_, pitch, yaw) = (np.array(visual.find('origin').get(name).split(), dtype=float)
                               for name in ('xyz', 'rpy'))
    along = 0.15 * np.array([np.cos(yaw) * np.sin(pitch), np.sin(yaw) * np.sin(pitch),
                             np.cos(pitch)])
    np.testing.assert_allclose(middle + along, 0.0, atol=1e-6)
    np.testing.assert_allclose(
        middle - along, 0.3 * np.array([np.sin(0.6), 0.0, -np.cos(0.6)]), atol=1e-6)


def launch_file(name):
    """Return what a launch file defines that needs no launch: it is not on PyPI."""
    tree = ast.parse((ROOT / 'launch' / name).read_text())
    tree.body = [node for node in tree.body if not isinstance(node, ast.ImportFrom)
                 or node.module.split('.')[0] not in ('launch', 'launch_ros')]
    scope = {'__file__': str(ROOT / 'launch' / name),
             'PythonLaunchDescriptionSource': None, 'LaunchDescription': None}
    exec(compile(tree, name, 'exec'), scope)
    return scope


def test_launch_arguments_fit_together():
    one, two = launch_file('brush.launch.py'), launch_file('two_brushes.launch.py')
    names = [name for name, *_ in one['ARGUMENTS']]
    assert {'scene', 'params', 'log', 'namespace', 'use_sim_time', 'rviz', 'autostart',
            'rsp', 'frame_prefix'} == set(names)
    assert set(two['PASSED_ON']) <= set(names) & {name for name, *_ in two['ARGUMENTS']}
    known = {key.name for key in keys()}
    for name in ('brush.launch.py', 'two_brushes.launch.py'):
        text = (ROOT / 'launch' / name).read_text()
        used = set(re.findall(r'\b(?:run|log|sweeper)\.[a-z_]+', text)) - {'log.path'}
        assert used
        assert {key for key in used if key not in ('run.autostart',)} <= known
    for topic in re.findall(r"'(\w+)'", re.search(
            r'for topic in \((.+?)\)', (ROOT / 'launch/brush.launch.py').read_text(),
            re.DOTALL).group(1)):
        assert f'/{topic}' in PUBLISHED | OF_OTHERS


@pytest.mark.parametrize(('name', 'package'), [
    ('rsp', 'robot_state_publisher'), ('rviz', 'rviz2')])
def test_what_is_not_installed_is_said_before_anything_starts(name, package):
    one = launch_file('brush.launch.py')
    asked = []

    def prefix(package):
        asked.append(package)
        raise one['PackageNotFoundError'](package)

    one['get_package_prefix'] = prefix
    one['_look_up']({'rsp': False, 'rviz': False})
    assert asked == []
    with pytest.raises(RuntimeError, match=f'{name}:=true: the package {package} is not inst'):
        one['_look_up']({'rsp': name == 'rsp', 'rviz': name == 'rviz'})
    assert asked == [package]


def test_what_launch_files_make_of_their_arguments(tmp_path):
    one, two = launch_file('brush.launch.py'), launch_file('two_brushes.launch.py')
    assert [one['_truth']('rviz', text) for text in ('true', 'False', '1', 'no')] == [
        True, False, True, False]
    with pytest.raises(RuntimeError, match='rviz:=maybe: must be true or false'):
        one['_truth']('rviz', 'maybe')
    assert one['_changes']('') == []
    assert one['_changes']('{drive.mean_speed: 8.0}') == [{'drive.mean_speed': 8.0}]
    assert one['_changes']('~/more.yaml') == [str(Path('~/more.yaml').expanduser())]
    path = str(ROOT / 'config/cutting_brush.yaml')
    given = '{brush: {mount_radius: 0.2}, sweeper.mount_position: [1, 0.5]}'
    scene = one['_described'](path, one['_changes'](given))
    assert (scene.brush.mount_radius, scene.sweeper.mount_position) == (0.2, (1.0, 0.5))
    (tmp_path / 'more.yaml').write_text('/**: {ros__parameters: {brush: {mount_radius: 0.3}}}')
    scene = one['_described'](path, one['_changes'](str(tmp_path / 'more.yaml')))
    assert scene.brush.mount_radius == 0.3
    with pytest.raises(RuntimeError, match='is no YAML'):
        one['_changes']('{drive: [')
    assert one['_scene_path']('./here.yaml') == 'here.yaml'
    assert two['_log']('', 'left') == ''
    assert two['_log']('logs/run1', 'left') == 'logs/run1_left'
    assert two['_log']('run1.mcap', 'right') == 'run1_right.mcap'
    with pytest.raises(RuntimeError, match='spacing:=wide: must be a number'):
        two['_number']('spacing', 'wide')
