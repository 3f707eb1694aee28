"""What a jump of the mount's acceleration does to the wires, at the moment of a command."""
from bristle_ros.physics.motion import GRAVITY, SPIN_RATE
from bristle_ros.physics.step import Model, State
from bristle_ros.physics.wire import A0, ACC0, ELEMENTS, LANES, Q0, ROWS, X0
import numpy as np
from numpy.typing import NDArray


def jump_accelerations(models: tuple[Model, ...], states: tuple[State, ...],
                       before: NDArray[np.float64], after: NDArray[np.float64]) -> None:
    """
    Let the nodes' accelerations jump as those of their frame do.

    before, after : (FRAME,) frame records of one moment at azimuth 0, brush axes. Places and
    velocities are the same in both, so in the frame a node's acceleration jumps by that of
    (g - a0) - Omega' x x, and its angular one by that of -Omega'. The integrator remembers
    both; with the old ones it would be of first order at each jump.
    """
    push = after[GRAVITY:GRAVITY + 3] - before[GRAVITY:GRAVITY + 3]
    turn = after[SPIN_RATE:SPIN_RATE + 3] - before[SPIN_RATE:SPIN_RATE + 3]
    for model, state in zip(models, states):
        rows = state.nodes.reshape(model.bristles, model.blocks, ROWS, LANES)
        nodes = rows.transpose(0, 1, 3, 2)
        c, s = (model.azimuth[:, i, None, None] for i in range(2))
        forces, turns = (np.stack((c * vector[0] + s * vector[1], c * vector[1] - s * vector[0],
                                   0.0 * c + vector[2]), axis=-1) for vector in (push, turn))
        linear = forces - np.cross(turns, nodes[..., X0:X0 + 3])
        w, axis = nodes[..., Q0:Q0 + 1], -nodes[..., Q0 + 1:Q0 + 4]
        twice = 2.0 * np.cross(axis, turns)
        angular = -(turns + w * twice + np.cross(axis, twice))
        change = np.concatenate((linear, angular), axis=-1)
        element = np.arange(model.blocks)[:, None] * ELEMENTS + np.arange(LANES) % ELEMENTS
        change[:, element >= model.elements] = 0.0      # fillers never move
        nodes[..., A0:A0 + 6] += change
        nodes[..., ACC0:ACC0 + 6] += change
