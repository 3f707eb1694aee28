"""What a page of figures needs of a run: read from a log, or from the arrays of `simulate`."""
import csv
import math
from pathlib import Path
from typing import NamedTuple

from bristle_ros.messages import command_types, decode_diagnostics, TOPICS
from bristle_ros.scene import bristle_count, brush_rows, SceneError, start_speed
import numpy as np

_TOPICS = {topic.name: topic for topic in TOPICS}
_NEEDED = ('tip_pose', 'contact_wrench', 'joint_states')
_ARRAYS = ('t', 'theta', 'tip_position', 'contact_force', 'brush_torque', 'newton_iterations',
           'wall_time')


class Timing(NamedTuple):
    """How long the run took, as the page shows it."""

    t: np.ndarray           # [s] simulation time
    value: np.ndarray
    title: str
    unit: str
    real_time: float        # the value that real time would have; NaN where there is none
    delay: np.ndarray = np.empty(0)     # [s] (as t) behind the first chunk's pace, or empty
    told: str = ''          # what the node said of its pace at the end


class Series(NamedTuple):
    """A run as functions of time; n samples, SI units."""

    t: np.ndarray           # [s] (n,) simulation time
    tip: np.ndarray         # [m] (n, 3) bristle 0's tip, mount axes, from the mount centre
    normal_force: np.ndarray    # [N] (n,) of the road on the brush, along the road normal
    torque: np.ndarray      # [N m] (n,) of the drive on the brush, about +z
    timing: Timing
    commands: np.ndarray    # [s] when commands and resets took effect
    rest: tuple             # [m] (clamp, undeformed tip) of bristle 0 as (radius, z), or ()
    about: str              # one line: what was run


def read(path, begin=0.0, end=math.inf):
    """
    Read a log (an .mcap file or a bag directory, also one that was cut off), an .npz or a .csv.

    begin, end : [s] of simulation time between which samples are kept
    Raises SceneError when it cannot be used, or fewer than two samples are left.
    """
    path = Path(path).expanduser()
    if not begin < end:
        raise SceneError(f'must come before --to {end:g}', key='--from', value=begin)
    if path.suffix == '.npz':
        series = _of_arrays(path, _arrays_of_npz(path))
    elif path.suffix == '.csv':
        series = _of_arrays(path, _arrays_of_table(path))
    else:
        series = _of_log(path)
    kept = (series.t >= begin) & (series.t <= end)
    if np.count_nonzero(kept) < 2:
        raise SceneError(f'fewer than two samples from {begin:g} s to {end:g} s: it has '
                         f'{len(series.t)}' + (f' from {series.t[0]:g} s to {series.t[-1]:g} s'
                                               if len(series.t) else ''), source=str(path))
    for name in ('t', 'tip', 'normal_force', 'torque'):
        if not np.isfinite(getattr(series, name)).all():
            raise SceneError(f'{name} is not finite everywhere: the file is damaged',
                             source=str(path))
    timing, commands = series.timing, series.commands
    timed = (timing.t >= begin) & (timing.t <= end)
    return series._replace(
        t=series.t[kept], tip=series.tip[kept], normal_force=series.normal_force[kept],
        torque=series.torque[kept],
        timing=timing._replace(t=timing.t[timed], value=timing.value[timed],
                               delay=timing.delay[timed] if len(timing.delay) else timing.delay),
        commands=commands[(commands >= begin) & (commands <= end)])


def _of_log(path):
    from bristle_ros.log import is_event, Recording
    recording = Recording(path)
    scene, its = recording.scene, recording.integration_time_step
    steps, values = {name: [] for name in _NEEDED}, {name: [] for name in _NEEDED}
    walls, changes, told = [], [], ''
    commands = command_types(True)
    for entry in recording.entries():
        if entry.name in steps:
            try:
                values[entry.name].append(_TOPICS[entry.name].decode(entry.message.data))
            except ValueError as error:
                raise SceneError(f'{entry.name} at step {entry.step}: {error}',
                                 source=str(path)) from None
            steps[entry.name].append(entry.step)
            if entry.name == _NEEDED[0]:
                walls.append(entry.message.publish_time)
        elif entry.name == '/diagnostics':
            told = _pace(entry.message.data) or told
        elif entry.name in commands or is_event(entry, 'reset'):
            changes.append(entry.step)
    # A log that was cut off or damaged may lack some topics of a sample.
    complete = set(steps[_NEEDED[0]]).intersection(*(steps[name] for name in _NEEDED[1:]))
    pose, wrench, joint = (_rows(name, steps[name], values[name], complete) for name in _NEEDED)
    step = np.array(sorted(complete), dtype=float)
    rest, normal = _geometry(scene)
    return Series(step * its, pose[:, :3], wrench[:, :3] @ normal, joint[:, 2],
                  _chunks(steps[_NEEDED[0]], walls, its)._replace(told=told),
                  np.array(changes, dtype=float) * its, rest, _about(scene))


def _rows(name, steps, values, complete):
    rows = {step: value for step, value in zip(steps, values) if step in complete}
    return np.array([rows[step] for step in sorted(rows)]).reshape(
        len(rows), len(_TOPICS[name].fields))


def _geometry(scene):
    """Return ((radius, z) of clamp and undeformed tip), and the road normal in mount axes."""
    row, tilt, azimuth = brush_rows(scene)[0], scene.road.attack_angle, scene.road.tilt_azimuth
    rest = ((row.radius, 0.0), (row.tip_radius, -row.tip_depth))
    # The low side of the tilted brush faces the azimuth: there the normal leans away.
    return rest, np.array([-math.sin(tilt) * math.cos(azimuth),
                           -math.sin(tilt) * math.sin(azimuth), math.cos(tilt)])


def _chunks(steps, walls, its):
    """Return the wall time that each chunk took: samples of a chunk are logged together."""
    steps, walls = np.array(steps, dtype=float), np.array(walls, dtype=np.int64)
    last = np.flatnonzero(np.diff(walls, append=walls[-1:] + 1))
    took = np.diff(walls[last]) * 1e-6
    simulated = np.diff(steps[last]) * its * 1e3
    return Timing(steps[last[1:]] * its, took, 'Wall time of each chunk', 'wall time [ms]',
                  float(np.median(simulated)) if len(simulated) else math.nan,
                  (np.cumsum(took) - np.cumsum(simulated)) * 1e-3)


def _pace(payload):
    """Return what diagnostics say of late chunks and wall time given up, or ''."""
    try:
        [(_, told), *_] = decode_diagnostics(payload)
        return (f'{told["late chunks"]} late chunks, '
                f'{told["wall time given up [s]"]} s given up')
    except (ValueError, KeyError):
        return ''


def _about(scene):
    drive = scene.drive
    wires = bristle_count(scene) * scene.brush.wires_per_bristle
    road = (f'penetration {scene.road.penetration * 1e3:.4g} mm' if scene.contact.enabled
            else 'no road')
    return (f'{wires} wire{"s" if wires > 1 else ""}, {start_speed(drive) * 30 / math.pi:.4g} rpm '
            f'at the start, {road}, step {scene.solver.integration_time_step * 1e3:.4g} ms')


def _arrays_of_npz(path):
    try:
        with np.load(path, allow_pickle=False) as file:
            return {name: file[name] for name in _ARRAYS}
    except OSError as error:
        raise SceneError(f'cannot be read ({error.strerror or error})', source=str(path)) from None
    except KeyError as error:
        name = str(error.args[0]).split()[0]
        raise SceneError(f'holds no array {name}: name a file that `simulate --output` wrote',
                         source=str(path)) from None
    except Exception as error:  # zipfile, zlib and numpy each have their own for a mangled file
        raise SceneError(f'is no .npz file that can be read ({error})',
                         source=str(path)) from None


def _arrays_of_table(path):
    """Return the arrays that the columns of a table of `simulate` are; it has no run time."""
    try:
        with open(path, newline='', encoding='utf-8') as file:
            names = next(csv.reader(file), [])
            bristles = sum(name.startswith('contact_force_') and name.endswith('_z')
                           for name in names)
            wanted = {
                't': ['t'], 'theta': ['theta'], 'newton_iterations': ['newton_iterations'],
                'tip_position': [f'tip_position_0_{axis}' for axis in 'xyz'],
                'contact_force': [f'contact_force_{i}_z' for i in range(max(1, bristles))],
                'brush_torque': ['brush_torque_z']}
            columns = [name for group in wanted.values() for name in group]
            missing = [name for name in columns if name not in names]
            if missing:
                raise SceneError(f'has no column {missing[0]}: name a file that '
                                 '`simulate --output` wrote', source=str(path))
            rows = np.loadtxt(file, delimiter=',', ndmin=2,
                              usecols=[names.index(name) for name in columns])
    except OSError as error:
        raise SceneError(f'cannot be read ({error.strerror or error})', source=str(path)) from None
    except (ValueError, csv.Error) as error:
        raise SceneError(f'is no table that can be read ({error})', source=str(path)) from None
    column = dict(zip(columns, rows.reshape(-1, len(columns)).T))
    found = {name: np.array([column[part] for part in group]).T
             for name, group in wanted.items()}
    zeros = np.zeros((len(rows), 2))
    return {**{name: found[name][:, 0] for name in ('t', 'theta', 'newton_iterations')},
            'tip_position': found['tip_position'][:, None],
            'contact_force': np.stack([0.0 * found['contact_force'], 0.0 * found['contact_force'],
                                       found['contact_force']], axis=-1),
            'brush_torque': np.column_stack((zeros, found['brush_torque'])),
            'wall_time': np.array(0.0)}


def _of_arrays(path, arrays):
    t, theta = arrays['t'], arrays['theta']
    try:
        x, y, z = arrays['tip_position'][:, 0].T
        force, newton = arrays['contact_force'][:, :, 2].sum(axis=1), arrays['newton_iterations']
        tip = np.column_stack((x * np.cos(theta) - y * np.sin(theta),
                               x * np.sin(theta) + y * np.cos(theta), z))
        torque, wall = -arrays['brush_torque'][:, 2], float(arrays['wall_time'])
        rows = np.column_stack((t, tip, force, torque, newton))
    except (IndexError, TypeError, ValueError) as error:
        raise SceneError(f'its arrays do not fit together ({error})', source=str(path)) from None
    bristles = arrays['contact_force'].shape[1]
    about = f'{bristles} bristle{"s" if bristles > 1 else ""} (normal force: one wire of each)'
    if wall > 0.0 and len(rows):
        about += f', simulated at {t[-1] / wall:.3g} times real time'
    return Series(t, tip, force, torque, Timing(
        t[1:], np.diff(newton).astype(float), 'Work from sample to sample', 'Newton iterations',
        math.nan),
        np.empty(0), (), about)
