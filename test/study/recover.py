#!/usr/bin/env python3
"""
Fits made-up measurements with noise: how often do the intervals hold the truth?

    test/study/recover.py [--cases 20] [--seed 1] [--workers 2]

Each case draws friction.kinetic, friction.static, friction.decay and damping.stiffness, simulates
16 rows of speed and depth, adds 3 % of noise to three measures, and fits. Of 80 intervals, 70 are
to hold the truth. Then one case whose speeds are all alike, which should be said not to tell.
"""
import argparse
from dataclasses import replace
from pathlib import Path
import sys
import time

import numpy as np

ROOT = Path(__file__).resolve().parents[2]
sys.path.insert(0, str(ROOT))

from bristle_ros.scene import load  # noqa: E402
from bristle_ros.study.cluster import open_cluster  # noqa: E402
from bristle_ros.study.factor import Factor  # noqa: E402
from bristle_ros.study.fit import residuals, study_of  # noqa: E402
from bristle_ros.study.fitting import fit  # noqa: E402

FACTORS = [Factor('friction.kinetic', None, 0.1, 0.6), Factor('friction.static', None, 0.6, 1.2),
           Factor('friction.decay', None, 0.1, 2.0, log=True),
           Factor('damping.stiffness', None, 1e-4, 1e-2, log=True)]
SET = [Factor('drive.mean_speed', None), Factor('road.penetration', None)]
MEASURES = ('drive_torque_mean', 'normal_force_mean', 'clamp_stress_range')
SPEEDS = (0.3, 0.6, 1.2, 2.5, 5.0, 10.0, 15.0, 20.0) * 2
DEPTHS, NOISE = (0.03, 0.05), 0.03


def case(rng, client, speeds):
    scene = load(ROOT / 'config/cutting_brush.yaml', {
        'solver.integration_time_step': 1e-3, 'solver.elements': 4})
    study = replace(study_of(scene, [*SET, *FACTORS], 2.0, 1.0, sample=0.005), turns=None,
                    duration=2.0)
    truth = [factor.at(place) for factor, place in zip(FACTORS, rng.uniform(0.2, 0.8, 4))]
    given = {'set': [np.array(speeds), np.repeat(DEPTHS, len(speeds) // 2)],
             'values': np.zeros((3, len(speeds))), 'deviations': np.ones((3, len(speeds)))}
    exact = residuals(study, MEASURES, given, client)([truth])[0].reshape(len(speeds), 3).T
    size = np.abs(exact)    # a tenth of the mean: no row is exact because it is small
    given['deviations'] = NOISE * np.maximum(size, 0.1 * size.mean(axis=1, keepdims=True))
    given['values'] = exact + given['deviations'] * rng.standard_normal(exact.shape)
    return truth, fit(FACTORS, residuals(study, MEASURES, given, client))


def main():
    parser = argparse.ArgumentParser(description=__doc__,
                                     formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument('--cases', type=int, default=20)
    parser.add_argument('--seed', type=int, default=1)
    parser.add_argument('--workers', type=int, default=2)
    options = parser.parse_args()
    rng, held = np.random.default_rng(options.seed), np.zeros(4, int)
    with open_cluster(None, options.workers) as client:
        for number in range(options.cases):
            began = time.monotonic()
            truth, found = case(rng, client, SPEEDS)
            inside = (found.low <= truth) & (truth <= found.high)
            held += inside
            print(number, inside.astype(int), ' '.join(
                f'{t:.3g}:{v:.3g}[{a:.3g},{b:.3g}]' for t, v, a, b in zip(
                    truth, found.value, found.low, found.high)), found.doubts,
                f'scale {found.scale:.2f}, {time.monotonic() - began:.0f} s', flush=True)
        print(f'{held.sum()} of {4 * options.cases} intervals hold the truth: {held}')
        print('one speed:', case(rng, client, (8.0,) * 16)[1].doubts)


if __name__ == '__main__':
    main()
