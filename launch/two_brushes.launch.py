"""
Start the left and the right brush of a sweeper: `ros2 launch bristle_ros two_brushes.launch.py`.

Each has its namespace, frame prefix, place on the sweeper and log. Commands go to each, such as
/left/cmd_brush_speed; a cmd_vel for both is published to both.
"""
import math
from pathlib import Path

from ament_index_python.packages import get_package_prefix, PackageNotFoundError
from launch import LaunchDescription
from launch.actions import (DeclareLaunchArgument, IncludeLaunchDescription, LogInfo,
                            OpaqueFunction)
from launch.launch_description_sources import PythonLaunchDescriptionSource
from launch.substitutions import LaunchConfiguration
from launch_ros.actions import Node

ARGUMENTS = (
    ('scene', 'cutting_brush', 'of both: a scene of this package by name, or a path'),
    ('log', '', 'of the logs to write: log:=run1 gives run1_left and run1_right; empty: none'),
    ('forward', '0.0', 'mount centres from the base of the sweeper, forward [m]'),
    ('spacing', '1.6', 'from the left mount centre to the right one [m]'),
    ('use_sim_time', 'false', 'whether time comes from /clock'),
    ('autostart', 'true', 'whether the nodes configure and activate themselves'),
    ('rsp', 'false', 'whether robot_state_publisher draws the boards'))
PASSED_ON = ('scene', 'use_sim_time', 'autostart', 'rsp')


def generate_launch_description():
    """Declare the arguments; the nodes are made when their values are known."""
    declared = [DeclareLaunchArgument(name, default_value=default, description=text)
                for name, default, text in ARGUMENTS]
    return LaunchDescription([*declared, OpaqueFunction(function=_brushes)])


def _brushes(context):
    value = {name: LaunchConfiguration(name).perform(context).strip() for name, _, _ in ARGUMENTS}
    forward, spacing = (_number(name, value[name]) for name in ('forward', 'spacing'))
    one = PythonLaunchDescriptionSource(str(Path(__file__).with_name('brush.launch.py')))
    actions = []
    for side, left in (('left', 0.5 * spacing), ('right', -0.5 * spacing)):
        arguments = {
            **{name: value[name] for name in PASSED_ON},
            'namespace': side, 'frame_prefix': f'{side}/', 'log': _log(value['log'], side),
            'params': f'{{sweeper.mount_position: [{forward!r}, {left!r}]}}'}
        actions.append(IncludeLaunchDescription(one, launch_arguments=list(arguments.items())))
    return actions + _common_road()


def _common_road():
    """Join the two roads, which are one: both have their origin below the sweeper's base."""
    try:
        get_package_prefix('tf2_ros')
    except PackageNotFoundError:
        return [LogInfo(msg='left/road and right/road stay apart: tf2_ros is not installed')]
    return [Node(package='tf2_ros', executable='static_transform_publisher', name=f'road_{side}',
                 arguments=['--frame-id', 'road', '--child-frame-id', f'{side}/road'])
            for side in ('left', 'right')]


def _log(path, side):
    if not path:
        return ''
    place = Path(path)
    return str(place.with_name(f'{place.stem}_{side}{place.suffix}'))


def _number(name, text):
    try:
        value = float(text)
    except ValueError:
        value = math.nan
    if not math.isfinite(value):
        raise RuntimeError(f'{name}:={text}: must be a number')
    return value
