"""Steps a brush whose drive feels its load: hub and wires together, one step at a time."""
from typing import Any

from bristle_ros.physics.contact import MATRIX_STEP
from bristle_ros.physics.motion import (ACCELERATION, ADDED, COMMAND, drive_torque, END, HUB, Hub,
                                        keep_place, PSEUDO, REACTION, SPIN_RATE, START, TORQUE,
                                        TURNING)
from bristle_ros.physics.step import (advance_driven, attempt_share, begin_turn, board_wrench,
                                      end_turn, Model, own_frame, Scratch, State)
from bristle_ros.physics.wire import HA, JUMP, LANES, LR, ROWS, SECTION_FORCE, STRAIN0, X, X0
import numpy as np
from numpy.typing import NDArray

from .model import new_turn, rows_of, states_of
from .stepper import Failure, Stepper


class DrivenStepper(Stepper):
    """
    Advances bristles and hub of a state; what they give depends on no number of threads.

    All bristles feel what each does to the hub within a step, so they meet at each step's end. A
    lone one is stepped with its hub in one call.
    """

    def __init__(self, *args: Any, **options: Any) -> None:
        """Take what a Stepper takes; the models' drives have a hub."""
        super().__init__(*args, **options)
        self._turn = new_turn(self._state)
        self._turns = [
            self._turn._replace(torques=self._turn.torques[part], kept=kept)
            for part, kept in zip(rows_of(self.models), states_of(self._turn.kept, self.models))]

    def warm(self) -> None:
        """Compile what stepping needs; the state stays as it is."""
        if self._bristles == 1:
            self._alone(0)
            return
        motion = self._state.motion.copy()
        self._begin()
        self._queues[:] = self._bristles    # none is left to be stepped
        for scratch in self._scratch[:1]:
            self._take(scratch)
        end_turn(self.models[0], self.models[0].drive.hub, self._state.motion, self._turn.torques)
        self._state.motion[:] = motion

    def _alone(self, steps: int) -> int:
        status: int = advance_driven(self.models[0], *self._features, self._state,
                                     self._scratch[0][0], self._turn, steps)
        return status

    def _batch(self, steps: int) -> tuple[int, int] | None:
        for _ in range(steps):
            failure = self._step()
            if failure:
                return failure
        return None

    def _begin(self) -> None:
        model = self.models[0]
        begin_turn(model, model.drive.hub, self._state.motion, self._turn.hub,
                   int(self._state.step[0]), self._scratch[0][0])

    def _step(self) -> tuple[int, int] | None:
        """Make one step; None, or status and bristle of a failure."""
        self._begin_extremes(self._fresh)
        self._fresh = False
        self._begin()
        model, motion, stands = self.models[0], self._state.motion, False
        while not stands:
            failed = self._share(1)
            if failed is not None:
                self._put_back()
                return failed[1:]
            stands = end_turn(model, model.drive.hub, motion, self._turn.torques)
        keep_place(self._scratch[0][0].table, motion, 1)
        self._state.step[0] += 1
        return None

    def _put_back(self) -> None:
        """Let all be as it was before the step."""
        kept, state = self._turn.kept, self._state
        state.motion[TURNING:TURNING + HUB] = self._turn.hub
        nodes = state.nodes.reshape(-1, ROWS, LANES)
        for first, end in ((X0, HA), (STRAIN0, LR), (JUMP, SECTION_FORCE)):
            nodes[:, first:end] = kept.nodes.reshape(nodes.shape)[:, first:end]
        nodes[:, X:X + 7] = nodes[:, X0:X0 + 7]
        for name in ('tip', 'points', 'audit'):
            getattr(state, name)[...] = getattr(kept, name)
        state.tip[:, MATRIX_STEP] = 0.0

    def _take(self, scratches: list[Scratch]) -> list[Failure]:
        law, viscosity, audit = self._features
        found: list[Failure] = []
        for model, state, scratch, turn, queue, first in zip(
                self.models, self._states, scratches, self._turns, self._queues, self._firsts):
            status = attempt_share(model, law, viscosity, None if audit is None else state.audit,
                                   state, scratch, turn, queue)
            if status:
                found.append((0, status, first + int(scratch.failed[2])))
        return found

    def _work(self, scratch: list[Scratch], steps: int) -> Failure | None:
        return min(self._take(scratch), default=None)


def start_hub(hub: Hub, models: tuple[Model, ...], states: tuple[State, ...],
              scratch: Scratch) -> None:
    """
    Fill the hub's acceleration at the start: drive, wires at rest, clamps' mass in balance.

    states : of each model; their hub record has angle and speed
    """
    motion, frame = states[0].motion, scratch.frames[0]
    record = motion[TURNING:]
    reaction = clamps = mount = 0.0
    for model, state in zip(models, states):
        clamps += model.bristles * model.wires * model.clamp_mass * model.clamp[0] ** 2
        for nodes, azimuth in zip(state.nodes, model.azimuth):
            own_frame(model, motion, azimuth, 0.0, scratch, frame)
            mount = frame[SPIN_RATE + 2]
            reaction += board_wrench(model, None, nodes, frame)[5]
    torque = drive_torque(hub, record[END + 1], record[COMMAND], record[END + 1])[0]
    acceleration = (torque + reaction - hub.inertia * mount) / (hub.inertia + clamps)
    for end in (START, END):
        record[end + ACCELERATION] = record[end + PSEUDO] = acceleration
    record[TORQUE] = torque
    record[REACTION:REACTION + 4] = (reaction - clamps * acceleration, acceleration) * 2


def jump_torque(hub: Hub, motion: NDArray[np.float64], torque: float) -> None:
    """Let the hub's acceleration jump with a commanded torque [N m]."""
    record = motion[TURNING:]
    change = (torque - record[COMMAND]) / (hub.inertia + record[ADDED])
    record[COMMAND] = torque
    record[END + ACCELERATION] += change
    record[END + PSEUDO] += change
