"""Scenes S1 to S5 against solutions by other programs: reference/README.md."""
import numpy as np
from physics.scenes import (bouncing_sweep, cantilever_drop, free_rotation, path_difference,
                            REFERENCE, run, tilted_sweep)
import pytest


def reference(name):
    with np.load(REFERENCE / f'{name}.npz') as file:
        return {key: file[key].astype(float) for key in file}


# 12 elements, 0.2 ms. The references' own mesh error is 0.06 %.
@pytest.mark.parametrize(('scene', 'name', 'bound'), [
    pytest.param(cantilever_drop(), 's1_cantilever_drop_exudyn', 2e-3, id='S1 exudyn'),
    pytest.param(cantilever_drop(), 's1_cantilever_drop_opensees', 2e-3, id='S1 opensees'),
    pytest.param(free_rotation(), 's2_free_rotation_exudyn', 2e-3, id='S2 exudyn'),
    pytest.param(free_rotation(), 's2_free_rotation_opensees', 2e-3, id='S2 opensees'),
    pytest.param(free_rotation(viscosity=0.021), 's5_stiff_damping_exudyn', 3e-4, id='S5 exudyn')])
def test_free_tip_path(scene, name, bound):
    other = reference(name)
    ours = run(scene, 0.5)
    np.testing.assert_allclose(ours.t, other['t'][1:], atol=1e-7)
    error = path_difference(ours.tip, other['tip_xyz'][1:], other['tip_xyz'][0])
    assert error < bound


def onsets(result):
    """Return the ends of the samples in which the normal impulse begins to grow."""
    grows = np.diff(result.impulse[:, 2], prepend=0.0) > 0.0
    return result.t[1:][grows[1:] & ~grows[:-1]]


@pytest.mark.parametrize('name', ['s3_bouncing_sweep_exudyn48', 's3_bouncing_sweep_mujoco'])
def test_bouncing_sweep(name):
    other = reference(name)
    ours = run(bouncing_sweep(), 0.3, 1e-4)
    impulse = ours.impulse[:, 2]
    theirs = other['normal_impulse']
    early = np.interp(0.05, ours.t, impulse)
    assert early == pytest.approx(np.interp(0.05, other['t'], theirs), rel=0.02)
    assert impulse[-1] == pytest.approx(theirs[-1], rel=0.05)
    # the tip bounces off once it is up to speed, and comes back
    starts = onsets(ours)
    assert starts[starts > 0.06][0] == pytest.approx(other['onset'][1], abs=5e-4)
    # paths of different programs agree to some per cent as long as they have seen the same impacts
    until = other['t'] <= 0.08
    every = ours.tip[9::10][:until.sum() - 1]
    assert path_difference(every, other['tip_xyz'][until][1:], other['tip_xyz'][0]) < 0.02


@pytest.mark.parametrize('name', ['s4_tilted_deep_exudyn', 's4_tilted_deep_mujoco48'])
def test_tilted_sweep(name):
    other = reference(name)
    ours = run(tilted_sweep(damping=1.0), 0.4, 1e-4)
    assert onsets(ours)[0] == pytest.approx(other['onset'][0], abs=1e-4)
    assert ours.impulse[-1, 2] == pytest.approx(other['normal_impulse'][-1], rel=0.03)
    until = other['t'] <= 0.11  # before the first touch
    every = ours.tip[9::10][:until.sum() - 1]
    assert path_difference(every, other['tip_xyz'][until][1:], other['tip_xyz'][0]) < 0.01
