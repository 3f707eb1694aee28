"""The tip on curved surfaces: turned planes, passivity, rigid contact, the way over the road."""
from dataclasses import replace
from functools import cache
import math

from bristle_ros.physics.contact.tip import FORCE, GAP, STATE
from bristle_ros.physics.step.energy import INJECTED
from bristle_ros.scene.error import SceneError
from bristle_ros.scene.scene import from_parameters, tip_depth
from bristle_ros.simulation.model import build_model
from bristle_ros.simulation.simulation import Simulation, StepFailure
import numpy as np
import pytest

BASE = {
    'friction.static': 0.5, 'friction.kinetic': 0.5, 'damping.stiffness': 1e-3,
    'drive.profile': 'constant', 'drive.mean_speed': 10.47, 'solver.elements': 4,
    'brush.start_angle': math.pi, 'run.chunk': 0.001, 'solver.integration_time_step': 1e-4}
SINE = BASE | {
    'road.penetration': 0.02, 'road.approach_time': 0.05, 'profile.kind': 'sine',
    'profile.amplitude': 0.0025, 'profile.wavelength': 0.08, 'profile.phase': math.pi,
    'sweeper.velocity': (1.2, 0.0)}
KERB = BASE | {
    'road.attack_angle': 0.139626, 'road.penetration': 0.06, 'road.approach_time': 0.0,
    'gutter.enabled': True, 'gutter.kerb_distance': 0.185, 'sweeper.velocity': (1.1, 0.0)}
ROUGH = BASE | {
    'road.attack_angle': 0.087266, 'road.penetration': 0.03, 'road.approach_time': 0.0,
    'profile.kind': 'iso8608', 'profile.shortest': 0.02, 'profile.seed': 7,
    'sweeper.velocity': (1.2, 0.0)}


def scene(given, **more):
    return from_parameters(
        given | {key.replace('__', '.'): value for key, value in more.items()}, 'test')


def test_inclined_plane_is_a_level_one_seen_from_a_tilted_brush(tmp_path):
    """The same motion in the brush frame, to the tolerance of Newton's method."""
    slope = 0.15
    file = tmp_path / 'plane.csv'
    file.write_text('\n'.join(f'{x},{x * math.tan(slope)!r}' for x in (-20.0, 20.0)))
    still = BASE | {'road.approach_time': 0.0, 'gravity': 0.0, 'solver.largest_error': 2e-4,
                    'solver.tolerance': 1e-9}
    level = scene(still, road__attack_angle=slope, road__penetration=0.03)
    distance = tip_depth(level) - 0.03
    deep = tip_depth(scene(still)) - distance / math.cos(slope)
    inclined = scene(still, road__penetration=deep, profile__kind='file',
                     profile__file=str(file))
    ends = []
    for one in (level, inclined):
        simulation = Simulation(one, energies=True)
        simulation.advance(4000)
        ends.append(simulation.snapshot())
    assert np.abs(ends[0].tip_position - ends[1].tip_position).max() < 1e-6
    assert np.abs(ends[0].contact_impulse).max() > 1e-3
    c, s = math.cos(slope), math.sin(slope)
    turned = ends[0].contact_impulse[0] @ np.array(((c, 0.0, s), (0.0, 1.0, 0.0), (-s, 0.0, c)))
    assert turned == pytest.approx(ends[1].contact_impulse[0], abs=1e-6)


@cache
def audited(name, its, stiffness=1e5):
    """Return injected energy over that of the drive, imbalance over it, and tip records."""
    given = {'sine': SINE, 'kerb': KERB, 'rough': ROUGH}[name]
    simulation = Simulation(scene(given, solver__integration_time_step=its,
                                  contact__normal_stiffness=stiffness), energies=True)
    first = simulation.snapshot()
    driven, tips = 0.0, []
    for _ in range(round(0.3 / 1e-3)):
        simulation.advance(round(1e-3 / its))
        now = simulation.snapshot()
        driven += abs(now.brush_torque[2] * now.omega) * 1e-3
        tips.append(simulation.state.tip[0].copy())

    def energy(of):
        return of.energy_kinetic + of.energy_elastic + of.energy_dissipated - of.work_external
    imbalance = abs(energy(now) - energy(first)) / driven
    return simulation.state.audit[0, INJECTED] / driven, imbalance, np.array(tips)


@pytest.mark.parametrize('name', ['sine', 'kerb', 'rough'])
@pytest.mark.parametrize('its', [1e-3, 1e-4])
def test_contact_on_a_curved_surface_is_passive_at_every_step_size(name, its):
    injected, imbalance, tips = audited(name, its)
    assert injected <= 1e-12
    assert imbalance < 2e-3
    assert (tips[:, STATE] > 0.0).sum() > 30    # it touches at all


@pytest.mark.parametrize('name', ['sine', 'kerb'])
def test_rigid_surface_is_not_entered_and_pushes_only_where_it_is_touched(name):
    injected, _, tips = audited(name, 1e-4, math.inf)
    assert injected <= 1e-9
    assert tips[:, GAP].min() >= -1e-12
    assert (np.abs(tips[tips[:, GAP] > 1e-9, FORCE:FORCE + 3]) == 0.0).all()


def test_sweeper_that_turns_goes_along_its_way_whatever_the_chunks():
    """Against the integral of the commanded velocity; the bits do not depend on the calls."""
    given = scene(SINE, sweeper__mount_position=(0.5, -0.3), sweeper__velocity=(0.0, 0.0),
                  road__penetration=-0.003, road__approach_time=0.0)
    one, two = Simulation(given, energies=True), Simulation(given, energies=True)
    for simulation, calls in ((one, (300, 3700)), (two, (300, 100, 1, 2599, 1000))):
        assert simulation.base_pose() == (0.0, 0.0, 0.0)
        simulation.advance(calls[0])
        simulation.command('cmd_vel', (0.4, 0.1, 1.5))
        simulation.command('cmd_penetration', (0.02,))
        for steps in calls[1:]:
            simulation.advance(steps)
    assert one.base_pose() == two.base_pose()
    assert np.array_equal(one.state.tip, two.state.tip)
    assert one.snapshot().contact_impulse[0, 2] > 0.0
    t = np.linspace(0.0, 0.37, 370_001)
    rise = math.hypot(0.4, 0.1) / 2.0
    part, heading = np.minimum(t / rise, 1.0), np.where(t < 0.75, t * t, 0.0)
    along, left = 0.4 * part, 0.1 * part
    x = np.trapezoid(np.cos(heading) * along - np.sin(heading) * left, t)
    y = np.trapezoid(np.sin(heading) * along + np.cos(heading) * left, t)
    assert one.base_pose() == pytest.approx((x, y, heading[-1]), abs=2e-5)


def test_clamp_that_is_steered_into_the_kerb_ends_the_run():
    simulation = Simulation(scene(KERB, gutter__kerb_distance=0.3, gutter__kerb_height=0.4,
                                  sweeper__velocity=(0.0, 2.0)), energies=True)
    with pytest.raises(StepFailure, match='a clamp has come to the surface') as failure:
        simulation.advance(10_000)
    # clamps stand 0.1125 m around the mount, and the face leans back by 0.05 m to their height
    assert (0.3 - 0.1125) / 2.0 < failure.value.time < (0.35 + 0.1125) / 2.0
    assert simulation.step == failure.value.step


def test_kerb_that_approaches_arrives():
    simulation = Simulation(scene(KERB, gutter__approach=0.1, road__approach_time=0.0501,
                                  gutter__kerb_distance=0.3, sweeper__velocity=(0.0, 0.0)),
                            energies=True)
    assert simulation.base_pose() == pytest.approx((0.0, 0.0, 0.0), abs=1e-15)
    simulation.advance(600)
    assert simulation.base_pose() == pytest.approx((0.0, 0.0, 0.0), abs=1e-9)


def test_start_inside_the_kerb_is_refused():
    with pytest.raises(SceneError, match='would start 0.0.* m inside'):
        Simulation(scene(KERB, brush__start_angle=math.pi / 2.0))


def test_steady_start_says_why_not():
    with pytest.raises(SceneError, match='level plane alone'):
        Simulation(replace(scene(SINE), solver=replace(scene(SINE).solver, start='steady')))


def test_climbing_road_tilts_gravity():
    """A wire that hangs from a level board over a climbing road feels gravity askew."""
    drive = build_model(scene(BASE, road__grade=0.2, road__cross_slope=-0.1)).drive
    down = np.array((drive.down_x, drive.down_y, drive.down_z))
    assert np.linalg.norm(down) == pytest.approx(9.81)
    assert down[0] == pytest.approx(-9.81 * math.sin(0.2))
    assert down[1] == pytest.approx(9.81 * math.cos(0.2) * math.sin(0.1))
    assert down[2] < 0.0
