"""Points of contact along the wire: where they are looked for, the laws and energy of each."""
from functools import cache
import math

from bristle_ros.physics.contact.point import ALIVE, OFFSET, weights
from bristle_ros.physics.contact.search import (descend, gap_along, is_clear_of_plane, lowest_on,
                                                mark_near)
from bristle_ros.physics.contact.tip import FORCE, SLIP_MOVED, TANK
from bristle_ros.physics.motion import FRAME, HEIGHT, ROTATION
from bristle_ros.physics.step.energy import INJECTED
from bristle_ros.physics.wire import layout
from bristle_ros.scene.scene import from_parameters
from bristle_ros.simulation.model import build_models, new_room
from bristle_ros.simulation.simulation import Simulation
from bristle_ros.simulation.surface import surface_of
import numpy as np
import pytest
from scipy.optimize import minimize_scalar

SUMS = np.zeros(16)
LYING = {
    'friction.static': 0.5, 'friction.kinetic': 0.5, 'friction.decay': 0.0,
    'damping.stiffness': 1e-3, 'drive.profile': 'constant', 'drive.mean_speed': 7.330383,
    'brush.start_angle': 0.0, 'road.penetration': 0.15, 'road.approach_time': 0.1,
    'run.chunk': 0.001, 'solver.integration_time_step': 1e-4}
EDGE = LYING | {
    'road.penetration': 0.03, 'road.attack_angle': 0.0, 'drive.mean_speed': 10.47,
    'profile.kind': 'file'}
KERB = LYING | {
    'road.attack_angle': 0.139626, 'road.penetration': 0.06, 'road.approach_time': 0.0,
    'brush.start_angle': math.pi, 'drive.mean_speed': 10.47, 'gutter.enabled': True,
    'gutter.kerb_distance': 0.15, 'sweeper.velocity': (1.1, 0.0)}


@pytest.fixture(scope='module')
def kerb():
    return surface_of(from_parameters(KERB, 'test'))


def lines(count, reach=0.02):
    """Return nodes of `count` bent elements near the origin, (3, 3) each."""
    random = np.random.default_rng(3)
    for _ in range(count):
        along = np.outer([-1.0, 0.0, 1.0], random.normal(size=3))
        yield np.ascontiguousarray(0.01 * along + reach * random.normal(size=(3, 3)) * 0.2
                                   + [0.0, 0.15, random.uniform(0.0, 0.1)])


def curve(line, xi):
    return np.array(weights(xi)) @ line


def test_the_slope_is_that_of_the_gap(kerb):
    for surface in (None, kerb):
        for line in lines(40):
            for xi in (-0.9, 0.1, 0.7):
                step = 1e-6
                two = (gap_along(surface, line, 0, xi + step, SUMS)[0],
                       gap_along(surface, line, 0, xi - step, SUMS)[0])
                slope = gap_along(surface, line, 0, xi, SUMS)[1]
                assert slope == pytest.approx((two[0] - two[1]) / (2.0 * step), abs=1e-6)


def test_a_search_downhill_ends_in_a_local_minimum(kerb):
    """Against scipy's bounded minimisation around the place that was found."""
    for surface in (None, kerb):
        for line in lines(60):
            found = descend(surface, line, 0, 0.2, 0.25, SUMS)

            def gap(xi, line=line, surface=surface):
                return gap_along(surface, line, 0, xi, SUMS)[0]
            assert gap(found) <= gap(0.2) + 1e-15
            low, high = max(found - 1e-3, -1.0), min(found + 1e-3, 1.0)
            near = minimize_scalar(gap, bounds=(low, high), method='bounded',
                                   options={'xatol': 1e-9})
            assert gap(found) <= near.fun + 1e-9


def test_the_lowest_place_of_an_element_is_found(kerb):
    for surface in (None, kerb):
        for line in lines(60):
            place, gap = lowest_on(surface, line, 0, 4, SUMS)
            dense = min(gap_along(surface, line, 0, xi, SUMS)[0]
                        for xi in np.linspace(-1.0, 1.0, 401))
            assert gap <= dense + 2e-6
            assert gap == gap_along(surface, line, 0, place, SUMS)[0]


def wires(count, elements=6, length=0.24):
    """Return random smooth wires as lines (2 elements + 1, 3), tips at the road."""
    random = np.random.default_rng(5)
    s = np.linspace(0.0, 1.0, 2 * elements + 1)
    for _ in range(count):
        lean = random.uniform(0.0, 1.5) + random.normal() * s ** 2 + random.normal() * s ** 3
        step = length / (2 * elements)
        x = np.concatenate(([0.0], np.cumsum(np.sin(lean[:-1]) * step)))
        z = np.concatenate(([0.0], np.cumsum(-np.cos(lean[:-1]) * step)))
        line = np.stack((x, 0.1 + 0.0 * x, z - z[-1]), axis=1)
        yield np.ascontiguousarray(line)


def lowest_beside_tip(surface, line, elements):
    """Return the least gap of all places but those next to the tip, by brute force."""
    found = [gap_along(surface, line, e, xi, SUMS)[0] for e in range(elements)
             for xi in np.linspace(-1.0, 1.0, 41) if e < elements - 1 or xi < 0.9]
    return min(found)


def test_no_wire_in_the_road_is_taken_for_clear(kerb):
    elements, length = 6, 0.24
    scene = from_parameters(KERB | {'solver.elements': elements}, 'test')
    room = new_room(build_models(scene)[0])
    frame = np.zeros(FRAME)
    frame[ROTATION:ROTATION + 9] = np.eye(3).ravel()
    counts = np.zeros(2, int)
    for line in wires(300):
        nodes = np.zeros((2, layout.ROWS, layout.LANES))
        frame[HEIGHT] = line[0, 2]
        for e in range(elements):
            block, lane = divmod(e, layout.ELEMENTS)
            nodes[block, layout.X:layout.X + 3, lane] = line[2 * e + 1] - line[0]
            nodes[block, layout.X:layout.X + 3, layout.ELEMENTS + lane] = line[2 * e + 2] - line[0]
        below = lowest_beside_tip(None, line, elements) < 0.0
        said = is_clear_of_plane(nodes.reshape(2, -1), elements, length / elements, frame)
        assert not (said and below)
        counts += said, below
        room.line[:] = line
        near = mark_near(kerb, elements, length / elements, room, SUMS)
        if lowest_beside_tip(kerb, line, elements) < 0.0:
            assert near
    assert counts.min() > 30      # both happen


@cache
def steps(name, stiffness=1e5, its=1e-4, seconds=0.25):
    """Run a scene step by step; return what its points were, and the simulation."""
    given = {'lying': LYING, 'kerb': KERB}[name]
    simulation = Simulation(from_parameters(
        given | {'contact.normal_stiffness': stiffness, 'solver.integration_time_step': its},
        'test'), energies=True)
    seen = []
    while simulation.step < round(seconds / its):
        simulation.advance(1)
        points = simulation.state.points[0]
        seen.append(points[points[:, ALIVE] > 0.0].copy())
    return seen, simulation


def test_the_laws_hold_at_every_point():
    """Spring by its discrete gradient, Coulomb's cone, friction against the slip."""
    seen, _ = steps('lying')
    points = np.concatenate(seen)
    assert len(points) > 1000
    normal, tangential = points[:, FORCE + 2], points[:, FORCE:FORCE + 2]
    size = np.linalg.norm(tangential, axis=1)
    assert normal.min() >= 0.0
    assert (size <= 0.5 * normal * (1.0 + 1e-9) + 1e-12).all()
    slip = points[:, SLIP_MOVED:SLIP_MOVED + 2]
    moved = np.linalg.norm(slip, axis=1)
    slipping = (moved > 1e-9) & (normal > 1e-4)
    along = (tangential * slip).sum(axis=1)[slipping] / (size * moved)[slipping]
    assert along == pytest.approx(-np.ones(slipping.sum()), abs=1e-4)


@pytest.mark.parametrize('name', ['lying', 'kerb'])
@pytest.mark.parametrize('its', [2e-5, 1e-4, 1e-3])
def test_no_step_makes_contact_give_energy(name, its):
    seconds = 0.1 if its < 1e-4 else 0.25
    seen, simulation = steps(name, its=its, seconds=seconds)
    snapshot = simulation.snapshot()
    driven = abs(snapshot.work_external) + snapshot.energy_elastic
    assert simulation.state.audit[:, INJECTED].max() <= 1e-9 * driven
    assert simulation.state.tip[0, TANK] >= -1e-15
    balance = (snapshot.energy_kinetic + snapshot.energy_elastic + snapshot.energy_dissipated
               - snapshot.work_external)
    assert balance <= 0.02 * driven
    if name == 'lying' and its == 1e-4:
        assert max(len(points) for points in seen) >= 2


@pytest.mark.parametrize('stiffness', [1e4, 1e5, math.inf])
def test_the_road_does_not_yield(stiffness):
    """What the law's gap has over the true one stays small, and so does the wire's depth."""
    seen, simulation = steps('lying', stiffness)
    offsets = np.concatenate([points[:, OFFSET] for points in seen if len(points)])
    assert offsets.max() < 2e-4
    assert simulation.snapshot().worst[0, 1] < 2e-4


def test_the_tip_alone_is_what_it_was():
    """Where nothing else comes near the road the two ways give the same bits."""
    ends = []
    for points in ('wire', 'tip'):
        simulation = Simulation(from_parameters(
            LYING | {'road.penetration': 0.03, 'contact.points': points}, 'test'), energies=True)
        simulation.advance(3000)
        ends.append(simulation.snapshot())
    assert np.array_equal(ends[0].tip_position, ends[1].tip_position)
    assert np.array_equal(ends[0].contact_impulse, ends[1].contact_impulse)
    assert ends[0].contact_impulse[0, 2] > 0.0
    assert ends[0].contact_length[0] == 0.0
