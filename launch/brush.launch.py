"""
Start a brush: `ros2 launch bristle_ros brush.launch.py scene:=tilted_sweep log:=run1`.

The node brings itself up (run.autostart), so that nothing here depends on launch_ros' own
autostart, which came with 0.26.7. Two brushes: include this file twice, with a namespace each.
"""
from pathlib import Path

from ament_index_python.packages import get_package_share_directory
from launch import LaunchDescription
from launch.actions import DeclareLaunchArgument, OpaqueFunction, Shutdown
from launch.substitutions import LaunchConfiguration
from launch_ros.actions import Node

ARGUMENTS = (
    ('scene', 'cutting_brush', 'a scene of this package by name, or the path of a scene file'),
    ('log', '', 'path of the log to write; empty: none, or what the scene says'),
    ('namespace', '', 'of the node and its topics: one for each brush'),
    ('use_sim_time', 'false', 'whether time comes from /clock'),
    ('autostart', 'true', 'whether the node configures and activates itself'))
SPELLINGS = {'true': True, '1': True, 'yes': True, 'false': False, '0': False, 'no': False}


def generate_launch_description():
    """Declare the arguments; the node is made when their values are known."""
    declared = [DeclareLaunchArgument(name, default_value=default, description=text)
                for name, default, text in ARGUMENTS]
    return LaunchDescription([*declared, OpaqueFunction(function=_brush)])


def _brush(context):
    value = {name: LaunchConfiguration(name).perform(context).strip() for name, _, _ in ARGUMENTS}
    parameters = {'use_sim_time': _truth('use_sim_time', value['use_sim_time']),
                  'run.autostart': _truth('autostart', value['autostart'])}
    if value['log']:
        parameters['log.path'] = value['log']
    return [Node(
        package='bristle_ros', executable='brush_node', name='brush_node',
        namespace=value['namespace'], parameters=[_scene_path(value['scene']), parameters],
        output='screen', emulate_tty=True, on_exit=Shutdown())]


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
