"""What a correction does to the nodes, and how far they have turned in a step."""
from math import acos, sqrt

from bristle_ros.physics.compiler import jit

from .layout import LANES, Q, Q0, R, X


@jit
def move_nodes(s, blocks, element_length):
    """Apply the increments in the residual rows; return the largest (element length, 1 rad)."""
    largest = 0.0
    inverse = 1.0 / element_length
    for j in range(blocks):
        for i in range(LANES):
            u1, u2, u3 = s[j, R * LANES + i], s[j, (R + 1) * LANES + i], s[j, (R + 2) * LANES + i]
            t1 = s[j, (R + 3) * LANES + i]
            t2 = s[j, (R + 4) * LANES + i]
            t3 = s[j, (R + 5) * LANES + i]
            q0 = s[j, Q * LANES + i]
            q1 = s[j, (Q + 1) * LANES + i]
            q2 = s[j, (Q + 2) * LANES + i]
            q3 = s[j, (Q + 3) * LANES + i]
            s[j, R * LANES + i] = inverse * inverse * (u1 * u1 + u2 * u2 + u3 * u3) + (
                t1 * t1 + t2 * t2 + t3 * t3)
            s[j, X * LANES + i] += ((1.0 - 2.0 * (q2 * q2 + q3 * q3)) * u1
                                    + 2.0 * (q1 * q2 - q0 * q3) * u2
                                    + 2.0 * (q1 * q3 + q0 * q2) * u3)
            s[j, (X + 1) * LANES + i] += (2.0 * (q1 * q2 + q0 * q3) * u1
                                          + (1.0 - 2.0 * (q1 * q1 + q3 * q3)) * u2
                                          + 2.0 * (q2 * q3 - q0 * q1) * u3)
            s[j, (X + 2) * LANES + i] += (2.0 * (q1 * q3 - q0 * q2) * u1
                                          + 2.0 * (q2 * q3 + q0 * q1) * u2
                                          + (1.0 - 2.0 * (q1 * q1 + q2 * q2)) * u3)
            t1, t2, t3 = 0.5 * t1, 0.5 * t2, 0.5 * t3
            p0 = q0 - q1 * t1 - q2 * t2 - q3 * t3
            p1 = q1 + q0 * t1 + q2 * t3 - q3 * t2
            p2 = q2 + q0 * t2 + q3 * t1 - q1 * t3
            p3 = q3 + q0 * t3 + q1 * t2 - q2 * t1
            n = 1.0 / sqrt(p0 * p0 + p1 * p1 + p2 * p2 + p3 * p3)
            s[j, Q * LANES + i] = p0 * n
            s[j, (Q + 1) * LANES + i] = p1 * n
            s[j, (Q + 2) * LANES + i] = p2 * n
            s[j, (Q + 3) * LANES + i] = p3 * n
        for i in range(LANES):
            if not s[j, R * LANES + i] < 1e29:
                return 1e30
            largest = max(largest, s[j, R * LANES + i])
    return sqrt(largest)


@jit
def largest_turn(s, blocks):
    """Return the largest angle between a node's axes and what they were at the step's start."""
    least = 1.0
    for j in range(blocks):
        for i in range(LANES):
            cosine = abs(s[j, Q * LANES + i] * s[j, Q0 * LANES + i]
                         + s[j, (Q + 1) * LANES + i] * s[j, (Q0 + 1) * LANES + i]
                         + s[j, (Q + 2) * LANES + i] * s[j, (Q0 + 2) * LANES + i]
                         + s[j, (Q + 3) * LANES + i] * s[j, (Q0 + 3) * LANES + i])
            least = min(least, cosine)
    return 2.0 * acos(least)
