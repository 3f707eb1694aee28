"""
Axial stress at the four corners of the section at the clamp, and its extremes over sub-steps.

Section axes: x along the wire, y along the breadth b, z along the width w. With the traction
sigma along x that the wire beyond a section puts on it there,

    N = int sigma dA,    M_y = int z sigma dA,    M_z = -int y sigma dA    [r x (sigma, 0, 0)]

and for a plane section (Navier) sigma is linear in y and z:

    sigma = N / A + M_y z / I_y - M_z y / I_z,    A = b w,  I_y = b w^3 / 12,  I_z = w b^3 / 12

(Timoshenko, Strength of Materials, part I, unsymmetrical bending). Tension is positive. N and M at
the clamp are those of the wire on the board, mount_force and mount_moment; what the board answers,
their negatives, acts on the face whose normal is -x: the same stress. Shear and torsion are left
out: they vanish at the corners of a rectangle.
"""
from bristle_ros.physics.compiler import jit
from bristle_ros.physics.motion import CLAMP, DRAG_SPIN
from bristle_ros.physics.wire import clamp_air, clamp_reaction
import numpy as np
from numpy.typing import NDArray

from .energy import frame_force, STRESS_MAX, STRESS_MIN, to_brush

CORNERS = ((1, 1), (-1, 1), (-1, -1), (1, -1))  # signs of y, z: around the wire, thumb along it


def corner_factors(breadth: float, width: float,
                   axes: NDArray[np.float64]) -> NDArray[np.float64]:
    """
    Return what a force [N] and moment [N m] at the clamp give of stress at each corner: (4, 6).

    axes : (3, 3)    columns: the section's x, y, z in the axes of force and moment
    """
    area = breadth * width
    about_y, about_z = area * width ** 2 / 12.0, area * breadth ** 2 / 12.0
    x, y, z = np.transpose(axes)
    return np.array([np.concatenate((
        x / area, 0.5 * right * width / about_y * y - 0.5 * left * breadth / about_z * z))
        for left, right in CORNERS])


@jit
def corner_stress(factors, f1, f2, f3, m1, m2, m3):
    """Return the stress [Pa] of a force and moment of the wire on the board; factors : (6,)."""
    return (factors[0] * f1 + factors[1] * f2 + factors[2] * f3
            + factors[3] * m1 + factors[4] * m2 + factors[5] * m3)


@jit
def air_on_clamp(model, air, frame):
    """Return the air's force on the clamped node [N], the frame's axes."""
    if air is None:
        return 0.0, 0.0, 0.0
    f1, f2, f3, _ = clamp_air(air, model.clamp_mass, frame[DRAG_SPIN], frame)
    return f1, f2, f3


@jit
def note_stress(model, audit, s, scratch):
    """
    Widen the extremes by one converged step, after its account: arguments as in `account_step`.

    The internal forces are those of the step's end; the force includes that of the clamped node.
    """
    solved = scratch.frames[2]
    end = scratch.turned[1] if model.displacement else solved
    f1, f2, f3, m1, m2, m3 = clamp_reaction(s, solved[CLAMP:])
    f1, f2, f3 = to_brush(model, solved, f1, f2, f3)
    m1, m2, m3 = to_brush(model, solved, m1, m2, m3)
    g1, g2, g3 = frame_force(end, model.clamp[0], model.clamp[1], model.clamp[2])
    a1, a2, a3 = air_on_clamp(model, model.air, solved)
    a1, a2, a3 = to_brush(model, solved, a1, a2, a3)
    f1 += model.clamp_mass * g1 + a1
    f2 += model.clamp_mass * g2 + a2
    f3 += model.clamp_mass * g3 + a3
    for i in range(4):
        stress = corner_stress(model.corners[i], f1, f2, f3, m1, m2, m3)
        audit[STRESS_MIN + i] = min(audit[STRESS_MIN + i], stress)
        audit[STRESS_MAX + i] = max(audit[STRESS_MAX + i], stress)
