"""Sub-steps, load steps and the driven clamp, against the same with shorter steps, or numpy."""
from dataclasses import replace

from bristle_ros.physics.contact.tip import LEVEL
from bristle_ros.physics.motion import BASICS, CLAMP, drive_clamp, FRAME, frame_at
from bristle_ros.physics.step.records import FACTORISATIONS, NEWTON, SUBSTEPS
from bristle_ros.physics.wire.layout import LANES, ROWS, X0
from bristle_ros.simulation.simulation import Simulation
import numpy as np
from physics.interpreted.test_motion import case, ITS, touching
import pytest


def commanded(scene, energies=True):
    simulation = Simulation(scene, energies=energies)
    # all of them end after whole steps of any length used here
    simulation.command('cmd_brush_speed', (21.0,))
    simulation.command('cmd_vel', (2.1, 0.5, 1.0))
    simulation.command('cmd_penetration', (0.031,))
    return simulation


def path(simulation):
    """Return the positions of all nodes at the start of the next step."""
    rows = simulation.state.nodes.reshape(-1, ROWS, LANES)
    return rows[:, X0:X0 + 7].copy()


def finer(scene, factor):
    """Return the scene with an integration step `factor` times shorter."""
    return replace(scene, solver=replace(
        scene.solver, integration_time_step=scene.solver.integration_time_step / factor))


@pytest.mark.parametrize('scene', [
    touching(), touching(load_case='displacement'),
    case(solver={'elements': 2}, brush={'bristle_count': 3})],
    ids=['inertia', 'displacement', 'three'])
def test_halves_are_steps_of_half_the_length(scene):
    halves, steps = commanded(scene), commanded(finer(scene, 2))
    for _ in range(10):
        halves.state.tip[:, LEVEL] = 1.0
        halves.advance(1)
        steps.advance(2)
        np.testing.assert_allclose(path(halves), path(steps), rtol=0.0, atol=1e-10)
    bristles = scene.brush.bristle_count
    assert halves.state.counts[:, SUBSTEPS].sum() == 20 * bristles
    one, two = halves.snapshot(), steps.snapshot()
    for name in ('contact_impulse', 'work_external', 'energy_dissipated', 'mount_force'):
        wanted = getattr(two, name)
        np.testing.assert_allclose(getattr(one, name), wanted, rtol=0.0,
                                   atol=1e-6 * np.abs(wanted).max() + 1e-12, err_msg=name)


def test_sub_steps_grow_again_where_they_are_easy():
    # from an eighth: two of it, then one of a quarter, one of a half
    simulation = commanded(case(solver={'elements': 2}, brush={'bristle_count': 1}))
    simulation.advance(2)
    simulation.state.tip[:, LEVEL] = 3.0
    before = simulation.state.counts[0, SUBSTEPS]
    simulation.advance(1)
    assert simulation.state.counts[0, SUBSTEPS] - before == 4
    assert simulation.state.tip[0, LEVEL] == 0.0


def test_adaptive_steps_keep_to_their_tolerance():
    scene = touching(step='adaptive', error_tolerance=1e-6, integration_time_step=5e-4)
    simulation, exact = commanded(scene), commanded(finer(touching(), 8))
    simulation.advance(12)
    exact.advance(96)
    counts = simulation.state.counts[0]
    # measured: what rescaling and prediction get wrong costs sub-steps and iterations
    assert 20 < counts[SUBSTEPS] <= 27, counts
    assert counts[NEWTON] <= 94, counts
    assert counts[FACTORISATIONS] <= 8, counts
    moved = path(exact)[:, :3] - path(commanded(touching()))[:, :3]
    off = path(simulation)[:, :3] - path(exact)[:, :3]
    assert abs(off).max() < 1e-2 * abs(moved).max()


def polygon(time_step):
    return case(solver={'elements': 2, 'load_case': 'displacement', 'time_step': time_step},
                brush={'bristle_count': 1})


def clamp_at(simulation, t):
    frame = np.zeros(FRAME)
    model, motion = simulation.model, simulation.state.motion
    basics = np.zeros((2, BASICS))
    frame_at(t, model.drive, True, motion, basics, frame)
    drive_clamp(t, model.drive, motion, model.clamp, basics, frame)
    return frame[CLAMP:CLAMP + 7]


def turned(simulation, angle, x):
    c, s = np.cos(angle), np.sin(angle)
    return np.array([c * x[0] - s * x[1], s * x[0] + c * x[1], x[2]])


def test_the_clamp_moves_along_the_chords_of_its_circle():
    # Fig. 2a of the paper; with a command inside a load step, from the place that it had reached
    long = 8 * ITS
    simulation = Simulation(polygon(long))
    clamp = simulation.model.clamp
    drive = simulation.scene.drive

    def theta(t, ramp=0.0, since=0.0):
        w = 2.0 * np.pi * drive.frequency
        return (0.7 + drive.mean_speed * t + drive.alternating_speed / w * (1.0 - np.cos(w * t))
                + 0.5 * ramp * (t - since) ** 2)

    for part in (0.25, 0.75):
        ends = [turned(simulation, theta(at), clamp[:3]) for at in (2 * long, 3 * long)]
        found = clamp_at(simulation, (2.0 + part) * long)
        np.testing.assert_allclose(found[:3], (1.0 - part) * ends[0] + part * ends[1], atol=1e-13)
        angle = (1.0 - part) * theta(2 * long) + part * theta(3 * long)
        half = np.array([np.cos(angle / 2), np.sin(angle / 2)])
        q = clamp[3:]
        wanted = [half[0] * q[0] - half[1] * q[3], half[0] * q[1] - half[1] * q[2],
                  half[0] * q[2] + half[1] * q[1], half[0] * q[3] + half[1] * q[0]]
        np.testing.assert_allclose(found[3:], wanted, atol=1e-13)
    now = 2.5 * long
    simulation.state.step[0] = round(now / ITS)
    start = clamp_at(simulation, now)[:3].copy()
    simulation.command('cmd_brush_speed', (drive.mean_speed + 12.0,))
    np.testing.assert_allclose(clamp_at(simulation, now + 1e-12)[:3], start, atol=1e-10)
    end = turned(simulation, theta(3 * long, drive.max_acceleration, now), clamp[:3])
    np.testing.assert_allclose(clamp_at(simulation, 2.75 * long)[:3], 0.5 * (start + end),
                               atol=1e-9)
    np.testing.assert_allclose(clamp_at(simulation, 3 * long)[:3], end, atol=1e-9)


def test_the_accounts_of_a_polygon_close():
    # to a twentieth of what they would miss without the work of its corners
    scene = finer(polygon(4 * ITS), 2)
    # thin: frame forces on the rotary inertia are in no account
    thin = replace(scene.bristle, breadth=0.002, width=0.0012, youngs_modulus=4e8)
    simulation = Simulation(replace(scene, bristle=thin), energies=True)
    simulation.command('cmd_brush_speed', (21.0,))
    simulation.advance(32)
    now = simulation.snapshot()
    left = (now.energy_kinetic + now.energy_elastic + now.energy_dissipated - now.work_external)
    assert abs(left) < 2.2e-4 * now.work_external
