"""Frame records against finite differences of the motion that they describe."""
from dataclasses import replace

from bristle_ros.physics.motion.drive import SINE, VAP
from bristle_ros.physics.motion import (APPROACHING, BASICS, FORWARD, FRAME, frame_at, GRAVITY,
                                        HEIGHT, HEIGHT_RATE, LEFT, OMEGA, PATH_SPIN, PENETRATION,
                                        ROTATION, SPEED, SPIN, SPIN_RATE, THETA, turn_frame,
                                        VELOCITY, YAW)
from bristle_ros.scene.scene import Scene
from bristle_ros.scene.sections import Brush, Drive, Road, Sweeper
from bristle_ros.simulation.model import build_model, start_motion
import numpy as np
import pytest

# Everything moves: tilted to an azimuth, mounted off the base, all commanded ramps under way.
SCENE = Scene(
    brush=Brush(start_angle=0.7),
    road=Road(attack_angle=0.2, tilt_azimuth=-0.9, penetration=0.03, approach_time=0.4),
    drive=Drive(profile='vap', mean_speed=12.0, alternating_speed=0.9, frequency=3.0, shape=0.2),
    sweeper=Sweeper(velocity=(1.5, -0.3), mount_position=(1.2, -0.8)))
RAMPS = {SPEED: (0.05, 12.0, 15.0, 0.5, 0.6), YAW: (0.1, 0.2, 1.1, 0.6, 0.05),
         PENETRATION: (0.12, 0.01, 0.03, 0.3, 0.0), FORWARD: (0.08, 1.5, 2.4, 0.4, 0.0),
         LEFT: (0.08, -0.3, 0.5, 0.4, 0.0)}
TIMES = (0.15, 0.3, 0.9)


def motion_of(scene, approaching):
    motion = start_motion(scene)
    for at, ramp in RAMPS.items():
        motion[at:at + len(ramp)] = ramp
    motion[APPROACHING] = approaching
    return motion


def record(t, drive, motion):
    frame = np.zeros(FRAME)
    frame_at(t, drive, False, motion, np.zeros((2, BASICS)), frame)
    return frame


def slope(function, t, h=1e-4):
    """Fourth-order central difference."""
    return (8.0 * (function(t + h) - function(t - h))
            - (function(t + 2 * h) - function(t - 2 * h))) / (12.0 * h)


def about(axis, angle):
    c, s = np.cos(angle), np.sin(angle)
    if axis == 'y':
        return np.array([[c, 0, s], [0, 1, 0], [-s, 0, c]])
    return np.array([[c, -s, 0], [s, c, 0], [0, 0, 1]])


@pytest.fixture(params=['sine', 'vap', 'approach'])
def moving(request):
    drive = build_model(SCENE).exact
    drive = drive._replace(profile=VAP if request.param == 'vap' else SINE)
    motion = motion_of(SCENE, request.param == 'approach')
    return lambda t: record(t, drive, motion)


def heading(t):
    start, value, target, duration, before = RAMPS[YAW]
    tau = min(t - start, duration)
    return (before + value * tau + 0.5 * (target - value) / duration * tau ** 2
            + target * max(0.0, t - start - duration))


def rotation(frame):
    return frame[ROTATION:ROTATION + 9].reshape(3, 3)


@pytest.mark.parametrize('t', TIMES)
def test_orientation(moving, t):
    frame = moving(t)
    azimuth, tilt = SCENE.road.tilt_azimuth, SCENE.road.attack_angle
    wanted = (about('z', heading(t)) @ about('z', azimuth) @ about('y', tilt)
              @ about('z', -azimuth) @ about('z', frame[THETA]))
    np.testing.assert_allclose(rotation(frame), wanted, atol=1e-14)
    # beta > 0 lowers the side that tilt_azimuth faces
    low = about('z', heading(t)) @ about('z', azimuth) @ about('y', tilt)
    assert (low @ [1.0, 0.0, 0.0])[2] < 0.0


def turns_at(of, t):
    """Return the angular velocity, brush axes, by the change of ROTATION."""
    turning = rotation(of(t)).T @ slope(lambda at: rotation(of(at)), t)
    np.testing.assert_allclose(turning, -turning.T, atol=1e-7)
    return [turning[2, 1], turning[0, 2], turning[1, 0]]


@pytest.mark.parametrize('t', TIMES)
def test_spin_and_its_rate(moving, t):
    frame = moving(t)
    np.testing.assert_allclose(frame[SPIN:SPIN + 3], turns_at(moving, t), atol=1e-7)
    np.testing.assert_array_equal(frame[PATH_SPIN:PATH_SPIN + 3], frame[SPIN:SPIN + 3])
    rate = slope(lambda at: moving(at)[SPIN:SPIN + 3], t)
    np.testing.assert_allclose(frame[SPIN_RATE:SPIN_RATE + 3], rate, atol=1e-6)
    assert frame[OMEGA] == pytest.approx(slope(lambda at: moving(at)[THETA], t), abs=1e-7)


@pytest.mark.parametrize('t', TIMES)
def test_velocity_and_acceleration_of_the_mount(moving, t):
    frame = moving(t)
    offset = np.array([*SCENE.sweeper.mount_position, 0.0])

    def base(at):
        result = np.zeros(3)
        for i, row in enumerate((FORWARD, LEFT)):
            start, value, target, duration, _ = RAMPS[row]
            part = min((at - start) / duration, 1.0)
            result[i] = value + part * (target - value)
        return result

    arm = slope(lambda at: about('z', heading(at)) @ offset, t)
    wanted = about('z', heading(t)) @ base(t) + arm
    np.testing.assert_allclose(frame[VELOCITY:VELOCITY + 3], wanted, atol=1e-9)
    acceleration = slope(lambda at: moving(at)[VELOCITY:VELOCITY + 3], t)
    np.testing.assert_allclose(
        frame[GRAVITY:GRAVITY + 3], rotation(frame).T @ ([0.0, 0.0, -9.81] - acceleration),
        atol=1e-7)
    assert np.linalg.norm(acceleration) > 0.5


@pytest.mark.parametrize('t', TIMES)
def test_height(moving, t):
    frame = moving(t)
    assert frame[HEIGHT_RATE] == pytest.approx(
        slope(lambda at: moving(at)[HEIGHT], t), abs=1e-9)


@pytest.mark.parametrize('t', [0.1527, 0.3033, 0.9025])
@pytest.mark.parametrize('displacement', [False, True])
def test_places_within_load_steps_have_rates_of_their_own(displacement, t):
    drive = build_model(SCENE).exact._replace(profile=VAP, time_step=5e-3)
    motion = motion_of(SCENE, False)

    def of(at):
        frame = np.zeros(FRAME)
        frame_at(at, drive, displacement, motion, np.zeros((2, BASICS)), frame)
        return frame
    frame = of(t)
    np.testing.assert_allclose(frame[PATH_SPIN:PATH_SPIN + 3], turns_at(of, t), atol=1e-7)
    assert frame[HEIGHT_RATE] == pytest.approx(slope(lambda at: of(at)[HEIGHT], t), abs=1e-9)
    apart = np.abs(frame[SPIN:SPIN + 3] - frame[PATH_SPIN:PATH_SPIN + 3]).max()
    assert displacement or 1e-5 < apart < 0.1       # what loads go by


def test_lowest_undeformed_tip_goes_penetration_deep():
    drive = build_model(SCENE).exact
    length, lean = SCENE.bristle.length, SCENE.brush.mount_angle
    own = np.array([SCENE.brush.mount_radius + length * np.sin(lean), 0.0, -length * np.cos(lean)])
    motion = start_motion(SCENE)
    depths = [-(rotation(record(1.0, drive._replace(start_angle=angle), motion)) @ own)[2]
              for angle in np.linspace(0.0, 2.0 * np.pi, 2001)]
    height = record(1.0, drive, motion)[HEIGHT]
    assert max(depths) - height == pytest.approx(SCENE.road.penetration, abs=1e-6)
    # halfway through the approach 3 x^2 - 2 x^3 is one half
    assert max(depths) - record(0.2, drive, motion)[HEIGHT] == pytest.approx(0.015, abs=1e-6)


def test_frame_of_a_bristle_at_another_azimuth():
    drive = build_model(SCENE).exact
    motion = motion_of(SCENE, False)
    angle = 2.0 * np.pi / 3.0
    own = np.zeros(FRAME)
    turn_frame(record(0.3, drive, motion), np.cos(angle), np.sin(angle), own)
    wanted = record(0.3, drive._replace(start_angle=drive.start_angle + angle), motion)
    np.testing.assert_allclose(own[:THETA], wanted[:THETA], atol=1e-13)


def test_load_steps_are_ramped():
    # TS: exact at its multiples, linear in speed and acceleration between them
    scene = replace(SCENE, solver=replace(SCENE.solver, time_step=0.02))
    model = build_model(scene)
    motion = motion_of(SCENE, True)
    np.testing.assert_allclose(record(0.14, model.drive, motion),
                               record(0.14, model.exact, motion), atol=1e-12)
    ends = [record(at, model.exact, motion) for at in (0.14, 0.16)]
    ramped = record(0.145, model.drive, motion)
    assert ramped[HEIGHT] == pytest.approx(0.75 * ends[0][HEIGHT] + 0.25 * ends[1][HEIGHT],
                                           abs=1e-15)
    exact = record(0.145, model.exact, motion)
    assert ramped[[THETA, OMEGA]] == pytest.approx(exact[[THETA, OMEGA]], abs=0.0)
    assert abs(ramped[SPIN_RATE + 2] - exact[SPIN_RATE + 2]) > 1e-3
