"""
A wrong derivative costs iterations only: those are bounded, and derivatives tested.

Counts are the same on every machine: kernels run as plain Python.
"""
from bristle_ros.physics.contact import bracket, newton, tip
from bristle_ros.physics.contact.law import ContactLaw, SLIP, STICK
from bristle_ros.physics.step import equilibrium, newton as step_newton
from bristle_ros.physics.step.records import FACTORISATIONS, FAILURES, NEWTON
from bristle_ros.simulation.simulation import Simulation
import numpy as np
from physics.interpreted.test_motion import case, SCENES, touching
import pytest

LAWS = {'spring': ContactLaw(3e4, 1.0, 0.8, 0.2, 2.0),
        'undamped': ContactLaw(1e5, 0.0, 0.6, 0.6, 0.0),
        'rigid': ContactLaw(0.0, 0.0, 0.9, 0.1, 3.0)}
H = 1e-4


def problems(law, wanted, count=25):
    """Yield contact problems with their solution, all terms of their compliance at work."""
    rng = np.random.default_rng(5)
    found = 0
    while found < count:
        m = rng.normal(size=(3, 3))
        w = 2e-5 * (m @ m.T + 0.3 * np.eye(3))
        base = 1e-4 * rng.normal(size=3) * ([1.0, 1.0, 1.0] if wanted == SLIP else [0.1, 0.1, 1.0])
        base[2] = -abs(base[2])
        gap0 = 2e-5 * rng.normal() if law.stiffness else 0.0
        force = np.zeros(3)
        state = bracket.solve_contact(law, H, w, gap0, base, SLIP, force)
        if state == wanted:
            found += 1
            yield w, gap0, base, force


@pytest.mark.parametrize('name', LAWS)
def test_slip_is_found_quadratically(monkeypatch, name):
    # From 1e-4 off corrections are 1e-4, 1e-8, 1e-16: of a wrong derivative, so much each time
    law = LAWS[name]
    monkeypatch.setattr(newton, 'SLIP_ITERATIONS', 4)
    for w, gap0, base, force in problems(law, SLIP):
        start = force * [1.0 + 1e-4, 1.0 - 1e-4, 1.0 + 1e-4]
        assert newton.slip_by_newton(law, H, w, gap0, base, start) == SLIP
        np.testing.assert_allclose(start, force, rtol=1e-8, atol=1e-9 * force[2])


@pytest.mark.parametrize('axis', [0, 1])
def test_slip_is_not_taken_for_found_while_one_component_still_moves(axis):
    # slip along one axis of an uncoupled compliance: the other components are exact at once
    law = LAWS['rigid']
    w, base, force = np.diag([2e-5, 2e-5, 4e-5]), np.array([0.0, 0.0, -4e-5]), np.zeros(3)
    base[axis] = 1e-4
    assert bracket.solve_contact(law, H, w, 0.0, base, SLIP, force) == SLIP
    start = force.copy()
    start[axis] *= 1.01
    assert newton.slip_by_newton(law, H, w, 0.0, base, start) == SLIP
    np.testing.assert_allclose(start, force, rtol=1e-12, atol=1e-15)


@pytest.mark.parametrize('name', LAWS)
def test_stick_is_found_quadratically(monkeypatch, name):
    law = LAWS[name]
    monkeypatch.setattr(newton, 'SLIP_ITERATIONS', 4)
    for w, gap0, base, force in problems(law, STICK):
        start = force * (1.0 + 1e-4)
        assert newton.stick(law, H, w, gap0, base, start) == STICK
        np.testing.assert_allclose(start, force, rtol=1e-8, atol=1e-9 * force[2])


def test_the_bounded_friction_force_is_found_quadratically(monkeypatch):
    # (W + sigma I) f = -s with sigma >= 0, |f| = bound
    monkeypatch.setattr(bracket, 'BRACKETINGS', 6)
    rng = np.random.default_rng(6)
    for _ in range(30):
        m = rng.normal(size=(2, 2))
        w, s = m @ m.T + 0.1 * np.eye(2), rng.normal(size=2)
        bound = 0.5 * np.linalg.norm(np.linalg.solve(w, s))
        f = np.array(bracket._bounded(*w.ravel(), *s, bound))
        assert np.linalg.norm(f) == pytest.approx(bound, rel=1e-12)
        slip = w @ f + s
        assert f @ slip == pytest.approx(-np.linalg.norm(f) * np.linalg.norm(slip), rel=1e-10)


@pytest.mark.parametrize(('name', 'most'), [('spring', 13.6), ('undamped', 15.9), ('rigid', 10.1)])
def test_brackets_close_fast(monkeypatch, name, most):
    calls = []
    mismatch = bracket._mismatch
    monkeypatch.setattr(bracket, '_mismatch', lambda *a: calls.append(1) or mismatch(*a))
    count = sum(1 for wanted in (SLIP, STICK) for _ in problems(LAWS[name], wanted))
    assert len(calls) / count < most


def counted(scene, steps):
    """Return Newton iterations and factorisations per step, and what contact fell back on."""
    simulation = Simulation(scene)
    simulation.command('cmd_brush_speed', (20.0,))
    simulation.command('cmd_vel', (2.0, 0.4, 1.0))
    simulation.command('cmd_penetration', (0.03,))
    fallbacks = []
    mismatch = bracket._mismatch
    bracket._mismatch = lambda *a: fallbacks.append(1) or mismatch(*a)
    try:
        simulation.advance(steps)
    finally:
        bracket._mismatch = mismatch
    counts = simulation.state.counts.sum(axis=0) / simulation.model.bristles
    assert counts[FAILURES] == 0
    return counts[NEWTON] / steps, counts[FACTORISATIONS] / steps, len(fallbacks) / steps


# per step: measured, and one iteration of the whole run on top
MOST = {'free': (3.7, 0.25, 0.0), 'free undamped': (3.9, 0.25, 0.0),
        'displacement': (3.3, 0.25, 0.0), 'hht': (3.2, 0.34, 0.0), 'slip': (5.3, 0.18, 0.33),
        'stick': (6.03, 0.23, 3.33), 'rigid slip': (5.63, 0.2, 0.2),
        'rigid stick': (6.53, 0.23, 0.5), 'displacement stick': (6.14, 0.24, 2.04)}


@pytest.mark.parametrize('name', SCENES)
def test_a_step_takes_few_iterations(name):
    scene, steps = SCENES[name]
    found = counted(scene, steps)
    assert all(one <= most for one, most in zip(found, MOST[name])), found


@pytest.mark.parametrize('load_case', ['inertia', 'displacement'])
@pytest.mark.parametrize('stage', [4, 25])
def test_the_compliance_of_the_tip_is_that_of_the_whole_step(monkeypatch, load_case, stage):
    # w is what positions at the step's end change by with a force held over the step, converged
    simulation = Simulation(touching(load_case=load_case))
    simulation.command('cmd_brush_speed', (20.0,))
    simulation.command('cmd_vel', (2.0, 0.4, 1.0))
    simulation.command('cmd_penetration', (0.03,))
    simulation.advance(stage)
    monkeypatch.setattr(step_newton, 'SLOW', -1.0)      # a new matrix in each iteration
    before = [array.copy() for array in simulation.state]
    seen = []

    def end_of_step(force):
        for array, kept in zip(simulation.state, before):
            array[...] = kept

        def prescribed(law, h, w, gap0, base, state, into):
            seen.append(w[:, :3].copy())
            into[:3] = force
            return SLIP
        monkeypatch.setattr(tip, 'solve_contact', prescribed)
        simulation.state.tip[0, tip.FORCE + 2] = 1e-9   # else the road is out of reach
        simulation.advance(1)
        return simulation.state.tip[0, tip.SLIP_MOVED:tip.SLIP_MOVED + 3].copy()

    usual = np.array([0.02, -0.03, 0.05])
    columns = [(end_of_step(usual + change) - end_of_step(usual - change)) / 2e-3
               for change in 1e-3 * np.eye(3)]
    ours, wanted = seen[-1], np.array(columns).T
    # it leaves out the Coriolis force of what a force adds to the velocity
    assert abs(ours - wanted).max() < 3e-4 * abs(wanted).max()


def test_equilibrium_is_found_in_few_iterations(monkeypatch):
    calls = []
    factorise = equilibrium.factorise
    monkeypatch.setattr(equilibrium, 'factorise', lambda *a: calls.append(1) or factorise(*a))
    Simulation(case(solver={'start': 'steady', 'elements': 3}, brush={'bristle_count': 1},
                    contact={'enabled': True, 'normal_stiffness': 2e3},
                    road={'penetration': 0.02}))
    assert len(calls) <= 60, len(calls)
