#!/usr/bin/env python3
"""
Measure what each solver.preset costs and gives on the scenes of config/; print it as JSON.

    tools/measure_presets.py [--repeats 3] [SCENE ...] > docs/presets.json

Each scene is run with its own solver keys and with those of each preset instead, and held against
a converged run: 24 elements, 10 us. Times are taken in turns on one core, one thread.
"""
import argparse
from datetime import datetime, timezone
import json
from pathlib import Path
import sys

ROOT = Path(__file__).resolve().parent.parent
sys.path.insert(0, str(ROOT))

from bristle_ros.log import measured_on  # noqa: E402
from bristle_ros.report.runs import timed, tip_error, whole_impulse_error  # noqa: E402
from bristle_ros.report.timing import quartiles, Timed, timer  # noqa: E402
from bristle_ros.scene import load, PRESETS  # noqa: E402
import numpy as np  # noqa: E402

OWN = 'as the file has it'
CONVERGED = {'elements': 24, 'step': 'fixed', 'integration_time_step': 1e-5,
             'largest_error': 1e-8, 'tolerance': 1e-10}
DURATION, SETTLED = 0.6, 0.3    # [s] of a run, and from when on means are taken
SAMPLE = 1e-3                   # [s]


def scene_of(name, preset):
    """Return the Scene of config/ with the solver keys of a preset; OWN: with its own."""
    solver = {OWN: {}, 'converged': CONVERGED, **PRESETS}[preset]
    return load(ROOT / f'config/{name}.yaml', {
        'run.chunk': SAMPLE, 'run.sample': SAMPLE,
        **{f'solver.{key}': value for key, value in solver.items()}})


class Run:
    """What a run gave: `Path` as report.runs has it, impulses those of all wires together."""

    def __init__(self, name, preset):
        from bristle_ros.simulation import Simulation
        simulation = Simulation(scene_of(name, preset))
        every = round(SAMPLE / simulation.its)
        rows = [simulation.snapshot()]
        for _ in range(round(DURATION / SAMPLE)):
            simulation.advance(every)
            rows.append(simulation.snapshot())
        self.t = np.array([row.t for row in rows])
        self.tip = np.array([row.tip_position[0] for row in rows])
        self.impulse = np.array([row.contact_impulse.sum(axis=0) for row in rows])
        late = self.t > SETTLED - 1e-9
        force = np.diff(self.impulse[late, 2]).sum() / (DURATION - SETTLED)
        torque = np.array([row.brush_torque[2] for row in rows])[late].mean()
        self.means = {'force': force, 'torque': torque}


def errors_of(run, exact):
    """Return errors [%] of tip path, impulse per 5 ms, mean normal force and mean torque."""
    found = {'tip': tip_error(run, exact), 'impulse': whole_impulse_error(run, exact)}
    for name, value in exact.means.items():
        found[name] = abs(run.means[name] - value) / abs(value) if value else 0.0
    return {name: float(f'{100.0 * value:.3g}') for name, value in found.items()}


def prepare(name, preset):
    """Build; return what runs it on one thread and tells its wall time."""
    from bristle_ros.simulation import Simulation
    return timed(Simulation(scene_of(name, preset), threads=1), DURATION)


def measure(name, clock):
    """Return the rows of a scene."""
    exact = Run(name, 'converged')
    presets = (OWN, *PRESETS)
    errors = {preset: errors_of(Run(name, preset), exact) for preset in presets}
    timings = clock.group([Timed(preset, prepare, (name, preset), per=DURATION)
                           for preset in presets])
    rows = []
    for preset in presets:
        pace = [1.0 / wall for wall in quartiles(timings[preset]['walls'])]
        rows.append({'scene': name, 'preset': preset, **errors[preset],
                     'times_real_time': [float(f'{value:.3g}') for value in pace],
                     'disturbed': timings[preset]['disturbed']})
    return rows


def main():
    """Measure and print."""
    parser = argparse.ArgumentParser(description=__doc__.strip().splitlines()[0])
    parser.add_argument('--repeats', type=int, default=3)
    parser.add_argument('scenes', nargs='*', metavar='SCENE')
    options = parser.parse_args()
    names = options.scenes or sorted(path.stem for path in (ROOT / 'config').glob('*.yaml'))
    rows = []
    with timer(options.repeats, lambda text: None) as clock:
        for name in names:
            rows += measure(name, clock)
            print(json.dumps(rows[-4:], indent=1), file=sys.stderr)
    print(json.dumps({'date': datetime.now(timezone.utc).strftime('%Y-%m-%d'),
                      'machine': measured_on(), 'repeats': options.repeats,
                      'duration': DURATION, 'means_from': SETTLED, 'rows': rows}, indent=1))


if __name__ == '__main__':
    main()
