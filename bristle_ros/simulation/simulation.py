"""One scene being stepped: model, state and the compiled functions that it needs, no more."""
import math
from operator import index
import time
from typing import Any, SupportsIndex

from bristle_ros.physics.contact import GAP, gap_at, IMPULSE, MOST
from bristle_ros.physics.motion import (CARRY, DRIVE_WORK, HEIGHT, MOVED, renew_rates, ROTATION,
                                        SEGMENT, split_load_step, TORQUE, TURNING)
from bristle_ros.physics.step import (AT_FINEST, CLAMP_INSIDE, FAILURES, initialise, Model, NEWTON,
                                      NO_CONVERGENCE, NOT_FINITE, output, own_frame,
                                      SINGULAR_MATRIX, SPLIT, SUBSTEPS, TOO_MANY_POINTS,
                                      UNFINISHED, WRENCH)
from bristle_ros.physics.wire import ELEMENTS, LANES, ROWS, X
from bristle_ros.scene import brush_rows, Scene, spell, to_parameters
import numpy as np
from numpy.typing import NDArray

from .ahead import compiling_ahead
from .carried import brake, check_way, MountState, target_of, way_to
from .commands import BRAKING, check_command, CommandRefused, Values
from .driven import DrivenStepper, jump_torque, start_hub
from .equilibrium import settle_state
from .model import (build_models, build_state, check_start, contact_law, local_error_of,
                    new_scratch, ready_to_carry, rows_of, states_of, turn_nodes,
                    viscosity_of)
from .jump import jump_accelerations
from .mount import Mount
from .mount_path import Pose
from .observe import observe_rows
from .snapshot import ACCOUNTED, Snapshot
from .stepper import Stepper

_BRISTLE, _BRUSH = output.columns(output.BRISTLE), output.columns(output.BRUSH)
# what failed in the smallest sub-step, and what may do
REASONS = {
    SINGULAR_MATRIX: 'the iteration matrix became singular: a smaller '
                     'solver.integration_time_step may do',
    NO_CONVERGENCE: "Newton's corrections did not shrink: a smaller solver.integration_time_step "
                    'or some damping.stiffness may do',
    NOT_FINITE: 'forces or positions overflowed: look at the sizes of bristle.* and drive.*',
    UNFINISHED: 'the step was not done after as many sub-steps as there may be: a smaller '
                'solver.integration_time_step may do',
    TOO_MANY_POINTS: f'more than {MOST - 1} elements of a wire touch the road at one time: fewer '
                     'solver.elements would do',
    CLAMP_INSIDE: 'a clamp has come to the surface of the road: keep the brush higher, or further '
                  'from the kerb',
}
LOADS = "the brush's motion is not finite there: that is no fault of the scene, please report it"


TORQUE_Z = output.BRUSH_TORQUE + 2
MOST_STEPS = 2**62  # of one call: what a kernel can count


class StepFailure(RuntimeError):
    """The simulation could not go on; the state is the last good one."""

    def __init__(self, at: float, step: int, reason: str) -> None:
        """Keep when [s], in which step and why."""
        super().__init__(f'stopped at t = {at:.9g} s, step {step}: {reason}')
        self.time = at
        self.step = step
        self.reason = reason


class Simulation:
    """
    A scene being stepped.

    scene : Scene
    energies : bool    keep the accounts of work and dissipation, and the extremes of the clamp
                       stress over sub-steps (snapshots have NaN without)
    threads : int      that share out the bristles; None: what the machine has. The bits are the
                       same for any number

    Building compiles what the scene needs (`compile_time` [s]) and puts the brush at its start.
    Raises SceneError where a bristle would start inside the road.
    """

    def __init__(self, scene: Scene, *, energies: bool = False,
                 threads: int | None = None) -> None:
        """Build, compile and go to the start."""
        self.scene = scene
        self.its = scene.solver.integration_time_step
        began = time.perf_counter()
        self._energies = energies
        models = build_models(scene)
        self._law = contact_law(scene)
        self._viscosity = viscosity_of(scene)
        self._scratch = new_scratch(models[0], self._law)
        self.bristles = sum(model.bristles for model in models)
        self._rows = np.zeros((self.bristles, output.BRISTLE_COLUMNS))
        self._totals = np.zeros(output.TOTALS)
        self.state = build_state(scene, *models)
        self._states = states_of(self.state, models)
        self._mount = Mount(scene, models[0].drive, self.state.motion)
        self._lengths = [(part, row.length)
                         for part, row in zip(rows_of(models), brush_rows(scene))]
        stepper = Stepper if models[0].drive.hub is None else DrivenStepper
        self._stepper = stepper(models, self._law, self._viscosity, self.state,
                                accounting=energies, threads=threads)
        self._start: list[NDArray[np.float64] | NDArray[np.int64]] = []
        with compiling_ahead(scene):
            self._to_start()
            self._warm()
        self.compile_time = time.perf_counter() - began

    def __repr__(self) -> str:
        """Say how far it is, how many bristles, and in what the scene is not the default one."""
        usual = to_parameters(Scene())
        keys = [f'{key}: {spell(value)}' for key, value in to_parameters(self.scene).items()
                if value != usual[key]]
        count = self.bristles
        return (f'<Simulation at t = {self.step * self.its:.9g} s, step {self.step}; {count} '
                f'bristle{"s" * (count != 1)}; scene: {", ".join(keys) or "the default"}>')

    @property
    def model(self) -> Model:
        """
        Return the Model being stepped; another of the same sizes may take its place.

        Where the brush has several rows, that of the first one: see `models`.
        """
        return self._stepper.models[0]

    @model.setter
    def model(self, model: Model) -> None:
        self._stepper.models = model, *self._stepper.models[1:]

    @property
    def models(self) -> tuple[Model, ...]:
        """Return the Models of all rows of the brush."""
        return self._stepper.models

    @property
    def step(self) -> int:
        """Integration steps since the start."""
        return int(self.state.step[0])

    @property
    def newton_failures(self) -> int:
        """Return attempts at a step that Newton gave up, all bristles, since the start."""
        return int(self.state.counts[:, FAILURES].sum())

    @property
    def split_steps(self) -> int:
        """Return integration steps taken in sub-steps, all bristles, since the start."""
        return int(self.state.counts[:, SPLIT].sum())

    @property
    def finest_steps(self) -> int:
        """Return those of them in the shortest sub-steps that the local error may ask for."""
        return int(self.state.counts[:, AT_FINEST].sum())

    @property
    def touched(self) -> bool:
        """Whether any tip has touched the road since the start."""
        return bool(self.state.tip[:, IMPULSE + 2].any())

    def _to_start(self) -> None:
        steady = self.scene.solver.start == 'steady'
        if steady:
            settle_state(self.scene, self.models, self.state, self._scratch)
        if self.model.displacement:
            turn_nodes(self.state, self.scene.brush.start_angle)
        if self.model.drive.hub is not None:
            start_hub(self.model.drive.hub, self.models, self._states, self._scratch)
        for model, part in zip(self.models, self._states):
            initialise(model, self._viscosity, part, self._scratch)
        gaps = self._start_gaps()
        if not steady:
            check_start(self.scene, gaps)
        self._start = [array.copy() for array in self.state]

    def _start_gaps(self) -> NDArray[np.float64]:
        """Return the tips' gaps to the road [m] (B,), and keep them in the tip records."""
        frame = self._scratch.frames[0]
        positions = self.centreline_own()[:, -1]
        gaps = np.empty(self.bristles)
        surface = self._law and self._law.surface
        for bristle, azimuth in enumerate(self._azimuths()):
            own_frame(self.model, self.state.motion, azimuth, 0.0, self._scratch, frame)
            gaps[bristle] = frame[ROTATION + 6:ROTATION + 9] @ positions[bristle] + frame[HEIGHT]
            if surface is not None:
                place = frame[ROTATION:ROTATION + 9].reshape(3, 3) @ positions[bristle]
                place[:2] += self.state.motion[MOVED:MOVED + 2]
                gaps[bristle] = gap_at(surface, place[0], place[1], place[2] + frame[HEIGHT],
                                       self._scratch.contact[8])[0]
        self.state.tip[:, GAP] = gaps
        return gaps

    def _azimuths(self) -> NDArray[np.float64]:
        """Return cosine and sine of each bristle's azimuth, and of half of it: (B, 4)."""
        return np.concatenate([model.azimuth for model in self.models])

    def _warm(self) -> None:
        """Compile by taking no step and one look; neither changes the state."""
        self._stepper.warm()
        self._observe()
        drive, motion = self.model.drive, self.state.motion.copy()
        if drive.time_step:
            split_load_step(0.5 * drive.time_step, drive, motion, self._scratch.basics)
            renew_rates(0.5 * drive.time_step, drive, motion, self._scratch.basics)

    def advance(self, steps: SupportsIndex) -> None:
        """
        Advance by `steps` integration steps in compiled calls that let go of the GIL.

        steps : int, 0 or more; anything else is a TypeError or ValueError

        Raises StepFailure where even the smallest sub-step fails; the state is then the one at the
        start of the failed step.
        """
        steps = index(steps)
        if not 0 <= steps <= MOST_STEPS:
            raise ValueError(f'{steps} steps: must be 0 to {MOST_STEPS}')
        status, bristle = self._stepper.advance(steps)
        if status:
            step = self.step
            reason = REASONS[status] if self._loads_finite(step) else LOADS
            if self.bristles > 1:
                reason = f'bristle {bristle}: {reason}'
            raise StepFailure(step * self.its, step, reason)

    def _loads_finite(self, step: int) -> bool:
        """Whether the frame's motion is finite at the ends of a step."""
        frame = self._scratch.frames[0]
        finite = True
        for end in (step, step + 1):
            own_frame(self.model, self.state.motion, self.model.azimuth[0], end * self.its,
                      self._scratch, frame)
            finite = finite and bool(np.isfinite(frame).all())
        return finite

    def reset(self) -> None:
        """Go back to the scene's start, step 0."""
        self._stepper.forget()
        for array, start in zip(self.state, self._start):
            array[:] = start

    def set_error_tolerance(self, tolerance: float) -> None:
        """
        Let adaptive steps have this local error, relative to the length; resets keep it.

        No step may have more than model.WORST_ERROR.
        """
        self._stepper.models = tuple(
            model._replace(local_error=local_error_of(self.scene, tolerance, length))
            for model, (_, length) in zip(self.models, self._lengths))

    def check_command(self, topic: str, values: Values) -> None:
        """Raise CommandRefused where `command` would; change nothing."""
        checked = check_command(self.scene, topic, values)
        if topic in ('cmd_vel', 'cmd_penetration') and self.carried:
            raise CommandRefused(f'{topic}: the mount is carried by cmd_mount, until a reset')
        if topic == 'cmd_mount' and checked != BRAKING[1]:
            target_of(checked)

    def command(self, topic: str, values: Values) -> None:
        """
        Follow a command from now on.

        topic : 'cmd_brush_speed' (rad/s,), 'cmd_vel' (m/s, m/s, rad/s), 'cmd_penetration' (m,) or
        'cmd_drive_torque' (N m,), which acts at once, or 'cmd_mount' (13 values: see
        carried.target_of), reached run.chunk later; the first one compiles what that needs,
        unless it is `ready_to_carry`
        Changes are limited by drive.max_acceleration, sweeper.max_acceleration,
        sweeper.max_yaw_acceleration and road.max_rate. Raises CommandRefused.
        """
        self.check_command(topic, values)
        checked = check_command(self.scene, topic, values)
        drive, now = self.model.drive, self.step * self.its
        if drive.time_step:
            split_load_step(now, drive, self.state.motion, self._scratch.basics)
        self._follow(topic, checked, now)
        if drive.time_step:
            renew_rates(now, drive, self.state.motion, self._scratch.basics)

    def _follow(self, topic: str, values: tuple[float, ...], now: float) -> None:
        if topic == 'cmd_mount':
            self._carry(values, now)
        elif topic == 'cmd_drive_torque':
            if self.model.drive.hub is not None:
                jump_torque(self.model.drive.hub, self.state.motion, values[0])
        else:
            self._mount.follow(topic, values, now)

    def _carry(self, values: tuple[float, ...], now: float) -> None:
        scene, state = self.scene, self.mount_state()
        if values == BRAKING[1]:
            segment = brake(now, state, scene)
        else:
            segment = way_to(now, state, target_of(values), round(
                scene.run.chunk / self.its) * self.its)
            check_way(scene, segment)
        if not self.ready_to_carry:
            self._stepper.models = tuple(map(ready_to_carry, self.models))
            self._warm()
        frames, azimuth = self._scratch.frames[:2], np.array((1.0, 0.0, 1.0, 0.0))
        own_frame(self.model, self.state.motion, azimuth, now, self._scratch, frames[0])
        self.state.motion[CARRY:CARRY + SEGMENT] = segment
        own_frame(self.model, self.state.motion, azimuth, now, self._scratch, frames[1])
        jump_accelerations(self.models, self._states, *frames)

    @property
    def ready_to_carry(self) -> bool:
        """Whether a cmd_mount needs nothing compiled any more."""
        return self.model.drive.carrier is not None

    @property
    def carried(self) -> bool:
        """Whether the mount is carried: since the first cmd_mount."""
        return self._mount.carried

    def mount_state(self) -> MountState:
        """Return where the mount is and how it moves, road axes."""
        return self._mount.state(self.step * self.its)

    def mount_pose(self) -> Pose:
        """Return where a mount that is carried is."""
        return self._mount.pose(self.step * self.its)

    def sweeper_motion(self) -> tuple[float, float, float, float]:
        """Return (height of the mount [m], heading [rad], forward, left [m/s] of the base)."""
        return self._mount.sweeper(self.step * self.its)

    def kerb_offset(self) -> float:
        """Return how much further away than `gutter.kerb_distance` the gutter still is [m]."""
        return self._mount.kerb_offset(self.step * self.its)

    def base_pose(self) -> tuple[float, float, float]:
        """Return x, y [m], heading [rad] of the sweeper's base; of a mount that is carried."""
        return self._mount.base_pose(self.step * self.its)

    def _observe(self) -> None:
        observe_rows(self.models, self._states, self._law, self._viscosity, self._scratch,
                     self._rows, self._totals)

    def snapshot(self) -> Snapshot:
        """Return the outputs of the present state as a Snapshot of its own arrays."""
        self._observe()
        rows, totals = self._rows.copy(), self._totals.copy()
        if not self._energies:
            for name in ACCOUNTED:
                numbers, columns = (rows, _BRISTLE) if name in _BRISTLE else (totals, _BRUSH)
                numbers[..., columns[name]] = math.nan
        found: dict[str, Any] = {name: rows[:, place] for name, place in _BRISTLE.items()}
        found |= {name: totals[place] for name, place in _BRUSH.items()}
        found['error_estimate'] = max(float(found['error_estimate'][part].max()) / length
                                      for part, length in self._lengths)
        driven, hub = self.model.drive.hub is not None, self.state.motion[TURNING:]
        counts = self.state.counts.sum(axis=0)
        return Snapshot(step=self.step, t=self.step * self.its,
                        newton_iterations=int(counts[NEWTON]), substeps=int(counts[SUBSTEPS]),
                        base_pose=np.array(self.base_pose()),
                        drive_torque=float(hub[TORQUE] if driven else -totals[TORQUE_Z]),
                        drive_work=float(hub[DRIVE_WORK]) if driven else math.nan, **found)

    def wrench_impulse(self) -> NDArray[np.float64]:
        """
        Return force and torque of the brush on the sweeper, summed over all steps since the start.

        (6,) [N s, N m s] about the mount centre, mount axes of each step. Kept where the mount may
        be carried.
        """
        impulse: NDArray[np.float64] = self.state.audit[:, WRENCH:WRENCH + 6].sum(axis=0)
        return impulse

    def begin_sample(self) -> None:
        """Let clamp_stress_min and _max of the samples to come be those from here on."""
        self._stepper.begin_sample()

    def centreline_own(self) -> NDArray[np.float64]:
        """Return the nodes from clamp to tip in each bristle's own axes [m]: (B, nodes, 3)."""
        nodes = self.state.nodes.reshape(self.bristles, self.model.blocks, ROWS, LANES)
        positions = nodes[:, :, X:X + 3, :]
        mids = positions[..., :ELEMENTS].transpose(0, 1, 3, 2).reshape(self.bristles, -1, 3)
        ends = positions[..., ELEMENTS:].transpose(0, 1, 3, 2).reshape(self.bristles, -1, 3)
        line = np.empty((self.bristles, 2 * self.model.elements + 1, 3))
        for part, model in zip(rows_of(self.models), self.models):
            line[part, 0] = model.clamp[:3]
        line[:, 1::2] = mids[:, :self.model.elements]
        line[:, 2::2] = ends[:, :self.model.elements]
        return line

    def centreline(self) -> NDArray[np.float64]:
        """Return the nodes from clamp to tip in mount axes [m]: (B, nodes, 3)."""
        self._observe()
        theta = self._totals[output.ANGLE]
        c, s = math.cos(theta), math.sin(theta)
        azimuth = self._azimuths()
        cosine = (c * azimuth[:, 0] - s * azimuth[:, 1])[:, None]
        sine = (s * azimuth[:, 0] + c * azimuth[:, 1])[:, None]
        own = self.centreline_own()
        turned = own.copy()
        turned[..., 0] = cosine * own[..., 0] - sine * own[..., 1]
        turned[..., 1] = sine * own[..., 0] + cosine * own[..., 1]
        if self.model.displacement:     # all but the clamp have turned with the brush already
            cosine, sine = azimuth[:, :1], azimuth[:, 1:2]
            x, y = own[:, 1:, 0], own[:, 1:, 1]
            turned[:, 1:, 0] = cosine * x - sine * y
            turned[:, 1:, 1] = sine * x + cosine * y
        return turned
