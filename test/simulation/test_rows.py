"""Rows of bristles on one brush: each is what it would be on a brush of its own."""
from dataclasses import replace
import math

from bristle_ros.scene.rows import brush_rows
from bristle_ros.scene.scene import from_parameters
from bristle_ros.simulation.equilibrium import static_equilibrium
from bristle_ros.simulation.simulation import Simulation
import numpy as np
import pytest

STEPS = 300
BASE = {
    'solver.elements': 6, 'solver.integration_time_step': 2e-4, 'damping.stiffness': 1e-3,
    'road.approach_time': 0.02, 'road.penetration': 0.02, 'drive.mean_speed': 10.0,
    'friction.static': 0.5, 'friction.kinetic': 0.3, 'road.max_rate': 2.0,
    'contact.normal_stiffness': 1e3, 'contact.damping': 1.0}
ROWS = {
    'brush.row_radii': [0.09, 0.1125, 0.12], 'brush.row_angles': [0.42, 0.4537856, 0.48],
    'brush.row_lengths': [0.24, 0.245, 0.25], 'brush.row_orientations': [0.0, 0.5, 1.5],
    'brush.row_counts': [2, 3, 1], 'brush.wires_per_bristle': 7}
CASES = {
    'road': {}, 'tilted': {'road.attack_angle': 0.15, 'sweeper.velocity': (1.0, 0.2)},
    'no road': {'contact.enabled': False},
    'load steps': {'solver.time_step': 1e-3, 'solver.load_case': 'displacement',
                   'contact.enabled': False},
    'steady': {'solver.start': 'steady', 'road.approach_time': 0.0, 'road.penetration': 0.03}}


def scene(*parts):
    return from_parameters({key: value for part in parts for key, value in part.items()}, 'test')


def alone(whole, row):
    """Return the scene of one row, at the height and azimuth that it has on the whole brush."""
    one = scene(CASES['no road'], {
        'brush.mount_radius': row.radius, 'brush.mount_angle': row.angle,
        'brush.mount_orientation': row.orientation, 'bristle.length': row.length,
        'brush.bristle_count': row.count, 'brush.wires_per_bristle': 7,
        'brush.start_angle': whole.brush.start_angle + row.offset})
    cosine, sine = math.cos(whole.road.attack_angle), math.sin(whole.road.attack_angle)

    def depth(of):
        return (of.length * math.cos(of.angle) * cosine
                + (of.radius + of.length * math.sin(of.angle)) * sine)

    deepest = max(map(depth, brush_rows(whole)))
    road = replace(whole.road,
                   penetration=whole.road.penetration - deepest + depth(row), approach_time=0.0)
    return replace(whole, bristle=one.bristle, brush=one.brush, road=road)


@pytest.mark.parametrize('case', CASES)
def test_a_row_is_what_it_is_alone(case):
    whole = scene(BASE, ROWS, {'brush.row_offsets': [0.0, 0.3, 2.0]}, CASES[case],
                  {'road.approach_time': 0.0, 'brush.start_angle': math.pi})
    if whole.contact.enabled and case != 'steady':
        whole = replace(whole, road=replace(whole.road, penetration=-1e-3))
    brush = Simulation(whole, energies=True)
    rows = brush_rows(whole)
    singles = [Simulation(alone(whole, row), energies=True) for row in rows]
    for simulation in (brush, *singles):
        if whole.contact.enabled:
            simulation.command('cmd_penetration', [
                simulation.scene.road.penetration + 0.03])
        simulation.advance(STEPS)
    # contact and corners make more of the last bit of a height or an azimuth
    tolerance = 1e-5 if whole.contact.enabled or whole.solver.time_step else 1e-9
    found, parts = brush.snapshot(), [single.snapshot() for single in singles]
    assert not whole.contact.enabled or any(
        part.contact_impulse.any() for part in parts)
    for name in ('tip_position_road', 'tip_position_mount', 'contact_force', 'contact_impulse',
                 'mount_damping_force', 'clamp_stress', 'clamp_stress_max'):
        together = np.concatenate([getattr(part, name) for part in parts])
        scale = np.abs(together).max() + 1e-300
        np.testing.assert_allclose(getattr(found, name), together, rtol=0.0,
                                   atol=tolerance * scale, err_msg=name)
    for name in ('brush_force', 'brush_torque', 'contact_torque_mount', 'energy_kinetic',
                 'energy_elastic', 'energy_dissipated', 'work_external'):
        sums = sum(getattr(part, name) for part in parts)
        np.testing.assert_allclose(getattr(found, name), sums, rtol=0.0,
                                   atol=tolerance * np.abs(sums).max(), err_msg=name)
    assert found.newton_iterations == sum(part.newton_iterations for part in parts)
    assert found.error_estimate == pytest.approx(
        max(part.error_estimate for part in parts), rel=1e-6)
    lines = np.concatenate([single.centreline() for single in singles])
    np.testing.assert_allclose(brush.centreline(), lines, rtol=0.0, atol=1e-9)


def test_two_equal_rows_are_one_of_twice_as_many():
    one = Simulation(scene(BASE, {'brush.bristle_count': 4}), energies=True)
    two = Simulation(scene(BASE, {'brush.bristle_count': 2,
                                  'brush.row_offsets': [0.0, math.pi / 2.0]}), energies=True)
    for simulation in (one, two):
        simulation.advance(STEPS)
    order = [0, 2, 1, 3]    # numbered row by row
    np.testing.assert_array_equal(one.state.nodes[order], two.state.nodes)
    ours, theirs = two.snapshot(), one.snapshot()
    assert theirs.contact_impulse.all(axis=1).all()
    for name in ('tip_position', 'contact_force', 'mount_force', 'mount_moment', 'clamp_stress'):
        np.testing.assert_array_equal(getattr(ours, name), getattr(theirs, name)[order])
    for name in ('brush_force', 'brush_torque', 'energy_kinetic', 'energy_elastic'):
        np.testing.assert_allclose(getattr(ours, name), getattr(theirs, name), rtol=1e-12,
                                   atol=1e-15)


def test_bits_of_rows_do_not_depend_on_threads_or_calls():
    one = Simulation(scene(BASE, ROWS), threads=1)
    three = Simulation(scene(BASE, ROWS), threads=3)
    one.advance(300)
    for steps in (1, 129, 64, 106):
        three.advance(steps)
    for ours, theirs in zip(one.state, three.state):
        np.testing.assert_array_equal(ours, theirs)


def test_the_road_is_below_the_deepest_tips_of_all_rows():
    still = scene(BASE, ROWS, {
        'drive.mean_speed': 0.0, 'gravity': 0.0, 'road.penetration': 2e-3,
        'contact.normal_stiffness': math.inf, 'contact.damping': 0.0})
    force = static_equilibrium(still).normal_force
    depths = np.repeat([row.length * math.cos(row.angle) for row in brush_rows(still)],
                       ROWS['brush.row_counts'])
    touches = depths > depths.max() - 2e-3
    assert 0 < touches.sum() < len(depths)
    np.testing.assert_array_equal(force > 0.0, touches)


def test_a_failed_row_is_named_by_its_bristle(monkeypatch):
    simulation = Simulation(scene(BASE, ROWS), threads=1)
    good = Simulation(scene(BASE, ROWS))
    good.advance(30)
    # what no step can go through, in the second row
    simulation.advance(30)
    simulation.state.nodes[3, 0, 8 * 8] = math.nan
    with pytest.raises(RuntimeError, match='step 30: bristle 3: '):
        simulation.advance(10)
    for number in (0, 1, 2, 4, 5):
        np.testing.assert_array_equal(simulation.state.nodes[number], good.state.nodes[number])


@pytest.mark.parametrize('load_case', ['inertia', 'displacement'])
def test_the_wires_that_are_drawn_end_in_the_tips(load_case):
    simulation = Simulation(scene(BASE, ROWS, {
        'brush.start_angle': 0.7, 'solver.load_case': load_case, 'contact.enabled': False}))
    simulation.advance(100)
    drawn, snapshot = simulation.centreline(), simulation.snapshot()
    np.testing.assert_allclose(drawn[:, -1], snapshot.tip_position_mount, atol=1e-12)
    rows = brush_rows(simulation.scene)
    angles = snapshot.theta + np.concatenate([row.azimuths for row in rows])
    radii = np.repeat([row.radius for row in rows], [row.count for row in rows])
    clamps = np.column_stack((radii * np.cos(angles), radii * np.sin(angles), 0.0 * radii))
    np.testing.assert_allclose(drawn[:, 0], clamps, atol=1e-12)
