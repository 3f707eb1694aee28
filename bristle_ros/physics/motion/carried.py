"""
The way of a mount that is carried: position and rotation, cubic in time, and their derivatives.

With tau the time since the segment began, in road axes and with R from mount to road axes,

    x = x0 + tau (v0 + tau (c2 + tau c3)),    R = R0 exp(rho),   rho = tau (r1 + tau (r2 + tau r3))

exp(rho) a turn about rho by its length. The angular velocity, mount axes, is J rho' with

    J = 1 - b [rho] + c [rho]^2,    b = (1 - cos s) / s^2,    c = (s - sin s) / s^3,    s = |rho|

the right Jacobian of the exponential (Chirikjian 2012, Stochastic Models, Information Theory, and
Lie Groups 2, 10.3.1; [rho] y = rho x y), and its rate follows by differentiating that. Beyond its
end a segment goes on with the velocity it has there: straight, and about one axis.
"""
from math import cos, sin, sqrt

from bristle_ros.physics.compiler import jit

from .drive import END_SLACK

# record of the segment, in the motion
CARRIED = 0             # 1  1 from the first command on
SINCE = CARRIED + 1     # 1  when it began [s]
MOVES = SINCE + 1       # 1  how long its position is cubic [s]
TURNS = MOVES + 1       # 1  how long its rotation is
CUBIC = TURNS + 1       # 12  x0, v0, c2, c3
FROM = CUBIC + 12       # 9  R0, row by row
VECTOR = FROM + 9       # 9  r1, r2, r3
SEGMENT = VECTOR + 9

# what `carried_at` fills
AT_PLACE = 0            # 3  x [m], road axes
AT_VELOCITY = AT_PLACE + 3  # 3  [m/s], road axes
AT_ACCELERATION = AT_VELOCITY + 3  # 3  [m/s^2], road axes
AT_ROTATION = AT_ACCELERATION + 3  # 9  R, row by row
AT_RATE = AT_ROTATION + 9  # 3  angular velocity [rad/s], mount axes
AT_RATE_RATE = AT_RATE + 3  # 3  its rate [rad/s^2]
CARRIED_AT = AT_RATE_RATE + 3

SMALL = 0.05            # of s^2: series below


@jit
def jacobian_factors(square):
    """Return a = sin s / s, b, c, db / d(s^2) and dc / d(s^2) at s^2."""
    if square < SMALL:
        z = square
        return (1.0 - z / 6.0 * (1.0 - z / 20.0 * (1.0 - z / 42.0 * (1.0 - z / 72.0))),
                0.5 - z / 24.0 * (1.0 - z / 30.0 * (1.0 - z / 56.0 * (1.0 - z / 90.0))),
                1.0 / 6.0 - z / 120.0 * (1.0 - z / 42.0 * (1.0 - z / 72.0 * (1.0 - z / 110.0))),
                -1.0 / 24.0 + z / 360.0 * (1.0 - z * 3.0 / 112.0 * (1.0 - z * 4.0 / 270.0)),
                -1.0 / 120.0 + z / 2520.0 * (1.0 - z / 48.0 * (1.0 - z * 4.0 / 330.0)))
    s = sqrt(square)
    si, co = sin(s), cos(s)
    return (si / s, (1.0 - co) / square, (s - si) / (square * s),
            (s * si - 2.0 * (1.0 - co)) / (2.0 * square * square),
            (3.0 * si - 2.0 * s - s * co) / (2.0 * square * square * s))


@jit
def _cross(x, y):
    return (x[1] * y[2] - x[2] * y[1], x[2] * y[0] - x[0] * y[2], x[0] * y[1] - x[1] * y[0])


@jit
def _spin(rho, first, second):
    """Return angular velocity and its rate of exp(rho), with rho' and rho''; tuples of three."""
    square = rho[0] * rho[0] + rho[1] * rho[1] + rho[2] * rho[2]
    growth = 2.0 * (rho[0] * first[0] + rho[1] * first[1] + rho[2] * first[2])
    _, b, c, by_b, by_c = jacobian_factors(square)
    p1 = _cross(rho, first)
    p2 = _cross(rho, p1)
    q1 = _cross(rho, second)
    q2 = _cross(rho, q1)
    r2 = _cross(first, p1)
    by_b, by_c = growth * by_b, growth * by_c
    return ((first[0] - b * p1[0] + c * p2[0], first[1] - b * p1[1] + c * p2[1],
             first[2] - b * p1[2] + c * p2[2]),
            (second[0] - b * q1[0] + c * q2[0] - by_b * p1[0] + by_c * p2[0] + c * r2[0],
             second[1] - b * q1[1] + c * q2[1] - by_b * p1[1] + by_c * p2[1] + c * r2[1],
             second[2] - b * q1[2] + c * q2[2] - by_b * p1[2] + by_c * p2[2] + c * r2[2]))


@jit
def _turn(motion, at, rho, out, place):
    """Fill out[place:] with the matrix at motion[at:] times exp(rho)."""
    x, y, z = rho
    a, b, _, _, _ = jacobian_factors(x * x + y * y + z * z)
    for row in range(0, 9, 3):
        m1, m2, m3 = motion[at + row], motion[at + row + 1], motion[at + row + 2]
        out[place + row] = (m1 * (1.0 - b * (y * y + z * z)) + m2 * (a * z + b * x * y)
                            + m3 * (b * x * z - a * y))
        out[place + row + 1] = (m1 * (b * x * y - a * z) + m2 * (1.0 - b * (x * x + z * z))
                                + m3 * (a * x + b * y * z))
        out[place + row + 2] = (m1 * (a * y + b * x * z) + m2 * (b * y * z - a * x)
                                + m3 * (1.0 - b * (x * x + y * y)))


@jit
def carried_at(t, motion, at, out):
    """
    Fill where the mount is at time t [s], how fast, and how that changes.

    motion[at:] : the segment;  out : (CARRIED_AT,)
    At the segment's end, to within END_SLACK, the accelerations are those before it: a step that
    ends there has felt them.
    """
    since = max(t - motion[at + SINCE], 0.0)
    tau = min(since, motion[at + MOVES])
    beyond = since - tau
    for i in range(3):
        k = at + CUBIC + i
        c2, c3 = motion[k + 6], motion[k + 9]
        velocity = motion[k + 3] + tau * (2.0 * c2 + tau * 3.0 * c3)
        out[AT_PLACE + i] = (motion[k] + tau * (motion[k + 3] + tau * (c2 + tau * c3))
                           + beyond * velocity)
        out[AT_VELOCITY + i] = velocity
        out[AT_ACCELERATION + i] = 2.0 * c2 + 6.0 * tau * c3 if beyond <= END_SLACK else 0.0
    tau = min(since, motion[at + TURNS])
    beyond = since - tau
    r = at + VECTOR
    rho = (tau * (motion[r] + tau * (motion[r + 3] + tau * motion[r + 6])),
           tau * (motion[r + 1] + tau * (motion[r + 4] + tau * motion[r + 7])),
           tau * (motion[r + 2] + tau * (motion[r + 5] + tau * motion[r + 8])))
    first = (motion[r] + tau * (2.0 * motion[r + 3] + tau * 3.0 * motion[r + 6]),
             motion[r + 1] + tau * (2.0 * motion[r + 4] + tau * 3.0 * motion[r + 7]),
             motion[r + 2] + tau * (2.0 * motion[r + 5] + tau * 3.0 * motion[r + 8]))
    second = (2.0 * motion[r + 3] + 6.0 * tau * motion[r + 6],
              2.0 * motion[r + 4] + 6.0 * tau * motion[r + 7],
              2.0 * motion[r + 5] + 6.0 * tau * motion[r + 8])
    rate, rise = _spin(rho, first, second)
    _turn(motion, at + FROM, rho, out, AT_ROTATION)
    if beyond > 0.0:
        ahead = (beyond * rate[0], beyond * rate[1], beyond * rate[2])
        _turn(out, AT_ROTATION, ahead, out, AT_ROTATION)
    for i in range(3):
        out[AT_RATE + i] = rate[i]
        out[AT_RATE_RATE + i] = rise[i] if beyond <= END_SLACK else 0.0
