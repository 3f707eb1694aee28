"""
A log as a page plays it: what it says at chunk ends, and its wires, simulated again.

A log holds one tip and the sums over all wires. All else follows from its scene and its commands,
to the last bit, and that is where the wires come from; until they are there, and where a log does
not begin at its run's start, they are drawn straight.
"""
from typing import NamedTuple

from bristle_ros.log import read_commands, Recording
from bristle_ros.messages import TOPICS, transforms_topic
from bristle_ros.scene import bristle_count, Scene, SceneError
import numpy as np

from .frame import COLUMNS, Frame, frame_of, resting_pose, rotation_of, tracked, trail_of

FRAMES = 4000           # kept of a log, at most,
MEMORY = 300_000_000    # and bytes of their wires
BATCH = 50              # frames that are sent at once
DATA, FRAMES_MADE, NOTE = 'data', 'frames', 'note'
_TOPICS = {topic.name: topic for topic in (*TOPICS, transforms_topic())}
_NEEDED = ('contact_wrench', 'joint_states')


class Logged(NamedTuple):
    """What a log says at n chunk ends."""

    scene: Scene
    rows: np.ndarray    # (n, len(COLUMNS)); stress is not logged: NaN
    theta: np.ndarray   # [rad] (n,)
    poses: np.ndarray   # (n, 7) mount centre [m] and quaternion x, y, z, w, on the road
    note: str           # that it was cut off or damaged, or ''

    @property
    def duration(self):
        """[s] from the run's start to the last chunk."""
        return float(self.rows[-1, 0])

    def at(self, t):
        """Return the number of the last row at or before t [s]; the first where there is none."""
        return max(0, int(np.searchsorted(self.rows[:, 0], t + 1e-9, side='right')) - 1)


def read(path):
    """Return the Logged of a log, also of one that was cut off; raise SceneError."""
    recording = Recording(path)
    scene, its = recording.scene, recording.integration_time_step
    chunk, latest = max(1, round(scene.run.chunk / its)), 0
    found = {name: {} for name in (*_NEEDED, '/tf')}
    for entry in recording.entries():
        values = found.get(entry.name)
        if values is None:
            continue
        if entry.name == _NEEDED[0] and entry.step // chunk > latest // chunk:
            latest = entry.step
        if entry.step == latest or entry.name == '/tf':
            try:
                values[entry.step] = _TOPICS[entry.name].decode(entry.message.data)
            except ValueError:
                continue    # of another sender, or damaged
    steps = sorted(found[_NEEDED[0]].keys() & found[_NEEDED[1]].keys())
    if not steps:
        raise SceneError('holds no outputs to show', source=str(path))
    poses = _poses(scene, steps, found['/tf'])
    wrench, joint = (np.array([found[name][step] for step in steps]) for name in _NEEDED)
    normal = np.array([rotation_of(pose[3:])[2] @ force for pose, force in zip(
        poses, wrench[:, :3])])
    rows = np.column_stack((np.array(steps) * its, joint[:, 1], normal, joint[:, 2],
                            joint[:, 2] * joint[:, 1], np.full(len(steps), np.nan)))
    assert rows.shape[1] == len(COLUMNS)
    note = recording.cut or (recording.damage[0] if recording.damage else '')
    return Logged(scene, rows, joint[:, 0], poses, note)


def _poses(scene, steps, transforms):
    """Return the mount's pose at each step: the last one before it that is logged."""
    if not transforms:
        position, orientation = resting_pose(scene)
        return np.tile((*position, *orientation), (len(steps), 1))
    known = sorted(transforms)
    at = np.searchsorted(known, steps, side='right') - 1
    return np.array([transforms[known[max(0, i)]][:7] for i in at])


class LogRun:
    """Reads a log and simulates it again; what child.main runs."""

    def __init__(self, connection, path):
        """Read; the page can play the log from then on."""
        self._connection, self._path = connection, path
        self._logged = read(path)

    def start(self):
        """Tell the page what the log says."""
        self._connection.send((DATA, self._logged))

    def obey(self, *order):
        """Have nothing to do: the page plays by itself."""

    def tell(self):
        """Simulate the log again, and send the frames."""
        stride, batch = _stride(self._logged.scene, self._logged), []
        try:
            for made in frames(self._path, self._logged, stride):
                batch.append(made)
                if len(batch) == BATCH:
                    self._connection.send((FRAMES_MADE, batch))
                    batch = []
        except SceneError as error:
            self._connection.send((NOTE, f'wires are drawn straight: {error.problem}'))
            return
        self._connection.send((FRAMES_MADE, batch))
        self._connection.send((NOTE, ''))


def frames(path, logged, stride):
    """
    Simulate a log again; yield (Frame, trail) of every stride-th chunk up to its end.

    Or up to where the run ended. Raises SceneError where the log does not begin at the start.
    """
    Recording(path).from_start()
    from bristle_ros.realtime import Driver
    from bristle_ros.simulation import MountPath, Simulation
    scene = logged.scene
    driver = Driver(Simulation(scene), paced=False)
    driver.mount = MountPath(scene)
    driver.schedule([event for _, event in read_commands(path, driver.its)])
    bristles = tracked(bristle_count(scene))
    for chunk in _chunks(driver, logged.duration, stride):
        yield (frame_of(driver.simulation, chunk.last, chunk.mount),
               trail_of(chunk.last, chunk.mount, bristles))


def _stride(scene, logged):
    """Return which of the chunks are kept, every first, second, ..."""
    nodes = bristle_count(scene) * (2 * scene.solver.elements + 1)
    kept = max(100, min(FRAMES, MEMORY // (12 * nodes)))
    return -(-round(logged.duration / scene.run.chunk) // kept) or 1


def _chunks(driver, duration, stride):
    """Run until `duration` [s]; yield every chunk whose number `stride` divides."""
    count = round(duration / (driver.chunk * driver.its))
    for number in range(1, count + 1):
        chunk = driver.run_chunk()
        if chunk.failure is not None:
            return
        if number % stride == 0:
            yield chunk


def straight_frame(logged, row, lines):
    """Return the Frame of a row of a log with the wires as they are given: (B, n, 3)."""
    return Frame(float(logged.rows[row, 0]), float(logged.theta[row]), lines,
                 np.zeros((len(lines), 3), np.float32), logged.poses[row, :3],
                 tuple(logged.poses[row, 3:].tolist()), exact=False)
