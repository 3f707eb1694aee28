#!/usr/bin/env python3
"""
Print docs/reference.md, made from the code: tools/make_reference.py > docs/reference.md.

Verbs, keys and arrays are read from the modules that define them, topics and services from a node
that is brought up for it. What they mean is written here; a name without a meaning is an error,
and so is a meaning without a name.
"""
import json
import os
from pathlib import Path
import sys

ROOT = Path(__file__).resolve().parent.parent
sys.path.insert(0, str(ROOT))
os.environ.setdefault('ROS_AUTOMATIC_DISCOVERY_RANGE', 'OFF')

from bristle_ros.__main__ import VERBS  # noqa: E402
from bristle_ros.messages.encode import TF  # noqa: E402
from bristle_ros.scene.presets import PRESETS  # noqa: E402
from bristle_ros.scene.scene import from_parameters, keys  # noqa: E402
from bristle_ros.scene.error import spell  # noqa: E402
from bristle_ros.simulation.snapshot import AIR_ARRAYS, DRIVE_ARRAYS, NPZ_ARRAYS  # noqa: E402

HEAD = """# Reference

Made from the code by `tools/make_reference.py`; a test fails when it is stale. SI units and
radians everywhere. Names without a leading `/` are relative: a namespace goes before them. `~` is
the node's own name, `brush_node` unless it is remapped.
"""
PUBLISHED = {
    'contact_wrench': 'road on brush, summed over all wires, about the mount centre; frame '
                      '`brush_mount`',
    'tip_wrench': "road on bristle 0's tip, at the tip (no torque); frame `road`",
    'mount_wrench': 'brush on sweeper, about the mount centre; frame `brush_mount`',
    'mount_wrench_mean': 'its mean over the chunk, from all steps: what another simulator should '
                         'apply; only with `mount.enabled` or `run.carried`',
    'tip_pose': "bristle 0's tip; frame `brush_mount`, x of the pose along the wire, y along the "
                'breadth',
    'joint_states': '`brush_joint`: angle, speed, and the torque of the drive on the brush about '
                    '+z',
    'bristle_markers': 'bristles (lines), road (a plate under the brush; where that is not level, '
                       'faces of the surface near it) and the contact force wherever a wire '
                       'touches, at its tip or along it (arrows, 0.5 m/N, at most a bristle '
                       'long); made only while somebody subscribes, `run.marker_rate` times a '
                       'second',
    '/tf': '`road` to `brush_mount` to `brush`, see `run.publish_tf`; `road` has its origin below '
           "the sweeper's base at the start; made only while somebody subscribes, and only where "
           'tf2_msgs is installed',
    '~/events': 'JSON, kept for those who come later: start, commands, timeouts, resets and load '
                'decisions as they took effect, and the failure that ends a run; `event`, `step` '
                'and a `number` without gaps, `topic` and `values` of commands',
    '~/scene': 'JSON, kept for those who come later: the scene file, processor and versions, '
               'step and origin of time, names of topics. With it what `ros2 bag` records or '
               'converts can be used like a log',
    '/diagnostics': 'each second: real-time factor asked and reached, late chunks, estimated '
                    'error, Newton failures, log backlog, refused commands, and what makes '
                    'the run doubtful (a value `warning: ...` each; WARN where results are '
                    'senseless)',
    '/clock': 'simulation time, at most 100 Hz of wall time but at each `~/step`; only with '
              '`run.publish_clock`',
}
SUBSCRIBED = {
    'cmd_brush_speed': 'speed of the brush [rad/s], in place of `drive.mean_speed`; changes at '
                       'most by `drive.max_acceleration`. With `drive.mode: motor` the speed '
                       'without load',
    'cmd_vel': "sweeper's velocity: `linear.x`, `linear.y` [m/s], `angular.z` [rad/s]; a Twist "
               'when `run.stamped_cmd_vel` is false. With `run.command_timeout`, one whose stamp '
               'is older is refused',
    'cmd_penetration': 'depth of the undeformed tip below the road [m]; the road moves at most at '
                       '`road.max_rate`',
    'cmd_mount': 'where the mount (`brush_mount` in `road`) is to be, and its velocity (mount '
                 'axes), `run.chunk` after it takes effect. Without `mount.enabled` or '
                 '`run.carried` the brush halts while the first one has what it needs compiled, '
                 'or loaded. The way there is cubic in position and in the rotation vector: '
                 'velocities are continuous, accelerations jump at the ends of chunks, and wires'
                 ' are told of a jump at a command (second order stays), but not where a way '
                 'ends without a next one. From the first one on `cmd_vel` and `cmd_penetration`'
                 ' are refused, until `~/reset`. Without another the velocity stays, for '
                 '`run.command_timeout` if that is given; then it brakes by '
                 '`sweeper.max_acceleration` and `sweeper.max_yaw_acceleration`',
    'cmd_drive_torque': 'torque on the brush [N m], at once; only with `drive.mode: torque`',
}
SERVICES = {
    '~/pause': '`true` holds at the end of the chunk that is running, `false` goes on',
    '~/step': 'one chunk more, while paused',
    '~/reset': "back to the scene's start with the next chunk; simulation time goes on",
}
# Not of the node that is brought up here: where simulation_interfaces is installed; a test
# compares these names with what is served then.
STANDARD = {
    '~/step_simulation': ('StepSimulation', '`steps` chunks (`run.chunk`), while paused'),
    '~/reset_simulation': ('ResetSimulation', 'as `~/reset`, for `SCOPE_DEFAULT` and '
                           '`SCOPE_STATE`; others are not supported, as time goes on'),
    '~/set_simulation_state': ('SetSimulationState', 'playing and paused as `~/pause`; stopped is '
                               'paused and reset with the next chunk'),
    '~/get_simulation_state': ('GetSimulationState', 'playing, paused or stopped; paused while '
                               'the node is not active'),
    '~/get_simulator_features': ('GetSimulatorFeatures', 'which of all these there are'),
    '~/get_entity_state': ('GetEntityState', 'of `brush_mount` and `brush`, at the end of the '
                           'last chunk: pose and twist in axes of `road`; acceleration is NaN'),
}
ARRAYS = {
    't': ('n', 's', 'simulation time'),
    'theta': ('n', 'rad', 'angle of the brush'),
    'omega': ('n', 'rad/s', 'its speed'),
    'tip_position': ('n, B, 3', 'm', 'tips in brush axes (x along the radius of bristle 0, z '
                     'along the brush axis, away from the road), from the mount centre'),
    'tip_position_road': ('n, B, 3', 'm', 'tips in road axes (z up), from the mount centre'),
    'tip_orientation': ('n, B, 4', '1', "quaternions x, y, z, w of the tips' sections in brush "
                        'axes: x along the wire, y along the breadth'),
    'contact_force': ('n, B, 3', 'N', 'road on the whole wire in road axes, mean over the last '
                      'step; z is up'),
    'contact_impulse': ('n, B, 3', 'N s', 'its sum since t = 0'),
    'mount_force': ('n, B, 3', 'N', 'wire on board in brush axes; with a clamp on a polygon '
                    '(`solver.time_step`) its damping is the mean over the step'),
    'mount_moment': ('n, B, 3', 'N m', "the same, about the wire's clamp"),
    'mount_damping_force': ('n, B, 3', 'N', 'its part from `damping.stiffness`, x along the '
                            'radius of that bristle'),
    'brush_force': ('n, 3', 'N', 'brush on sweeper, all wires, mount axes'),
    'brush_torque': ('n, 3', 'N m', 'the same, about the mount centre'),
    'energy_kinetic': ('n', 'J', 'of the motion relative to the brush frame'),
    'energy_elastic': ('n', 'J', 'strain and contact spring'),
    'energy_dissipated': ('n', 'J', 'damping, friction and impact since t = 0'),
    'work_external': ('n', 'J', 'all other work since t = 0; kinetic + elastic + dissipated '
                      'equals it, up to discretisation'),
    'newton_iterations': ('n', '1', 'running count, summed over bristles'),
    'substeps': ('n', '1', 'running count, summed over bristles'),
    'clamp_stress': ('n, B, 4', 'Pa', 'axial stress at the clamp, tension positive, at the '
                     'corners (+y, +z), (-y, +z), (-y, -z), (+y, -z) of the section (y along the '
                     'breadth), from mount_force and mount_moment; shear and torsion left out'),
    'clamp_stress_min': ('n, B, 4', 'Pa', 'its least over all steps and sub-steps since the '
                         'sample before'),
    'clamp_stress_max': ('n, B, 4', 'Pa', 'its largest'),
    'air_force': ('n, B, 3', 'N', 'of still air on the whole wire, road axes; with `air.density` '
                  'above 0'),
    'tip_force': ('n, B, 3', 'N', 'the part of contact_force at the tip'),
    'wire_gap': ('n, B', 'm', 'least gap of any contact point, the tip among them, as the law '
                 'sees it; inf where there is no road'),
    'contact_length': ('n, B', 'm', 'of wire that the touching points beside the tip stand for: '
                       'an element each'),
    'base_pose': ('n, 3', 'm, m, rad', "x, y and heading of the sweeper's base on the road; of a "
                  'mount that is carried, its own'),
    'drive_torque': ('n', 'N m', 'of the drive on the brush; with `drive.mode: motor` or '
                     '`torque`, as the next one'),
    'drive_work': ('n', 'J', 'what it has done since t = 0'),
    'wall_time': ('', 's', 'stepping alone'),
    'compile_time': ('', 's', 'all that was compiled or loaded before'),
}
# What every lifecycle node has; ROS 2 documents it.
OF_ROS = ('/rosout', '/parameter_events', '~/transition_event', '~/change_state', '~/get_state',
          '~/get_available_states', '~/get_available_transitions', '~/get_transition_graph',
          '~/describe_parameters', '~/get_parameter_types', '~/get_parameters',
          '~/list_parameters', '~/set_parameters', '~/set_parameters_atomically',
          '~/get_type_description')


def table(head, rows):
    """Return the lines of a Markdown table."""
    return [' | '.join(('', *cells, '')).strip()
            for cells in (head, ['---'] * len(head), *rows)]


def with_meaning(names, meanings, what):
    """Return (name, meaning) pairs; leave where the two do not name the same."""
    if set(names) != set(meanings):
        sys.exit(f'{what}: without a meaning {sorted(set(names) - set(meanings))}, gone '
                 f'{sorted(set(meanings) - set(names))}: see {Path(__file__).name}')
    return list(meanings.items())


def graph():
    """Bring a node up; return its published, subscribed and served names with their types."""
    from bristle_ros.node.lifecycle import BrushNode
    import rclpy
    rclpy.init(args=['--ros-args', '-r', '__ns:=/ns', '--log-level', 'warn'])
    scene = from_parameters({'run.publish_clock': True, 'contact.enabled': False,
                             'mount.enabled': True, 'solver.elements': 1}, 'tables')
    node = BrushNode(scene, print, wall_ns=lambda: 0)
    node.trigger_configure()
    found = [
        _entities((one.topic_name, one.msg_type) for one in node.publishers),
        _entities((one.topic_name, one.msg_type) for one in node.subscriptions),
        _entities((one.srv_name, one.srv_type) for one in node.services)]
    found[0].setdefault('/tf', TF)      # also where tf2_msgs is not installed
    node.finish()
    rclpy.shutdown()
    return found


def presets():
    """Return the section on solver.preset, with what was measured of each."""
    kept = json.loads((ROOT / 'docs/presets.json').read_text(encoding='utf-8'))
    lines = ['', '## Presets', '',
             '`solver.preset: draft | standard | reference`, in a scene file or by `-p`, fills '
             'keys of `solver` that', 'are left out, when the scene is read; logs have what came '
             'of it.', '']
    lines += table(('preset', 'fills'), [
        (f'`{name}`', ', '.join(f'`{key}: {spell(value)}`' for key, value in keys_.items()))
        for name, keys_ in PRESETS.items()])
    processor = kept['machine']['cpu'].split(',')[0]
    lines += ['', f'Measured {kept["date"]} on one core ({processor}), median of '
              f'{kept["repeats"]}, runs of {kept["duration"]:g} s.', 'Errors in % against a '
              'converged run of 24 elements at 10 us: tip path of the first wire, impulse per',
              '5 ms of all wires together, means of the normal force and the torque from '
              f'{kept["means_from"]:g} s on.', '']
    apart = [row['scene'] for row in kept['rows']
             if row['preset'] == 'reference' and row['impulse'] > 1.0]
    if apart:
        lines[-1:] = [f'In {", ".join(apart)} not even `reference` has the impulses within 1 %: '
                      'nothing there repeats in detail.', '']
    disturbed = sum(row['disturbed'] for row in kept['rows'])
    if disturbed:
        count = kept['repeats'] * len(kept['rows'])
        lines[-1:] = [f'{disturbed} of {count} timings were disturbed by other work on the '
                      'machine: compare paces within a scene.', '']
    lines += table(('scene', 'preset', 'path', 'impulse', 'mean force', 'mean torque',
                    'times real time'), [
        (f'`{row["scene"]}`', row['preset'], *(f'{row[name]:g}' for name in (
            'tip', 'impulse', 'force', 'torque')), f'{row["times_real_time"][0]:g}')
        for row in kept['rows']])
    return lines


def _entities(pairs):
    found = {}
    for name, type_ in pairs:
        for full, short in (('/ns/brush_node/', '~/'), ('brush_node/', '~/'), ('/ns/', '')):
            if name.startswith(full):
                name = short + name[len(full):]
        package, kind, _ = type_.__module__.split('.')[:3]
        if name not in OF_ROS:
            found[name] = f'{package}/{kind}/{type_.__name__}'
    return found


def main():
    """Print the page."""
    published, subscribed, services = graph()
    lines = [HEAD, '## Verbs', '',
             '`ros2 run bristle_ros VERB`, `python3 -m bristle_ros VERB` or, in a checkout, '
             '`./run.sh VERB`;', '`VERB --help` tells its arguments.', '']
    lines += table(('verb', 'what it does'),
                   [(f'`{verb}`', does) for verb, (_, does) in VERBS.items()])
    for title, names, meanings in (
            ('Topics that the node publishes', published, PUBLISHED),
            ('Topics that the node subscribes to', subscribed, SUBSCRIBED),
            ('Services', services, SERVICES)):
        lines += ['', f'## {title}', '']
        lines += table(('name', 'type', 'meaning'),
                       [(f'`{name}`', names[name], meaning)
                        for name, meaning in with_meaning(names, meanings, title)])
    lines += ['', '## Services of simulators', '',
              'Where the package `simulation_interfaces` is installed; without it nothing of this '
              'is there.', '']
    lines += table(('name', 'type', 'meaning'),
                   [(f'`{name}`', f'simulation_interfaces/srv/{type_}', meaning)
                    for name, (type_, meaning) in STANDARD.items()])
    lines += ['', '## Parameters', '',
              'Keys of a scene file and parameters of the node alike. They can be set while the '
              'node is', 'unconfigured; after that, `run.real_time_factor` alone.', '']
    lines += table(('key', 'default', 'unit', 'meaning', 'range'),
                   [(f'`{key.name}`', f'`{spell(key.default)}`', key.unit, key.description,
                     key.range) for key in keys()])
    lines += presets()
    lines += ['', '## Arrays of `simulate --output FILE.npz`', '',
              'n samples of B bristles; one wire each, but for `brush_*`.', '']
    lines += table(('array', 'shape', 'unit', 'meaning'),
                   [(f'`{name}`', f'({meaning[0]})', *meaning[1:]) for name, meaning in
                    with_meaning((*NPZ_ARRAYS, *AIR_ARRAYS, *DRIVE_ARRAYS, 'wall_time',
                                  'compile_time'), ARRAYS, 'arrays')])
    print('\n'.join(lines))


if __name__ == '__main__':
    main()
