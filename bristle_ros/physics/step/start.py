"""Consistent accelerations at the start: without them every second-order scheme is first order."""
from bristle_ros.physics.motion import CLAMP, DRAG_RATE, DRAG_SPIN
from bristle_ros.physics.wire import (A0, ACC0, add_air, ELEMENTS, HA, HV, INERTIA,
                                      internal_forces, LANES, MASS, Q, R, RATEACC0, residual, ROWS,
                                      SECTION_FORCE0, STRAIN, STRAIN0, STRAIN_BEFORE, STRESS, V0,
                                      X, X0)
import numpy as np

from .records import Model, Scratch, State
from .stepping import own_frame

PROBE = 1e-7    # relative size of the displacement that shows the strains' acceleration


def initialise(model: Model, viscosity: float | None, state: State, scratch: Scratch) -> None:
    """
    Fill the accelerations that the equation of motion gives for the present positions, velocities.

    X, Q, X0, Q0 are given; V0, W0 become those of a rigid turn with the brush. ACC0 and A0 follow,
    and with damping the strains and their second derivative. Once in a run: not compiled itself.
    """
    frame = scratch.frames[0]
    for s, azimuth in zip(state.nodes, model.azimuth):
        own_frame(model, state.motion, azimuth, state.step[0] * model.its, scratch, frame)
        nodes = s.reshape(model.blocks, ROWS, LANES).swapaxes(1, 2)
        internal_forces(s, model.blocks, frame[CLAMP:], model.section, 1.0, 0.0)
        nodes[..., SECTION_FORCE0:SECTION_FORCE0 + 3] = nodes[..., STRESS:STRESS + 3]
        _accelerate(model, s, nodes, frame)
        if viscosity is not None:
            _start_strain_rates(model, s, nodes, frame)


def _accelerate(model, s, nodes, frame):
    """Fill V0, W0, ACC0 and A0; nodes: a view (blocks, LANES, ROWS) of s."""
    x, q = nodes[..., X:X + 3], nodes[..., Q:Q + 4]
    spin = np.array([0.0, 0.0, frame[DRAG_SPIN]])
    if spin[2] != 0.0:
        nodes[..., V0:V0 + 3] = np.cross(spin, x)
        nodes[..., V0 + 3:V0 + 6] = _turned(_conjugate(q), spin)
    nodes[..., HA:HA + 6] = 0.0
    nodes[..., HV:HV + 6] = nodes[..., V0:V0 + 6]
    residual(s, model.blocks, 0.0, 0.0, model.mass_damping, frame)
    add_air(s, model.blocks, 0.0, model.air, frame)
    force, moment = nodes[..., R:R + 3], nodes[..., R + 3:R + 6]
    nodes[..., ACC0:ACC0 + 3] = _turned(q, force) / nodes[..., MASS:MASS + 1]
    nodes[..., ACC0 + 3:ACC0 + 6] = moment / nodes[..., INERTIA:INERTIA + 3]
    element = np.arange(model.blocks)[:, None] * ELEMENTS + np.arange(LANES) % ELEMENTS
    nodes[element >= model.elements, ACC0:ACC0 + 6] = 0.0   # fillers never move
    nodes[..., A0:A0 + 6] = nodes[..., ACC0:ACC0 + 6]


def _start_strain_rates(model, s, nodes, frame):
    """Fill STRAIN0 and RATEACC0: how a nudge along the accelerations changes the strains."""
    x, q = nodes[..., X:X + 3], nodes[..., Q:Q + 4]
    strain = nodes[..., STRAIN:STRAIN + 6]
    linear, angular = nodes[..., ACC0:ACC0 + 3], nodes[..., ACC0 + 3:ACC0 + 6]
    half = PROBE / (max(np.abs(linear).max() / model.section.element_length,
                        np.abs(angular).max()) + 1e-300)
    spin, rate = np.array([0.0, 0.0, frame[DRAG_SPIN]]), np.array([0.0, 0.0, frame[DRAG_RATE]])
    nodes[..., STRAIN0:STRAIN0 + 6] = nodes[..., STRAIN_BEFORE:STRAIN_BEFORE + 6] = strain
    # relative to the turning brush: a rigid turn strains nothing
    turn = 0.5 * half * (angular - _turned(_conjugate(q), rate))
    x += half * (linear - np.cross(spin, np.cross(spin, x)) - np.cross(rate, x))
    q += np.concatenate((-(q[..., 1:] * turn).sum(axis=-1, keepdims=True),
                         q[..., :1] * turn + np.cross(q[..., 1:], turn)), axis=-1)
    internal_forces(s, model.blocks, frame[CLAMP:], model.section, 1.0, 0.0)
    nodes[..., RATEACC0:RATEACC0 + 6] = (strain - nodes[..., STRAIN0:STRAIN0 + 6]) / half
    nodes[..., X:X + 7] = nodes[..., X0:X0 + 7]


def _conjugate(q):
    return q * [1.0, -1.0, -1.0, -1.0]


def _turned(q, vector):
    """Return vectors (..., 3) turned by the unit quaternions (..., 4) w, x, y, z."""
    twice = 2.0 * np.cross(q[..., 1:], vector)
    return vector + q[..., :1] * twice + np.cross(q[..., 1:], twice)
