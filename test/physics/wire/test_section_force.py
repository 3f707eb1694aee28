"""The section force as an unknown of its own: its linearisation, and what it is for."""
from bristle_ros.physics.motion import FRAME
from bristle_ros.physics.wire.increments import move_nodes
from bristle_ros.physics.wire import layout
from bristle_ros.physics.wire.beam import internal_forces, Section
from bristle_ros.physics.wire.chain import (chain_work, eliminate, factorise, MIDS, OK, RECORD,
                                            STRAIN_MATRIX, substitute)
from bristle_ros.physics.wire.coefficients import pseudo_step
from bristle_ros.physics.wire.dynamics import residual
from bristle_ros.physics.wire.section_force import add_excess, update_section_forces
import numpy as np
from physics.beams import Beam, derivative, turn
import pytest

# a steel wire of 2 mm x 0.5 mm: EA l^2 / EI is 43,000 and 2,700
LENGTH = 0.03
SECTION = Section(2e5, 6.4e4, 6.4e4, 0.0055, 0.0042, 0.0667, LENGTH)


def arc(elements, curvature):
    """Return the nodes of a wire bent to an arc."""
    nodes = []
    for n in range(2 * elements + 1):
        s = 0.5 * LENGTH * n
        angle = curvature * s
        x = s * np.sinc(angle / np.pi), 0.0, -s * 0.5 * angle * np.sinc(0.5 * angle / np.pi) ** 2
        nodes.append((np.array(x), turn((0.0, angle, 0.0))))
    return nodes


class Frozen:
    """A beam with the matrix of its present state, and Newton's method with it."""

    def __init__(self, nodes, acceleration=1e6):
        self.acceleration = acceleration        # [1/s^2] ca of the steps
        self.beam = Beam(nodes, SECTION)
        self.beam.rows[:, layout.MASS] = 1e-4
        self.beam.rows[:, layout.INERTIA:layout.INERTIA + 3] = 1e-10
        self.mids = np.zeros((self.beam.blocks, MIDS))
        self.chain = np.zeros((self.beam.elements, RECORD))
        self.frame = np.zeros(FRAME)
        self.freeze()

    def freeze(self):
        beam = self.beam
        assert factorise(beam.s, beam.elements, SECTION, pseudo_step(self.acceleration),
                         self.frame, self.mids, self.chain, chain_work()) == OK

    def corrections(self, count, mixed):
        """Return the sizes of Newton's corrections from here on, X0 and Q0 at rest, no loads."""
        beam = self.beam
        beam.rows[:, layout.SECTION_FORCE:layout.SECTION_FORCE + 3] = 0.0
        clamp, sizes = np.concatenate(beam.nodes[0]), []
        for _ in range(count):
            internal_forces(beam.s, beam.blocks, clamp, SECTION, 1.0, mixed)
            residual(beam.s, beam.blocks, self.acceleration, 0.0, 0.0, self.frame)
            add_excess(beam.s, self.mids)
            eliminate(beam.s, beam.elements, self.mids, self.chain)
            substitute(beam.s, beam.elements, self.mids, self.chain)
            update_section_forces(beam.s, self.mids, SECTION, 1.0)
            sizes.append(move_nodes(beam.s, beam.blocks, LENGTH))
        return sizes


def strain_matrix(frozen):
    """Return B of all Gauss points, (points, 3, nodes without the clamp, 6), dense."""
    beam = frozen.beam
    kept = frozen.mids[:, STRAIN_MATRIX:].reshape(beam.blocks, 3, 2, 3, 3, layout.LANES)
    points = []
    for block in range(beam.blocks):
        for lane in range(layout.LANES):
            element = block * layout.ELEMENTS + lane % layout.ELEMENTS
            if element >= beam.elements:
                continue
            b = np.zeros((3, 2 * beam.elements + 1, 6))
            for node in range(3):
                b[:, 2 * element + node, :3] = kept[block, node, 0, :, :, lane]
                b[:, 2 * element + node, 3:] = kept[block, node, 1, :, :, lane]
            points.append(b[:, 1:])
    return np.array(points)


def test_strain_matrix_is_the_derivative_of_the_force_strains():
    rng = np.random.default_rng(1)
    nodes = [(x + 0.003 * rng.normal(size=3), turn(0.3 * rng.normal(size=3)))
             for x, _ in arc(6, 2.0)]
    frozen = Frozen(nodes)
    wanted = derivative(frozen.beam, lambda: frozen.beam.points(layout.STRAIN, 3).ravel())
    ours = strain_matrix(frozen).reshape(wanted.shape)
    assert abs(ours - wanted).max() < 1e-7 * abs(wanted).max()


@pytest.mark.parametrize('elements', [3, 6])
def test_excess_does_the_work_of_its_force(elements):
    frozen = Frozen(arc(elements, 2.0))
    beam, rng = frozen.beam, np.random.default_rng(2)
    beam.rows[:, layout.R:layout.R + 6] = beam.rows[:, layout.LR:layout.LR + 6] = 0.0
    used = beam.rows[:, layout.WEIGHT] > 0.0
    excess = rng.normal(size=(np.count_nonzero(used), 3))
    np.moveaxis(beam.rows[:, layout.EXCESS:layout.EXCESS + 3], 1, 2)[used] = excess
    add_excess(beam.s, frozen.mids)
    wanted = -0.5 * LENGTH * np.einsum('pi,pink->nk', excess, strain_matrix(frozen))
    for n in range(1, 2 * elements + 1):
        ours = beam.at(n, layout.R, 6).copy()
        if n % 2 == 0 and n < 2 * elements:     # from the element on the right
            block, lane = divmod(n // 2, layout.ELEMENTS)
            ours -= beam.rows[block, layout.LR:layout.LR + 6, layout.ELEMENTS + lane]
        np.testing.assert_allclose(ours, wanted[n - 1], atol=1e-12)


def test_an_old_matrix_still_contracts():
    # The wire turns by 0.02 rad and 0.15 rad from clamp to tip after its matrix was made.
    ratios = {}
    for mixed in (0.0, 1.0):
        frozen = Frozen(arc(8, 2.0))
        frozen.beam.place(arc(8, 2.6))
        for row in range(7):
            frozen.beam.rows[:, layout.X0 + row] = frozen.beam.rows[:, layout.X + row]
        sizes = frozen.corrections(4, mixed)
        ratios[mixed] = sizes[3] / sizes[2]
    assert ratios[1.0] < 0.1
    assert ratios[0.0] > 5.0 * ratios[1.0]


def test_both_forms_have_the_same_solution():
    ends = []
    for mixed in (0.0, 1.0):
        frozen = Frozen(arc(8, 2.0), acceleration=1e8)
        for row in range(7):
            frozen.beam.rows[:, layout.X0 + row] = frozen.beam.rows[:, layout.X + row]
        assert frozen.corrections(60, mixed)[-1] < 1e-13
        ends.append(frozen.beam.rows[:, layout.X:layout.X + 7].copy())
    assert abs(ends[1] - ends[0]).max() < 1e-11
