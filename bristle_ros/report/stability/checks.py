"""What a run of any scene must satisfy at every look, whatever its parameters."""
import math

from bristle_ros.scene import brush_rows, longest, widest
from bristle_ros.simulation import EnergyBalance, GAIN, load_steps, ring_of
import numpy as np

from .contact_checks import ContactWatch

STRETCH = 0.02      # of the chord beyond the length, on top of what the loads explain


class Watch:
    """
    Looks at the outputs of a run as it goes; `wrong` lists in words what cannot be.

    The energy balance and the bristle's length here, what the contact does in contact_checks.py.
    """

    def __init__(self, scene, simulation):
        """Note the scene's bounds."""
        self.scene = scene
        self.wrong = []
        self._its = simulation.its
        bristles = [(row, azimuth) for row in brush_rows(scene) for azimuth in row.azimuths]
        self._clamps = np.array([(row.radius * math.cos(azimuth), row.radius * math.sin(azimuth),
                                  0.0) for row, azimuth in bristles])
        self._lengths = np.array([row.length for row, _ in bristles])
        self._corners = load_steps(scene)
        self._scheme = simulation.model.scheme
        self._contact = ContactWatch(scene, simulation) if scene.contact.enabled else None
        self._balance = EnergyBalance()
        self._stretch = 0.0
        self._peak = self._speed = self._change = 0.0
        self._turned = math.inf, 0.0

    def commanded(self):
        """Note that a command came."""
        if self._contact:
            self._contact.commanded()

    def before_step(self, snapshot):
        """Note the outputs at the start of a step that is then made alone."""
        if self._contact:
            self._contact.before_step(snapshot)

    def look(self, snapshot, stepped=False):
        """Check one snapshot; stepped: one step after the one given to `before_step`."""
        if not self._finite(snapshot):
            return
        self._speed = max(self._speed, abs(snapshot.omega))
        t, omega = self._turned
        if snapshot.t > t:
            self._change = max(self._change, abs(snapshot.omega - omega) / (snapshot.t - t))
        self._turned = snapshot.t, snapshot.omega
        self._energy(snapshot)
        self._reach(snapshot)
        if self._contact:
            self._contact.look(snapshot, stepped)
            self.wrong += self._contact.wrong
            self._contact.wrong = []

    def _finite(self, snapshot):
        for name, value in zip(snapshot._fields, snapshot):
            if name == 'drive_work' and self.scene.drive.mode == 'speed':
                continue    # NaN: nothing drives but what the speed takes
            # nothing near the wire is a gap of inf
            if np.any(np.isnan(value)) or name != 'wire_gap' and not np.all(np.isfinite(value)):
                self.wrong.append(f'{name} is not finite at t = {snapshot.t:.6g} s')
                return False
        return True

    def _energy(self, snapshot):
        gain = self._balance.take(snapshot, self._ringing(snapshot))
        if gain > GAIN:
            self.wrong.append(f'energy from nowhere: {gain:.3g} of what there is, at t = '
                              f'{snapshot.t:.6g} s')

    def _ringing(self, snapshot):
        """
        Return what the ringing behind a polygon's corner may change the energy by [J].

        With d the deviation of the velocities, at most m d^2 / 2 + m v d; the run warns of it. At
        a corner the clamp's direction turns, and the speed of turning changes.
        """
        if not self._corners:
            return self._shaken(snapshot)
        corners, steps = divmod(round(snapshot.t / self._its), self._corners)
        if steps == 0:      # the corner's own step is yet to come
            corners, steps = corners - 1, self._corners
        ring = ring_of(self._scheme, self._corners, corners + 1)
        solver = self.scene.solver
        far = widest(self.scene)
        # between corners the outputs' frame turns on, the clamp goes straight: half a jump apart
        speed = (0.5 + abs(float(ring.at[steps - 1]))) * solver.time_step * (
            far * self._speed ** 2 + (far + longest(self.scene)) * self._change)
        return self._in_motion(speed, snapshot)

    def _in_motion(self, speed, snapshot):
        """Return what velocities that are off by `speed` may change the energy by [J]."""
        bristle = self.scene.bristle
        mass = bristle.density * bristle.breadth * bristle.width * float(self._lengths.sum())
        own = 0.5 * mass * speed * speed
        return own + 2.0 * math.sqrt(own * snapshot.energy_kinetic)

    def _shaken(self, snapshot):
        """
        Return what jumps of the brush's acceleration may change the energy by [J].

        In the displacement load case the integrator finds the clamp's velocity from its places; a
        jump of the acceleration, as at a ramp's end, puts that off by a step's share of it, which
        a scheme without numerical damping keeps. Where every step is a load step, the clamp's
        direction turns at each.
        """
        if self.scene.solver.load_case != 'displacement':
            return 0.0
        far = widest(self.scene) + longest(self.scene)
        turned = self._speed ** 2 if self.scene.solver.time_step > 0.0 else 0.0
        return self._in_motion(2.0 * self._its * far * (self._change + turned), snapshot)

    def _reach(self, snapshot):
        bristle = self.scene.bristle
        area = bristle.breadth * bristle.width
        far = widest(self.scene) + longest(self.scene)
        weight = bristle.density * area * longest(self.scene)
        self._peak = max(self._peak, float(np.abs(snapshot.contact_force).max()))
        load = weight * (self._speed ** 2 * far + self.scene.gravity) + self._peak
        chords = np.linalg.norm(snapshot.tip_position - self._clamps, axis=1) / self._lengths
        stretch = float(chords.max())
        self._stretch = max(self._stretch, stretch - 1.0)
        # the clamp that goes along a chord is that far from the outputs' one
        turn = self._speed * self.scene.solver.time_step if self._corners else 0.0
        chord = 0.25 * widest(self.scene) * turn * turn / float(self._lengths.min())
        # twice: a load that comes suddenly overshoots
        if stretch - 1.0 > STRETCH + chord + 2.0 * load / (bristle.youngs_modulus * area):
            self.wrong.append(f'a tip is {stretch:.4g} lengths from its clamp at t = '
                              f'{snapshot.t:.6g} s')

    def measures(self):
        """Return the worst values seen, by name."""
        found = {'energy_gain': self._balance.gain, 'energy_loss': self._balance.loss,
                 'stretch': self._stretch, 'largest_force_n': self._peak}
        return {**found, **(self._contact.measures() if self._contact else {})}

