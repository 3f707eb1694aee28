"""
The stability campaign: run each case within bounds of time, and judge what came out.

A case ends as one of
    finished    it reached its end with finite, plausible values
    stopped     the simulation said that it could not go on, and why
    cut         its budget of processor time ran out; what it gave until then was plausible
    refused     the scene or a command was refused, with a line that says why
    wrong       values that are not finite or not plausible, or a case that did not come back
"""
from dataclasses import asdict, dataclass, field
import time

from bristle_ros.report.workers import Failed, Job
from bristle_ros.scene import from_parameters, SceneError

from . import cases as campaign_cases
from .checks import Watch
from .draws import build_of, drawn
from .surfaces import surface_name

KINDS = ('finished', 'stopped', 'cut', 'refused', 'wrong')
LIMIT = 20.0            # [s] of a processor for stepping one case
PATIENCE = 10.0         # times its limit, of its process's time, before a case is given up
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
    spent: float = 0.0              # [s] of a processor, for stepping
    steps: int = 0
    newton: int = 0
    substeps: int = 0
    worst_step_newton: int = 0      # iterations in the worst step (an upper bound)
    worst_step_s: float = 0.0       # [s] in the longest call
    warnings: str = ''              # kinds of what the run warned of
    measures: dict = field(default_factory=dict)    # of checks.Watch
    parameters: dict = field(default_factory=dict)
    drawn: bool = False             # at random
    surface: str = 'level'          # what the road is

    def row(self):
        """Return it as a flat dict, for a table."""
        flat = asdict(self)
        flat.pop('parameters')
        return {**flat, **flat.pop('measures')}


def run_case(case, limit=LIMIT, clock=time.process_time):
    """
    Run one case and return its Result; in a worker.

    limit : [s] of `clock`, the processor's: a busy machine cuts nothing off
    """
    from bristle_ros.simulation import CommandRefused, Simulation, StepFailure
    result = Result(case.name, duration=case.duration, parameters=case.parameters,
                    drawn=case.drawn, surface=surface_name(case.parameters))
    try:
        scene = from_parameters(case.parameters, case.name)
        simulation = Simulation(scene, energies=True)
    except SceneError as error:
        result.kind, result.reason = 'refused', str(error)
        return result
    try:
        return _Trial(case, scene, simulation, limit, clock).go(result)
    except StepFailure as failure:
        result.kind, result.reason = 'stopped', str(failure)
    except CommandRefused as refused:
        result.kind, result.reason = 'refused', str(refused)
    return result


class _Trial:
    """One case under way: its events, and looks at single steps."""

    def __init__(self, case, scene, simulation, limit, clock):
        self.simulation, self.limit, self.clock = simulation, limit, clock
        its = simulation.its
        self.total = max(1, round(case.duration / its))
        self.pending = sorted(
            [(round(t / its), topic, values) for t, topic, values in case.commands]
            + [(max(1, round(t / its)), None, ()) for t in case.resets], key=lambda e: e[0])
        self.look = max(1, self.total // LOOKS)
        self.call = max(1, self.total // CALLS)
        self.scene, self.done = scene, 0    # steps in all, through resets
        self.warned = set()
        self._begin()

    def _begin(self):
        from bristle_ros.simulation import RunWatch
        self.watch = Watch(self.scene, self.simulation)
        self.doubts = RunWatch(self.simulation)

    def _look(self, stepped=False):
        snapshot = self.simulation.snapshot()
        self.watch.look(snapshot, stepped)
        self.doubts.take(snapshot)

    def go(self, result):
        """Run to the end; fill the result, also where it stops."""
        from bristle_ros.simulation import StepFailure
        result.kind = 'finished'
        wrong = []
        try:
            self._look()
            while self.done < self.total and not self.watch.wrong:
                wrong += self._events()
                self._advance(result)
                if result.spent > self.limit and self.done < self.total:
                    result.kind, result.reason = 'cut', self._pace(result)
                    break
        except StepFailure as failure:
            result.kind, result.reason = 'stopped', str(failure)
        if not self.watch.wrong:
            self._look()
        wrong += self.watch.wrong
        self._note_warnings()
        if wrong:
            result.kind, result.reason = 'wrong', '; '.join([*wrong, result.reason]).rstrip('; ')
        result.reached, result.steps = self.done * self.simulation.its, self.done
        result.newton += int(self.simulation.state.counts[:, 0].sum())
        result.substeps += self.simulation.snapshot().substeps
        result.warnings = ', '.join(sorted(self.warned))
        result.measures = self.watch.measures()
        return result

    def _note_warnings(self):
        self.warned |= {warning.kind for warning in self.doubts.warnings()}

    def _pace(self, result):
        """Return why the budget ran out, in numbers."""
        snapshot = self.simulation.snapshot()
        return (f'{self.done} of {self.total} steps in {result.spent:.3g} s: '
                f'{1e6 * result.spent / self.done:.3g} us, '
                f'{snapshot.newton_iterations / max(1, snapshot.step):.3g} Newton iterations and '
                f'{snapshot.substeps / max(1, snapshot.step):.3g} sub-steps each')

    def _events(self):
        """Follow what is due; return what was wrong before a reset."""
        wrong = []
        while self.pending and self.pending[0][0] <= self.done:
            _, topic, values = self.pending.pop(0)
            if topic is None:
                wrong += self.watch.wrong
                self._note_warnings()
                self.simulation.reset()
                self._begin()
                self._look()
            else:
                self.simulation.command(topic, values)
                self.watch.commanded()
        return wrong

    def _advance(self, result):
        simulation, step = self.simulation, self.done
        to_look = self.look - step % self.look      # the last step before a look is made alone
        n = min(self.call, max(1, to_look - 1), self.total - step)
        if self.pending:
            n = min(n, self.pending[0][0] - step)
        before = int(simulation.state.counts[:, 0].sum())
        if to_look == 1:
            self.watch.before_step(simulation.snapshot())
        began = self.clock()
        try:
            simulation.advance(n)
        finally:
            took = self.clock() - began
            result.spent += took
        self.done += n
        made = int(simulation.state.counts[:, 0].sum()) - before
        result.worst_step_s = max(result.worst_step_s, took)
        result.worst_step_newton = max(result.worst_step_newton, made - (n - 1))
        if to_look == 1:
            self._look(stepped=True)
        if took > 0.5 and self.call > 1:
            self.call = max(1, self.call // 4)


def measure(context, cases=None):
    """Return the part's data: a row for each case."""
    if cases is None:
        cases = campaign_cases.short() if context.quick else campaign_cases.listed()
        cases = cases + drawn(context.seed, context.drawn, 0.1 if context.quick else 0.5,
                              context.case_limit, context.builds)

    def tell(value, job, done, total):
        context.progress.count(done, total, f'campaign {done} of {total}: {job.label}')
    found = context.crew.run([Job(run_case, (case, context.case_limit), case.name)
                              for case in cases], limit=PATIENCE * context.case_limit, show=tell)
    rows = []
    for case, result in zip(cases, found):
        if isinstance(result, Failed):
            result = Result(case.name, reason=result.reason, drawn=case.drawn,
                            parameters=case.parameters, surface=surface_name(case.parameters))
        rows.append(result.row())
    return {'cases': rows, 'seed': context.seed, 'case_limit': context.case_limit,
            'builds': len({build_of(case.parameters) for case in cases if case.drawn}),
            'of_builds': context.builds}
