"""What one sample of a run holds: the record that is published, logged, written and compared."""
from typing import NamedTuple, TypeAlias

import numpy as np
from numpy.typing import NDArray

Floats: TypeAlias = NDArray[np.float64]


class Snapshot(NamedTuple):
    """
    Outputs at the end of one integration step; B bristles, SI units.

    Arrays are per wire except `brush_*` and `contact_*_mount`, which sum over all wires. Axes:
    `brush` (x along bristle 0's radius, z along the brush axis), `road` (inertial, z up), `mount`
    (fixed to the sweeper). All are float64 and owned by the snapshot: it does not change when the
    run goes on.
    """

    step: int                           # integration steps since the scene's start
    t: float                            # [s] = step * integration_time_step
    theta: float                        # [rad] angle of the brush
    omega: float                        # [rad/s] its speed
    tip_position: Floats                # [m] (B, 3), brush axes, from the mount centre
    tip_position_road: Floats           # [m] (B, 3), road axes, from the mount centre
    tip_position_mount: Floats          # [m] (B, 3), mount axes, from the mount centre
    tip_orientation: Floats             # (B, 4) quaternion x, y, z, w, brush axes
    tip_orientation_mount: Floats       # (B, 4) quaternion x, y, z, w, mount axes
    contact_force: Floats               # [N] (B, 3) on the whole wire, road axes, mean over the
                                        # last step
    contact_impulse: Floats             # [N s] (B, 3) since t = 0, road axes
    mount_force: Floats                 # [N] (B, 3) of the wire on the board, brush axes
    mount_moment: Floats                # [N m] (B, 3) about the wire's clamp, brush axes
    mount_damping_force: Floats         # [N] (B, 3) its beta_D part, x along that bristle's radius
    air_force: Floats                   # [N] (B, 3) of still air on the wire, road axes
    brush_force: Floats                 # [N] (3,) of the brush on the sweeper, mount axes
    brush_torque: Floats                # [N m] (3,) about the mount centre, mount axes
    contact_force_mount: Floats         # [N] (3,) of the road on the brush, mount axes
    contact_torque_mount: Floats        # [N m] (3,) about the mount centre, mount axes
    energy_kinetic: float               # [J] the four energies: whole scene, brush frame;
    energy_elastic: float               # NaN where the simulation was built without them
    energy_dissipated: float
    work_external: float
    newton_iterations: int              # running counts, summed over bristles
    substeps: int
    error_estimate: float               # local error of the last step, per length of the bristle
    clamp_stress: np.ndarray            # [Pa] (B, 4) axial, at the section's corners at the clamp
    clamp_stress_min: np.ndarray        # [Pa] (B, 4) its least since the last sample, sub-steps
    clamp_stress_max: np.ndarray        # too, and largest; NaN as the energies
    worst: np.ndarray                   # [Pa, m, m] (B, 3) largest of these three; depth of the
                                        # wire below both road and tip; of the tip in the road
    tip_force: Floats                   # [N] (B, 3) the part of contact_force at the tip
    wire_gap: Floats                    # [m] (B,) least gap of any contact point; inf: no road
    contact_length: Floats              # [m] (B,) of wire that touching points stand for; the tip
                                        # alone: 0
    base_pose: NDArray[np.float64]          # (3,) [m, m, rad] of the sweeper's base on the road
    drive_torque: float                 # [N m] of the drive on the brush
    drive_work: float                   # [J] what it has done since t = 0; NaN where the speed is
                                        # given


NPZ_ARRAYS = (
    't', 'theta', 'omega', 'tip_position', 'tip_position_road', 'tip_orientation', 'contact_force',
    'contact_impulse', 'mount_force', 'mount_moment', 'mount_damping_force', 'brush_force',
    'brush_torque', 'energy_kinetic', 'energy_elastic', 'energy_dissipated', 'work_external',
    'newton_iterations', 'substeps', 'base_pose', 'clamp_stress', 'clamp_stress_min',
    'clamp_stress_max', 'tip_force', 'wire_gap', 'contact_length')
# where the scene has air
AIR_ARRAYS = ('air_force',)
# where the drive feels its load
DRIVE_ARRAYS = ('drive_torque', 'drive_work')
# what is kept only where the simulation was built with its accounts
ACCOUNTED = ('energy_kinetic', 'energy_elastic', 'energy_dissipated', 'work_external',
             'clamp_stress_min', 'clamp_stress_max')
