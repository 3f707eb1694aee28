"""What a run of any scene must satisfy at every look, whatever its parameters."""
import math

from bristle_ros.simulation import load_steps, ring_of
import numpy as np

GAIN = 0.2          # energy that may appear from nowhere, of the energy there is: 10 ms steps
CONE = 1e-9         # excess of the friction over mu_s times the normal force, relative
PASSED = 0.01       # share of the energy that went through, which the balance may be off by
STRETCH = 0.02      # of the chord beyond the length, on top of what the loads explain
RIGID = 1e-12       # [m] a rigid road may be entered


class Watch:
    """
    Looks at the outputs of a run as it goes; `wrong` lists in words what cannot be.

    The energy balance, the friction cone, the contact law between force and penetration (from the
    road's height alone, not from the stepper's own gap), and the bristle's length.
    """

    def __init__(self, scene, simulation, *, follows_road):
        """Note the scene's bounds; follows_road: the road moves as the scene says, no commands."""
        self.scene = scene
        self.wrong = []
        self._its = simulation.its
        self._depth = simulation.model.drive.tip_depth
        self._clamp = simulation.model.clamp[:3]
        self._follows_road = follows_road and scene.solver.time_step == 0.0
        self._corners = load_steps(scene)
        self._scheme = simulation.model.scheme
        self._before = None
        self._residual = self._lowest = 0.0
        self._scale = 0.0
        self._throughput = 0.0
        self._work = self._at_start = None
        self._gain = self._loss = 0.0
        self._cone = self._stretch = 0.0
        self._law = self._entered = 0.0
        self._peak = self._speed = 0.0

    def _height(self, t):
        """Return the mount centre's height above the road at time t [m]."""
        road = self.scene.road
        s = min(1.0, t / road.approach_time) if road.approach_time > 0.0 else 1.0
        return self._depth - road.penetration * s * s * (3.0 - 2.0 * s)

    def commanded(self):
        """Note that a command came: the road may move otherwise than the scene says."""
        self._follows_road = False

    def before_step(self, snapshot):
        """Note the outputs at the start of a step that is then made alone."""
        self._before = snapshot

    def look(self, snapshot, stepped=False):
        """Check one snapshot; stepped: one step after the one given to `before_step`."""
        if not self._finite(snapshot):
            return
        self._speed = max(self._speed, abs(snapshot.omega))
        self._energy(snapshot)
        self._reach(snapshot)
        if self.scene.contact.enabled:
            self._friction(snapshot)
            if self._follows_road:
                self._contact(snapshot, self._before if stepped else None)

    def _finite(self, snapshot):
        for name, value in zip(snapshot._fields, snapshot):
            if not np.all(np.isfinite(value)):
                self.wrong.append(f'{name} is not finite at t = {snapshot.t:.6g} s')
                return False
        return True

    def _energy(self, snapshot):
        stored = snapshot.energy_kinetic + snapshot.energy_elastic
        if self._work is None:
            self._work = snapshot.work_external
        self._throughput += abs(snapshot.work_external - self._work)
        self._work = snapshot.work_external
        self._scale = max(self._scale, stored)
        residual = stored + snapshot.energy_dissipated - snapshot.work_external
        if self._at_start is None:
            self._at_start = residual   # a start from equilibrium is bent already
        residual -= self._at_start
        ringing = self._ringing(snapshot)
        self._lowest = min(self._lowest, residual + ringing)
        # what went through friction is much more than what the bristle holds
        through = abs(snapshot.energy_dissipated) + self._throughput
        scale = self._scale + PASSED * through + 1e-12
        gain = (residual - ringing - self._lowest) / scale
        self._gain = max(self._gain, gain)
        self._loss = max(self._loss, -residual / scale)
        if gain > GAIN:
            self.wrong.append(f'energy from nowhere: {gain:.3g} of what there is, at t = '
                              f'{snapshot.t:.6g} s')

    def _ringing(self, snapshot):
        """
        Return what the ringing behind a polygon's corner may change the energy by [J].

        With d the deviation of the velocities, at most m d^2 / 2 + m v d; the run warns of it.
        """
        if not self._corners:
            return 0.0
        corners, steps = divmod(round(snapshot.t / self._its), self._corners)
        if steps == 0:      # the corner's own step is yet to come
            corners, steps = corners - 1, self._corners
        ring = ring_of(self._scheme, self._corners, corners + 1)
        solver, bristle = self.scene.solver, self.scene.bristle
        speed = abs(float(ring.at[steps - 1])) * (
            self.scene.brush.mount_radius * self._speed ** 2 * solver.time_step)
        mass = bristle.density * bristle.breadth * bristle.width * bristle.length
        own = 0.5 * mass * speed * speed
        return own + 2.0 * math.sqrt(own * snapshot.energy_kinetic)

    def _reach(self, snapshot):
        bristle = self.scene.bristle
        area = bristle.breadth * bristle.width
        radius = self.scene.brush.mount_radius + bristle.length
        weight = bristle.density * area * bristle.length
        self._peak = max(self._peak, float(np.abs(snapshot.contact_force).max()))
        load = weight * (self._speed ** 2 * radius + self.scene.gravity) + self._peak
        stretch = float(np.linalg.norm(snapshot.tip_position[0] - self._clamp)) / bristle.length
        self._stretch = max(self._stretch, stretch - 1.0)
        # twice: a load that comes suddenly overshoots
        if stretch - 1.0 > STRETCH + 2.0 * load / (bristle.youngs_modulus * area):
            self.wrong.append(f'the tip is {stretch:.4g} lengths from the clamp at t = '
                              f'{snapshot.t:.6g} s')

    def _friction(self, snapshot):
        for x, y, normal in snapshot.contact_force:
            if normal < 0.0:
                self.wrong.append(f'the road pulls: {normal:.3g} N at t = {snapshot.t:.6g} s')
                return
            excess = math.hypot(x, y) - self.scene.friction.static * normal
            if excess > 0.0:
                self._cone = max(self._cone, excess / (normal + 1e-9))
            if excess > CONE * normal + 1e-15:
                self.wrong.append(f'friction {math.hypot(x, y):.6g} N outside its cone, normal '
                                  f'force {normal:.6g} N, at t = {snapshot.t:.6g} s')
                return

    def _contact(self, snapshot, before):
        gap = float(snapshot.tip_position_road[0, 2]) + self._height(snapshot.t)
        stiffness = self.scene.contact.normal_stiffness
        self._entered = max(self._entered, -gap)
        if math.isinf(stiffness):
            if gap < -RIGID:
                self.wrong.append(f'{-gap:.3g} m inside a rigid road at t = {snapshot.t:.6g} s')
            return
        if before is None or snapshot.substeps != before.substeps or (
                self.scene.solver.step != 'fixed'):
            return
        gap0 = float(before.tip_position_road[0, 2]) + self._height(before.t)
        force = float(snapshot.contact_force[0, 2])
        wanted = spring_force(stiffness, self.scene.contact.damping, self._its, gap0, gap)
        # Newton ends within its tolerance of the gap
        length = self.scene.bristle.length / self.scene.solver.elements
        slack = 10.0 * self.scene.solver.tolerance * length + 1e-15
        excess = abs(force - wanted) / (stiffness * slack + 1e-3 * max(force, wanted) + 1e-12)
        self._law = max(self._law, excess)
        if excess > 1.0:
            self.wrong.append(f'contact force {force:.6g} N where the penetration explains '
                              f'{wanted:.6g} N, at t = {snapshot.t:.6g} s')

    def measures(self):
        """Return the worst values seen, by name."""
        return {'energy_gain': self._gain, 'energy_loss': self._loss, 'cone_excess': self._cone,
                'stretch': self._stretch, 'law_excess': self._law, 'entered_m': self._entered,
                'largest_force_n': self._peak}


def spring_force(stiffness, damping, h, gap0, gap1):
    """Return the mean normal force [N] of a step of h [s] between two gaps [m]; 0 if open."""
    if gap0 <= 0.0 and gap1 <= 0.0:
        force = -0.5 * stiffness * (gap0 + gap1)
    elif gap0 >= 0.0 and gap1 >= 0.0:
        return 0.0
    else:
        inside = min(gap0, gap1)
        force = 0.5 * stiffness * inside * inside / abs(gap1 - gap0)
    return max(0.0, force * (1.0 + damping * (gap0 - gap1) / h))
