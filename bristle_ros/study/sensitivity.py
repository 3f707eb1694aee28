"""Sobol's sensitivity indices of each measure from rows of Saltelli's scheme, with intervals."""
import numpy as np
from SALib.analyze import sobol

from . import store
from .measure import MEASURES

RESAMPLES = 200         # of the bootstrap that the intervals are from


def indices(study, folder):
    """
    Return (measure -> list of dicts of a key's indices, reason).

    key, S1, S1_ci95 (its own influence), ST, ST_ci95 (with others); shares of the variance. Empty,
    with the reason, where rows are missing or did not finish. Measures that do not vary, or have
    no value in some rows, are left out.
    """
    found = store.table(folder, ['run', 'status', *MEASURES])
    status = np.array(found['status'].to_pylist())
    bad = int((status != 'finished').sum())
    if bad or len(status) < study.runs:
        return {}, (f'{bad} of {len(status)} rows did not finish, {study.runs - len(status)} are '
                    'missing: indices cannot be had from what is left')
    problem = {'num_vars': len(study.factors), 'names': [f.key for f in study.factors],
               'bounds': [[0.0, 1.0]] * len(study.factors)}
    result = {}
    for name in MEASURES:
        values = found[name].to_numpy(zero_copy_only=False).astype(float)
        scale = float(np.abs(values).max(initial=0.0)) if np.isfinite(values).all() else 0.0
        if scale == 0.0 or float(np.std(values)) <= 1e-12 * scale:
            continue
        with np.errstate(all='ignore'):
            si = sobol.analyze(problem, values, num_resamples=RESAMPLES, seed=study.seed,
                               print_to_console=False)
        result[name] = [
            {'key': key, 'S1': float(si['S1'][i]), 'S1_ci95': float(si['S1_conf'][i]),
             'ST': float(si['ST'][i]), 'ST_ci95': float(si['ST_conf'][i])}
            for i, key in enumerate(problem['names'])]
    return result, ''
