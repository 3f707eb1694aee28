"""Commands and load steps: a command acts from its own time on, whatever the load steps are."""
from functools import cache
import math

from bristle_ros.physics.motion import DRAG_RATE, FRAME, HEIGHT_RATE, PATH_SPIN, SPIN_RATE
from bristle_ros.physics.step.stepping import own_frame
from bristle_ros.scene.error import SceneError
from bristle_ros.scene.scene import Scene
from bristle_ros.scene.sections import Brush, Contact, Damping, Drive, Road, Solver
from bristle_ros.simulation import CommandRefused, Simulation, StepFailure
import numpy as np
from physics.scenes import MOUNT_ANGLE, RPM
import pytest

ITS = 1e-4
SPEED = 100.0 * RPM
# Off the grid of every load step tried but the last; times are whole integration steps.
COMMANDS = {
    'speed': [(0.0512, 'cmd_brush_speed', [8.0])],
    'speed it has': [(0.0512, 'cmd_brush_speed', [SPEED])],
    'velocity and yaw': [(0.0512, 'cmd_vel', [0.3, 0.1, 0.5])],
    'velocity, yaw as it is': [(0.0512, 'cmd_vel', [0.3, 0.0, 0.0])],
    'turned back before it is there': [(0.0512, 'cmd_vel', [0.3, 0.1, 0.5]),
                                       (0.0534, 'cmd_vel', [0.0, 0.0, -0.5])],
    'depth': [(0.0512, 'cmd_penetration', [0.015])],
    'depth during the approach': [(0.0112, 'cmd_penetration', [0.015])],
    'all at once': [(0.0512, 'cmd_penetration', [0.015]), (0.0512, 'cmd_vel', [0.3, 0.1, 0.5]),
                    (0.0512, 'cmd_brush_speed', [8.0])],
    'four in a load step': [(0.0512, 'cmd_vel', [0.3, 0.1, 0.5]),
                            (0.0516, 'cmd_vel', [0.1, 0.1, 0.5]),
                            (0.0521, 'cmd_brush_speed', [9.0]),
                            (0.0523, 'cmd_penetration', [0.021])],
    'on the load step': [(0.05, 'cmd_vel', [0.3, 0.1, 0.5])],
}
# largest difference of the tip's path from TS = 0 [m], twice what was found; it falls with TS^2
BOUND = {1e-3: 1.3e-4, 2e-3: 5.6e-4, 5e-3: 4e-4}


def scene(load_case, time_step, contact=True):
    return Scene(
        brush=Brush(mount_angle=MOUNT_ANGLE), road=Road(penetration=0.02, approach_time=0.2),
        contact=Contact(enabled=contact), damping=Damping(mass=0.1, stiffness=1e-3),
        drive=Drive(profile='constant', mean_speed=SPEED),
        solver=Solver(integration_time_step=ITS, load_case=load_case, time_step=time_step,
                      spectral_radius=0.0, tolerance=1e-9))


def follow(simulation, commands, steps, every=1):
    """Step to the end with the commands given on the way; yields after each `every` steps."""
    waiting = list(commands)
    for step in range(0, steps, every):
        while waiting and round(waiting[0][0] / ITS) <= step:
            simulation.command(*waiting.pop(0)[1:])
        simulation.advance(every)
        yield simulation


@cache
def path(load_case, time_step, name, contact=True):
    simulation = Simulation(scene(load_case, time_step, contact))
    tips, exact = [], []
    for one in follow(simulation, COMMANDS[name], 800, 2):
        snapshot = one.snapshot()
        tips.append(snapshot.tip_position_road[0])
        exact.append([snapshot.theta, snapshot.omega, *one.sweeper_motion()])
    return np.array(tips), np.array(exact)


@pytest.mark.parametrize('name', COMMANDS)
@pytest.mark.parametrize('time_step', BOUND)
@pytest.mark.parametrize('load_case', ['inertia', 'displacement'])
def test_commands_act_as_without_load_steps(load_case, time_step, name):
    tips, exact = path(load_case, time_step, name)
    reference, reference_exact = path(load_case, 0.0, name)
    np.testing.assert_array_equal(exact, reference_exact)
    assert np.abs(tips - reference).max() < BOUND[time_step]


@pytest.mark.parametrize('name', ['velocity and yaw', 'four in a load step'])
def test_what_load_steps_change_is_second_order(name):
    # without contact, whose impacts have an order of their own
    reference = path('displacement', 0.0, name, False)[0]
    errors = [np.abs(path('displacement', ts, name, False)[0] - reference).max()
              for ts in (1e-3, 2e-3, 4e-3)]
    assert np.polyfit(np.log([1.0, 2.0, 4.0]), np.log(errors), 1)[0] == pytest.approx(2.0, abs=0.3)


@pytest.mark.parametrize('name', COMMANDS)
@pytest.mark.parametrize('load_case', ['inertia', 'displacement'])
def test_no_load_jumps_at_a_command(load_case, name):
    """Angles, speeds, height and the clamp's place go on; their rates may change at once."""
    simulation = Simulation(scene(load_case, 5e-3))
    before, steady = None, 0.0
    rates = [*range(SPIN_RATE, SPIN_RATE + 6), *range(PATH_SPIN, PATH_SPIN + 3), HEIGHT_RATE,
             DRAG_RATE]
    values = [i for i in range(FRAME) if i not in rates]
    waiting = list(COMMANDS[name])
    for step in range(600):
        frame = np.empty(FRAME)
        while waiting and round(waiting[0][0] / ITS) <= step:
            simulation.command(*waiting.pop(0)[1:])
        own_frame(simulation.model, simulation.state.motion, simulation.model.azimuth[0],
                  step * ITS, simulation._scratch, frame)
        assert np.isfinite(frame).all()
        if before is not None:
            steady = max(steady, np.abs(frame - before)[values].max())
        before = frame
        simulation.state.step[0] += 1
    # the fastest of all: a speed of 1 rad/s^2 .. 50 rad/s^2, and turning at 10.5 rad/s
    assert steady < 50.0 * ITS * 1.01


@pytest.mark.parametrize('load_case', ['inertia', 'displacement'])
def test_bits_do_not_depend_on_chunks(load_case):
    ends = []
    for every in (1, 2):
        simulation = Simulation(scene(load_case, 2e-3))
        for _ in follow(simulation, COMMANDS['turned back before it is there'], 600, every):
            pass
        ends.append(simulation.state.nodes.tobytes())
    assert ends[0] == ends[1]


def test_a_failure_names_what_failed():
    simulation = Simulation(scene('inertia', 0.0))
    simulation.advance(1)
    simulation.state.motion[2] = math.nan
    with pytest.raises(StepFailure, match='motion is not finite') as failure:
        simulation.advance(1)
    assert 'damping' not in str(failure.value)


@pytest.mark.parametrize('attack', [0.0, 0.3])
def test_no_clamp_is_brought_to_the_road(attack):
    """The limit by hand: how far the lowest undeformed tip is below its clamp."""
    def deep(penetration, contact=True):
        return Scene(brush=Brush(mount_angle=MOUNT_ANGLE), contact=Contact(enabled=contact),
                     road=Road(penetration=penetration, attack_angle=attack))

    # a wire in the plane of the tilt is at mount angle + attack angle from the normal
    limit = 0.24 * math.cos(MOUNT_ANGLE - attack)
    with pytest.raises(SceneError, match=r'road\.penetration = .*clamp.*stay below 0\.2'):
        deep(limit + 1e-6)
    assert deep(limit + 1e-6, contact=False).road.penetration > limit     # ignored there
    simulation = Simulation(deep(limit - 1e-6))
    with pytest.raises(CommandRefused, match='clamp to the road'):
        simulation.check_command('cmd_penetration', [limit + 1e-6])
    simulation.check_command('cmd_penetration', [limit - 1e-6])


def test_a_lifted_brush_is_no_deep_one():
    simulation = Simulation(scene('inertia', 0.0))
    simulation.check_command('cmd_penetration', [-0.5])
    with pytest.raises(CommandRefused, match='lifted by at most 10 m') as refused:
        simulation.check_command('cmd_penetration', [-10.5])
    assert 'above the undeformed tip' not in str(refused.value)
    assert Scene(road=Road(penetration=-5.0)).road.penetration == -5.0
