"""Threads that share out the bristles: same bits, and failures that leave all at one step."""
from dataclasses import replace

from bristle_ros.simulation.simulation import Simulation, StepFailure
import numpy as np
from physics.scenes import bouncing_sweep
import pytest


def brush(**solver):
    scene = bouncing_sweep(its=1e-4, count=7, **solver)
    return replace(scene, contact=replace(scene.contact, damping=0.0))


def test_bits_do_not_depend_on_threads_or_calls():
    one, three = Simulation(brush(), threads=1), Simulation(brush(), threads=3)
    one.advance(300)
    for steps in (1, 129, 64, 106):
        three.advance(steps)
    for ours, theirs in zip(one.state, three.state):
        np.testing.assert_array_equal(ours, theirs)


def test_a_bristle_of_many_is_the_lone_bristle():
    many = Simulation(brush())
    scene = brush()
    alone = Simulation(replace(scene, brush=replace(
        scene.brush, bristle_count=1, start_angle=scene.brush.start_angle)))
    many.advance(200)
    alone.advance(200)
    np.testing.assert_array_equal(many.state.nodes[0], alone.state.nodes[0])


@pytest.mark.parametrize('threads', [1, 3])
def test_after_a_failure_all_bristles_are_at_the_failed_step(threads):
    simulation = Simulation(brush(), threads=threads)
    simulation.advance(100)
    good = Simulation(brush())
    good.advance(110)
    state = simulation.state
    stepper = simulation._stepper
    wrapped = stepper._work

    def fails(scratch, steps):
        # bristle 4 fails ten steps on, bristle 5 twelve: what kernels report of a lost bristle
        outcomes = [wrapped(scratch, steps)]
        for bristle, step in ((4, 110), (5, 112)):
            ahead = step - int(state.step[0])
            if scratch is stepper._scratch[bristle % threads] and ahead < steps:
                outcomes.append((ahead, 2, bristle))
        return min(filter(None, outcomes), default=None)

    stepper._work = fails
    with pytest.raises(StepFailure, match='step 110: bristle 4: ') as failure:
        simulation.advance(50)
    assert failure.value.step == simulation.step == 110
    for ours, theirs in zip(state, good.state):
        np.testing.assert_array_equal(ours, theirs)


def test_rows_of_lanes_lie_in_cache_lines():
    simulation = Simulation(bouncing_sweep(its=2e-4, elements=5))
    arrays = [simulation.state.nodes, simulation.state.mids, simulation.state.chain]
    for array in arrays:
        assert array.ctypes.data % 64 == 0
        assert array.strides[1] % 64 == 0
