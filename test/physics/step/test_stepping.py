"""The guaranteed step: repeatable to the bit, subdivides, and fails with the last good state."""
from dataclasses import replace

from bristle_ros.physics.step.records import FAILURES
from bristle_ros.physics.wire.layout import ACC0, LANES, MASS, ROWS, SECTION_FORCE, STRAIN0
from bristle_ros.scene.sections import Damping
from bristle_ros.simulation.model import WORST_ERROR
from bristle_ros.simulation.simulation import Simulation, StepFailure
import numpy as np
from physics.scenes import bouncing_sweep, cantilever_drop, free_rotation, run, tilted_sweep
import pytest

SWEEP = bouncing_sweep(its=1e-4)
# what a step carries over to the next one; the other rows are its own room
CARRIED = [*range(ACC0 + 6), *range(STRAIN0, SECTION_FORCE)]


def bits(simulation, also=('chain', 'counts')):
    """Return all that decides what the next step does, as bytes."""
    state = simulation.state
    nodes = state.nodes.reshape(len(state.tip), -1, ROWS, LANES)[:, :, CARRIED]
    return nodes.tobytes() + b''.join(
        getattr(state, name).tobytes() for name in ('tip', 'motion', 'step', *also))


def rows_of(snapshot):
    return b''.join(np.asarray(value).tobytes() for value in snapshot)


@pytest.mark.parametrize('scene', [SWEEP, free_rotation(), tilted_sweep(its=1e-3)],
                         ids=['S3', 'S2', 'S4'])
def test_chunks_do_not_matter(scene):
    whole, parts = Simulation(scene, energies=True), Simulation(scene, energies=True)
    whole.advance(300)
    for steps in (1, 9, 90, 0, 200):
        parts.advance(steps)
        parts.snapshot()  # looking changes nothing either
    assert bits(whole) == bits(parts)
    assert rows_of(whole.snapshot()) == rows_of(parts.snapshot())


def test_accounts_change_nothing():
    plain, counted = Simulation(SWEEP), Simulation(SWEEP, energies=True)
    for simulation in (plain, counted):
        simulation.advance(1200)
    assert bits(plain) == bits(counted)
    assert np.isnan(plain.snapshot().work_external)
    assert counted.snapshot().work_external != 0.0


def test_reset_starts_over():
    simulation = Simulation(SWEEP, energies=True)
    first = bits(simulation)
    simulation.advance(500)
    once = bits(simulation)
    simulation.command('cmd_brush_speed', (3.0,))
    simulation.advance(10)
    simulation.reset()
    assert bits(simulation) == first
    simulation.advance(500)
    assert bits(simulation) == once


def test_a_brush_is_its_bristles():
    # Three at once, and each alone with its azimuth as start angle: apart from round-off, which
    # impacts amplify, the same. It decides, too, how little Newton leaves: next to nothing here.
    tight = {'its': 1e-4, 'tolerance': 1e-9}
    brush = Simulation(bouncing_sweep(count=3, **tight), energies=True)
    brush.advance(1000)
    together = brush.snapshot()
    force = np.zeros(3)
    for i in range(3):
        alone = Simulation(bouncing_sweep(start_angle=2.0 * np.pi * i / 3.0, **tight),
                           energies=True)
        alone.advance(1000)
        one = alone.snapshot()
        np.testing.assert_allclose(together.tip_position_road[i], one.tip_position_road[0],
                                   atol=1e-9)
        np.testing.assert_allclose(together.contact_impulse[i], one.contact_impulse[0], atol=1e-9)
        force += one.brush_force
    np.testing.assert_allclose(together.brush_force, force, atol=1e-6)


def test_no_step_of_a_fixed_length_is_wildly_wrong():
    # Converged, they would gain energy from nowhere: S4 at 1 ms, and an impact on a hard road
    simulation = Simulation(tilted_sweep(its=1e-3, stiffness=1e5))
    worst = 0.0
    for _ in range(400):
        simulation.advance(1)
        worst = max(worst, simulation.snapshot().error_estimate)
    assert 0.1 * WORST_ERROR < worst <= WORST_ERROR
    assert simulation.snapshot().substeps > 0


def test_large_steps_are_subdivided():
    # S4 without damping at 1 ms on a hard road: Newton alone fails there, as in other programs
    result = run(tilted_sweep(its=1e-3, stiffness=1e5), 0.4)
    assert len(result.t) == 400
    assert np.isfinite(result.tip).all()
    assert result.substeps > 0
    fine = run(tilted_sweep(), 0.4, 1e-4)
    assert result.impulse[-1, 2] == pytest.approx(fine.impulse[-1, 2], rel=0.1)


def test_failure_leaves_the_last_good_state():
    simulation = Simulation(SWEEP, energies=True)
    simulation.advance(30)
    masses = simulation.state.nodes.reshape(-1, ROWS, LANES)[:, MASS]
    good = masses[0, 2]
    masses[0, 2] = np.nan  # makes every sub-step fail
    with pytest.raises(StepFailure) as failure:
        simulation.advance(5)
    assert failure.value.step == simulation.step == 30
    assert failure.value.time == pytest.approx(30 * 1e-4)
    assert '\n' not in str(failure.value)
    assert simulation.state.counts[0, FAILURES] > 10
    masses[0, 2] = good
    after = simulation.snapshot()
    fresh = Simulation(SWEEP, energies=True)
    fresh.advance(30)
    before = fresh.snapshot()
    for name in ('tip_position', 'tip_orientation', 'contact_force', 'contact_impulse',
                 'mount_force', 'mount_damping_force', 'energy_elastic', 'energy_kinetic'):
        np.testing.assert_array_equal(getattr(after, name), getattr(before, name), name)
    # mended, it goes on
    for run_on in (simulation, fresh):
        run_on.advance(100)
    np.testing.assert_allclose(simulation.snapshot().tip_position, fresh.snapshot().tip_position,
                               atol=1e-6)


def test_mass_damping():
    # alpha_D alone, from free swings of the undamped wire: amplitude falls by exp(-alpha t / 2)
    alpha = 8.0
    light = replace(cantilever_drop(), damping=Damping(mass=alpha, stiffness=0.0))
    rest, swing = run(cantilever_drop(), 0.5).tip[:, 2], run(light, 0.5).tip[:, 2]
    middle = 0.5 * (rest.max() + rest.min())
    tops = [i for i in range(1, len(swing) - 1) if swing[i - 1] < swing[i] > swing[i + 1]
            and swing[i] > middle]
    heights = swing[tops] - middle
    times = run(light, 0.5).t[tops]
    rate = np.polyfit(times, np.log(heights), 1)[0]
    assert rate == pytest.approx(-0.5 * alpha, rel=0.1)
