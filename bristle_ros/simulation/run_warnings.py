"""
What makes a run's results doubtful, decided here alone from what the run measured.

Means and worst values come from its samples (without samples, from the ends of its chunks), shares
of steps from counts that the kernels keep: watching costs a few microseconds a sample.
"""
from math import inf, isnan, pi
from typing import TYPE_CHECKING, NamedTuple

from bristle_ros.scene import Scene, widest
import numpy as np

from .batch_means import BatchMean
from .energy_balance import EnergyBalance, GAIN
from .polygon import load_steps, ring_of
from .snapshot import Snapshot

if TYPE_CHECKING:
    from .simulation import Simulation

DEEP = 1e-3             # [m] in the road: a tip that is deeper meets no road any more
BESIDE = 1e-6           # [m] that a wire may be below road and tip where that alone touches
FEW_ELEMENTS = 6
SPLIT_SHARE = 0.05      # of fixed steps, in sub-steps
FINEST_SHARE = 0.01     # of all steps, down to the finest sub-steps
STILL_RINGING = 0.1     # of a jump at a polygon's corner, when the next corner comes
QUANTITIES = (('normal force', 'N'), ('drive torque', 'N m'), ('drive power', 'W'))


class RunWarning(UserWarning):
    """
    One doubt about a run: `str()` is one line with numbers and what would do.

    kind : str      few words that name it, the same in each run
    acts : bool     whether results are senseless until somebody acts; else it is good to know
    """

    def __init__(self, kind: str, text: str, acts: bool) -> None:
        """Keep what it is about."""
        super().__init__(text)
        self.kind = kind
        self.acts = acts


class _Worst(NamedTuple):
    """The largest value that was seen, and where."""

    value: float = -inf
    t: float = 0.0          # [s]
    bristle: int = 0


class RunWatch:
    """
    Watches one simulation: who steps it calls `take` with each sample, and `restart` at a reset.

    simulation : Simulation    asked for its counts only
    """

    def __init__(self, simulation: 'Simulation') -> None:
        """Begin at the simulation's present step, taken for the run's start."""
        self._simulation = simulation
        self._scene: Scene = simulation.scene
        self._touches = self._scene.contact.enabled
        self.largest_normal = 0.0       # [N] of the samples, all wires
        self.restart(0.0)

    def restart(self, t: float) -> None:
        """Forget what was; the scene starts again at t [s]."""
        self._start = self._before = t
        self._impulse = self._speed = 0.0       # [N s], the largest brush speed [rad/s]
        # while the road comes up nothing can have settled
        self._begin = t + (self._scene.road.approach_time if self._touches else 0.0)
        self.window = (self._begin, self._begin)    # [s] over which means are taken
        self.means = tuple(BatchMean() for _ in QUANTITIES)
        self._balance, self._gained_most = EnergyBalance(), _Worst()
        self._worst = [_Worst(), _Worst(), _Worst()]    # stress, wire below the road, tip in it

    def take(self, snapshot: Snapshot) -> None:
        """Take a sample, its t counted from the run's start through resets."""
        t, wires = snapshot.t, self._scene.brush.wires_per_bristle
        impulse = wires * float(np.add.reduce(snapshot.contact_impulse[:, 2]))
        if t > self._before >= self._begin - 1e-9:
            torque = -float(snapshot.brush_torque[2])
            self.means[0].add((impulse - self._impulse) / (t - self._before))
            self.means[1].add(torque)
            self.means[2].add(torque * snapshot.omega)
            if self.means[0].count == 1:
                self.window = (self._before, t)
            self.window = (self.window[0], t)
        self._before, self._impulse = t, impulse
        self._speed = max(self._speed, abs(snapshot.omega))
        if not isnan(snapshot.energy_kinetic):      # the accounts are kept
            gain = self._balance.take(snapshot)
            if gain > self._gained_most.value:
                self._gained_most = _Worst(gain, t)
        for i, value in enumerate(np.maximum.reduce(snapshot.worst).tolist()):
            if value > self._worst[i].value:
                self._worst[i] = _Worst(value, t, int(snapshot.worst[:, i].argmax()))
        if self._touches:
            force = float(np.add.reduce(snapshot.contact_force[:, 2]))
            self.largest_normal = max(self.largest_normal, wires * force)

    def warnings(self, *, ended: bool = True) -> list[RunWarning]:
        """
        Return what is doubtful so far; a run that deserves no warning gives none.

        ended : bool    False while the run goes on: that nothing touched is said only after the
                        approach and a turn of the brush
        """
        found = (self._wire_in_road(), self._tip_in_road(), self._yield(), self._gained(),
                 self._polygon(),
                 self._never(ended), self._not_settled(), self._split(), self._finest(),
                 self._coarse())
        return [warning for warning in found if warning is not None]

    def _wire_in_road(self) -> RunWarning | None:
        worst, contact = self._worst[1], self._scene.contact
        alone = contact.points == 'tip'
        if not self._touches or worst.value <= (BESIDE if alone else DEEP):
            return None
        why = ('the road holds the tip alone, so forces are wrong: contact.points: wire would do'
               if alone else f'above {_mm(DEEP)}: a contact.normal_stiffness above '
               f'{contact.normal_stiffness:.3g} N/m or more solver.elements would do')
        return RunWarning(
            'wire below the road', f'the wire of bristle {worst.bristle} was {_mm(worst.value)} '
            f'below the road beside its tip, most at t = {worst.t:.6g} s; {why}', True)

    def _tip_in_road(self) -> RunWarning | None:
        worst = self._worst[2]
        if not self._touches or worst.value <= DEEP:
            return None
        return RunWarning(
            'tip deep in the road', f'the tip of bristle {worst.bristle} was {_mm(worst.value)} '
            f'deep in the road, most at t = {worst.t:.6g} s, above {_mm(DEEP)}: a '
            'contact.normal_stiffness above '
            f'{self._scene.contact.normal_stiffness:.3g} N/m would do', True)

    def _yield(self) -> RunWarning | None:
        worst, limit = self._worst[0], self._scene.bristle.yield_stress
        if limit == 0.0 or worst.value <= limit:
            return None
        return RunWarning(
            'clamp stress', f'the stress at the clamp of bristle {worst.bristle} reached '
            f'{worst.value * 1e-6:.4g} MPa, at t = {worst.t:.6g} s, above bristle.yield_stress = '
            f'{limit * 1e-6:.4g} MPa: a real wire would stay bent; less road.penetration, a lower '
            'drive speed or a thinner wire would do', True)

    def _gained(self) -> RunWarning | None:
        worst, solver = self._gained_most, self._scene.solver
        # what rings behind a clamp that is moved by hand is told of by `_polygon`
        if worst.value <= GAIN or load_steps(self._scene):
            return None
        return RunWarning(
            'energy from nowhere', f'the energy accounts gained {100.0 * worst.value:.3g} % of '
            f'what the wires held, most at t = {worst.t:.6g} s: a motion is not resolved; a '
            f'shorter solver.integration_time_step than {solver.integration_time_step:.3g} s, a '
            'smaller solver.spectral_radius or some damping.stiffness would do', True)

    def _polygon(self) -> RunWarning | None:
        every, solver = load_steps(self._scene), self._scene.solver
        jump = widest(self._scene) * self._speed ** 2 * solver.time_step
        if not every or jump == 0.0:
            return None
        ring = ring_of(self._simulation.model.scheme, every, 1 + self._simulation.step // every)
        left = abs(float(ring.at[-1]))
        acts = left > STILL_RINGING
        rest = (f'{100.0 * left:.3g} % of a jump are left at the next corner' if acts else
                f'after {ring.lasts} of {every} steps less than 1 % is left')
        return RunWarning(
            'polygon corners', f'at each corner of the polygon (solver.time_step = '
            f'{solver.time_step:.6g} s) the speed of the clamp jumps by up to {jump:.3g} m/s, '
            f'{100.0 * abs(ring.at[0]):.3g} % too far in the first step, and {rest}: forces and '
            "energies of these steps are the integrator's; solver.time_step: 0.0 or load_case: "
            'inertia would do', acts)

    def _never(self, ended: bool) -> RunWarning | None:
        lasted = self._before - self._start
        approach = self._scene.road.approach_time
        nearest = -self._worst[2].value
        if not self._touches or nearest == inf or self._simulation.touched:
            return None
        turned = abs(self._scene.drive.mean_speed) * (lasted - approach) >= 2.0 * pi
        if not ended and not turned:
            return None
        way_out = ('more road.penetration, or contact.enabled: false' if lasted > approach else
                   f'a run that is longer than road.approach_time = {approach:.6g} s')
        return RunWarning(
            'never touched', f'no tip touched the road in {lasted:.6g} s, though contact is on; '
            f'the nearest was {_mm(nearest)} above it: {way_out} would do', False)

    def _not_settled(self) -> RunWarning | None:
        parts = []
        for (name, unit), mean in zip(QUANTITIES, self.means):
            halves = mean.halves
            if halves is not None and not mean.settled:
                parts.append(f'{name} {halves.first:.4g}, then {halves.second:.4g} {unit} '
                             f'(+- {halves.chance:.2g} by chance)')
        if not parts:
            return None
        begin, end = self.window
        return RunWarning(
            'not settled', f'means of {begin:.6g} to {end:.6g} s have not settled, first against '
            f'second half: {"; ".join(parts)}: a longer run would do', False)

    def _split(self) -> RunWarning | None:
        split, steps = self._simulation.split_steps, self._steps
        if self._scene.solver.step != 'fixed' or split <= SPLIT_SHARE * steps:
            return None
        return RunWarning(
            'sub-stepped', f'{split} of {steps} fixed steps ({100.0 * split / steps:.3g} %) were '
            'taken in sub-steps, above 5 %: a shorter solver.integration_time_step than '
            f'{self._scene.solver.integration_time_step:.3g} s, or solver.step: adaptive, would '
            'do', False)

    def _finest(self) -> RunWarning | None:
        finest, steps = self._simulation.finest_steps, self._steps
        if finest <= FINEST_SHARE * steps:
            return None
        return RunWarning(
            'finest sub-steps', f'{finest} of {steps} steps ({100.0 * finest / steps:.3g} %) went '
            'down to 1/1024 of solver.integration_time_step or less, above 1 %: sub-steps '
            'as short as that are taken whatever their error; some damping.stiffness, a lower '
            'contact.normal_stiffness or a shorter step would do', True)

    def _coarse(self) -> RunWarning | None:
        elements = self._scene.solver.elements
        if elements >= FEW_ELEMENTS:
            return None
        return RunWarning(
            'few elements', f'solver.elements = {elements} are too few for the shape of a bent '
            f'wire: {FEW_ELEMENTS} or more would do', False)

    @property
    def _steps(self) -> int:
        return self._simulation.step * self._simulation.bristles


def _mm(length: float) -> str:
    return f'{length * 1e3:.3g} mm'
