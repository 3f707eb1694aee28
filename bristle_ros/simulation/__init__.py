"""A scene being stepped: model and state, commands, snapshots, threads."""
from typing import TYPE_CHECKING

from bristle_ros.lazy import lazily

if TYPE_CHECKING:
    from .ahead import kind_of as kind_of
    from .commands import (check_command as check_command, CommandRefused as CommandRefused,
                           Values as Values, values_of as values_of)
    from .contacts import Contacts as Contacts, wire_contacts as wire_contacts
    from .energy_balance import EnergyBalance as EnergyBalance, GAIN as GAIN
    from .equilibrium import static_equilibrium as static_equilibrium
    from .model import (new_scratch as new_scratch, viscosity_of as viscosity_of,
                        WORST_ERROR as WORST_ERROR)
    from .mean_wrench import MeanWrench as MeanWrench
    from .mount_path import MountPath as MountPath, Pose as Pose
    from .polygon import load_steps as load_steps, ring_of as ring_of
    from .run_warnings import (QUANTITIES as QUANTITIES, RunWarning as RunWarning,
                               RunWatch as RunWatch)
    from .simulation import Simulation as Simulation, StepFailure as StepFailure
    from .snapshot import (ACCOUNTED as ACCOUNTED, AIR_ARRAYS as AIR_ARRAYS,
                           DRIVE_ARRAYS as DRIVE_ARRAYS, NPZ_ARRAYS as NPZ_ARRAYS,
                           Snapshot as Snapshot)
    from .surface import surface_of as surface_of

__getattr__, __dir__ = lazily(__name__, {
    'ahead': ['kind_of'],
    'commands': ['check_command', 'CommandRefused', 'Values', 'values_of'],
    'contacts': ['Contacts', 'wire_contacts'],
    'energy_balance': ['EnergyBalance', 'GAIN'],
    'equilibrium': ['static_equilibrium'],
    'model': ['new_scratch', 'viscosity_of', 'WORST_ERROR'],
    'mean_wrench': ['MeanWrench'],
    'mount_path': ['MountPath', 'Pose'],
    'polygon': ['load_steps', 'ring_of'],
    'run_warnings': ['QUANTITIES', 'RunWarning', 'RunWatch'],
    'simulation': ['Simulation', 'StepFailure'],
    'snapshot': ['ACCOUNTED', 'AIR_ARRAYS', 'DRIVE_ARRAYS', 'NPZ_ARRAYS', 'Snapshot'],
    'surface': ['surface_of'],
})
