#!/usr/bin/env python3
"""
Fits made-up measurements with noise: how often do the intervals hold the truth?

    test/study/recover.py KEPT.jsonl [--cases 20] [--seed 1] [--workers 2]

Each case draws friction.kinetic, friction.static, friction.decay and damping.stiffness, simulates
16 rows of speed and depth, adds 3 % of noise to three measures, and fits. Of 80 intervals, 70 are
to hold the truth. Then one case whose speeds are all alike, which should be said not to tell.
KEPT.jsonl gets a line for each case; cases that it has already are not run again. The sets of the
first round are the same in all cases, and are run once.
"""
import argparse
from dataclasses import replace
import json
from pathlib import Path
import sys
import time

import numpy as np

ROOT = Path(__file__).resolve().parents[2]
sys.path.insert(0, str(ROOT))

from bristle_ros.scene import load  # noqa: E402
from bristle_ros.study.cluster import open_cluster  # noqa: E402
from bristle_ros.study.factor import Factor  # noqa: E402
from bristle_ros.study.fit import residuals, simulated, study_of  # noqa: E402
from bristle_ros.study.fitting import fit  # noqa: E402

FACTORS = [Factor('friction.kinetic', None, 0.1, 0.6), Factor('friction.static', None, 0.6, 1.2),
           Factor('friction.decay', None, 0.1, 2.0, log=True),
           Factor('damping.stiffness', None, 1e-4, 1e-2, log=True)]
SET = [Factor('drive.mean_speed', None), Factor('road.penetration', None)]
# no stress range: of a wire that slides steadily it is a few Pa, and 3 % of that no measurement
MEASURES = ('drive_torque_mean', 'normal_force_mean', 'normal_force_rms')
SPEEDS = (0.3, 0.6, 1.2, 2.5, 5.0, 10.0, 15.0, 20.0) * 2
DEPTHS, NOISE = (0.03, 0.05), 0.03


def model(client, speeds):
    """Return the function of places that simulates all rows, each place once."""
    scene = load(ROOT / 'config/cutting_brush.yaml', {
        'solver.integration_time_step': 1e-3, 'solver.elements': 4})
    study = replace(study_of(scene, [*SET, *FACTORS], 2.0, 1.0, sample=0.005), turns=None,
                    duration=2.0)
    of = simulated(study, list(zip(speeds, np.repeat(DEPTHS, len(speeds) // 2).tolist())),
                   MEASURES, client)
    known = {}

    def once(places):
        new = [place for place in places if place not in known]
        if new:
            known.update(zip(new, of(new)))
        return np.array([known[place] for place in places])
    return once


def case(of, seed):
    """Return what was drawn, and the Fit."""
    rng = np.random.default_rng(seed)
    truth = tuple(factor.at(place)
                  for factor, place in zip(FACTORS, rng.uniform(0.2, 0.8, 4).tolist()))
    exact = of([truth])[0].T
    size = np.abs(exact)    # a tenth of the mean: no row is exact because it is small
    sd = NOISE * np.maximum(size, 0.1 * size.mean(axis=1, keepdims=True))
    given = {'values': exact + sd * rng.standard_normal(exact.shape), 'deviations': sd}
    return truth, fit(FACTORS, residuals(of, given))


def main():
    parser = argparse.ArgumentParser(description=__doc__,
                                     formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument('kept', type=Path)
    parser.add_argument('--cases', type=int, default=20)
    parser.add_argument('--seed', type=int, default=1)
    parser.add_argument('--workers', type=int, default=2)
    options = parser.parse_args()
    options.kept.touch()
    done = [json.loads(line) for line in options.kept.read_text().splitlines()]
    with open_cluster(None, options.workers) as client:
        of = model(client, SPEEDS)
        for number in set(range(options.cases)) - {one['case'] for one in done}:
            began = time.monotonic()
            truth, found = case(of, (options.seed, number))
            inside = (found.low <= truth) & (truth <= found.high)
            done.append({'case': number, 'inside': inside.tolist(), 'truth': truth,
                         'value': found.value.tolist(), 'low': found.low.tolist(),
                         'high': found.high.tolist(), 'doubts': found.doubts, 'sets': found.sets,
                         'scale': found.scale, 'seconds': round(time.monotonic() - began)})
            with open(options.kept, 'a') as file:
                file.write(json.dumps(done[-1]) + '\n')
            print(done[-1], flush=True)
        held = np.sum([one['inside'] for one in done], axis=0)
        print(f'{held.sum()} of {4 * len(done)} intervals hold the truth: {held}', flush=True)
        print('one speed:', case(model(client, (8.0,) * 16), options.seed)[1].doubts)


if __name__ == '__main__':
    main()
