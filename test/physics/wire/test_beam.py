"""Strains, internal forces and tangents of the beam: objectivity, and finite differences."""
from bristle_ros.physics.compiler.lanes import load4
from bristle_ros.physics.motion import FRAME, GRAVITY, SPIN, SPIN_RATE
from bristle_ros.physics.wire import layout
from bristle_ros.physics.wire.beam import internal_forces, Section, stiffness
from bristle_ros.physics.wire.chain import (chain_work, eliminate, factorise, MIDS, RECORD,
                                            substitute)
from bristle_ros.physics.wire.coefficients import pseudo_step
from bristle_ros.physics.wire.dynamics import residual
from bristle_ros.physics.wire.tangent import (block_tangent, LEFT_LEFT, moment_tangent, SIX_BY_SIX,
                                              TANGENT_WORK)
from numba import njit
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
        f = beam.at(n, layout.NODE_FORCE, 3)
        force += f
        moment += np.cross(x, f) + product(beam.at(n, layout.TORQUE, 4), p * [1, -1, -1, -1])[1:]
    assert abs(force).max() < 1e-13
    assert abs(moment).max() < 1e-13


@njit
def _moment_tangents(rows, a):
    """Fill a : (2, 144) with the moment tangents of the mid and right nodes, four lanes each."""
    for half in (0, 4):
        at = layout.Q * 8 + half
        q0, q1 = load4(rows, at), load4(rows, at + 8)
        q2, q3 = load4(rows, at + 16), load4(rows, at + 24)
        at = layout.TORQUE * 8 + half
        y0, y1 = load4(rows, at), load4(rows, at + 8)
        y2, y3 = load4(rows, at + 16), load4(rows, at + 24)
        moment_tangent(a[half // 4], 3 * 28, q0 * y0 + q1 * y1 + q2 * y2 + q3 * y3,
                       q0 * y1 - q1 * y0 - q2 * y3 + q3 * y2,
                       q0 * y2 - q2 * y0 - q3 * y1 + q1 * y3,
                       q0 * y3 - q3 * y0 - q1 * y2 + q2 * y1)


def tangents(beam, factor=1.0):
    """Return the matrices of the four elements of the beam's first block: (4, 18, 18)."""
    work = np.zeros(TANGENT_WORK)
    block_tangent(beam.s[0], SECTION, factor, work)
    matrices = np.empty((4, 18, 18))
    at = LEFT_LEFT
    for one in range(3):
        for two in range(one, 3):
            block = work[at:at + SIX_BY_SIX].reshape(6, 6, 4).transpose(2, 0, 1)
            matrices[:, 6 * one:6 * one + 6, 6 * two:6 * two + 6] = block
            matrices[:, 6 * two:6 * two + 6, 6 * one:6 * one + 6] = block.transpose(0, 2, 1)
            at += SIX_BY_SIX
    return matrices


@pytest.mark.parametrize('seed', range(3))
def test_tangent_is_the_derivative_of_the_forces(seed):
    beam = Beam(bent_nodes(4, seed), SECTION)
    axes = [matrix(q) for _, q in beam.nodes[1:]]
    numeric = derivative(beam, lambda: beam.forces(axes).ravel())
    ours = np.zeros((54, 54))
    whole = tangents(beam)
    added = np.zeros((2, 144))
    _moment_tangents(beam.s[0], added)
    for element in range(4):
        at = slice(12 * element, 12 * element + 18)
        ours[at, at] += whole[element]
        for node in range(2):
            at = slice(12 * element + 6 + 6 * node, 12 * element + 12 + 6 * node)
            ours[at, at] += added[node].reshape(6, 6, 4)[..., element]
    ours = ours[6:, 6:]
    assert abs(ours - numeric).max() < 1e-8 * abs(numeric).max()
    # the geometric part matters at this state: without prestress the matrix is another one
    beam.rows[:, layout.STRESS:layout.STRESS + 6] = 0.0
    assert abs(tangents(beam) - whole).max() > 1e-2 * abs(whole).max()


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
    mids = np.zeros((beam.blocks, MIDS))
    right = rng.normal(size=(2 * elements, 6))
    step = pseudo_step(ca)._replace(cv=cv, mass_factor=ca + alpha * cv)
    assert factorise(beam.s, elements, SECTION, step, frame, mids, chain, chain_work()) == 0
    for n in range(2 * elements):
        beam.at(n + 1, layout.R, 6)[:] = right[n]
    eliminate(beam.s, elements, mids, chain)
    substitute(beam.s, elements, mids, chain)
    ours = np.array([beam.at(n + 1, layout.R, 6) for n in range(2 * elements)])
    assert abs(dense @ ours.ravel() - right.ravel()).max() < 1e-6 * abs(right).max()


def test_damped_factor_scales_the_material_part_only():
    # Kelvin-Voigt with the stress held: K(factor) - K(1) = (factor - 1) x material part, which at
    # zero stress is the whole of K.
    beam = Beam(bent_nodes(4, 7), SECTION)
    matrices = [tangents(beam, factor) for factor in (1.0, 3.0)]
    beam.rows[:, layout.STRESS:layout.STRESS + 6] = 0.0
    material = tangents(beam)
    scale = abs(material).max()
    assert abs(matrices[1] - matrices[0] - 2.0 * material).max() < 1e-13 * scale


def test_initial_stress_is_added():
    beam = Beam(bent_nodes(4, 2), SECTION)
    strain = beam.points(layout.STRAIN)
    beam.rows[:, layout.STRESS0:layout.STRESS0 + 6] = 0.25
    internal_forces(beam.s, beam.blocks, np.concatenate(beam.nodes[0]), SECTION, 2.0, 0.0)
    np.testing.assert_allclose(beam.points(layout.STRESS),
                               2.0 * strain * stiffness(SECTION) + 0.25, rtol=1e-14)
