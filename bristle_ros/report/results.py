"""results.json: all that a report measured, from which its page is made."""
import json
import math

from bristle_ros.scene import SceneError
import numpy as np

FORMAT = 1
COUNTED = ('name', 'kind', 'drawn', 'reason', 'newton', 'steps', 'worst_step_newton',
           'worst_step_s', 'warnings', 'surface', 'looks', 'wire_points')


def clean(value):
    """Return a value as JSON can hold it: no arrays, no NaN, no infinities."""
    if isinstance(value, dict):
        return {str(key): clean(each) for key, each in value.items()}
    if isinstance(value, (list, tuple, np.ndarray)):
        return [clean(each) for each in value]
    if isinstance(value, np.generic):
        value = value.item()
    if isinstance(value, float):
        # 6 digits are more than any of it is sure to
        return float(f'{value:.6g}') if math.isfinite(value) else None
    return value


def write(path, results, indent=1):
    """Write results as JSON."""
    path.write_text(json.dumps(clean(results), indent=indent) + '\n', encoding='utf-8')


def read(path, key='--compare'):
    """Return the results in a file; raise SceneError for one that holds none."""
    try:
        found = json.loads(path.read_text(encoding='utf-8'))
        if found['format'] != FORMAT or not isinstance(found['parts'], dict):
            raise KeyError
    except OSError as error:
        raise SceneError(f'{(error.strerror or "unreadable").lower()}: name a results.json of the '
                         'verb report', key=key, value=str(path)) from None
    except (ValueError, KeyError, TypeError):
        raise SceneError("is no results.json of this version's verb report", key=key,
                         value=str(path)) from None
    return found


def kept(results):
    """Return results without what only figures need: what is kept with the source."""
    parts = {name: {key: value for key, value in data.items() if key not in ('series', 'steps')}
             for name, data in results['parts'].items() if name != 'estimate'}
    if 'stability' in parts:    # what is counted and shown of each case
        parts['stability'] = {**parts['stability'], 'cases': [
            {key: row[key] for key in COUNTED if key in row}
            for row in parts['stability']['cases']]}
    return {**results, 'parts': parts}
