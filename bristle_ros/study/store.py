"""
The directory of a study: its description, the parts of its table, its curves.

Parts are written beside their place and renamed, each for rows that no other part has: one written
twice is the same one. What is not there has not been run.
"""
import json
import os
from pathlib import Path
import re

from bristle_ros import __version__
from bristle_ros.log import measured_on
from bristle_ros.scene import SceneError, spell
import numpy as np
import pyarrow
from pyarrow import csv, parquet

from .measure import MEANS, MEASURES

RUNS, HALVED, CURVES, DESCRIPTION = 'runs.parquet', 'halved.parquet', 'curves.zarr', 'study.json'
_PART = re.compile(r'part-(\d{9})-(\d{9})\.parquet')
_TYPES = {bool: pyarrow.bool_(), int: pyarrow.int64(), float: pyarrow.float64(),
          str: pyarrow.string(), tuple: pyarrow.string(), list: pyarrow.string()}
EXTENSIBLE = ('sobol', 'saltelli', 'optimise')      # their first rows do not depend on the others


def schema_of(study):
    """Return the columns of a study's table."""
    fields = [('run', pyarrow.int64())]
    for factor in study.factors:
        value = factor.values[0] if factor.values else (0 if factor.whole else 0.0)
        fields.append((factor.key, _TYPES[type(value)]))
    fields += [('status', pyarrow.string()), ('message', pyarrow.string())]
    for name in MEASURES:
        fields.append((name, pyarrow.float64()))
        if name in MEANS:
            fields.append((f'{name}_ci95', pyarrow.float64()))
    fields += [('settled', pyarrow.string()), ('turns', pyarrow.int64()),
               ('local_error_max', pyarrow.float64()), ('wall_time', pyarrow.float64()),
               ('version', pyarrow.string()), ('target', pyarrow.string())]
    return pyarrow.schema(fields)


def write_part(folder, table, schema, first, end, rows):
    """Write rows `first` to `end` - 1 as a part of a table, whole or not at all."""
    place = Path(folder) / table / f'part-{first:09d}-{end:09d}.parquet'
    beside = place.with_name(f'.{place.name}.{os.uname().nodename}.{os.getpid()}')
    try:
        with open(beside, 'wb') as file:
            parquet.write_table(pyarrow.Table.from_pylist(rows, schema), file)
            file.flush()
            os.fsync(file.fileno())
        os.replace(beside, place)
    finally:
        beside.unlink(missing_ok=True)


def parts(folder, table=RUNS):
    """Return (first, end, path) of the parts of a table, in order."""
    found = []
    for path in (Path(folder) / table).glob('part-*.parquet'):
        match = _PART.fullmatch(path.name)
        if match:
            found.append((int(match[1]), int(match[2]), path))
    return sorted(found)


def missing(batches, folder):
    """Yield the stretches of (first, end) `batches` that no part has."""
    done = parts(folder)
    place = 0
    for first, end in batches:
        while place < len(done) and done[place][1] <= first:
            place += 1
        at, part = first, place
        while at < end:
            if part < len(done) and done[part][0] <= at:
                at, part = max(at, done[part][1]), part + 1
                continue
            until = min(end, done[part][0]) if part < len(done) else end
            yield at, until
            at = until


def check(study, folder, *, resume):
    """
    Return what is kept in a directory of this study, None where it has yet to be begun.

    Raises SceneError where it is of another study, or of this one and not `resume`.
    """
    folder = Path(folder)
    if (folder / DESCRIPTION).exists():
        if not resume:
            raise SceneError('has a study already: give --resume to go on with it, or another '
                             'place', key='--output', value=str(folder))
        there = description(folder)
        _compare(there, {'version': __version__, 'study': study.described()}, folder,
                 study.design)
        return there
    if folder.exists() and (not folder.is_dir() or any(folder.iterdir())):
        raise SceneError('is no directory of a study, and not empty: name another place',
                         key='--output', value=str(folder))
    return None


def begin(study, folder, *, resume):
    """
    Make the directory of a study, or go on in it; return what is kept there about it.

    Raises SceneError as `check` does.
    """
    folder = Path(folder)
    here = {'version': __version__, 'study': study.described(), 'batch': None,
            'machine': measured_on(), 'file': _text(study.source)}
    there = check(study, folder, resume=resume)
    if there is not None:
        if there['study'] == here['study']:
            return there
        here['batch'] = there['batch']
    for table in (RUNS, HALVED):
        (folder / table).mkdir(parents=True, exist_ok=True)
    save(folder, here)
    return here


def save(folder, description):
    """Write the description, whole or not at all."""
    path = Path(folder) / DESCRIPTION
    beside = path.with_name(f'.{path.name}.{os.getpid()}')
    try:
        with open(beside, 'w', encoding='utf-8') as file:
            json.dump(description, file, indent=1)
            file.flush()
            os.fsync(file.fileno())
        os.replace(beside, path)
    finally:
        beside.unlink(missing_ok=True)


def description(folder):
    """Return what a study's directory says about it; raise SceneError where it is none."""
    try:
        found = json.loads((Path(folder) / DESCRIPTION).read_text(encoding='utf-8'))
        if {'version', 'study', 'batch', 'file'} <= set(found):
            return found
    except (OSError, ValueError, TypeError):
        pass
    raise SceneError('is no directory of a study', source=str(folder))


def _text(path):
    try:
        return Path(path).read_text(encoding='utf-8')
    except OSError:
        return ''


def _compare(there, here, folder, design):
    if there['version'] != here['version']:
        raise SceneError(f'was begun by version {there["version"]} and this is '
                         f'{here["version"]}: begin it anew in another place', source=str(folder))
    names = {*there['study'], *here['study']}
    changed = [f'{name} was {spell(there["study"].get(name))}, is {spell(here["study"].get(name))}'
               for name in sorted(names)
               if there['study'].get(name) != here['study'].get(name)]
    if [line.partition(' ')[0] for line in changed] == ['samples'] and design in EXTENSIBLE and (
            here['study']['samples'] > there['study']['samples']):
        return
    if changed:
        more = f', and {len(changed) - 3} more' if len(changed) > 3 else ''
        raise SceneError(f'is of another study: {"; ".join(changed[:3])}{more}: begin anew in '
                         'another place', source=str(folder))


def table(folder, columns=None, name=RUNS):
    """
    Return a table of a study, in the order of its rows, as a pyarrow Table.

    Measures that the study's version had not are null.
    """
    files = [str(path) for _, _, path in parts(folder, name)]
    if not files:
        raise SceneError('has no finished runs yet', source=str(folder))
    there = parquet.read_schema(files[0]).names
    read = [column for column in columns if column in there] if columns else None
    found = pyarrow.concat_tables([parquet.read_table(file, columns=read) for file in files])
    for column in columns or MEASURES:
        if column not in found.column_names:
            found = found.append_column(column, pyarrow.nulls(len(found), pyarrow.float64()))
    return found.sort_by('run')


def write_csv(table, file):
    """Write a table, with a line of names, to an open file."""
    csv.write_csv(table, file)


def rows_between(folder, first, end):
    """Return rows `first` to `end` - 1, those that there are, as dicts in their order."""
    found = [row for low, high, path in parts(folder) if low < end and high > first
             for row in parquet.read_table(path).to_pylist() if first <= row['run'] < end]
    return sorted(found, key=lambda row: row['run'])


def count(folder):
    """Return how many rows the table of a study has."""
    return sum(end - first for first, end, _ in parts(folder))


def make_curves(study, folder, runs, shapes, samples):
    """Make room for the curves of all runs: NaN where none has been."""
    import zarr
    group = zarr.open_group(str(Path(folder) / CURVES), mode='a')
    for name in study.keep:
        if name in group:
            group[name].resize((runs, *group[name].shape[1:]))
            continue
        shape = (runs, samples, *shapes[name])
        group.create_array(
            name, shape=shape, chunks=(1, *shape[1:]), dtype='float64', fill_value=np.nan,
            dimension_names=('run', 'sample', *('bristle', 'axis')[2 - len(shape[2:]):]))


def write_curves(study, folder, run, history_of):
    """Keep the curves of one run; one written twice is the same."""
    import zarr
    group = zarr.open_group(str(Path(folder) / CURVES), mode='r+')
    for name in study.keep:
        values = history_of(name)
        group[name][run, :len(values)] = values


def open_study(folder):
    """
    Return a study's directory as an xarray Dataset along `run`; curves are read when used.

    Raises SceneError where the directory is of no study, or nothing of it has been run.
    """
    import xarray
    found = description(folder)
    frame = table(folder).to_pandas().set_index('run')
    data = xarray.Dataset.from_dataframe(frame)
    data.attrs.update(version=found['version'], study=json.dumps(found['study']))
    if (Path(folder) / CURVES).exists():
        curves = xarray.open_zarr(Path(folder) / CURVES, consolidated=False, chunks=None)
        data = data.merge(curves.isel(run=frame.index.to_numpy()))
    return data
