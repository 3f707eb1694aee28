"""Samples made up for tests of messages and logs, and the chunks that hold them."""
import sys

from bristle_ros.realtime.driver import Chunk
from bristle_ros.scene.scene import from_parameters
from bristle_ros.simulation.mount_path import Pose
from bristle_ros.simulation.snapshot import Snapshot
import numpy as np


def random_snapshot(seed, bristles=2):
    rng = np.random.default_rng(seed)
    shapes = {'tip_orientation': (bristles, 4), 'tip_orientation_mount': (bristles, 4),
              'brush_force': (3,), 'brush_torque': (3,), 'contact_force_mount': (3,),
              'contact_torque_mount': (3,),
              **{f'clamp_stress{which}': (bristles, 4) for which in ('', '_min', '_max')}}
    scalars = {'t': 0.25, 'theta': 1.5, 'omega': -10.472, 'energy_kinetic': 1.0,
               'energy_elastic': np.nan, 'energy_dissipated': 0.0, 'work_external': 0.0,
               'drive_torque': -1.25, 'drive_work': np.nan,
               'error_estimate': 1e-6, 'step': 250, 'newton_iterations': 7, 'substeps': 5}
    return Snapshot(**{
        name: scalars[name] if name in scalars
        else rng.normal(size=shapes.get(name, (bristles, 3))) for name in Snapshot._fields})


SCENE = from_parameters(
    {'brush.bristle_count': 2, 'contact.normal_stiffness': float('inf')}, 'test')
ITS = SCENE.solver.integration_time_step
SNAPSHOT = random_snapshot(1)
POSE = Pose(np.array([1.0, 2.0, 0.3]), np.eye(3), (0.0, 0.0, 0.0, 1.0))


def chunk_of(steps, events=(), failure=None):
    """Return a chunk with samples at these steps, all of the same state."""
    samples = tuple(SNAPSHOT._replace(step=step, t=step * ITS) for step in steps)
    return Chunk(0, max(steps, default=0), samples, SNAPSHOT, tuple(events), failure, POSE)


def waits_in(thread, function):
    """Whether a thread is just now in `function` of Python; it stays there when that waits."""
    frame = sys._current_frames().get(thread.ident)
    return frame is not None and frame.f_code.co_name == function
