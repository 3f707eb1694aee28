"""Static equilibrium of a scene's bristles in the turning brush frame."""
from typing import NamedTuple

from bristle_ros.physics.contact import ContactLaw, FORCE, SLIP, STATE
from bristle_ros.physics.motion import APPROACHING, PENETRATION, SPIN_RATE
from bristle_ros.physics.step import (lowest_node, Model, output, own_frame, Scratch, settle,
                                      State)
from bristle_ros.physics.wire import LANES, OK, ROWS, X, X0
from bristle_ros.scene import Scene, SceneError
import numpy as np
from numpy.typing import NDArray

from .model import build_models, build_state, contact_law, new_scratch, rows_of, states_of
from .observe import observe_rows
from .run_warnings import BESIDE


class Equilibrium(NamedTuple):
    """Static equilibrium; B bristles, per wire."""

    tip_position: NDArray[np.float64]   # [m] (B, 3), brush axes, from the mount centre
    normal_force: NDArray[np.float64]   # [N] (B,) of the road on the tip
    root_moment: NDArray[np.float64]   # [N m] (B, 3) of the wire on the board, about its clamp


def settle_state(scene: Scene, models: tuple[Model, ...], state: State, scratch: Scratch) -> None:
    """
    Move all bristles of `state` to equilibrium at time 0 of its motion; friction off.

    The brush turns steadily at the drive's speed at t = 0. Raises SceneError where none is found.
    Leaves the tips' normal forces in the state.
    """
    law = contact_law(scene)
    if law and law.surface:
        raise SceneError(
            'the static equilibrium is sought on the level plane alone: take straight, and leave '
            'gutter and profile out of what is to be static', key='solver.start',
            value=scene.solver.start)
    for row, model, part in zip(rows_of(models), models, states_of(state, models)):
        failed = _settle_row(scene, model._replace(displacement=False), law, part, scratch)
        if failed is not None:
            raise SceneError(
                f'bristle {row.start + failed} has no static equilibrium that could be found: try '
                'a smaller road.penetration or drive.mean_speed', key='drive.mean_speed',
                value=scene.drive.mean_speed)
    nodes = state.nodes.reshape(len(state.nodes), -1, ROWS, LANES)
    nodes[:, :, X0:X0 + 7] = nodes[:, :, X:X + 7]


def _settle_row(scene: Scene, model: Model, law: ContactLaw | None, state: State,
                scratch: Scratch) -> int | None:
    """Settle the bristles of a row; return the number of one that has no equilibrium, or None."""
    frame = scratch.frames[0]
    for bristle, azimuth in enumerate(model.azimuth):
        own_frame(model, state.motion, azimuth, 0.0, scratch, frame)
        frame[SPIN_RATE:SPIN_RATE + 3] = 0.0
        if settle(model, law, state, bristle, frame, np.zeros(6), scratch) != OK:
            return bristle
        _check_wire(scene, law, state, bristle, frame, scratch)
        if state.tip[bristle, FORCE + 2] > 0.0:
            state.tip[bristle, STATE] = SLIP
    return None


def _check_wire(scene: Scene, law: ContactLaw | None, state: State, bristle: int,
                frame: NDArray[np.float64], scratch: Scratch) -> None:
    """Raise SceneError where the road would hold more of the wire than its tip, and may."""
    if law is None or law.wire is None:
        return
    depth = -lowest_node(state.nodes[bristle], scene.solver.elements, None, frame,
                         scratch.contact[8])
    if depth > BESIDE:
        raise SceneError(
            f'bristle {bristle} would be {depth * 1e3:.3g} mm below the road beside its tip, and '
            'the static equilibrium holds the tip alone: take a smaller penetration, a run from '
            'straight, or contact.points: tip', key='road.penetration',
            value=scene.road.penetration)


def static_equilibrium(scene: Scene) -> Equilibrium:
    """
    Return the Equilibrium at theta = brush.start_angle: spin, gravity and road on, friction off.

    The road stands at its final height, whatever the approach. Raises SceneError.
    """
    models = tuple(model._replace(displacement=False) for model in build_models(scene))
    state = build_state(scene, *models)
    scratch = new_scratch(models[0], contact_law(scene))
    state.motion[APPROACHING] = 0.0
    state.motion[PENETRATION + 1:PENETRATION + 3] = scene.road.penetration
    settle_state(scene, models, state, scratch)
    rows = np.zeros((len(state.nodes), output.BRISTLE_COLUMNS))
    observe_rows(models, states_of(state, models), contact_law(scene), None, scratch, rows,
                 np.zeros(output.TOTALS))
    return Equilibrium(rows[:, :3].copy(), state.tip[:, FORCE + 2].copy(),
                       rows[:, output.MOUNT_MOMENT:output.MOUNT_MOMENT + 3].copy())
