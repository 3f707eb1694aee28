"""A point mass that slides, rests and lifts off by the one-point problem, against closed forms."""
import math

from bristle_ros.physics.contact.curved import across, solve_in_plane, step_normal
from bristle_ros.physics.contact.law import ContactLaw, OPEN
from bristle_ros.physics.contact.surface import gap_at
from bristle_ros.physics.contact.tip import FORCE, GAP, STATE, stopping_force, TIP
from bristle_ros.scene.scene import Scene
from bristle_ros.scene.surface import Gutter, Profile
from bristle_ros.simulation.surface import surface_of
import numpy as np
import pytest

MASS = 1e-4         # [kg]
GRAVITY = 9.81


def surface(gutter=None, profile=None):
    return surface_of(Scene(gutter=gutter or Gutter(), profile=profile or Profile()))


class Point:
    """A point mass on a surface: the trapezoidal rule with the kernels' contact over each step."""

    def __init__(self, ground, friction, place, velocity, h=1e-4, stiffness=0.0):
        self.x, self.v, self.h = np.array(place, float), np.array(velocity, float), h
        self.ground, self.law = ground, ContactLaw(stiffness, 0.0, friction, friction, 0.0)
        self.tip, self.scratch = np.zeros(TIP), np.zeros((9, 16))
        self.force = np.zeros(3)    # mean over the last step, with what stopped it at its end

    def step(self):
        h, tip, sums = self.h, self.tip, self.scratch[8]
        load = np.array((0.0, 0.0, -GRAVITY))
        free = h * self.v + 0.5 * h * h * load
        gap0 = gap_at(self.ground, *self.x, sums)[0]
        self.scratch[:3, :3] = 0.5 * h * h / MASS * np.eye(3)
        for _ in range(20):     # the surface is linearised anew, as Newton's iterations do
            before = tip[FORCE:FORCE + 3].copy()
            d = free + 0.5 * h * h / MASS * before
            gap1, *normal, _ = gap_at(self.ground, *(self.x + d), sums)
            if not before.any() and gap0 >= 0.0 and gap1 >= 0.0:
                tip[STATE], tip[GAP] = OPEN, gap1
                break
            n = step_normal(self.ground, self.x, d, gap0, gap1, sums)
            axes = across(*n)
            basis = (axes[:3], axes[3:6], n)
            assert solve_in_plane(self.law, h, tip, self.scratch, basis, tuple(normal), d,
                                  (gap0, gap1))
            if np.abs(tip[FORCE:FORCE + 3] - before).max() <= 1e-14 * MASS * GRAVITY:
                break
        self.force = tip[FORCE:FORCE + 3].copy()
        self.x += free + 0.5 * h * h / MASS * self.force
        self.v += h * (load + self.force / MASS)
        if tip[STATE] != OPEN:
            self._stop()

    def _stop(self):
        n = gap_at(self.ground, *self.x, self.scratch[8])[1:4]
        rows = np.array(across(*n)[:6] + tuple(n)).reshape(3, 3)
        *change, _ = stopping_force(self.law, self.tip[STATE], MASS / self.h, self.h,
                                    tuple(rows @ self.v), tuple(rows @ self.force))
        change = rows.T @ change
        self.force += change
        self.tip[FORCE:FORCE + 3] = self.force
        self.v += self.h / MASS * change


def channel(slope):
    """Return a surface that falls by `slope` from y = 0 on, and the unit vector down it."""
    ground = surface(Gutter(enabled=True, kerb_distance=2.0, channel_width=2.0,
                            channel_slope=slope, lip_radius=0.01, foot_radius=0.01))
    return ground, np.array((0.0, math.cos(slope), -math.sin(slope)))


@pytest.mark.parametrize('stiffness', [0.0, 1e4])
@pytest.mark.parametrize('excess', [-1e-6, 1e-6, 0.3])
def test_a_block_on_an_incline_slides_beyond_the_angle_of_friction(excess, stiffness):
    """It rests where tan(slope) < mu, and slides with g (sin - mu cos) where not."""
    slope = 0.2
    ground, down = channel(slope)
    friction = math.tan(slope) - excess if excess < 0.1 else math.tan(slope) * (1.0 - excess)
    depth = MASS * GRAVITY * math.cos(slope) / stiffness if stiffness else 0.0
    normal = np.array((0.0, math.sin(slope), math.cos(slope)))
    block = Point(ground, friction, 0.5 * down - depth * normal, np.zeros(3), stiffness=stiffness)
    begun = block.x.copy()
    for _ in range(1000):
        block.step()
    t = 1000 * block.h
    way = float((block.x - begun) @ down)
    wanted = GRAVITY * (math.sin(slope) - friction * math.cos(slope)) * t * t / 2.0
    if excess < 0.0:
        assert abs(way) < 1e-15
    else:
        assert way == pytest.approx(wanted, rel=1e-4, abs=1e-14)
    assert block.force @ normal == pytest.approx(MASS * GRAVITY * math.cos(slope), rel=1e-9)


WAVE = Profile(kind='sine', amplitude=0.002, wavelength=0.1, phase=-0.5 * math.pi)


def wave(x):
    """Return height, slope and curvature of it."""
    k = 2.0 * math.pi / WAVE.wavelength
    a = k * x + WAVE.phase
    return (WAVE.amplitude * np.sin(a), WAVE.amplitude * k * np.cos(a),
            -WAVE.amplitude * k * k * np.sin(a) / (1.0 + (WAVE.amplitude * k * np.cos(a)) ** 2)
            ** 1.5)


def normal_force(x, square):
    """m (g cos(slope) + v^2 curvature) at a speed whose square this is."""
    _, slope, curvature = wave(x)
    return MASS * (GRAVITY / np.sqrt(1.0 + slope ** 2) + square * curvature)


def over_the_wave(speed, h, seconds):
    """Return places, normal forces and speeds of a point that starts in a trough."""
    ground = surface(profile=WAVE)
    point = Point(ground, 0.0, (0.0, 0.0, wave(0.0)[0]), (speed, 0.0, 0.0), h)
    found = []
    for _ in range(round(seconds / h)):
        before = point.x[0]
        point.step()
        middle = 0.5 * (before + point.x[0])    # a step's force is that of its middle
        found.append((middle, np.linalg.norm(point.force), *point.v, *point.x))
    return np.array(found)


def test_the_force_on_a_point_that_slides_over_a_sine():
    """m (g cos(slope) + v^2 curvature), v by the fall; an error of second order in the step."""
    errors = []
    for h in (4e-4, 2e-4, 1e-4):
        found = over_the_wave(0.6, h, 0.4)
        square = 0.36 + 2.0 * GRAVITY * (wave(0.0)[0] - wave(found[:, 0])[0])
        wanted = normal_force(found[:, 0], square)
        assert wanted.min() > 0.0
        errors.append(np.sqrt(np.mean((found[:, 1] - wanted) ** 2)) / wanted.mean())
    assert errors[-1] < 1e-5
    assert math.log2(errors[0] / errors[-1]) / 2.0 > 1.9, errors


def test_a_point_lifts_off_where_the_force_would_pull():
    """On the way to a crest, where m (g cos(slope) + v^2 curvature) becomes negative."""
    found = over_the_wave(1.3, 5e-5, 0.06)
    square = 1.69 + 2.0 * GRAVITY * (wave(0.0)[0] - wave(found[:, 0])[0])
    wanted = normal_force(found[:, 0], square)
    place = found[np.flatnonzero(wanted < 0.0)[0], 0]
    off = found[np.flatnonzero(found[:, 1] == 0.0)[0], 0]
    assert 0.01 < place < 0.05
    assert off == pytest.approx(place, abs=1e-4)
