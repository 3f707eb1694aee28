#!/usr/bin/env python3
"""
Measure what a lockstep exchange costs an arm that carries the brush: error against chunk length.

    tools/measure_exchange.py [--mass 10] [--stiffness 1200] [--damping 30] [-p KEY:=VALUE ...]

The arm is a mass on a spring and a damper that moves along the road's normal, stepped exactly;
the brush is the scene below, turning on a level road. Both meet as in examples/sweeper: over a
chunk the arm feels the mean force of the chunk before, and the brush follows the cubic to where
the arm is at the chunk's end. A small load is put on the arm, and the cosine that dies away is
fitted. Errors are against the limit of short chunks, beside what theory says for a linear brush
of that stiffness and damping.

12 equal bristles on a level road all feel the same when the mount heaves: one stands for all.
"""
import argparse
from itertools import pairwise
import math
from pathlib import Path
import sys
import time
from typing import NamedTuple

sys.path.insert(0, str(Path(__file__).resolve().parent.parent))

from bristle_ros import build, SceneError
from bristle_ros.scene import from_parameters, read_scalar, to_parameters, Scene
from bristle_ros.simulation import MeanWrench
import numpy as np
from scipy.interpolate import PchipInterpolator
from scipy.linalg import expm
from scipy.optimize import brentq, least_squares

SCENE = {
    'brush.bristle_count': 1, 'brush.wires_per_bristle': 240, 'road.penetration': 0.02,
    'road.approach_time': 0.1, 'friction.static': 0.5, 'friction.kinetic': 0.5,
    'friction.decay': 0.0, 'damping.mass': 1.0, 'damping.stiffness': 0.001,
    'drive.profile': 'constant', 'drive.mean_speed': 10.0, 'solver.elements': 6,
    'mount.enabled': True}
CHUNKS = (0.5, 1.0, 2.0, 5.0, 10.0, 20.0, 50.0, 100.0)  # [ms]
REFERENCE = 5           # of them, the shortest, from which the limit is extrapolated
SETTLED = 1.5           # [s] after which the turning brush is at rest in its frame
SAG = 2e-3              # [m] by which the load would move the arm without the brush
SHOWN = 1.5             # [s] of its motion that is fitted,
AFTER = 0.15            # [s] and after which: by then the onset of the load is forgotten


class Arm(NamedTuple):
    """A mass on a spring and a damper, between the sweeper and the mount."""

    mass: float         # [kg]
    stiffness: float    # [N/m]
    damping: float      # [N s/m]

    def step(self, duration):
        """Return the exact step (2, 3) of place and velocity under a constant force."""
        rates = np.array(((0.0, 1.0, 0.0), (-self.stiffness / self.mass,
                                            -self.damping / self.mass, 1.0 / self.mass),
                          (0.0, 0.0, 0.0)))
        return expm(rates * duration)[:2]


class Run(NamedTuple):
    """An arm's motion at n chunk ends, and what became of the energy."""

    t: np.ndarray       # [s] (n,) since the load
    z: np.ndarray       # [m] (n,) from where it was
    added: float        # [J] by the exchange, which applies a force a chunk late
    damped: float       # [J] taken by the arm's damper


def couple(simulation, arm, chunk, load):
    """
    Let an arm carry a settled brush for AFTER + SHOWN seconds; return the Run.

    chunk [s] : whole steps of the simulation's; load [N] : on the arm from the start on
    """
    steps, mean, step = round(chunk / simulation.its), MeanWrench(), arm.step(chunk)
    state, orientation = simulation.mount_state(), simulation.mount_pose().orientation
    mean.follow(simulation, 0)
    simulation.advance(steps)
    rest = force = up(state, mean.follow(simulation, 0))
    now, added, damped, places = np.zeros(2), 0.0, 0.0, []
    for _ in range(math.ceil((AFTER + SHOWN) / chunk)):
        push = load + force - rest
        then = step @ (*now, push)
        simulation.command('cmd_mount', (
            *(state.position + (0.0, 0.0, then[0])), *orientation,
            *(state.rotation.T @ (0.0, 0.0, then[1])), 0.0, 0.0, 0.0))
        simulation.advance(steps)
        answer = up(state, mean.follow(simulation, 0))
        moved = then[0] - now[0]
        added += (force - answer) * moved
        damped += push * moved - 0.5 * (arm.mass * (then[1] ** 2 - now[1] ** 2)
                                        + arm.stiffness * (then[0] ** 2 - now[0] ** 2))
        now, force = then, answer
        places.append(now[0])
    return Run(chunk * np.arange(1, len(places) + 1), np.array(places), added, damped)


def up(state, wrench):
    """Return the part of a wrench's force along the road's normal [N]."""
    return float(state.rotation[2] @ wrench[:3])


def fit(run):
    """
    Return (rate [1/s], residual) of a motion: z = a + Re(b exp(rate t)), residual per amplitude.

    The start is Prony's: z of each time from those of the two times before, equally apart.
    """
    shown = run.t > AFTER
    t, z = run.t[shown] - AFTER, run.z[shown]
    apart = max(1, round(0.02 / (t[1] - t[0])))
    rows = np.stack((z[apart:-apart], z[:-2 * apart], np.ones(len(z) - 2 * apart)), axis=1)
    one, two, _ = np.linalg.lstsq(rows, z[2 * apart:], rcond=None)[0]
    root = max(np.roots((1.0, -one, -two)).astype(complex), key=lambda number: number.imag)
    start = np.log(root) / (apart * (t[1] - t[0]))

    def parts(guess):
        wave = np.exp((guess[0] + 1j * guess[1]) * t)
        basis = np.stack((wave.real, wave.imag, np.ones(len(t))), axis=1)
        return basis @ np.linalg.lstsq(basis, z, rcond=None)[0] - z

    found = least_squares(parts, (start.real, start.imag), x_scale=(1.0, abs(start)),
                          xtol=1e-12, ftol=1e-14)
    return complex(*found.x), math.sqrt(np.mean(found.fun ** 2)) / np.ptp(z)


def linear_brush(arm, rate):
    """Return stiffness [N/m], damping [N s/m] of the linear brush with which an arm has a rate."""
    rest = -(arm.mass * rate ** 2 + arm.damping * rate + arm.stiffness)
    damping = rest.imag / rate.imag
    return rest.real - damping * rate.real, damping


def closed_form(arm, stiffness, damping, chunk):
    """
    Return the rate [1/s] of an arm with a linear brush, coupled chunk by chunk.

    State: place z and velocity v of the arm, and the force F that it will feel. F of the next
    chunk is the mean over this one, on the cubic from (z, v) to (z', v'): of the place
    (z + z') / 2 + chunk (v - v') / 12, of the velocity (z' - z) / chunk. The rate is the logarithm
    of that eigenvalue of the state's map which is next to the arm's own.
    """
    step = np.zeros((3, 3))
    step[:2] = arm.step(chunk)
    before = np.eye(3)[:2]
    mean = 0.5 * (before[0] + step[0]) + chunk / 12.0 * (before[1] - step[1])
    step[2] = -stiffness * mean - damping * (step[0] - before[0]) / chunk
    whole = np.roots((arm.mass, arm.damping + damping, arm.stiffness + stiffness))
    own = np.exp(chunk * max(whole.astype(complex), key=lambda number: number.imag))
    rates = np.log(np.linalg.eigvals(step).astype(complex)) / chunk
    return min(rates[rates.imag >= 0.0], key=lambda rate: abs(np.exp(chunk * rate) - own))


def limit(chunks, rates):
    """Return the rate at chunk 0 by the parabola through the shortest chunks."""
    return np.polyfit(chunks[:REFERENCE], rates[:REFERENCE], 2)[-1]


def unstable_from(decay, chunks):
    """Return the shortest chunk [s] of these at whose decay(chunk) [1/s] is zero, or None."""
    values = [decay(chunk) for chunk in chunks]
    for i, (before, after) in enumerate(pairwise(values)):
        if before > 0.0 >= after:
            return brentq(decay, chunks[i], chunks[i + 1])
    return None


def measure(scene, arm):
    """Print the table of an arm."""
    chunks, rates, runs, residuals = np.array(CHUNKS) * 1e-3, [], [], []
    load = SAG * arm.stiffness
    for chunk in chunks:
        simulation = build(from_parameters({**scene, 'run.chunk': float(chunk)}, 'the scene'))
        simulation.advance(round(SETTLED / simulation.its))
        runs.append(couple(simulation, arm, chunk, load))
        rate, residual = fit(runs[-1])
        rates.append(rate)
        residuals.append(residual)
    free = limit(chunks, rates)
    stiffness, damping = linear_brush(arm, free)
    print(f'\nArm of {arm.mass:g} kg, {arm.stiffness:g} N/m, {arm.damping:g} N s/m. With the '
          f'brush {free.imag / (2.0 * math.pi):.4f} Hz, decay {-free.real:.4f} 1/s: a linear '
          f'brush of {stiffness:.1f} N/m, {damping:.2f} N s/m.\n')
    print('| chunk [ms] | frequency [Hz] | error | linear brush | decay [1/s] | error | '
          'linear brush | energy added, per damped | fit leaves |')
    print('| ---: ' * 9 + '|')
    for chunk, rate, run, residual in zip(chunks, rates, runs, residuals):
        theory = closed_form(arm, stiffness, damping, chunk)
        print(f'| {chunk * 1e3:g} | {rate.imag / (2.0 * math.pi):.4f} | '
              f'{rate.imag / free.imag - 1.0:+.3%} | {theory.imag / free.imag - 1.0:+.3%} | '
              f'{-rate.real:.4f} | {rate.real / free.real - 1.0:+.2%} | '
              f'{theory.real / free.real - 1.0:+.2%} | {run.added / run.damped:+.2%} | '
              f'{residual:.1e} |')
    grid = np.geomspace(chunks[0], 0.5, 60)
    of_theory = unstable_from(
        lambda chunk: -closed_form(arm, stiffness, damping, chunk).real, grid)
    decays = PchipInterpolator(chunks, [-rate.real for rate in rates])
    measured = unstable_from(decays, grid[grid <= chunks[-1]])
    print(f'\nUnstable from {_ms(measured, chunks[-1])} on, a linear brush from '
          f'{_ms(of_theory, grid[-1])}; damping over stiffness of the brush: '
          f'{(arm.damping + damping) / stiffness * 1e3:.1f} ms with its own, '
          f'{arm.damping / stiffness * 1e3:.1f} ms without.', flush=True)


def _ms(chunk, longest):
    return f'more than {longest * 1e3:g} ms' if chunk is None else f'{chunk * 1e3:.1f} ms'


def main():
    """Measure the arm that is asked for, or three."""
    parser = argparse.ArgumentParser(description=__doc__.strip().partition('\n')[0])
    for name, unit in (('mass', 'kg'), ('stiffness', 'N/m'), ('damping', 'N s/m')):
        parser.add_argument(f'--{name}', type=float, metavar=unit, help='of the arm')
    parser.add_argument('-p', action='append', default=[], metavar='KEY:=VALUE', dest='overrides',
                        help='of the scene')
    options = parser.parse_args()
    given = options.mass, options.stiffness, options.damping
    if any(value is not None and not 0.0 < value < math.inf for value in given):
        parser.error('an arm has a mass, a stiffness and a damping above 0')
    arms = [Arm(10.0, 1200.0, 30.0), Arm(20.0, 1200.0, 30.0), Arm(10.0, 1200.0, 10.0)]
    if any(value is not None for value in given):
        arms = [Arm(*(usual if value is None else value for value, usual in zip(given, arms[0])))]
    began, scene = time.monotonic(), dict(SCENE)
    try:
        for rule in options.overrides:
            key, _, value = rule.partition(':=')
            scene[key] = read_scalar(value)
        usual = to_parameters(Scene())
        changed = {key: value for key, value in to_parameters(
            from_parameters(scene, '-p')).items() if value != usual[key]}
    except SceneError as error:
        parser.error(str(error))
    print('Scene:', ', '.join(f'{key} {value}' for key, value in changed.items()))
    for arm in arms:
        measure(scene, arm)
    print(f'\n{time.monotonic() - began:.0f} s')


if __name__ == '__main__':
    main()
