"""
Still air: what it does to a wire that is moved through it, by the cross-flow principle.

Of the velocity v of a piece of wire through the air only the part across its axis counts (Hoerner,
Fluid-Dynamic Drag, 1965, ch. 3; brushes: Holopainen, Salonen 2004, Energy and Buildings 36),

    force per length = -1/2 rho Cd w |v_n| v_n,    w the section's width seen from there.

A rectangle with sides b along y and t along z shows w = (b |v_z| + t |v_y|) / |v_n|, so that the
force is -1/2 rho Cd (b |v_z| + t |v_y|) (v_y, v_z) in section axes: no root, and none at rest. It
is lumped like the mass, by the three-point Gauss-Lobatto rule.

The air rests where the road's surface does; v is the absolute velocity, of the turning frame and
of the sweeper. What the height actuator does moves the road, not the brush, here as in the frame's
accelerations. The frozen matrix leaves this force out: against inertia, m / h^2 there, it is as
the step h is to the time in which air would stop the wire, below a thousandth for steel in air.
"""
from typing import NamedTuple

from bristle_ros.physics.compiler import jit
from bristle_ros.physics.motion import CLAMP, ROTATION, SPIN, VELOCITY

from .layout import HV, LANES, MASS, Q, R, X, X0


class Air(NamedTuple):
    """How strong the air is: 1/2 rho Cd times a side of the section, per mass of wire [1/m]."""

    breadth: float
    width: float


@jit
def wind(frame):
    """Return the velocity of the frame's origin through the air, axes of the nodes [m/s]."""
    x, y = frame[VELOCITY], frame[VELOCITY + 1]
    return (frame[ROTATION] * x + frame[ROTATION + 3] * y,
            frame[ROTATION + 1] * x + frame[ROTATION + 4] * y,
            frame[ROTATION + 2] * x + frame[ROTATION + 5] * y)


@jit
def node_air(air, mass, x, q, v, frame):
    """
    Return the air's force on a node, axes of the nodes, and its power on it [W], never positive.

    air : Air;  mass [kg];  x [m], v [m/s] : place, velocity in the frame;  q : orientation
    """
    u1, u2, u3 = wind(frame)
    o1, o2, o3 = frame[SPIN], frame[SPIN + 1], frame[SPIN + 2]
    u1 += v[0] + o2 * x[2] - o3 * x[1]
    u2 += v[1] + o3 * x[0] - o1 * x[2]
    u3 += v[2] + o1 * x[1] - o2 * x[0]
    y1, y2, y3 = 2.0 * (q[1] * q[2] - q[0] * q[3]), 1.0 - 2.0 * (q[1] * q[1] + q[3] * q[3]), (
        2.0 * (q[2] * q[3] + q[0] * q[1]))
    z1, z2, z3 = 2.0 * (q[1] * q[3] + q[0] * q[2]), 2.0 * (q[2] * q[3] - q[0] * q[1]), (
        1.0 - 2.0 * (q[1] * q[1] + q[2] * q[2]))
    along_y = y1 * u1 + y2 * u2 + y3 * u3
    along_z = z1 * u1 + z2 * u2 + z3 * u3
    drag = mass * (air.breadth * abs(along_z) + air.width * abs(along_y))
    return (-drag * (y1 * along_y + z1 * along_z), -drag * (y2 * along_y + z2 * along_z),
            -drag * (y3 * along_y + z3 * along_z),
            -drag * (along_y * along_y + along_z * along_z))


@jit
def clamp_air(air, mass, spin, frame):
    """Return the same of the clamped node; spin [rad/s] : about z, that it has in the frame."""
    x = (frame[CLAMP], frame[CLAMP + 1], frame[CLAMP + 2])
    q = (frame[CLAMP + 3], frame[CLAMP + 4], frame[CLAMP + 5], frame[CLAMP + 6])
    return node_air(air, mass, x, q, (-spin * x[1], spin * x[0], 0.0), frame)


@jit
def add_air(s, blocks, cv, air, frame):
    """Add the air's force to the residual rows, section axes; air None: nothing, compiled away."""
    if air is None:
        return
    u1, u2, u3 = wind(frame)
    o1, o2, o3 = frame[SPIN], frame[SPIN + 1], frame[SPIN + 2]
    for j in range(blocks):
        for i in range(LANES):
            x1 = s[j, X * LANES + i]
            x2 = s[j, (X + 1) * LANES + i]
            x3 = s[j, (X + 2) * LANES + i]
            v1 = u1 + cv * (x1 - s[j, X0 * LANES + i]) + s[j, HV * LANES + i] + o2 * x3 - o3 * x2
            v2 = (u2 + cv * (x2 - s[j, (X0 + 1) * LANES + i]) + s[j, (HV + 1) * LANES + i]
                  + o3 * x1 - o1 * x3)
            v3 = (u3 + cv * (x3 - s[j, (X0 + 2) * LANES + i]) + s[j, (HV + 2) * LANES + i]
                  + o1 * x2 - o2 * x1)
            q0 = s[j, Q * LANES + i]
            q1 = s[j, (Q + 1) * LANES + i]
            q2 = s[j, (Q + 2) * LANES + i]
            q3 = s[j, (Q + 3) * LANES + i]
            along_y = (2.0 * (q1 * q2 - q0 * q3) * v1 + (1.0 - 2.0 * (q1 * q1 + q3 * q3)) * v2
                       + 2.0 * (q2 * q3 + q0 * q1) * v3)
            along_z = (2.0 * (q1 * q3 + q0 * q2) * v1 + 2.0 * (q2 * q3 - q0 * q1) * v2
                       + (1.0 - 2.0 * (q1 * q1 + q2 * q2)) * v3)
            drag = s[j, MASS * LANES + i] * (air.breadth * abs(along_z)
                                             + air.width * abs(along_y))
            s[j, (R + 1) * LANES + i] -= drag * along_y
            s[j, (R + 2) * LANES + i] -= drag * along_z
