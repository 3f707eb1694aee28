"""Designs: their order, and that any stretch of one is part of the whole."""
from bristle_ros.study.design import rows
import numpy as np
import pytest
from SALib.sample import sobol

RANGES = """
design: {}
samples: 64
seed: 5
duration: 1.0
vary:
  road.penetration: {{from: 0.01, to: 0.03}}
  drive.mean_speed: {{from: 1.0, to: 100.0, scale: log}}
  drive.profile: [constant, sine, vap]
"""


def test_the_last_key_of_a_grid_varies_fastest(study_of):
    study = study_of('duration: 1\nvary:\n  gravity: [1.0, 2.0]\n'
                     '  drive.mean_speed: {from: 1, to: 100, count: 3, scale: log}\n')
    assert rows(study, 0, 6) == [(g, pytest.approx(v)) for g in (1.0, 2.0)
                                 for v in (1.0, 10.0, 100.0)]


@pytest.mark.parametrize('design', ['latin_hypercube', 'sobol', 'saltelli'])
def test_a_stretch_is_part_of_the_whole(study_of, design):
    study = study_of(RANGES.format(design))
    whole = rows(study, 0, study.runs)
    assert len(whole) == study.runs == (64 * 8 if design == 'saltelli' else 64)
    for first, end in ((0, 1), (5, 23), (40, 64), (63, 64)):
        assert rows(study, first, end) == whole[first:end]
    assert all(0.01 <= a <= 0.03 and 1.0 <= b <= 100.0 for a, b, _ in whole)


def test_a_latin_hypercube_has_one_row_in_each_stratum(study_of):
    study = study_of(RANGES.format('latin_hypercube'))
    values = np.array([row[:2] for row in rows(study, 0, 64)])
    for places in ((values[:, 0] - 0.01) / 0.02, np.log(values[:, 1]) / np.log(100.0)):
        assert sorted(np.floor(64.0 * places).astype(int)) == list(range(64))


def test_a_sobol_sequence_is_balanced(study_of):
    study = study_of(RANGES.format('sobol'))
    profiles = [row[2] for row in rows(study, 0, 64)]
    assert all(20 <= profiles.count(name) <= 23 for name in ('constant', 'sine', 'vap'))
    low = sum(row[0] < 0.02 and row[1] < 10.0 for row in rows(study, 0, 64))
    assert low == 16    # a quarter of the points in a quarter of the square


def test_saltelli_rows_are_those_of_salib(study_of):
    study = study_of(RANGES.format('saltelli').replace('  drive.profile: [constant, sine, vap]\n',
                                                       '').replace(', scale: log', ''))
    theirs = sobol.sample({'num_vars': 2, 'names': ['a', 'b'], 'bounds': [[0.01, 0.03],
                                                                          [1.0, 100.0]]},
                          64, scramble=True, seed=np.random.default_rng(5))
    assert np.array(rows(study, 0, study.runs)) == pytest.approx(theirs, rel=1e-12)


def test_a_larger_sample_begins_with_the_smaller(study_of):
    small, large = (study_of(RANGES.format('saltelli').replace('64', size))
                    for size in ('64', '128'))
    assert rows(large, 0, small.runs) == rows(small, 0, small.runs)
