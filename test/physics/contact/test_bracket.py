"""The one-point contact problem: its laws as properties of random problems."""
from bristle_ros.physics.contact.bracket import solve_contact
from bristle_ros.physics.contact.law import (ContactLaw, normal_force, OPEN, SLIP, spring_energy,
                                             STICK)
from hypothesis import assume, given, HealthCheck, settings, strategies as st
import numpy as np
import pytest

settings.register_profile('contact', max_examples=400, deadline=None, derandomize=True,
                          suppress_health_check=[HealthCheck.too_slow])
settings.load_profile('contact')


def numbers(low, high):
    return st.floats(low, high, allow_nan=False, allow_subnormal=False)


def logarithmic(low, high):
    return numbers(np.log10(low), np.log10(high)).map(lambda exponent: 10.0 ** exponent)


@st.composite
def compliances(draw):
    """Symmetric positive definite, with directions up to 1e4 times as compliant as others."""
    q = np.array(draw(st.tuples(*[numbers(-1.0, 1.0)] * 4)))
    assume(np.linalg.norm(q) > 0.1)
    w, x, y, z = q / np.linalg.norm(q)
    turned = np.array([
        [1 - 2 * (y * y + z * z), 2 * (x * y - w * z), 2 * (x * z + w * y)],
        [2 * (x * y + w * z), 1 - 2 * (x * x + z * z), 2 * (y * z - w * x)],
        [2 * (x * z - w * y), 2 * (y * z + w * x), 1 - 2 * (x * x + y * y)]])
    values = np.array([draw(logarithmic(1e-8, 1e-4)) for _ in range(3)])
    return np.ascontiguousarray((turned * values) @ turned.T)


SPRINGS = st.one_of(st.just(0.0), logarithmic(1e2, 1e7))
LAWS = st.builds(
    lambda stiffness, damping, high, part, decay: ContactLaw(
        stiffness, damping if stiffness > 0.0 else 0.0, high, part * high, decay),
    SPRINGS, st.one_of(st.just(0.0), numbers(0.0, 10.0)),
    st.one_of(st.just(0.0), numbers(1e-6, 2.0)),
    st.one_of(st.just(1.0), numbers(0.0, 1.0)), numbers(0.0, 50.0))
# zero, or far above round-off of the mount's distance from the road
LENGTHS = st.one_of(st.just(0.0), st.tuples(st.sampled_from((-1.0, 1.0)), logarithmic(1e-14, 1e-4))
                    .map(lambda pair: pair[0] * pair[1]))
DISPLACEMENTS = st.tuples(LENGTHS, LENGTHS, LENGTHS).map(np.array)
STEPS = logarithmic(1e-6, 1e-3)
GAPS = LENGTHS
GUESSES = st.one_of(st.just(0.0), logarithmic(1e-6, 1e3))


class Solution:
    def __init__(self, law, h, w, gap0, base, guess=0.0, state=SLIP):
        self.force = np.array([0.1 * guess, -0.2 * guess, guess])
        self.state = solve_contact(law, h, w, gap0, base, state, self.force)
        assert self.state in (OPEN, SLIP, STICK)
        self.moved = base + w @ self.force      # slip, slip, gap at the end
        self.normal = self.force[2]
        self.friction = np.hypot(*self.force[:2])
        self.slip = np.hypot(*self.moved[:2])
        # what positions are known to: round-off of the terms that cancel
        self.blur = 1e-12 * (abs(base).max() + abs(w).max() * abs(self.force).max() + abs(gap0))


def coefficient(law, speed):
    return law.kinetic + (law.static - law.kinetic) * np.exp(-law.decay * speed)


def slack(law, h, w, solution):
    """How much more force a law may want where its arguments are known to the blur only."""
    slope = law.stiffness * (1.0 + law.damping * 1e-4 / h)
    return slope * solution.blur + 1e-9 * solution.normal


@given(LAWS, STEPS, compliances(), GAPS, DISPLACEMENTS, GUESSES)
def test_normal_law(law, h, w, gap0, base, guess):
    s = Solution(law, h, w, gap0, base, guess)
    assert s.normal >= 0.0
    if law.stiffness == 0.0:
        assert s.moved[2] >= -s.blur
        assert s.normal * s.moved[2] <= s.normal * s.blur
    else:
        assert s.normal == pytest.approx(normal_force(law, h, gap0, s.moved[2]),
                                         rel=1e-6, abs=slack(law, h, w, s))
    if s.state == OPEN:
        assert (s.force == 0.0).all()


@given(LAWS, STEPS, compliances(), GAPS, DISPLACEMENTS, GUESSES)
def test_friction_law(law, h, w, gap0, base, guess):
    s = Solution(law, h, w, gap0, base, guess)
    assert s.friction <= law.static * s.normal * (1.0 + 1e-9)
    if s.state == STICK:
        assert s.slip <= s.blur
    elif s.state == SLIP and s.slip > 1e3 * s.blur:
        # opposite to the slip, and as large as the law says at this speed
        assert s.force[:2] @ s.moved[:2] <= -(1.0 - 1e-6) * s.friction * s.slip + 1e-300
        bound = coefficient(law, s.slip / h) * s.normal
        blur = law.static * s.normal * min(1.0, law.decay * s.blur / h)
        assert s.friction == pytest.approx(bound, rel=1e-6, abs=1e-9 * s.normal + blur)


@given(LAWS, STEPS, compliances(), GAPS, DISPLACEMENTS, GUESSES)
def test_contact_gives_no_more_than_its_spring_lets_go(law, h, w, gap0, base, guess):
    s = Solution(law, h, w, gap0, base, guess)
    if law.stiffness == 0.0:
        gap0 = max(gap0, 0.0)  # a rigid road is never penetrated to begin with
        s = Solution(law, h, w, gap0, base, guess)
    moved = s.moved - [0.0, 0.0, gap0]
    stored = spring_energy(law.stiffness, s.moved[2]) - spring_energy(law.stiffness, gap0)
    work = s.force @ moved
    scale = abs(s.force) @ abs(moved) + abs(stored)
    assert work + stored <= 1e-8 * scale + s.blur * abs(s.force).max() * 10.0


@given(LAWS, STEPS, compliances(), GAPS, DISPLACEMENTS, GUESSES, numbers(0.0, 2.0 * np.pi))
def test_axes_of_the_road_plane_do_not_matter(law, h, w, gap0, base, guess, angle):
    c, s = np.cos(angle), np.sin(angle)
    r = np.array([[c, -s, 0.0], [s, c, 0.0], [0.0, 0.0, 1.0]])
    one = Solution(law, h, w, gap0, base, guess)
    two = Solution(law, h, np.ascontiguousarray(r @ w @ r.T), gap0, r @ base, guess)
    # where weakening friction makes the answer many-valued, round-off may choose the branch
    assume(law.decay == 0.0 or law.static == law.kinetic)
    stiff = 1.0 / np.linalg.eigvalsh(w)[0]
    np.testing.assert_allclose(two.force, r @ one.force,
                               atol=1e-6 * abs(one.force).max() + 10.0 * stiff * one.blur)


@given(LAWS, STEPS, compliances(), GAPS, DISPLACEMENTS, GUESSES, st.sampled_from((SLIP, STICK)))
def test_newtons_method_finds_what_brackets_find(law, h, w, gap0, base, guess, state):
    assume(law.decay == 0.0 or law.static == law.kinetic)   # else many-valued
    one = Solution(law, h, w, gap0, base, guess, state)
    # by older rules a touch that begins, no guess, is bracketed at once
    two = Solution(law._replace(older=True), h, w, gap0, base, 0.0)
    stiff = 1.0 / np.linalg.eigvalsh(w)[0]
    np.testing.assert_allclose(two.force, one.force,
                               atol=1e-6 * abs(one.force).max() + 10.0 * stiff * one.blur)


def test_stick_wherever_it_is_admissible():
    # mu from 0.8 to 0.2 within 1 mm/s: at f_n = 1 N both sticking at 0.5 N and slipping with less
    # satisfy the law; sticking is to be chosen.
    law = ContactLaw(0.0, 0.0, 0.8, 0.2, 1e3)
    w = np.diag([1e-6, 1e-6, 1e-6])
    base, h = np.array([5e-7, 0.0, -1e-6]), 1e-4
    slipping = base[0] - 1e-6 * 0.2  # what is left of the slip at the kinetic force
    assert coefficient(law, slipping / h) < 0.5  # so slip is self-consistent too
    s = Solution(law, h, w, 0.0, base)
    assert s.state == STICK
    assert s.force == pytest.approx([-0.5, 0.0, 1.0])
    base[0] = 0.81e-6
    assert Solution(law, h, w, 0.0, base).state == SLIP


def test_closed_form_of_slip():
    # uncoupled compliance, constant friction: f_n = -g / w, f_t = mu f_n against the slip
    law = ContactLaw(0.0, 0.0, 0.5, 0.5, 0.0)
    s = Solution(law, 1e-4, np.diag([2e-6, 2e-6, 4e-6]), 0.0, np.array([3e-5, -4e-5, -8e-6]))
    assert s.state == SLIP
    assert s.force == pytest.approx([-0.6, 0.8, 2.0], rel=1e-12)


def test_closed_form_of_a_spring():
    # from g0 = 0 to g1 < 0: f_n = -Kn g1 / 2, g1 = base + w f_n
    law = ContactLaw(1e4, 0.0, 0.0, 0.0, 0.0)
    s = Solution(law, 1e-4, np.diag([1e-6, 1e-6, 1e-4]), 0.0, np.array([0.0, 0.0, -3e-6]))
    assert s.normal == pytest.approx(0.5e4 * 3e-6 / (1.0 + 0.5e4 * 1e-4), rel=1e-12)


@pytest.mark.parametrize('gap0', [-2e-6, 0.0, 3e-6])
def test_normal_force_is_monotone_and_continuous(gap0):
    law = ContactLaw(1e4, 2.0, 0.5, 0.5, 0.0)
    gaps = np.linspace(-5e-6, 5e-6, 2001)
    forces = np.array([normal_force(law, 1e-4, gap0, gap) for gap in gaps])
    assert (forces >= 0.0).all()
    assert (np.diff(forces) <= 0.0).all()
    assert abs(np.diff(forces)).max() < 2e-4


@pytest.mark.parametrize(('gap0', 'gap1'), [(-2e-6, -3e-6), (-2e-6, 1e-6), (2e-6, -1e-6)])
def test_work_of_the_undamped_spring_is_what_it_stores(gap0, gap1):
    # Gonzalez (1996): the discrete gradient; at g1 = g0 it is the force itself
    law = ContactLaw(1e5, 0.0, 0.5, 0.5, 0.0)
    work = normal_force(law, 1e-4, gap0, gap1) * (gap0 - gap1)
    assert work == pytest.approx(spring_energy(1e5, gap1) - spring_energy(1e5, gap0), rel=1e-12)
    assert normal_force(law, 1e-4, -2e-6, -2e-6) == pytest.approx(0.2, rel=1e-14)


def test_of_two_solutions_the_one_that_goes_on_is_found():
    # Friction jams a steep tip: sticking wants a force five times that of slipping, both obey the
    # laws. A tip that slips goes on slipping, one that sticks sticks.
    law = ContactLaw(0.0, 0.0, 0.7, 0.27, 50.0)
    w = np.array([[1e-4, 0.0, 5e-5], [0.0, 1e-4, 0.0], [5e-5, 0.0, 4e-5]])
    base = np.array([1e-4, 0.0, -3e-5])
    slipping = Solution(law, 1e-4, w, 0.0, base, 1.0, SLIP)
    sticking = Solution(law, 1e-4, w, 0.0, base, 1.0, STICK)
    assert (slipping.state, sticking.state) == (SLIP, STICK)
    assert slipping.normal == pytest.approx(3e-5 / (4e-5 - 0.27 * 5e-5), rel=1e-6)
    assert sticking.normal == pytest.approx(8e-5 / 1.5e-5, rel=1e-6)
    fresh = Solution(law, 1e-4, w, 0.0, base)
    assert fresh.normal == pytest.approx(slipping.normal, rel=1e-6)


def test_no_root_where_the_slip_vanishes_outside_the_cone():
    """The equations of slip hold there for any friction; found by the campaign (2026.250)."""
    law = ContactLaw(1e7, 0.0, 0.7, 0.27, 0.4)
    w = np.array([
        [4.073105849449792e-05, 4.00187635366382e-06, -2.443313181293566e-05],
        [4.002200156356319e-06, 4.3164081888275805e-05, -2.06487324011545e-05],
        [-2.4433280799874558e-05, -2.0648539862941883e-05, 2.512809549368232e-05]])
    gap0 = -6.869677909859817e-08
    base = np.array([3.05679481e-06, 2.54761719e-05, -1.44242194e-05])
    # within a digit of the eighth all of these are the same problem
    for shift in np.linspace(-1e-8, 1e-8, 41):
        force = np.array([0.33692268, -0.30613274, 0.65111107])
        moved = base * (1.0 + shift)
        assert solve_contact(law, 1e-4, w, gap0, moved, SLIP, force) == SLIP
        gap1 = moved[2] + w[2] @ force
        assert force[2] == pytest.approx(normal_force(law, 1e-4, gap0, gap1), rel=1e-6)
