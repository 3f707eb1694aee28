"""Strains, internal forces and tangents of the beam: objectivity, and finite differences."""
from bristle_ros.physics import layout
from bristle_ros.physics.beam import internal_forces, Section, stiffness
from bristle_ros.physics.chain import (chain_work, CORNER, eliminate, factorise, load_residual,
                                       MID, RECORD, substitute)
from bristle_ros.physics.frame import FRAME, GRAVITY, SPIN, SPIN_RATE
from bristle_ros.physics.loads import residual
from bristle_ros.physics.tangent import ELEMENT, element_tangent, moment_tangent, tangent_work
import numpy as np
from physics.beams import Beam, derivative, matrix, product, turn
import pytest

LENGTH = 0.02
SECTION = Section(2.0, 1.5, 1.4, 0.3, 0.2, 0.6, LENGTH)


def straight_nodes(elements):
    return [(np.array([0.5 * LENGTH * n, 0.0, 0.0]), np.array([1.0, 0.0, 0.0, 0.0]))
            for n in range(2 * elements + 1)]


def bent_nodes(elements, seed):
    """Return nodes far from straight, rotated at random by half a radian."""
    rng = np.random.default_rng(seed)
    return [(x + 0.003 * rng.normal(size=3), turn(0.3 * rng.normal(size=3)))
            for x, _ in straight_nodes(elements)]


def rigidly_moved(nodes, seed):
    rng = np.random.default_rng(seed)
    q = rng.normal(size=4)  # any orientation, also beyond a half turn
    q /= np.linalg.norm(q)
    shift = rng.normal(size=3)
    return [(shift + matrix(q) @ x, product(q, p)) for x, p in nodes]


@pytest.mark.parametrize('seed', range(5))
def test_rigid_motion_of_the_straight_wire_strains_nothing(seed):
    beam = Beam(rigidly_moved(straight_nodes(6), seed), SECTION)
    assert abs(beam.points(layout.STRAIN)).max() < 1e-12


@pytest.mark.parametrize('seed', range(5))
def test_rigid_motion_leaves_stresses(seed):
    nodes = bent_nodes(6, seed)
    before = Beam(nodes, SECTION).points(layout.STRESS)
    assert abs(before[:, 3:]).min(axis=0).max() > 1e-3  # all of them are at work
    after = Beam(rigidly_moved(nodes, seed + 100), SECTION).points(layout.STRESS)
    scale = abs(before).max(axis=0)
    assert (abs(after - before) / scale).max() < 1e-12


def test_sign_of_a_quaternion_does_not_matter():
    nodes = bent_nodes(6, 1)
    one = Beam(nodes, SECTION).points(layout.STRESS)
    other = Beam([(x, -q) for x, q in nodes], SECTION).points(layout.STRESS)
    np.testing.assert_array_equal(one, other)


def test_strains_are_those_of_a_helix():
    # x' = R (1 + e) e_1 with the twist and curvatures of a rotating frame: on R(s) = exp(s [k]x)
    # strain and curvature are constant, e_1 elongated by e. Interpolation error: h^3.
    elongation, curvature = 0.01, np.array([3.0, 2.0, -1.0])
    errors = []
    for length in (0.02, 0.01):
        nodes = []
        for n in range(5):
            s = 0.5 * length * n
            fine = (np.arange(2000) + 0.5) / 2000 * s
            x = sum(matrix(turn(curvature * f))[:, 0] for f in fine) * (1 + elongation) * s / 2000
            nodes.append((x + np.zeros(3), turn(curvature * s)))
        strain = Beam(nodes, SECTION._replace(element_length=length)).points(layout.STRAIN)
        wanted = np.array([elongation, 0.0, 0.0, *curvature])
        errors.append(abs(strain - wanted).max(axis=0))
    assert (errors[1] < 1e-4).all()
    assert (errors[1][3:] < errors[0][3:] / 3.5).all()


@pytest.mark.parametrize('seed', range(3))
def test_internal_forces_are_the_gradient_of_the_energy(seed):
    beam = Beam(bent_nodes(6, seed), SECTION)
    gradient = derivative(beam, beam.energy).reshape(-1, 6)
    forces = beam.forces()
    assert abs(forces - gradient).max() < 1e-8 * abs(forces).max()


def test_internal_forces_balance():
    # No wire pulls itself along or round: forces and moments of all nodes, the clamp's in its left
    # rows, cancel.
    beam = Beam(bent_nodes(6, 4), SECTION)
    clamp, q = beam.nodes[0]
    force = beam.rows[0, layout.LFORCE:layout.LFORCE + 3, 0].copy()
    y = beam.rows[0, layout.LTORQUE:layout.LTORQUE + 4, 0]
    moment = product(y, q * [1, -1, -1, -1])[1:] + np.cross(clamp, force)
    for n, (x, p) in enumerate(beam.nodes[1:], 1):
        f = beam.at(n, layout.FORCE, 3)
        force += f
        moment += np.cross(x, f) + product(beam.at(n, layout.TORQUE, 4), p * [1, -1, -1, -1])[1:]
    assert abs(force).max() < 1e-13
    assert abs(moment).max() < 1e-13


@pytest.mark.parametrize('seed', range(3))
def test_tangent_is_the_derivative_of_the_forces(seed):
    beam = Beam(bent_nodes(4, seed), SECTION)
    axes = [matrix(q) for _, q in beam.nodes[1:]]
    numeric = derivative(beam, lambda: beam.forces(axes).ravel())
    ours = np.zeros((54, 54))
    work = tangent_work()
    for element in range(4):
        element_tangent(beam.s, 0, element, SECTION, 1.0, work)
        at = slice(12 * element, 12 * element + 18)
        ours[at, at] += work[ELEMENT:ELEMENT + 324].reshape(18, 18)
    ours = ours[6:, 6:]
    for n in range(1, 9):
        y = product(beam.nodes[n][1] * [1, -1, -1, -1], beam.at(n, layout.TORQUE, 4))
        at = slice(6 * n - 3, 6 * n)
        added = np.zeros((3, 3))
        moment_tangent(*y, added)
        ours[at, at] += added
    assert abs(ours - numeric).max() < 1e-8 * abs(numeric).max()
    # the geometric part matters at this state: without prestress the matrix is another one
    element_tangent(beam.s, 0, 0, SECTION, 1.0, work)
    whole = work[ELEMENT:ELEMENT + 324].copy()
    beam.rows[:, layout.STRESS:layout.STRESS + 6] = 0.0
    element_tangent(beam.s, 0, 0, SECTION, 1.0, work)
    assert abs(work[ELEMENT:ELEMENT + 324] - whole).max() > 1e-2 * abs(whole).max()


@pytest.mark.parametrize('elements', [1, 3, 4, 6])
def test_chain_solves_what_a_dense_matrix_solves(elements):
    # inertia, alpha_D, centrifugal, Euler and Coriolis forces included. The matrix leaves out what
    # frame forces do to the rotary inertia, so that is small here as it is in a wire.
    ca, cv, alpha = 400.0, 15.0, 3.0
    rng = np.random.default_rng(elements)
    beam = Beam(bent_nodes(elements, elements), SECTION)
    beam.rows[:, layout.MASS] = rng.uniform(0.5, 2.0, beam.rows[:, layout.MASS].shape)
    beam.rows[:, layout.INERTIA:layout.INERTIA + 3] = 1e-9
    beam.rows[:, layout.X0:layout.X0 + 7] = beam.rows[:, layout.X:layout.X + 7]
    frame = np.zeros(FRAME)
    frame[SPIN:SPIN + 3] = 10.0 * rng.normal(size=3)
    frame[SPIN_RATE:SPIN_RATE + 3] = 50.0 * rng.normal(size=3)
    frame[GRAVITY:GRAVITY + 3] = rng.normal(size=3)
    axes = [matrix(q) for _, q in beam.nodes[1:]]

    def out_of_balance():
        residual(beam.s, beam.blocks, ca, cv, alpha, frame)
        rows = []
        for n in range(1, len(beam.nodes)):
            r = beam.at(n, layout.R, 6).copy()
            r[:3] = axes[n - 1].T @ matrix(beam.nodes[n][1]) @ r[:3]
            rows.append(r)
        return np.concatenate(rows)

    dense = -derivative(beam, out_of_balance)
    chain = np.zeros((elements, RECORD))
    right = rng.normal(size=(2 * elements, 6))
    assert factorise(beam.s, elements, SECTION, 1.0, ca + alpha * cv, frame[SPIN:],
                     frame[SPIN_RATE:], cv, chain, chain_work()) == 0
    for n in range(2 * elements):
        beam.at(n + 1, layout.R, 6)[:] = right[n]
    load_residual(beam.s, elements, chain)
    eliminate(chain, elements)
    substitute(chain, elements)
    records = chain
    ours = np.empty((2 * elements, 6))
    ours[::2] = records[:, MID:MID + 6]
    ours[1::2] = records[:, CORNER:CORNER + 6]
    assert abs(dense @ ours.ravel() - right.ravel()).max() < 1e-6 * abs(right).max()


def test_damped_factor_scales_the_material_part_only():
    # Kelvin-Voigt with the stress held: K(factor) - K(1) = (factor - 1) x material part, which at
    # zero stress is the whole of K.
    beam = Beam(bent_nodes(4, 7), SECTION)
    work = tangent_work()
    matrices = []
    for factor in (1.0, 3.0):
        element_tangent(beam.s, 0, 1, SECTION, factor, work)
        matrices.append(work[ELEMENT:ELEMENT + 324].copy())
    beam.rows[:, layout.STRESS:layout.STRESS + 6] = 0.0
    element_tangent(beam.s, 0, 1, SECTION, 1.0, work)
    material = work[ELEMENT:ELEMENT + 324]
    scale = abs(material).max()
    assert abs(matrices[1] - matrices[0] - 2.0 * material).max() < 1e-13 * scale


def test_initial_stress_is_added():
    beam = Beam(bent_nodes(4, 2), SECTION)
    strain = beam.points(layout.STRAIN)
    beam.rows[:, layout.STRESS0:layout.STRESS0 + 6] = 0.25
    internal_forces(beam.s, beam.blocks, np.concatenate(beam.nodes[0]), SECTION, 2.0)
    np.testing.assert_allclose(beam.points(layout.STRESS),
                               2.0 * strain * stiffness(SECTION) + 0.25, rtol=1e-14)
