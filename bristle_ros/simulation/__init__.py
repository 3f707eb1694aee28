"""A scene being stepped: model and state, commands, snapshots, threads."""
from typing import TYPE_CHECKING

from bristle_ros.lazy import lazily

if TYPE_CHECKING:
    from .equilibrium import static_equilibrium as static_equilibrium
    from .model import (new_scratch as new_scratch, viscosity_of as viscosity_of,
                        WORST_ERROR as WORST_ERROR)
    from .mount_path import MountPath as MountPath, Pose as Pose
    from .simulation import (CommandRefused as CommandRefused, Simulation as Simulation,
                             StepFailure as StepFailure, Values as Values,
                             values_of as values_of)
    from .snapshot import NPZ_ARRAYS as NPZ_ARRAYS, Snapshot as Snapshot

__getattr__, __dir__ = lazily(__name__, {
    'equilibrium': ['static_equilibrium'],
    'model': ['new_scratch', 'viscosity_of', 'WORST_ERROR'],
    'mount_path': ['MountPath', 'Pose'],
    'simulation': ['CommandRefused', 'Simulation', 'StepFailure', 'Values', 'values_of'],
    'snapshot': ['NPZ_ARRAYS', 'Snapshot'],
})
