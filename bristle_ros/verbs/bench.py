"""
Run times of a scene: the `bench` verb, and the timing that the report's pages share.

Every number is the best of several repeats, since a shared core only ever makes things slower; a
calibration loop timed in between tells how fast the machine was while it happened.
"""
import json
import math
import sys
import time

from bristle_ros.command_line import add_scene, check_range, load_scene, Parser
from bristle_ros.log import measured_on

REPEATS = 5
DURATION = 0.5          # [s] simulated in each repeat
CALIBRATION = 300_000   # turns of the calibration loop


def calibrate(clock=time.perf_counter):
    """Return the wall time [s] of a fixed loop of floating-point work in the interpreter."""
    began = clock()
    x = 0.5
    for _ in range(CALIBRATION):
        x = 3.7 * x * (1.0 - x)
    return clock() - began


def best_of(run, repeats=REPEATS, clock=time.perf_counter):
    """Return the least wall time [s] of `repeats` calls of run(), and what the last returned."""
    least, result = math.inf, None
    for _ in range(repeats):
        began = clock()
        result = run()
        least = min(least, clock() - began)
    return least, result


def percentile(ordered, share):
    """Return the smallest entry that at least `share` of the ascending entries do not exceed."""
    return ordered[max(0, math.ceil(share * len(ordered) - 1e-9) - 1)]


def run_chunks(simulation, steps, chunk, clock=time.perf_counter):
    """Advance `steps` steps from the start in chunks; return each chunk's (wall [s], steps)."""
    simulation.reset()
    times = []
    left = steps
    while left > 0:
        now = min(chunk, left)
        began = clock()
        simulation.advance(now)
        times.append((clock() - began, now))
        left -= now
    return times


def measure(simulation, duration=DURATION, repeats=REPEATS, clock=time.perf_counter):
    """
    Return the run times of a scene as a dict: the keys that `bench` prints.

    simulation : Simulation     reset before each repeat and left at the end of the last
    duration : [s]              simulated in each repeat, rounded to whole steps
    Raises StepFailure where the scene does not reach the end.
    """
    its = simulation.its
    steps = max(1, round(duration / its))
    chunk = max(1, round(simulation.scene.run.chunk / its))
    calibration, best = math.inf, None
    for _ in range(repeats):
        calibration = min(calibration, calibrate(clock))
        times = run_chunks(simulation, steps, chunk, clock)
        wall = sum(seconds for seconds, _ in times)
        if best is None or wall < best[0]:
            best = wall, times
    wall, times = best
    snapshot = simulation.snapshot()
    walls = sorted(seconds for seconds, _ in times)
    # slowest first: 1 % of the chunks run below the factor p1
    factors = sorted(n * its / max(seconds, 1e-9) for seconds, n in times)
    newton, estimate = snapshot.newton_iterations, snapshot.error_estimate
    return {
        'wall_per_simulated_second': wall / (steps * its),
        'compile_time': simulation.compile_time,
        'step_us': 1e6 * wall / steps,
        'newton_us': 1e6 * wall / newton if newton else None,
        'newton_per_step': newton / steps / simulation.bristles,
        'substeps': snapshot.substeps,
        'chunk_time_s': {name: percentile(walls, share) for name, share in (
            ('p50', 0.50), ('p95', 0.95), ('p99', 0.99), ('max', 1.0))},
        'real_time_factor': {'mean': steps * its / max(wall, 1e-9),
                             'p50': percentile(factors, 0.50), 'p5': percentile(factors, 0.05),
                             'p1': percentile(factors, 0.01)},
        'steps': steps,
        'simulated_s': steps * its,
        'chunk_s': chunk * its,
        'bristles': simulation.bristles,
        'error_estimate': estimate if math.isfinite(estimate) else None,
        'repeats': repeats,
        'calibration_s': calibration,
    }


def main(arguments):
    """Run the verb `bench`; return its exit code."""
    parser = Parser('bench', 'Times a scene without pacing, best of several repeats; prints JSON. '
                    'calibration_s is the time of a fixed loop, taken in the same run.')
    add_scene(parser)
    parser.add_argument('--duration', type=float, default=DURATION, metavar='S',
                        help=f'simulated time of a repeat [s]; default {DURATION}')
    parser.add_argument('--repeats', type=int, default=REPEATS, metavar='N',
                        help=f'the best of so many counts; default {REPEATS}')
    options = parser.parse_args(arguments)
    check_range(options, 'duration', 1e-9, 1e5)
    check_range(options, 'repeats', 1, 1000)
    scene = load_scene(options)
    from bristle_ros.simulation import Simulation  # from here on the compiler is needed
    found = measure(Simulation(scene), options.duration, options.repeats)
    json.dump({'scene': options.scene, **found,
               'machine': measured_on()}, sys.stdout, indent=2)
    print()
    return 0
