"""Reads measured tables: CSV with a line of names and numbers below, all finite."""
import csv
import math

from bristle_ros.scene import SceneError
import numpy as np


def read_table(path, least=1):
    """Return name -> (n,) array of a CSV file's columns; raise SceneError, naming the line."""
    source = str(path)
    try:
        with open(path, newline='', encoding='utf-8') as file:
            lines = [line for line in csv.reader(file) if line]
    except OSError as error:
        raise SceneError(f'cannot be read ({error.strerror}): give a CSV file',
                         source=source) from None
    except (UnicodeDecodeError, csv.Error):
        raise SceneError('is no CSV file', source=source) from None
    if len(lines) < 1 + least:
        raise SceneError(f'needs a line of names and at least {least} of numbers', source=source)
    names = [name.strip() for name in lines[0]]
    if len(set(names)) < len(names):
        raise SceneError('has two columns of one name', source=source)
    rows = []
    for number, line in enumerate(lines[1:], 2):
        try:
            values = [float(value) for value in line]
        except ValueError:
            values = [math.nan]
        if len(values) != len(names) or not all(map(math.isfinite, values)):
            raise SceneError(f'must be {len(names)} finite numbers', value=','.join(line),
                             source=f'{source}:{number}')
        rows.append(values)
    return dict(zip(names, np.array(rows).T))
