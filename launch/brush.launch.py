"""
Start a brush and bring it up: `ros2 launch bristle_ros brush.launch.py scene:=tilted_sweep`.

Transitions are events, not `LifecycleNode(autostart=True)`, which launch_ros has since 0.26.7 only.
"""
from pathlib import Path

from ament_index_python.packages import get_package_share_directory
from launch import LaunchDescription
from launch.actions import (DeclareLaunchArgument, EmitEvent, OpaqueFunction,
                            RegisterEventHandler, Shutdown)
from launch.event_handlers import OnProcessStart
from launch.events import matches_action
from launch.substitutions import LaunchConfiguration
from launch_ros.actions import LifecycleNode
from launch_ros.event_handlers import OnStateTransition
from launch_ros.events.lifecycle import ChangeState
from lifecycle_msgs.msg import Transition

ARGUMENTS = (
    ('scene', 'cutting_brush', 'a scene of this package by name, or the path of a scene file'),
    ('log', '', 'path of the log to write; empty: none, or what the scene says'),
    ('namespace', '', 'of the node and its topics: one for each brush'),
    ('use_sim_time', 'false', 'whether time comes from /clock'),
    ('autostart', 'true', 'whether to configure and activate the node'))
TRUE = ('true', '1', 'yes', 'on')


def generate_launch_description():
    """Declare the arguments; the node is made when their values are known."""
    declared = [DeclareLaunchArgument(name, default_value=default, description=text)
                for name, default, text in ARGUMENTS]
    return LaunchDescription([*declared, OpaqueFunction(function=_brush)])


def scene_path(scene):
    """Return the path of a scene that is named as in `config/`, or given as a path."""
    if Path(scene).suffix or '/' in scene:
        return str(Path(scene).expanduser())
    config = Path(get_package_share_directory('bristle_ros')) / 'config'
    path = config / f'{scene}.yaml'
    if not path.exists():
        names = ', '.join(sorted(found.stem for found in config.glob('*.yaml')))
        raise RuntimeError(f'scene:={scene}: there is no such scene; give a path or one of {names}')
    return str(path)


def _brush(context):
    value = {name: LaunchConfiguration(name).perform(context).strip() for name, _, _ in ARGUMENTS}
    # The transitions come from here, so that `autostart:=false` holds whatever the scene says.
    parameters = {'run.autostart': False, 'use_sim_time': value['use_sim_time'].lower() in TRUE}
    if value['log']:
        parameters['log.path'] = value['log']
    node = LifecycleNode(
        package='bristle_ros', executable='brush_node', name='brush_node',
        namespace=value['namespace'], parameters=[scene_path(value['scene']), parameters],
        output='screen', emulate_tty=True, on_exit=Shutdown())
    if value['autostart'].lower() not in TRUE:
        return [node]

    def change(transition):
        return EmitEvent(event=ChangeState(
            lifecycle_node_matcher=matches_action(node), transition_id=transition))

    return [
        RegisterEventHandler(OnStateTransition(
            target_lifecycle_node=node, start_state='configuring', goal_state='inactive',
            entities=[change(Transition.TRANSITION_ACTIVATE)])),
        RegisterEventHandler(OnProcessStart(
            target_action=node, on_start=[change(Transition.TRANSITION_CONFIGURE)])),
        node]
