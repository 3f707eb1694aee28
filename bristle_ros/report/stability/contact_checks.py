"""What the contact of a run must satisfy at every look, on whatever surface; see ground.py."""
import math

from bristle_ros.scene import longest, widest
import numpy as np

from bristle_ros.report.ground import Ground, mount_to_road

CONE = 1e-9         # excess of the friction over mu_s times the normal force, relative
RIGID = 1e-12       # [m] a rigid road may be entered
NEWTON = 1e-8       # tolerance of its corrections that no local error takes it below, per element
SHARE = 0.1         # of the local error that it is else
ROUNDED = 4e-15     # [m] that places of some metres are known to
WIRE_RIGID = 1e-6   # [m] that a wire may be in a rigid road between the points that touch
MADE = 1e-6         # work that a contact may give beyond its spring's, of what went through it
BETWEEN = 4         # points looked at between two nodes
STEEP = math.radians(85.0)


class ContactWatch:
    """
    Friction cone, contact law and passivity at the tips; wires and clamps outside the surface.

    From positions and forces of the outputs and the keys of the scene alone. `wrong` lists in
    words what cannot be.
    """

    def __init__(self, scene, simulation):
        """Note the scene's surface and bounds."""
        self.ground = Ground(scene)
        self.wrong = []
        self._scene, self._simulation = scene, simulation
        self._depth = simulation.model.drive.tip_depth
        self._its = simulation.its
        self._commanded = False
        # ramped loads: the frame's places at step ends are not those of the outputs
        self._exact = scene.solver.time_step == 0.0
        self._along = scene.contact.points == 'wire'
        self._before = None
        self._cone = self._law = self._made = 0.0
        self._bend = self.ground.bend()
        self._entered = self._wire = 0.0
        self._pressed = None        # [m] (B,) deepest spring of each wire since it was outside
        self._looks = self._points = 0

    def commanded(self):
        """Note that a command came: the height is not the scene's own any more."""
        self._commanded = True

    def _place(self, snapshot):
        """Return where the mount's centre is, surface axes [m]."""
        x, y, heading = snapshot.base_pose
        c, s = math.cos(heading), math.sin(heading)
        forward, left = self._scene.sweeper.mount_position
        height = (self._simulation.sweeper_motion()[0] if self._commanded
                  else self._depth - self.ground.height(snapshot.t))
        return np.array((x + c * forward - s * left,
                         y + s * forward + c * left - self.ground.beside(snapshot.t), height))

    def _line(self, snapshot, place):
        """Return the centrelines in surface axes [m]: (B, nodes, 3)."""
        turn = mount_to_road(self._scene.road, float(snapshot.base_pose[2]))
        return self._simulation.centreline() @ turn.T + place

    def before_step(self, snapshot):
        """Note the outputs at the start of a step that is then made alone."""
        place = self._place(snapshot)
        self._before = (snapshot, snapshot.tip_position_road + place,
                        self._line(snapshot, place))

    def look(self, snapshot, stepped):
        """Check one snapshot; stepped: one step after the one given to `before_step`."""
        self._looks += 1
        place = self._place(snapshot)
        tips = snapshot.tip_position_road + place
        gaps, normals = self.ground.gap(tips)
        before = self._before if stepped else None
        alone = before is not None and snapshot.substeps == before[0].substeps and (
            self._scene.solver.step == 'fixed')
        if self._exact:
            self._enter(snapshot, gaps)
        if self.ground.uneven or self._along:
            self._outside(snapshot, self._line(snapshot, place), before)
        forces = snapshot.tip_force
        if not self.ground.uneven:      # there all points of a wire share one cone
            for part in (forces, snapshot.contact_force)[:1 + self._along]:
                self._friction(snapshot, part, np.broadcast_to((0.0, 0.0, 1.0), part.shape),
                               np.zeros(len(part)), 1.0, tips)
        if alone and self._exact:
            self._step(snapshot, forces, tips, gaps, normals, before)

    def _enter(self, snapshot, gaps):
        deepest = -float(gaps.min())
        self._entered = max(self._entered, deepest)
        if math.isinf(self._scene.contact.normal_stiffness) and deepest > RIGID + ROUNDED:
            self.wrong.append(f'{deepest:.3g} m inside a rigid road at t = {snapshot.t:.6g} s')

    def _step(self, snapshot, forces, tips, gaps, normals, before):
        """Check a step without sub-steps: the normal that its work is counted with is known."""
        _, starts, _ = before
        gaps0, _ = self.ground.gap(starts)
        moved = tips - starts
        middle = self.ground.gap(starts + 0.5 * moved)[1]
        along = (gaps - gaps0) - (middle * moved).sum(axis=1)
        square = (moved ** 2).sum(axis=1)
        step_normals = middle + np.where(square > 1e-20, along / np.maximum(square, 1e-20),
                                         0.0)[:, None] * moved
        length = np.sqrt((step_normals ** 2).sum(axis=1))
        unit = step_normals / length[:, None]
        bend = np.maximum(_angle(unit, normals), _angle(unit, middle))
        if self.ground.uneven:
            # gaps are known to that, and with them how the step's normal is turned
            bend = bend + 4.0 * ROUNDED / np.sqrt(np.maximum(square, 1e-20))
            self._friction(snapshot, forces, unit, bend, length, tips)
        if not math.isinf(self._scene.contact.normal_stiffness):
            slack = self._slack(snapshot, before)
            pushes = (forces * unit).sum(axis=1) / length
            for push, force, turn, gap0, gap in zip(pushes, forces, bend, gaps0, gaps):
                self._spring(snapshot, push, turn * float(np.abs(force).sum()), gap0, gap, slack)
            self._work(snapshot, forces, moved, gaps0, gaps, slack)

    def _friction(self, snapshot, forces, normals, bends, lengths, tips):
        """
        Check that forces push and lie in their cones about normals, which may turn by `bends`.

        What stops a tip at a step's end acts across the normal there, not that of the step. The
        force that bounds friction is that which does work over the gap: times the step's normal,
        whose length is 1 but for depth times curvature.
        """
        limits = np.arctan(self.ground.friction(tips[:, 1]) / np.minimum(lengths, 1.0)
                           ) + 1.01 * bends
        for force, normal, limit in zip(forces, normals, limits):
            push = float(force @ normal)
            if limit > STEEP or not force.any():
                continue
            if push < 0.0:
                self.wrong.append(f'the road pulls: {push:.3g} N at t = {snapshot.t:.6g} s')
                return
            across = float(np.linalg.norm(force - push * normal))
            excess = across - math.tan(limit) * push
            if excess > 0.0:
                self._cone = max(self._cone, excess / (push + 1e-9))
            if excess > CONE * push + 1e-15:
                self.wrong.append(f'friction {across:.6g} N outside its cone, normal force '
                                  f'{push:.6g} N, at t = {snapshot.t:.6g} s')
                return

    def _spring(self, snapshot, force, turned, gap0, gap, off):
        contact = self._scene.contact
        wanted = spring_force(contact.normal_stiffness, contact.damping, self._its, gap0, gap)
        slack = contact.normal_stiffness * off + 1e-3 * max(force, wanted) + 1e-12
        excess = abs(force - wanted) / (slack + turned)
        self._law = max(self._law, excess)
        if excess > 1.0:
            self.wrong.append(f'contact force {force:.6g} N where the penetration explains '
                              f'{wanted:.6g} N, at t = {snapshot.t:.6g} s')

    def _slack(self, snapshot, before):
        """
        Return what a gap may be off by [m]: Newton ends within its tolerance of it.

        That is a part of the local error, not less than NEWTON and at most the scene's.
        """
        length, solver = longest(self._scene), self._scene.solver
        error = max(snapshot.error_estimate, before[0].error_estimate)
        element = length / solver.elements
        allowed = solver.tolerance * element
        if solver.newton == 'estimate':
            allowed = min(max(SHARE * error * length, NEWTON * element), allowed)
        return 10.0 * allowed + 1e-15

    def _work(self, snapshot, forces, moved, gaps0, gaps, off):
        """Check that a contact gives no more work than its spring gives back."""
        stiffness = self._scene.contact.normal_stiffness
        stored0, stored = (0.5 * stiffness * np.minimum(gap, 0.0) ** 2 for gap in (gaps0, gaps))
        work = (forces * moved).sum(axis=1)
        size = np.sqrt((forces ** 2).sum(axis=1))
        through = size * np.sqrt((moved ** 2).sum(axis=1)) + stored0 + stored
        made = (work - (stored0 - stored) - size * off) / (through + 1e-15)
        worst = float(made.max())
        self._made = max(self._made, worst)
        if worst > MADE:
            self.wrong.append(f'the contact gives {worst:.3g} of the work that went through it '
                              f'from nowhere, at t = {snapshot.t:.6g} s')

    def _outside(self, snapshot, line, before):
        """Check that clamps, and wires where they touch with all their length, are outside."""
        if before is not None:      # a step that brings it there is followed by none
            clamp = float(self.ground.inside(before[2][:, 0]).max())
            if clamp > ROUNDED:
                self.wrong.append(f'a step begins with a clamp {clamp:.3g} m below the surface, '
                                  f'at t = {before[0].t:.6g} s')
        if not self._along or before is None:
            return
        gaps, _ = self.ground.gap(points_between(line))
        self._points += gaps.size
        deepest = -gaps.min(axis=1)
        self._press(snapshot, deepest)
        came = (self.ground.gap(points_between(before[2]))[0] - gaps).max(axis=1)
        self._wire = max(self._wire, float(deepest.max()))
        for number, depth in enumerate(deepest):
            allowed = (self._allowed(snapshot, number, line, before, max(0.0, float(came[number])))
                       + self._ramped(snapshot))
            if depth > allowed:
                self.wrong.append(f'wire {number} is {depth:.3g} m inside the surface, where its '
                                  f'forces explain {allowed:.3g} m, at t = {snapshot.t:.6g} s')
                return

    def _press(self, snapshot, deepest):
        stiffness = self._scene.contact.normal_stiffness
        if math.isinf(stiffness):
            return
        pressed = np.linalg.norm(snapshot.contact_force, axis=1) / stiffness
        if self._pressed is not None:
            pressed = np.maximum(pressed, self._pressed)
        self._pressed = np.where(deepest > 0.0, pressed, 0.0)

    def _allowed(self, snapshot, number, line, before, came):
        """
        Return how deep a wire may be [m]: what the mean force of the step takes, and its way.

        Half of a spring's force at the step's end is in its mean; what came in during the step is
        no deeper than any of it `came` [m] towards the surface. A point that takes over where a
        spring has pressed the wire in begins where that left it. No spring can hold more than the
        energy there is. Where a wire goes over a bend of the surface it is deepest at another
        place than where it touched when the step began: of second order in the way, and gone with
        the next step.
        """
        contact = self._scene.contact
        way = float(np.linalg.norm(line[number] - before[2][number], axis=1).max())
        beside = min(way, 0.5 * self._bend * way * way) + WIRE_RIGID
        if math.isinf(contact.normal_stiffness):
            return beside
        most = math.sqrt(2.0 * max(0.0, snapshot.energy_elastic) / contact.normal_stiffness)
        if not contact.damping:
            force = float(np.linalg.norm(snapshot.contact_force[number]))
            most = min(most, 2.0 * force / contact.normal_stiffness + came
                       + float(self._pressed[number]))
        return most + beside

    def _ramped(self, snapshot):
        """
        Return how far clamps and road may be from where the outputs have them [m].

        Both go straight from load step to load step: the heights of chords.
        """
        scene = self._scene
        long, approach = scene.solver.time_step, scene.road.approach_time
        turn = abs(snapshot.omega) * long
        away = 0.25 * (widest(scene) + longest(scene)) * turn * turn
        if approach > 0.0 and snapshot.t < approach + long:
            share = min(1.0, long / approach)
            away += 0.75 * share * share * (
                abs(scene.road.penetration) + abs(scene.gutter.approach))
        return away

    def measures(self):
        """Return the worst values seen, by name."""
        return {'cone_excess': self._cone, 'law_excess': self._law, 'work_made': self._made,
                'entered_m': self._entered, 'wire_entered_m': self._wire, 'looks': self._looks,
                'wire_points': self._points}


def _angle(one, other):
    """Return the angles between unit vectors (n, 3) [rad]."""
    return np.arctan2(np.linalg.norm(np.cross(one, other), axis=1), (one * other).sum(axis=1))


def points_between(line):
    """
    Return nodes (B, 2 n + 1, 3) of 3-node elements and points between them: (B, m, 3).

    On each element's own curve: the parabola through its nodes.
    """
    first, middle, last = (line[:, at:len(line[0]) - 2 + at:2, None] for at in (0, 1, 2))
    s = np.linspace(-1.0, 1.0, 2 * BETWEEN + 1)[:-1, None]
    inner = (0.5 * s * (s - 1.0) * first + (1.0 - s * s) * middle + 0.5 * s * (s + 1.0) * last)
    return np.concatenate((inner.reshape(len(line), -1, 3), line[:, -1:]), axis=1)


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
