"""Samples of an offline run as arrays, as an .npz file, as a table, or as a log."""
import csv
import os

from bristle_ros.command_line import check_new, check_place, partial, Undisturbed, WholeFile
from bristle_ros.scene import SceneError
from bristle_ros.simulation import ACCOUNTED, AIR_ARRAYS, DRIVE_ARRAYS, NPZ_ARRAYS

FORMATS = ('.npz', '.csv', '.mcap')


def chosen_arrays(names):
    """Return the names of the arrays to keep, t first: all for None; SceneError for unknown."""
    if names is None:
        return NPZ_ARRAYS
    known = (*NPZ_ARRAYS, *AIR_ARRAYS, *DRIVE_ARRAYS)
    for name in names:
        if name not in known:
            raise SceneError(f'must be some of {", ".join(known)}', key='--arrays',
                             value=str(name))
    return tuple(dict.fromkeys(('t', *names)))


def arrays_of(scene, arrays):
    """Return the arrays to keep of a scene; SceneError where one is chosen that it has not."""
    features = ((AIR_ARRAYS, scene.air.density > 0.0, 'air.density above 0'),
                (DRIVE_ARRAYS, scene.drive.mode != 'speed', 'drive.mode: motor or torque'))
    whole = arrays == NPZ_ARRAYS
    for names, there, needed in features:
        if there and whole:
            arrays = (*arrays, *names)
        for name in names:
            if not there and name in arrays:
                raise SceneError(f'needs {needed}', key='--arrays', value=name)
    return arrays


def wants_accounts(names):
    """Whether any of these arrays needs the accounts that steps keep only when asked to."""
    return not set(ACCOUNTED).isdisjoint(names)


class SampleArrays:
    """Collects samples as the arrays of the contract, in room for all that are expected."""

    def __init__(self, run):
        self._run, self._arrays, self._count = run, {}, 0

    def write(self, chunk):
        """Take a chunk's samples."""
        for snapshot in chunk.samples:
            if not self._arrays:
                self._make_room(snapshot)
            for name, array in self._arrays.items():
                array[self._count] = getattr(snapshot, name)
            self._count += 1

    def _make_room(self, snapshot):
        import numpy as np
        expected = self._run.expected_samples
        try:
            self._arrays = {name: np.empty((expected, *np.shape(value)), np.asarray(value).dtype)
                            for name in self._run.arrays for value in [getattr(snapshot, name)]}
        except (MemoryError, ValueError):
            raise SceneError(f'{expected} samples do not fit into memory: a longer run.sample, a '
                             'shorter run, or a log', key='--duration') from None

    def result(self):
        """Return the arrays by name, as far as samples came."""
        import numpy as np
        found = {name: array[:self._count] for name, array in self._arrays.items()}
        if not found:
            found = {name: np.empty(0) for name in self._run.arrays}
        found['wall_time'] = np.array(self._run.driver.stepping * 1e-9)
        found['compile_time'] = np.array(self._run.simulation.compile_time)
        return found


class _NpzFile:
    """Writes the arrays when the run is over."""

    def __init__(self, path, arrays, overwrite):
        self._arrays, self._whole = arrays, WholeFile(path, overwrite=overwrite)

    def __enter__(self):
        """Return itself."""
        self._whole.__enter__()
        return self

    def __exit__(self, kind, error, trace):
        """Write what came; put it in its place, or keep it beside."""
        if kind is None or issubclass(kind, KeyboardInterrupt):
            import numpy as np
            with Undisturbed():
                try:
                    np.savez(self._whole.file, **self._arrays.result())
                except OSError as failed:
                    kind, error = OSError, failed
        return self._whole.__exit__(kind, error, trace)

    def write(self, chunk):
        """Leave it to the arrays."""

    @property
    def kept(self):
        """Return where an interrupted run was kept, or None."""
        return self._whole.kept


class _TableFile:
    """Writes samples as a CSV: one column for each component, named like `tip_position_0_x`."""

    def __init__(self, path, arrays, overwrite):
        self._arrays = arrays
        self._whole = WholeFile(path, text=True, overwrite=overwrite)
        self._rows = csv.writer(self._whole.file)
        self._header = False

    def __enter__(self):
        """Return itself."""
        return self

    def __exit__(self, *error):
        """Put the table in its place, or keep it beside."""
        return self._whole.__exit__(*error)

    def write(self, chunk):
        """Write a row for each of a chunk's samples."""
        for snapshot in chunk.samples:
            if not self._header:
                self._rows.writerow([name for field in self._arrays
                                     for name in _columns(field, getattr(snapshot, field))])
                self._header = True
            self._rows.writerow([value for field in self._arrays
                                 for value in _flat(getattr(snapshot, field))])

    @property
    def kept(self):
        """Return where an interrupted run was kept, or None."""
        return self._whole.kept


class _LogFile:
    """Writes a log; one that replaces another stands beside it until it is complete."""

    def __init__(self, path, run, overwrite):
        from bristle_ros.log import Log
        from bristle_ros.simulation import MountPath
        check_new(path, overwrite=overwrite)
        self._path = path
        self._place = partial(path) if os.path.lexists(path) else path
        self._log = Log(self._place, run.scene, key='--output')
        self._driver = run.driver
        if run.scene.log.tf:
            run.driver.mount = MountPath(run.scene)
        self.kept = None

    def __enter__(self):
        """Return itself."""
        self._log.__enter__()
        return self

    def __exit__(self, kind, error, trace):
        """Complete the log; put it in the place of the one it replaces."""
        with Undisturbed():
            self._tell()
            self._log.__exit__(kind, error, trace)
            if self._log.failed:
                raise SceneError(f'the log ended early: {self._log.failed}', key='--output',
                                 value=str(self._place)) from None
            if kind is None and self._place != self._path:
                os.replace(self._place, self._path)
            elif kind is not None:
                self.kept = self._place

    def _tell(self):
        for warning in self._driver.warnings():
            self._log.event(self._driver.total_step, 'warning', kind=warning.kind,
                            text=str(warning))

    def write(self, chunk):
        """Log a chunk."""
        self._log.write(chunk)


def check_output(output, *, overwrite=False):
    """Return the path; raise SceneError for one that cannot be, before time is spent on a run."""
    return check_place(output, FORMATS, overwrite=overwrite)


def open_output(output, run, arrays, overwrite):
    """Return the context manager that takes chunks and leaves `output` whole."""
    path = check_output(output, overwrite=overwrite)
    if path.suffix == '.mcap':
        return _LogFile(path, run, overwrite)
    if path.suffix == '.csv':
        return _TableFile(path, run.arrays, overwrite)
    return _NpzFile(path, arrays, overwrite)


def _columns(field, value):
    shape = getattr(value, 'shape', ())
    if not shape:
        return [field]
    axes = '0123' if field.startswith('clamp_stress') else 'xyzw'[:shape[-1]]
    wires = [f'{field}_{i}' for i in range(shape[0])] if len(shape) == 2 else [field]
    return [f'{wire}_{axis}' for wire in wires for axis in axes]


def _flat(value):
    return value.ravel().tolist() if hasattr(value, 'ravel') else [value]
