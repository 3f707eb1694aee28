"""The same simulation without ROS and without a clock: `simulate`, to arrays, a table or a log."""
from contextlib import ExitStack
from dataclasses import replace
from math import isinf
import os
import sys
import time
from typing import TYPE_CHECKING
import warnings

from bristle_ros.command_line import add_scene, INTERRUPTED, load_scene, Parser, StopSignals
from bristle_ros.scene import follows_mount, load, Scene, SceneError, steps

from .sample_file import (arrays_of, check_output, chosen_arrays, open_output, SampleArrays,
                          wants_accounts)

if TYPE_CHECKING:
    from collections.abc import Iterable, Mapping
    from typing import Any, TypeAlias

    from bristle_ros.simulation import Values
    from numpy.typing import NDArray

    Place: TypeAlias = str | os.PathLike[str]

PATIENCE = 1.0          # [s] a run may last before it shows its progress


def simulate(scene_or_path: 'Scene | Place', duration: float, *, sample: float | None = None,
             commands: 'Place | Iterable[tuple[float, str, Values]] | None' = None,
             output: 'Place | None' = None, overrides: 'Mapping[str, object] | None' = None,
             overwrite: bool = False, arrays: 'Iterable[str] | None' = None
             ) -> 'dict[str, NDArray[Any]]':
    """
    Simulate `duration` [s] of a scene and return its samples.

    scene_or_path : Scene or path of a scene file
    sample : [s] between samples; default run.sample
    commands : path of a CSV `t,topic,values...` or of a log; or a list of (t, topic, values)
    output : path of an .npz, .csv or .mcap to write as well
    overrides : dict, dotted scene key to value
    overwrite : whether `output` may replace a file; that one stays until the new one is whole
    arrays : names of those to keep, t in any case; None: all. What others need is not compiled

    Returns dict of the arrays of `--output FILE.npz`, name to (n, ...) array, SI units.
    Raises SceneError for unusable input, and StepFailure when the simulation could not go on: then
    `output` holds what came before. A KeyboardInterrupt is passed on; what came before it is kept
    as NAME.partial.EXT beside `output`. What makes results doubtful is told as a RunWarning each,
    which the module `warnings` filters.
    """
    run = _Run(scene_or_path, duration, sample, commands, overrides, chosen_arrays(arrays))
    arrays = SampleArrays(run)
    with ExitStack() as stack:
        sinks = [arrays]
        if output is not None:
            sinks.append(stack.enter_context(open_output(output, run, arrays, overwrite)))
        run.go(sinks)
    for warning in run.driver.warnings():
        warnings.warn(warning, stacklevel=2)
    if run.failure:
        raise run.failure
    return arrays.result()


class _Run:
    """One offline run: its driver, and what the summary says about it."""

    def __init__(self, scene_or_path, duration, sample, commands, overrides, arrays):
        scene = _scene(scene_or_path, sample, overrides)
        events = list(_events(commands, scene.solver.integration_time_step))
        self.scene = scene = _carried_where_told(scene, events)
        self.arrays = arrays_of(scene, arrays)
        self.steps = steps(scene, duration, 'duration')
        from bristle_ros.realtime import Driver  # from here on the compiler is needed
        from bristle_ros.simulation import CommandRefused, MeanWrench, RunWatch, Simulation
        self.simulation = Simulation(self.scene, energies=wants_accounts(arrays))
        for place, event in events:
            try:
                if event.topic:
                    self.simulation.check_command(event.topic, event.values)
            except CommandRefused as refused:
                raise SceneError(str(refused), source=place) from None
        self.driver = Driver(self.simulation, paced=False,
                             sample=steps(self.scene, self.scene.run.sample, 'run.sample'))
        self.driver.watch = RunWatch(self.simulation)
        if follows_mount(self.scene):
            self.driver.mean = MeanWrench()
        self.driver.schedule([event for _, event in events])
        self.expected_samples = -(-self.steps // self.driver.sample)
        self.failure = None
        self.samples, self.applied = 0, 0

    def go(self, sinks, show=None):
        """Run to the end, giving each chunk to all `sinks`; `show(done, total)` sees it grow."""
        driver = self.driver
        while driver.total_step < self.steps and self.failure is None:
            chunk = driver.run_chunk(min(driver.chunk, self.steps - driver.total_step))
            if chunk.end == self.steps and chunk.end % driver.sample:
                chunk = chunk._replace(samples=(*chunk.samples, chunk.last))
                driver.look(chunk.last)
            self.failure = chunk.failure
            self.samples += len(chunk.samples)
            self.applied += len(chunk.events)
            for sink in sinks:
                sink.write(chunk)
            if show:
                show(chunk.end, self.steps)

    def summary(self):
        """Return what a user wants to know at the end, a few lines."""
        driver = self.driver
        simulated = driver.total_step * driver.its
        wall = driver.stepping * 1e-9
        last = self.simulation.snapshot()
        lines = [
            f'{simulated:.6g} s simulated in {wall:.3g} s, {simulated / max(wall, 1e-9):.3g} '
            f'times real time; compiled in {self.simulation.compile_time:.3g} s',
            *self._means(),
            f'{self.samples} samples; Newton iterations {last.newton_iterations}, sub-steps '
            f'{last.substeps}; commands {self.applied}']
        if driver.scheduled:
            lines.append(f'{driver.scheduled} commands lie after the end and had no effect')
        lines += [f'warning: {warning}' for warning in driver.warnings()]
        return '\n'.join(lines)

    def _means(self):
        """Return lines with the means since the approach, each with its 95 % interval."""
        from bristle_ros.simulation import QUANTITIES
        watch, parts = self.driver.watch, []
        begin, end = watch.window
        if not watch.means[0].count:
            return [f'no means: the road comes up until {begin:.6g} s (road.approach_time)']
        for (name, unit), mean in zip(QUANTITIES, watch.means):
            if name == 'normal force' and not self.scene.contact.enabled:
                continue
            width = '' if isinf(mean.half_width) else f' +- {mean.half_width:.2g}'
            parts.append(f'{name} {mean.mean:.4g}{width} {unit}'
                         f'{"" if mean.settled else " (not settled)"}')
        lines = [f'means over {begin:.6g} to {end:.6g} s, +- 95 % interval: {", ".join(parts)}']
        if self.scene.contact.enabled:
            lines.append(f'largest normal force: {watch.largest_normal:.4g} N')
        return lines


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


def _carried_where_told(scene, events):
    """Return the scene, with a mount that follows cmd_mount where commands have one."""
    if follows_mount(scene) or not any(event.topic == 'cmd_mount' for _, event in events):
        return scene
    return replace(scene, mount=replace(scene.mount, enabled=True))


def _events(commands, its):
    """Return (place, Event) pairs of whatever `commands` is."""
    if commands is None:
        return []
    from bristle_ros.log import event_at, read_commands
    if isinstance(commands, (str, os.PathLike)):
        return read_commands(commands, its)
    found = []
    if not hasattr(commands, '__iter__'):
        raise SceneError('must be a path, or a list of (t, topic, values)', key='commands',
                         value=commands)
    for i, command in enumerate(commands):
        place = f'commands[{i}]'
        try:
            t, topic, values = command
        except (TypeError, ValueError):
            raise SceneError(f'{command!r}: must be (t, topic, values)', source=place) from None
        found.append((place, event_at(t, topic, values, its, place)))
    return found


def _parse(arguments):
    parser = Parser('simulate', 'Simulates a scene without ROS, as fast as it goes. A CSV of '
                    'commands has lines t,topic,values... with topic cmd_brush_speed (rad/s), '
                    'cmd_vel (vx, vy, yaw rate), cmd_penetration (m), cmd_drive_torque (N m), '
                    'cmd_mount (x y z, quaternion x y z w, linear and angular velocity) or reset '
                    '(none).')
    add_scene(parser)
    parser.add_argument('--duration', type=float, required=True, metavar='S',
                        help='simulated time [s]')
    parser.add_argument('--sample', type=float, metavar='S',
                        help='time between samples [s]; default: run.sample')
    parser.add_argument('--commands', metavar='FILE.csv|LOG.mcap',
                        help='commands to apply: a table, or the log of an earlier run')
    parser.add_argument('--output', metavar='FILE.npz|.mcap|.csv', help='where samples go')
    parser.add_argument('--arrays', metavar='A,B,...',
                        help='arrays that --output keeps, t in any case; default: all. Energies '
                        'and extremes of the stress cost time only where they are kept')
    parser.add_argument('--overwrite', action='store_true',
                        help='let --output replace a file, once the new one is whole')
    return parser.parse_args(arguments)


def _arrays_of(options):
    logs = str(options.output).endswith('.mcap')
    if options.arrays is None:
        return () if logs else chosen_arrays(None)  # a log has no arrays
    if options.output is None or logs:
        raise SceneError('does nothing without --output FILE.npz or .csv', key='--arrays')
    return chosen_arrays([name.strip() for name in options.arrays.split(',')])


def main(arguments):
    """Run the verb `simulate`; return its exit code. Raises what bristle_ros.__main__ answers."""
    options = _parse(arguments)
    if options.overwrite and options.output is None:
        raise SceneError('does nothing without --output', key='--overwrite')
    if options.output is not None:
        check_output(options.output, overwrite=options.overwrite)
    if options.sample is not None:
        options.overrides.append(f'run.sample:={options.sample!r}')
    run = _Run(load_scene(options), options.duration, None, options.commands, None,
               _arrays_of(options))
    written, code = None, 0
    try:
        with StopSignals(), ExitStack() as stack:
            sinks = []
            if options.output is not None:
                arrays = SampleArrays(run)
                written = stack.enter_context(
                    open_output(options.output, run, arrays, options.overwrite))
                sinks = [arrays, written] if options.output.endswith('.npz') else [written]
            run.go(sinks, _progress(stack) if sys.stderr.isatty() else None)
    except KeyboardInterrupt as stop:
        code = getattr(stop, 'code', INTERRUPTED)
    print(run.summary())
    if code:
        kept = getattr(written, 'kept', None)
        place = f'; {kept} has what came before' if kept else ''
        print(f'simulate: interrupted{place}', file=sys.stderr)
        return code
    if options.output is not None:
        print(f'written: {options.output}')
    if run.failure:
        sys.stdout.flush()
        raise run.failure
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
