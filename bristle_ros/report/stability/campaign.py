"""
The stability campaign: run each case within bounds of time, and judge what came out.

A case ends as one of
    finished    it reached its end with finite, plausible values
    stopped     the simulation said that it could not go on, and why
    cut         the clock cut it off; what it gave until then was plausible
    refused     the scene was refused, with a line that says why
    wrong       values that are not finite or not plausible, or a case that did not come back
"""
from dataclasses import asdict, dataclass, field
import math
import multiprocessing
from multiprocessing.connection import wait
import signal
import time

from bristle_ros.scene import from_parameters, SceneError

from .checks import Watch

KINDS = ('finished', 'stopped', 'cut', 'refused', 'wrong')
WALL_LIMIT = 20.0       # [s] of stepping for one case
GRACE = 150.0           # [s] on top of it for compiling, and for a step that is under way
LOOKS = 250             # at the outputs of one case
CALLS = 20_000          # of advance() in one case: most are of a single step


@dataclass
class Result:
    """What became of a case."""

    name: str
    kind: str = 'wrong'
    reason: str = ''
    reached: float = 0.0            # [s] of simulated time
    duration: float = 0.0           # [s] asked for
    wall: float = 0.0               # [s] of stepping
    steps: int = 0
    newton: int = 0
    substeps: int = 0
    worst_step_newton: int = 0      # iterations in the worst step (an upper bound)
    worst_step_s: float = 0.0       # [s] in the longest call
    measures: dict = field(default_factory=dict)    # of campaign_checks.Watch
    parameters: dict = field(default_factory=dict)

    def row(self):
        """Return it as a flat dict, for a table."""
        flat = asdict(self)
        flat.pop('parameters')
        return {**flat, **flat.pop('measures')}


def run_case(case, wall_limit=WALL_LIMIT, clock=time.perf_counter):
    """Run one case and return its Result."""
    from bristle_ros.simulation import Simulation, StepFailure  # from here on: the compiler
    result = Result(case.name, duration=case.duration, parameters=case.parameters)
    try:
        scene = from_parameters(case.parameters, case.name)
        simulation = Simulation(scene, energies=True)
    except SceneError as error:
        result.kind, result.reason = 'refused', str(error)
        return result
    watch = Watch(scene, simulation, follows_road=not case.commands)
    total = round(case.duration / simulation.its)
    pending = [(round(t / simulation.its), topic, values) for t, topic, values in case.commands]
    look = max(1, total // LOOKS)
    call = max(1, total // CALLS)
    result.kind = 'finished'
    try:
        watch.look(simulation.snapshot())
        while simulation.step < total and not watch.wrong:
            step = simulation.step
            while pending and pending[0][0] <= step:
                simulation.command(*pending.pop(0)[1:])
            to_look = look - step % look        # the last step before a look is made alone
            n = min(call, max(1, to_look - 1), total - step)
            if pending:
                n = min(n, pending[0][0] - step)
            before = int(simulation.state.counts[:, 0].sum())
            if to_look == 1:
                watch.before_step(simulation.snapshot())
            began = clock()
            simulation.advance(n)
            took = clock() - began
            made = int(simulation.state.counts[:, 0].sum()) - before
            result.wall += took
            result.worst_step_s = max(result.worst_step_s, took)
            result.worst_step_newton = max(result.worst_step_newton, made - (n - 1))
            if to_look == 1:
                watch.look(simulation.snapshot(), stepped=True)
            if took > 0.5 and call > 1:
                call = max(1, call // 4)
            if result.wall > wall_limit and simulation.step < total:
                result.kind = 'cut'
                break
    except StepFailure as failure:
        result.kind, result.reason = 'stopped', str(failure)
    snapshot = simulation.snapshot()
    watch.look(snapshot)
    if watch.wrong:
        result.kind, result.reason = 'wrong', '; '.join([*watch.wrong, result.reason]).rstrip('; ')
    result.reached, result.steps = snapshot.t, snapshot.step
    result.newton, result.substeps = snapshot.newton_iterations, snapshot.substeps
    result.measures = watch.measures()
    return result


def _work(pipe):
    """Run cases from a pipe until it closes; what a worker process does."""
    try:
        while True:
            case, wall_limit = pipe.recv()
            pipe.send(run_case(case, wall_limit))
    except EOFError:
        pass


class _Worker:
    """A process that runs one case after the other and can be ended when one hangs."""

    def __init__(self, context):
        self.pipe, theirs = context.Pipe()
        self.process = context.Process(target=_work, args=(theirs,), daemon=True)
        # Ctrl-C is the parent's to answer; this would print where its imports were.
        signal.pthread_sigmask(signal.SIG_BLOCK, {signal.SIGINT})
        try:
            self.process.start()
        finally:
            signal.pthread_sigmask(signal.SIG_UNBLOCK, {signal.SIGINT})
        theirs.close()
        self.case, self.deadline = None, math.inf

    def give(self, case, wall_limit):
        self.case, self.deadline = case, time.monotonic() + wall_limit + GRACE
        self.pipe.send((case, wall_limit))

    def end(self):
        self.pipe.close()
        self.process.terminate()
        self.process.join()


def run_cases(cases, workers=1, wall_limit=WALL_LIMIT, show=None):
    """
    Run cases in `workers` processes; return their Results in the cases' order.

    show(result, done, total) is called as each one ends. A case whose process dies or does not
    come back is wrong; its process is replaced.
    """
    context = multiprocessing.get_context('spawn')
    todo = list(enumerate(cases))[::-1]
    found = {}
    crew = [_Worker(context) for _ in range(max(1, min(workers, len(todo))))]
    places = {}
    try:
        while len(found) < len(cases):
            for i, worker in enumerate(crew):
                if worker.case is None and todo:
                    places[i], case = todo.pop()
                    worker.give(case, wall_limit)
            ready = wait([worker.pipe for worker in crew if worker.case is not None], timeout=1.0)
            for i, worker in enumerate(crew):
                if worker.case is None:
                    continue
                result = None
                if worker.pipe in ready:
                    try:
                        result = worker.pipe.recv()
                    except (EOFError, OSError):
                        result = Result(worker.case.name, reason='its process died',
                                        parameters=worker.case.parameters)
                elif time.monotonic() > worker.deadline:
                    result = Result(worker.case.name, reason='did not come back within '
                                    f'{wall_limit + GRACE:g} s', parameters=worker.case.parameters)
                if result is None:
                    continue
                if result.reason.startswith(('its process', 'did not come')):
                    worker.end()
                    crew[i] = _Worker(context)
                worker.case = None
                found[places[i]] = result
                if show:
                    show(result, len(found), len(cases))
    finally:
        for worker in crew:
            worker.end()
    return [found[i] for i in range(len(cases))]


def problem_of(kinds):
    """
    Return why the counts of a campaign are not a pass, or an empty text.

    A case that was cut off tells nothing about the rest of its time, and no case tells nothing.
    """
    total = sum(kinds.values())
    texts = [f'{kinds[kind]} of {total} cases {words}' for kind, words in (
        ('wrong', 'are wrong'), ('cut', 'were cut off by the wall limit')) if kinds[kind]]
    if not kinds['finished'] + kinds['stopped']:
        texts.append(f'none of {total} cases ran to its end')
    return ', '.join(texts)


def count_kinds(results):
    """Return how many results there are of each kind."""
    return {kind: sum(result.kind == kind for result in results) for kind in KINDS}
