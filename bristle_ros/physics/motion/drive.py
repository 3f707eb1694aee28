"""
Speed functions of the brush with closed-form angle, and ramps between commanded values.

All times are absolute, so that nothing drifts: a ramp is (start time, value there, target,
duration, integral there, slack), and its value and integral at any later time are polynomials.
"""
from math import cos, exp, floor, pi, sin

from bristle_ros.physics.compiler import jit

CONSTANT = 0
SINE = 1
VAP = 2

END_SLACK = 1e-10   # [s] beyond which a table is at its end

RAMP = 6    # numbers of a ramp: start time, value, target, duration, integral there, slack


@jit
def ramp_at(ramp, at, t):
    """
    Return value, rate and integral at time t of the ramp stored at ramp[at:at + RAMP].

    The value moves linearly from ramp[at + 1] to ramp[at + 2] in ramp[at + 3] seconds, then stays.
    At the ramp's end, to within ramp[at + 5] seconds, the rate is the one before it: a step that
    ends there has felt it. Before its start a ramp is what it is there: rounding may ask for that.
    """
    tau = max(t - ramp[at], 0.0)
    change = ramp[at + 2] - ramp[at + 1]
    duration = ramp[at + 3]
    if tau < duration + ramp[at + 5]:
        rate = change / duration
        return (ramp[at + 1] + rate * tau, rate,
                ramp[at + 4] + tau * (ramp[at + 1] + 0.5 * rate * tau))
    return (ramp[at + 2], 0.0,
            ramp[at + 4] + duration * (ramp[at + 1] + 0.5 * change)
            + (tau - duration) * ramp[at + 2])


@jit
def vap_quarter(h, b):
    """
    Return the integral of h (1 - b exp(k (2 h - 1))) from 0 to h, k = (1 - b) / b, h in [0, 1/2].

    Source: eq. (2) of the paper over the first quarter period, integrated by parts.
    """
    k = (1.0 - b) / b
    if k < 0.05:  # (z e^z - e^z + 1) / z^2 as a series: the closed form cancels
        z = 2.0 * k * h
        series = 0.5 + z * (1.0 / 3.0 + z * (1.0 / 8.0 + z * (1.0 / 30.0 + z * (
            1.0 / 144.0 + z * (1.0 / 840.0 + z * (1.0 / 5760.0 + z / 45360.0))))))
        return h * h * (0.5 - b * exp(-k) * series)
    grown = exp(k * (2.0 * h - 1.0))
    return 0.5 * h * h - b * (h * grown / (2.0 * k) - (grown - exp(-k)) / (4.0 * k * k))


@jit
def profile_at(t, profile, amplitude, frequency, b):
    """
    Return what the profile adds to the brush's angle, speed and acceleration at time t.

    profile : CONSTANT, SINE (eq. 5 of the paper) or VAP (eqs. 2-4); amplitude [rad/s]; frequency
    [Hz]; b the VAP function's shape. h1 of the paper is a triangle wave in [-1/2, 1/2], h2 = |h1|.
    """
    if profile == CONSTANT or amplitude == 0.0:
        return 0.0, 0.0, 0.0
    phase = frequency * t
    phase -= floor(phase)
    if profile == SINE:
        w = 2.0 * pi * frequency
        angle = 2.0 * pi * phase
        half = sin(0.5 * angle)
        return (2.0 * amplitude / w * half * half, amplitude * sin(angle),
                amplitude * w * cos(angle))
    sign = 1.0
    within = phase
    if phase >= 0.5:
        sign = -1.0
        within = phase - 0.5
    if within <= 0.25:
        h = 2.0 * within
        rising = sign
    else:
        h = 1.0 - 2.0 * within
        rising = -sign
    scale = amplitude / (1.0 - b)
    k = (1.0 - b) / b
    fade = b * exp(k * (2.0 * h - 1.0))
    speed = 2.0 * scale * sign * h * (1.0 - fade)
    acceleration = 4.0 * frequency * scale * rising * (1.0 - fade * (1.0 + 2.0 * k * h))
    travelled = vap_quarter(h, b)
    if within > 0.25:
        travelled = 2.0 * vap_quarter(0.5, b) - travelled
    if phase >= 0.5:
        travelled = 2.0 * vap_quarter(0.5, b) - travelled
    return scale / frequency * travelled, speed, acceleration


@jit
def table_at(t, table):
    """
    Return what a table of speeds makes of the brush's angle, speed and acceleration at time t.

    table : (n, 6)    times, each with the cubic from there on and the angle there: see
                      scene/drive_table.py. Before the first time and after the last it is held.
    At the last time, to within END_SLACK, the acceleration is the one before it: a step that ends
    there has felt it.
    """
    if t < table[0, 0]:
        return table[0, 5] + (t - table[0, 0]) * table[0, 1], table[0, 1], 0.0
    first, beyond = 0, table.shape[0]
    if t <= table[beyond - 1, 0] + END_SLACK:
        beyond -= 1
    while beyond - first > 1:
        middle = (first + beyond) // 2
        if table[middle, 0] <= t:
            first = middle
        else:
            beyond = middle
    tau = t - table[first, 0]
    c0, c1, c2, c3 = table[first, 1], table[first, 2], table[first, 3], table[first, 4]
    return (table[first, 5] + tau * (c0 + tau * (c1 / 2.0 + tau * (c2 / 3.0 + tau * c3 / 4.0))),
            c0 + tau * (c1 + tau * (c2 + tau * c3)), c1 + tau * (2.0 * c2 + tau * 3.0 * c3))


@jit
def approach_at(t, depth, duration):
    """Return the penetration [m] that grows to `depth` in `duration` [s], and its rate [m/s]."""
    if t >= duration:
        return depth, 0.0
    s = t / duration
    return depth * s * s * (3.0 - 2.0 * s), depth * 6.0 * s * (1.0 - s) / duration
