"""
Start a brush: `ros2 launch bristle_ros brush.launch.py scene:=tilted_sweep log:=run1`.

The node brings itself up (run.autostart), so that nothing here depends on launch_ros' own
autostart, which came with 0.26.7. Two brushes: two_brushes.launch.py.
"""
from pathlib import Path

from ament_index_python.packages import (get_package_prefix, get_package_share_directory,
                                         PackageNotFoundError)
from bristle_ros.messages import robot_description
from bristle_ros.scene import from_arguments, load
from launch import LaunchDescription
from launch.actions import DeclareLaunchArgument, OpaqueFunction, Shutdown
from launch.substitutions import LaunchConfiguration
from launch_ros.actions import Node
from launch_ros.parameter_descriptions import ParameterValue
import yaml

ARGUMENTS = (
    ('scene', 'cutting_brush', 'a scene of this package by name, or the path of a scene file'),
    ('params', '', 'what to change in the scene: the path of another parameter file, or values '
                   "such as '{drive.mean_speed: 8.0}'"),
    ('log', '', 'path of the log to write; empty: none, or what the scene says'),
    ('namespace', '', 'of the node and its topics: one for each brush'),
    ('frame_prefix', '', 'goes before every frame, such as left/; empty: what the scene says'),
    ('use_sim_time', 'false', 'whether time comes from /clock'),
    ('autostart', 'true', 'whether the node configures and activates itself'),
    ('rsp', 'false', 'whether robot_state_publisher draws the board and gives the transform '
                     'brush_mount to brush'),
    ('rviz', 'false', 'whether to open RViz'))
WANTED = {'rsp': 'robot_state_publisher', 'rviz': 'rviz2'}
SPELLINGS = {'true': True, '1': True, 'yes': True, 'false': False, '0': False, 'no': False}


def generate_launch_description():
    """Declare the arguments; the nodes are made when their values are known."""
    declared = [DeclareLaunchArgument(name, default_value=default, description=text)
                for name, default, text in ARGUMENTS]
    return LaunchDescription([*declared, OpaqueFunction(function=_brush)])


def _brush(context):
    value = {name: LaunchConfiguration(name).perform(context).strip() for name, _, _ in ARGUMENTS}
    truth = {name: _truth(name, value[name])
             for name in ('use_sim_time', 'autostart', 'rsp', 'rviz')}
    _look_up(truth)
    scene, changes = _scene_path(value['scene']), _changes(value['params'])
    given = {'use_sim_time': truth['use_sim_time'], 'run.autostart': truth['autostart']}
    # Texts are marked as such, or a log called 1 would become a number.
    if value['log']:
        given['log.path'] = ParameterValue(value['log'], value_type=str)
    if value['frame_prefix']:
        given['run.frame_prefix'] = ParameterValue(value['frame_prefix'], value_type=str)
    if truth['rsp']:
        given['run.publish_tf'] = 'mount'   # one authority for each transform
    nodes = [Node(
        package='bristle_ros', executable='brush_node', name='brush_node',
        namespace=value['namespace'], parameters=[scene, *changes, given],
        output='screen', on_exit=Shutdown())]
    if truth['rsp']:
        nodes.append(_state_publisher(value, truth, scene, changes))
    if truth['rviz']:
        nodes.append(_rviz(value, truth))
    return nodes


def _look_up(truth):
    """Raise RuntimeError where a package is missing, before anything is started."""
    for name, package in WANTED.items():
        if truth[name]:
            try:
                get_package_prefix(package)
            except PackageNotFoundError:
                raise RuntimeError(f'{name}:=true: the package {package} is not installed: '
                                   f'install it, or leave {name} out') from None


def _state_publisher(value, truth, scene, changes):
    described = _described(scene, changes)
    return Node(
        package='robot_state_publisher', executable='robot_state_publisher',
        namespace=value['namespace'], output='screen', parameters=[{
            'robot_description': ParameterValue(robot_description(described), value_type=str),
            'frame_prefix': ParameterValue(value['frame_prefix'], value_type=str),
            'use_sim_time': truth['use_sim_time']}])


def _described(path, changes):
    """Return the scene that the node will make of a scene file and what is laid over it."""
    if changes and isinstance(changes[0], dict):
        return load(path, _flat(changes[0]))
    words = [word for file in (path, *changes) for word in ('--params-file', file)]
    return from_arguments(['--ros-args', *words])


def _flat(values, head=''):
    found = {}
    for key, value in values.items():
        inner = isinstance(value, dict)
        found |= _flat(value, f'{head}{key}.') if inner else {f'{head}{key}': value}
    return found


def _rviz(value, truth):
    config = Path(get_package_share_directory('bristle_ros')) / 'config/brush.rviz'
    space = f'/{value["namespace"].strip("/")}' if value['namespace'].strip('/') else ''
    return Node(
        package='rviz2', executable='rviz2', namespace=value['namespace'],
        arguments=['-d', str(config), '-f', f'{value["frame_prefix"]}road'],
        remappings=[(f'/{topic}', f'{space}/{topic}') for topic in (
            'bristle_markers', 'contact_wrench', 'tip_wrench', 'tip_pose', 'robot_description')],
        parameters=[{'use_sim_time': truth['use_sim_time']}])


def _changes(text):
    """Return the parameters to lay over the scene, as a list of one or none."""
    if not text:
        return []
    if not text.startswith('{'):
        return [str(Path(text).expanduser())]
    try:
        values = yaml.safe_load(text)
    except yaml.YAMLError as error:
        problem = str(error).partition('\n')[0]
        raise RuntimeError(f'params:={text}: is no YAML ({problem})') from None
    return [values]


def _truth(name, text):
    if text.lower() not in SPELLINGS:
        raise RuntimeError(f'{name}:={text}: must be true or false')
    return SPELLINGS[text.lower()]


def _scene_path(scene):
    if Path(scene).suffix or '/' in scene:
        return str(Path(scene).expanduser())
    config = Path(get_package_share_directory('bristle_ros')) / 'config'
    path = config / f'{scene}.yaml'
    if not path.exists():
        names = ', '.join(sorted(found.stem for found in config.glob('*.yaml')))
        raise RuntimeError(f'scene:={scene}: no such scene; give a path, or one of {names}')
    return str(path)
