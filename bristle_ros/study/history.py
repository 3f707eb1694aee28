"""One run of a scene, and what its measures need of each sample."""
from collections import namedtuple
import math
import time

from bristle_ros.scene import SceneError, steps
from bristle_ros.simulation import Simulation
import numpy as np

from .compiling import one_compiles
from .study_file import SAMPLE

NAMES = ('t', 'theta', 'omega', 'tip_position_road', 'tip_position', 'contact_force',
         'contact_impulse', 'mount_force', 'mount_moment', 'brush_force', 'brush_torque',
         'error_estimate', 'contact_length', 'tip_force')
# The samples of a run, the start included: SI units; arrays (n, B, 3), brush_* (n, 3),
# contact_length (n, B), others (n,)
History = namedtuple('History', NAMES)
AUTO = 5                # turns between looks at whether the means have settled
Plan = namedtuple('Plan', 'steps every settle auto')


def plan(study, scene):
    """
    Return how long a run of the scene is: integration steps, steps between samples, settle [s].

    Turns are of the mean speed. Raises SceneError where they cannot be had.
    """
    its = scene.solver.integration_time_step
    every = (steps(scene, study.sample, 'sample') if study.sample
             else max(1, round(SAMPLE / its)))
    auto = study.turns == 'auto'
    if study.duration is not None:
        whole, settle = steps(scene, study.duration, 'duration'), study.settle
    else:
        if scene.drive.profile == 'table':
            raise SceneError('turns are of drive.mean_speed, which a table has not: give duration',
                             key='drive.profile', value='table')
        if scene.drive.mean_speed == 0.0:
            raise SceneError('a brush that does not turn makes no turns: give duration',
                             key='drive.mean_speed', value=0.0)
        turn = 2.0 * math.pi / abs(scene.drive.mean_speed)
        turns = AUTO if auto else study.turns
        settle = study.settle * turn
        # a sample more: the last whole turn must not be lost to rounding
        whole = math.ceil((turns + auto * study.settle) * turn / its) + every
    return Plan(-(-whole // every) * every, every, settle, auto)


class Run:
    """A run that can be made longer."""

    def __init__(self, scene, every):
        self.scene, self._every = scene, every
        with one_compiles(scene):
            self._simulation = Simulation(scene, threads=1)
        self._snapshots = [self._simulation.snapshot()]
        self.wall_time = 0.0    # [s] without compiling

    def go(self, until):
        """Advance to a number of integration steps; raise StepFailure."""
        began = time.perf_counter()
        simulation = self._simulation
        try:
            for _ in range(simulation.step, until, self._every):
                simulation.advance(self._every)
                self._snapshots.append(_needed(simulation.snapshot()))
        finally:
            self.wall_time += time.perf_counter() - began

    def history(self):
        """Return the History so far."""
        self._snapshots[0] = _needed(self._snapshots[0])
        return History(*map(np.array, zip(*self._snapshots)))


def _needed(snapshot):
    return tuple(getattr(snapshot, name) for name in NAMES) if hasattr(
        snapshot, 'step') else snapshot
