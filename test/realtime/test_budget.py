"""The budget of adaptive steps: what it decides, and that its decisions are replayed."""
from dataclasses import replace

from bristle_ros.log.writer import Log
from bristle_ros.realtime.budget import LoadBudget, LOOSEST, PERIOD, TIGHTEST
from bristle_ros.realtime.driver import Driver
from bristle_ros.scene.sections import Run
from bristle_ros.simulation.model import WORST_ERROR
from bristle_ros.simulation.simulation import Simulation
from bristle_ros.verbs.verify import verify
from physics.scenes import free_rotation
import pytest

MS = 1_000_000


def decisions(budget, loads):
    """Return what the budget decides when stepping takes these shares of its periods."""
    now = stepping = 0
    budget.decide(now, stepping)
    made = []
    for load in loads:
        now += PERIOD
        stepping += round(load * PERIOD)
        made.append(budget.decide(now, stepping))
    return made


def test_too_much_load_loosens_and_too_little_tightens():
    looser, kept, tighter, halfway = decisions(LoadBudget(0.5, 1e-5), [0.6, 0.45, 0.1, 0.25])
    assert looser == pytest.approx(1e-5 * (0.6 / 0.4) ** 3)
    assert kept is None
    assert tighter == pytest.approx(looser / 8.0)
    assert halfway == pytest.approx(tighter * (0.25 / 0.4) ** 3)


def test_the_tolerance_stays_within_bounds():
    assert decisions(LoadBudget(0.5, 1e-5), [3.0] * 20)[-1] is None     # nothing left to give
    budget = LoadBudget(0.5, 1e-5)
    decisions(budget, [3.0] * 20)
    assert budget.tolerance == LOOSEST == WORST_ERROR
    budget = LoadBudget(0.5, 1e-5)
    decisions(budget, [0.01] * 20)
    assert budget.tolerance == TIGHTEST


def test_nothing_is_decided_within_a_period_or_after_a_pause():
    budget = LoadBudget(0.5, 1e-5)
    assert budget.decide(0, 0) is None
    assert budget.decide(PERIOD - 1, PERIOD) is None
    budget.forget()
    assert budget.decide(2 * PERIOD, 2 * PERIOD) is None


class Costly:
    """A clock of [ns] that one reading more moves by `each`: stepping seems to take that long."""

    def __init__(self, each):
        self.now, self.each = 0, each

    def __call__(self):
        self.now += self.each
        return self.now


def test_a_run_within_its_budget_is_replayed_bit_for_bit(tmp_path):
    scene = free_rotation(its=1e-3, step='adaptive', error_tolerance=1e-6)
    scene = replace(scene, run=Run(max_load=0.1, chunk=0.01, sample=0.005))
    driver = Driver(Simulation(scene), clock=Costly(10 * MS), sample=5)
    found = []
    with Log(tmp_path / 'a.mcap', scene) as log:
        for _ in range(40):
            chunk = driver.run_chunk()
            found += [event for event in chunk.events if event.kind == 'load']
            log.write(chunk)
    assert len(found) > 1
    verdict = verify(tmp_path / 'a.mcap')
    assert (verdict.difference, verdict.applied) == ('', len(found))
    # the decisions matter: without them the run is another one
    alone = Simulation(scene)
    alone.advance(driver.total_step)
    assert alone.snapshot().newton_iterations != chunk.last.newton_iterations
