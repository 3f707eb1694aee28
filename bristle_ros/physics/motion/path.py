"""
The way of the mount over the surface: the integral of its velocity, step by step.

Over a step of length h the velocity is taken as the parabola through its values V0, Vm, V1 at the
start, the middle and the end; its integral over the part f of the step is

    h [V0 (f - 3/2 f^2 + 2/3 f^3) + Vm (2 f^2 - 4/3 f^3) + V1 (2/3 f^3 - 1/2 f^2)]

which over all of it is Simpson's rule: exact for straight ramps, in turns to
(yaw rate h)^4 / 2880.
Sub-steps lie on the same parabola, so a step ends where its parts do.
"""
from bristle_ros.physics.compiler import jit

from .records import MOVED, PLACE, VELOCITY


@jit
def _go(table, step, part, h, frame):
    """
    Fill the place of a frame record that is `part` of the way through a step of a table.

    table : (2 n + 1, FRAME)    frame records at the starts, middles and ends of n steps
    """
    start, middle, end = table[2 * step], table[2 * step + 1], table[2 * step + 2]
    square, cube = part * part, part * part * part
    first = h * (part - 1.5 * square + 2.0 / 3.0 * cube)
    second = h * (2.0 * square - 4.0 / 3.0 * cube)
    third = h * (2.0 / 3.0 * cube - 0.5 * square)
    for i in range(2):
        frame[PLACE + i] = (start[PLACE + i] + first * start[VELOCITY + i]
                            + second * middle[VELOCITY + i] + third * end[VELOCITY + i])


@jit
def way_within(table, step, part, h, frame):
    """Fill a frame record's place; at a step's end it is the table's, to the last bit."""
    if part < 1.0:
        _go(table, step, part, h, frame)
    else:
        frame[PLACE], frame[PLACE + 1] = table[2 * step + 2, PLACE], table[2 * step + 2, PLACE + 1]


@jit
def follow_path(table, motion, h, steps):
    """Fill the places in a table of `steps` steps from where the motion has got to."""
    table[0, PLACE], table[0, PLACE + 1] = motion[MOVED], motion[MOVED + 1]
    for step in range(steps):
        _go(table, step, 0.5, h, table[2 * step + 1])
        _go(table, step, 1.0, h, table[2 * step + 2])


@jit
def keep_place(table, motion, steps):
    """Let the motion have got to where the table is after `steps` steps."""
    motion[MOVED], motion[MOVED + 1] = table[2 * steps, PLACE], table[2 * steps, PLACE + 1]
