"""Static equilibrium of a scene's bristles in the turning brush frame."""
from typing import NamedTuple

from bristle_ros.physics.contact import FORCE, SLIP, STATE
from bristle_ros.physics.motion import APPROACHING, PENETRATION, SPIN_RATE
from bristle_ros.physics.step import Model, output, own_frame, Scratch, settle, State
from bristle_ros.physics.wire import LANES, OK, ROWS, X, X0
from bristle_ros.scene import Scene, SceneError
import numpy as np
from numpy.typing import NDArray

from .model import build_model, build_state, contact_law, new_scratch


class Equilibrium(NamedTuple):
    """Static equilibrium; B bristles, per wire."""

    tip_position: NDArray[np.float64]# [m] (B, 3), brush axes, from the mount centre
    normal_force: NDArray[np.float64]# [N] (B,) of the road on the tip
    root_moment: NDArray[np.float64]# [N m] (B, 3) of the wire on the board, about its clamp


def settle_state(scene: Scene, model: Model, state: State, scratch: Scratch) -> None:
    """
    Move all bristles of `state` to equilibrium at time 0 of its motion; friction off.

    The brush turns steadily at the drive's speed at t = 0. Raises SceneError where none is found.
    Leaves the tips' normal forces in the state.
    """
    law = contact_law(scene)
    model = model._replace(displacement=False)
    frame = scratch.frames[0]
    for bristle, azimuth in enumerate(model.azimuth):
        own_frame(model, state.motion, azimuth, 0.0, scratch, frame)
        frame[SPIN_RATE:SPIN_RATE + 3] = 0.0
        status = settle(model, law, state.nodes[bristle], state.mids[bristle],
                        state.chain[bristle], state.tip[bristle], frame, np.zeros(6), scratch)
        if status != OK:
            raise SceneError(
                f'bristle {bristle} has no static equilibrium that could be found: try a smaller '
                'road.penetration or drive.mean_speed', key='drive.mean_speed',
                value=scene.drive.mean_speed)
        if state.tip[bristle, FORCE + 2] > 0.0:
            state.tip[bristle, STATE] = SLIP
    nodes = state.nodes.reshape(model.bristles, model.blocks, ROWS, LANES)
    nodes[:, :, X0:X0 + 7] = nodes[:, :, X:X + 7]


def static_equilibrium(scene: Scene) -> Equilibrium:
    """
    Return the Equilibrium at theta = brush.start_angle: spin, gravity and road on, friction off.

    The road stands at its final height, whatever the approach. Raises SceneError.
    """
    model = build_model(scene)._replace(displacement=False)
    state = build_state(scene, model)
    scratch = new_scratch(model)
    state.motion[APPROACHING] = 0.0
    state.motion[PENETRATION + 1:PENETRATION + 3] = scene.road.penetration
    settle_state(scene, model, state, scratch)
    rows = np.zeros((model.bristles, output.BRISTLE_COLUMNS))
    output.observe(model, contact_law(scene), None, state, scratch, rows, np.zeros(output.TOTALS))
    return Equilibrium(rows[:, :3].copy(), state.tip[:, FORCE + 2].copy(),
                       rows[:, output.MOUNT_MOMENT:output.MOUNT_MOMENT + 3].copy())
