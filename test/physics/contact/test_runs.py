"""Contact over whole runs: it injects no energy, stays in the cone, and rigid roads hold."""
import math

import numpy as np
from physics.scenes import bouncing_sweep, run, tilted_sweep
import pytest

RIGID = math.inf
SCENES = {
    'S3': bouncing_sweep(its=1e-4),
    'S3 1 ms': bouncing_sweep(its=1e-3, damping=0.0),
    'S3 rigid': bouncing_sweep(its=1e-4, stiffness=RIGID, damping=0.0),
    'S3 weakening friction': bouncing_sweep(its=1e-4, friction=(0.7, 0.27)),
    'S3 kinetic friction 0': bouncing_sweep(its=1e-4, friction=(0.5, 0.0)),
    'S4': tilted_sweep(its=1e-4),
    'S4 1 ms': tilted_sweep(its=1e-3),
    'S4 damped': tilted_sweep(its=5e-4, viscosity=2e-4, stiffness=1e5),
    'S4 rigid': tilted_sweep(its=1e-4, stiffness=RIGID, viscosity=2e-4)}
DURATION = {'S3': 0.15, 'S4': 0.25}


def each_step(name):
    scene = SCENES[name]
    return scene, run(scene, DURATION[name[:2]], scene.solver.integration_time_step)


@pytest.mark.parametrize('name', SCENES)
def test_contact_never_injects_energy(name):
    _, result = each_step(name)
    assert result.impulse[-1, 2] > 1e-3     # there was contact
    # round-off of work done by up to 10 N over 1e-4 m
    assert result.injected <= 1e-15


@pytest.mark.parametrize('name', SCENES)
def test_energy_only_leaks(name):
    # The accounts leave out what the integrator itself dissipates, which rings out of impacts: the
    # balance sinks. It may rise by the error of the trapezoidal work integrals only: 1e-3 of the
    # work done at 0.25 ms, and with the square of the step.
    scene, result = each_step(name)
    stored = abs(result.balance).max()
    rise = (result.balance - np.minimum.accumulate(result.balance)).max()
    assert rise < 3.5e-5 * max(1.0, scene.solver.integration_time_step / 2.5e-4) ** 2
    assert stored < 4e-3


@pytest.mark.parametrize('name', SCENES)
def test_forces_stay_in_the_cone(name):
    scene, result = each_step(name)
    normal = result.force[:, 2]
    assert (normal >= 0.0).all()
    friction = np.hypot(result.force[:, 0], result.force[:, 1])
    assert (friction <= scene.friction.static * normal * (1.0 + 1e-9)).all()
    if not result.substeps:  # then impulses are the forces' sums
        np.testing.assert_allclose(
            result.force.sum(axis=0) * scene.solver.integration_time_step, result.impulse[-1],
            rtol=1e-9)


@pytest.mark.parametrize('name', ['S3 rigid', 'S4 rigid'])
def test_rigid_road_is_never_entered(name):
    _, result = each_step(name)
    assert result.gap.min() >= -1e-12
    touching = result.force[:, 2] > 0.0
    assert touching.any()
    assert (~touching).any()
    # no force at a distance
    assert result.gap[touching].max() <= 1e-12


def test_rigid_impact_is_plastic():
    # Restitution e = 0: the step that lands ends on the road, and so does the next one
    _, result = each_step('S3 rigid')
    touching = result.force[:, 2] > 0.0
    landings = np.flatnonzero(touching[1:] & ~touching[:-1]) + 1
    landings = landings[landings < len(touching) - 1]
    assert len(landings) > 1
    speed = np.diff(result.gap)[landings] / 1e-4    # of leaving, right after the landing
    approach = -np.diff(result.gap)[landings - 1] / 1e-4
    assert (speed[approach > 1e-2] < 0.1 * approach[approach > 1e-2]).all()


def test_stiff_roads_approach_the_rigid_one():
    rigid = each_step('S3 rigid')[1].impulse[499, 2]
    stiff = run(bouncing_sweep(its=1e-4, stiffness=1e6, damping=0.0), 0.05, 1e-4).impulse[-1, 2]
    assert stiff == pytest.approx(rigid, rel=0.02)
