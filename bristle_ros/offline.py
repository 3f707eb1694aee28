"""The same simulation without ROS and without a clock: `simulate`, to arrays, a table or a log."""
from contextlib import ExitStack
import csv
from dataclasses import replace
import os
from pathlib import Path
import sys
import time

from bristle_ros.cli import add_scene, load_scene, Parser
from bristle_ros.scene import load, Scene, SceneError, steps
from bristle_ros.snapshot import NPZ_ARRAYS

INTERRUPTED = 130       # what a shell expects of a command that ended by Ctrl-C
PATIENCE = 1.0          # [s] a run may last before it shows its progress
_FORMATS = ('.npz', '.csv', '.mcap')


def simulate(scene_or_path, duration, *, sample=None, commands=None, output=None, overrides=None):
    """
    Simulate `duration` [s] of a scene and return its samples.

    scene_or_path : Scene or path of a scene file
    sample : [s] between samples; default run.sample
    commands : path of a CSV `t,topic,values...` or of a log; or a list of (t, topic, values)
    output : path of an .npz, .csv or .mcap to write as well
    overrides : dict, dotted scene key to value

    Returns dict of the arrays of `--output FILE.npz`, name to (n, ...) array, SI units.
    Raises SceneError for unusable input, and StepFailure when the simulation could not go on: then
    `output` holds what came before.
    """
    arrays = _Arrays()
    run = _Run(scene_or_path, duration, sample, commands, overrides)
    with ExitStack() as stack:
        run.go([arrays, *_open_output(output, run, arrays, stack)])
    if run.failure:
        raise run.failure
    return arrays.result(run)


class _Run:
    """One offline run: its driver, and what the summary says about it."""

    def __init__(self, scene_or_path, duration, sample, commands, overrides, *, energies=True):
        self.scene = _scene(scene_or_path, sample, overrides)
        self.steps = steps(self.scene, duration, 'duration')
        its = self.scene.solver.integration_time_step
        events = list(_events(commands, its))
        from bristle_ros.driver import Driver  # from here on the compiler is needed
        from bristle_ros.simulation import CommandRefused, Simulation
        self.simulation = Simulation(self.scene, energies=energies)
        for place, event in events:
            try:
                if event.topic:
                    self.simulation.check_command(event.topic, event.values)
            except CommandRefused as refused:
                raise SceneError(str(refused), source=place) from None
        self.driver = Driver(self.simulation, paced=False,
                             sample=steps(self.scene, self.scene.run.sample, 'run.sample'))
        self.driver.schedule([event for _, event in events])
        self.failure, self.interrupted = None, False
        self.samples, self.applied = 0, 0
        self._normal = self._torque = self._normal_max = 0.0

    def go(self, sinks, show=None):
        """Run to the end, giving each chunk to all `sinks`; `show(done, total)` sees it grow."""
        driver = self.driver
        try:
            while driver.total_step < self.steps and self.failure is None:
                chunk = driver.run_chunk(min(driver.chunk, self.steps - driver.total_step))
                if chunk.end == self.steps and chunk.end % driver.sample:
                    chunk = chunk._replace(samples=(*chunk.samples, chunk.last))
                self.failure = chunk.failure
                self._count(chunk)
                for sink in sinks:
                    sink.write(chunk)
                if show:
                    show(chunk.end, self.steps)
        except KeyboardInterrupt:
            self.interrupted = True

    def _count(self, chunk):
        wires = self.scene.brush.wires_per_bristle
        for snapshot in chunk.samples:
            normal = wires * float(snapshot.contact_force[:, 2].sum())
            self._normal += normal
            self._normal_max = max(self._normal_max, normal)
            self._torque -= float(snapshot.brush_torque[2])
        self.samples += len(chunk.samples)
        self.applied += len(chunk.events)

    def summary(self):
        """Return what a user wants to know at the end, a few lines."""
        driver = self.driver
        simulated = driver.total_step * driver.its
        wall = driver.stepping * 1e-9
        n, last = max(1, self.samples), self.simulation.snapshot()
        lines = [
            f'{simulated:.6g} s simulated in {wall:.3g} s, {simulated / max(wall, 1e-9):.3g} '
            f'times real time; compiled in {self.simulation.compile_time:.3g} s',
            f'normal force: mean {self._normal / n:.4g} N, largest {self._normal_max:.4g} N; '
            f'drive torque: mean {self._torque / n:.4g} N m',
            f'{self.samples} samples; Newton iterations {last.newton_iterations}, sub-steps '
            f'{last.substeps}; commands {self.applied}']
        if driver.scheduled:
            lines.append(f'{driver.scheduled} commands lie after the end and had no effect')
        return '\n'.join(lines)


def _scene(scene_or_path, sample, overrides):
    overrides = dict(overrides or {})
    if sample is not None:
        overrides['run.sample'] = sample
    if not isinstance(scene_or_path, Scene):
        return load(scene_or_path, overrides)
    scene = scene_or_path
    for key, value in overrides.items():
        section, _, leaf = key.rpartition('.')
        try:
            if section:
                value = replace(getattr(scene, section), **{leaf: value})
            scene = replace(scene, **{section or leaf: value})
        except (AttributeError, TypeError):
            raise SceneError('no such key', key=key, source='overrides') from None
    return scene


def _events(commands, its):
    """Return (place, Event) pairs of whatever `commands` is."""
    if commands is None:
        return []
    from bristle_ros.command_file import event_at, read_commands
    if isinstance(commands, (str, os.PathLike)):
        return read_commands(commands, its)
    return [(f'commands[{i}]', event_at(t, topic, values, its, f'commands[{i}]'))
            for i, (t, topic, values) in enumerate(commands)]


class _Arrays:
    """Collects samples as the arrays of the contract."""

    def __init__(self, path=None):
        self._path = path
        self._rows = []

    def write(self, chunk):
        self._rows.extend(chunk.samples)

    def result(self, run):
        """Return the arrays by name."""
        import numpy as np
        found = {name: np.array([getattr(row, name) for row in self._rows]) for name in NPZ_ARRAYS}
        found['wall_time'] = np.array(run.driver.stepping * 1e-9)
        found['compile_time'] = np.array(run.simulation.compile_time)
        return found


class _Table:
    """Writes samples as a CSV: one column for each component, named like `tip_position_0_x`."""

    def __init__(self, file):
        self._rows = csv.writer(file)
        self._header = False

    def write(self, chunk):
        for snapshot in chunk.samples:
            if not self._header:
                self._rows.writerow([name for field in NPZ_ARRAYS
                                     for name in _columns(field, getattr(snapshot, field))])
                self._header = True
            self._rows.writerow([value for field in NPZ_ARRAYS
                                 for value in _flat(getattr(snapshot, field))])


def _columns(field, value):
    shape = getattr(value, 'shape', ())
    if not shape:
        return [field]
    axes = 'xyzw'[:shape[-1]]
    wires = [f'{field}_{i}' for i in range(shape[0])] if len(shape) == 2 else [field]
    return [f'{wire}_{axis}' for wire in wires for axis in axes]


def _flat(value):
    return value.ravel().tolist() if hasattr(value, 'ravel') else [value]


def _check_output(output):
    """Raise SceneError for an output that cannot be one, before time is spent on the run."""
    path = Path(output).expanduser()
    if path.suffix not in _FORMATS:
        raise SceneError(f'must end in one of {", ".join(_FORMATS)}', key='--output',
                         value=str(output))
    if not path.parent.is_dir():
        raise SceneError(f'there is no directory {str(path.parent)!r}: make it first',
                         key='--output', value=str(output))
    return path


def _open_output(output, run, arrays, stack):
    """Return the sinks that write `output`; `stack` completes it, whatever happens meanwhile."""
    if output is None:
        return []
    path = _check_output(output)
    if path.suffix == '.mcap':
        from bristle_ros.log import Log
        from bristle_ros.simulation_mount import MountPath
        log = stack.enter_context(Log(path, run.scene, key='--output'))
        if run.scene.log.tf:
            run.driver.mount = MountPath(run.scene)
        stack.callback(_check_log, log, path)
        return [log]
    try:
        if path.suffix == '.csv':
            file = stack.enter_context(open(path, 'w', newline=''))  # noqa: SIM115
            return [_Table(file)]
        file = stack.enter_context(open(path, 'wb'))  # noqa: SIM115
    except OSError as error:
        raise SceneError(f'{(error.strerror or str(error)).lower()}: name another place',
                         key='--output', value=str(path)) from None
    import numpy as np
    stack.callback(lambda: np.savez(file, **arrays.result(run)))
    return []


def _check_log(log, path):
    log.close()
    if log.failed:
        raise SceneError(f'the log ended early: {log.failed}', key='--output', value=str(path))


def _parse(arguments):
    parser = Parser('simulate', 'Simulates a scene without ROS, as fast as it goes. A CSV of '
                    'commands has lines t,topic,values... with topic cmd_brush_speed (rad/s), '
                    'cmd_vel (vx, vy, yaw rate), cmd_penetration (m) or reset (none).')
    add_scene(parser)
    parser.add_argument('--duration', type=float, required=True, metavar='S',
                        help='simulated time [s]')
    parser.add_argument('--sample', type=float, metavar='S',
                        help='time between samples [s]; default: run.sample')
    parser.add_argument('--commands', metavar='FILE.csv|LOG.mcap',
                        help='commands to apply: a table, or the log of an earlier run')
    parser.add_argument('--output', metavar='FILE.npz|.mcap|.csv', help='where samples go')
    return parser.parse_args(arguments)


def main(arguments):
    """Run the verb `simulate`; return its exit code. Raises what bristle_ros.__main__ answers."""
    options = _parse(arguments)
    if options.output:
        _check_output(options.output)
    if options.sample is not None:
        options.overrides.append(f'run.sample:={options.sample!r}')
    arrays = _Arrays()
    with ExitStack() as stack:
        run = _Run(load_scene(options), options.duration, None, options.commands, None,
                   energies=not str(options.output).endswith('.mcap'))  # a log has none
        sinks = _open_output(options.output, run, arrays, stack)
        if str(options.output).endswith('.npz'):
            sinks.append(arrays)
        run.go(sinks, _progress(stack) if sys.stderr.isatty() else None)
    print(run.summary())
    if options.output:
        print(f'written: {options.output}')
    if run.failure:
        sys.stdout.flush()
        raise run.failure
    if run.interrupted:
        print('simulate: interrupted; the output is complete up to there', file=sys.stderr)
        return INTERRUPTED
    return 0


def _progress(stack):
    """Return show(done, total): a bar on stderr, once the run has shown to be a long one."""
    began, bar, shown = time.monotonic(), None, 0.0

    def show(done, total):
        nonlocal bar, shown
        now = time.monotonic()
        if now - began < PATIENCE or now - shown < 0.1:
            return
        shown = now
        if bar is None:
            from rich.console import Console
            from rich.progress import Progress
            bar = stack.enter_context(Progress(console=Console(stderr=True), transient=True))
            bar.add_task('simulating', total=total)
        bar.update(bar.task_ids[0], completed=done)
    return show
