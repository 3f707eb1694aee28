"""The sweeper of sweeper.xml in MuJoCo, on the road of the brush's scene, with its energy."""
from itertools import pairwise
import math
from pathlib import Path

from bristle_ros.scene import spline, tip_depth
import mujoco
import numpy as np

HERE = Path(__file__).resolve().parent
SPEED = 0.8             # [m/s] of the sweeper, reached in the first second
LIFT = 20.0             # [N m] of the cylinder, on the lowered arm, upwards: carries part of it
ARM = 0.45              # [m] height of the arm over the road
WHEEL = 0.2             # [m] radius
DRIVEN = ('left', 'right')
# What does work on the sweeper; of all but the road and the damping somebody else knows it too.
WORKS = 'drive', 'lift', 'brush', 'damping', 'road'


def add_road(world, profile):
    """Lay boxes whose tops join the points of the profile, and go on at its last height."""
    x, z = spline(profile)[:2]
    ends = [*zip(x.tolist(), z.tolist()), (x[-1] + 50.0, z[-1])]
    for (x, z), (further, higher) in pairwise(ends):
        if z == higher == 0.0:
            continue    # the plane is there
        slope, thick = math.atan2(higher - z, further - x), 0.05
        world.add_geom(
            type=mujoco.mjtGeom.mjGEOM_BOX, contype=1, conaffinity=1,
            size=(0.5 * math.hypot(further - x, higher - z), 5.0, thick),
            pos=(0.5 * (x + further) + thick * math.sin(slope), 0.0,
                 0.5 * (z + higher) - thick * math.cos(slope)),
            quat=(math.cos(0.5 * slope), 0.0, -math.sin(0.5 * slope), 0.0))


class Sweeper:
    """
    The model, its mount put where the brush's scene has it.

    work : (5,) [J]     done on the sweeper since the start, in the order of WORKS
    stored : [J]        kinetic energy, and potential of gravity and the arm's spring, by MuJoCo
    Both are at the start of the last step, where MuJoCo tells energies.
    """

    def __init__(self, scene):
        spec = mujoco.MjSpec.from_file(str(HERE / 'sweeper.xml'))
        height = tip_depth(scene) - scene.road.penetration
        spec.site('mount').pos = (0.0, 0.0, height - ARM)
        half = 0.5 * scene.road.attack_angle
        spec.site('mount').quat = (math.cos(half), 0.0, math.sin(half), 0.0)
        if scene.profile.kind == 'file':
            add_road(spec.worldbody, scene.profile)
        self.model = spec.compile()
        self.data = mujoco.MjData(self.model)
        self._wheels = [self.model.joint(f'rear_{side}').dofadr[0] for side in DRIVEN]
        self._drives = [self.model.actuator(f'drive_{side}').id for side in DRIVEN]
        self._hinge = self.model.joint('hinge').dofadr[0]
        self._lift = self.model.actuator('lift').id
        self._site = self.data.site('mount')
        self._jacobian = np.zeros((2, 3, self.model.nv))
        # the wheels have sunk in by then, and the arm hangs in its spring
        self.holding = self._settle()
        self.start = self._site.xpos.copy() - (0.0, 0.0, height)
        self.stored, self._done = self.data.energy.sum(), np.zeros(len(WORKS))
        self.work = self._done.copy()

    def _settle(self):
        """Let the cylinder hold the arm level; return its moment [N m]."""
        hinge, moment = self.data.joint('hinge'), 0.0
        for _ in range(3000):
            moment -= 20.0 * hinge.qpos[0] + 5.0 * hinge.qvel[0]
            self.data.ctrl[self._lift] = moment
            mujoco.mj_step(self.model, self.data)
        self.data.time, self.data.qvel[:] = 0.0, 0.0
        mujoco.mj_forward(self.model, self.data)
        return moment

    @property
    def place(self):
        """[m] (3,) of the mount over the road, whose origin is below it at the start."""
        return self._site.xpos - self.start

    @property
    def turn(self):
        """(3, 3) mount axes to road axes."""
        return self._site.xmat.reshape(3, 3)

    def go_on(self, until, wrench):
        """
        Step to `until` [s] with a wrench (6,) [N, N m] on the mount, mount axes.

        Returns the mount's way and turn meanwhile, mount axes: (6,) [m, rad], whose product with
        a wrench is its work.
        """
        model, data, way = self.model, self.data, np.zeros(6)
        places, turns = self._jacobian
        for _ in range(round((until - data.time) / model.opt.timestep)):
            t = data.time
            data.ctrl[self._drives] = SPEED / WHEEL * min(t, 1.0)
            down = min(max(t - 1.0, 0.0), 1.0)
            data.ctrl[self._lift] = self.holding + (-LIFT - self.holding) * down
            mujoco.mj_jacSite(model, data, places, turns, self._site.id)
            jacobian = np.concatenate((self.turn.T @ places, self.turn.T @ turns))
            data.qfrc_applied[:] = jacobian.T @ wrench
            before = data.qvel.copy()
            mujoco.mj_step(model, data)
            mean = 0.5 * (before + data.qvel)
            way += model.opt.timestep * jacobian @ mean
            self._account(mean)
        mujoco.mj_kinematics(model, data)
        mujoco.mj_comPos(model, data)
        return way

    def _account(self, mean):
        """
        Add what a step's forces have done along its mean velocity, which is how energy changes.

        Damping and drive are implicit in MuJoCo's implicitfast: they act with the new velocity.
        """
        data, after = self.data, self.data.qvel
        self.stored, self.work = data.energy.sum(), self._done.copy()
        gain = self.model.actuator_gainprm[self._drives[0], 0]
        slip = data.ctrl[self._drives] - after[self._wheels]
        self._done += self.model.opt.timestep * np.array((
            gain * slip @ mean[self._wheels],
            data.ctrl[self._lift] * mean[self._hinge],
            data.qfrc_applied @ mean,
            -(self.model.dof_damping * after) @ mean,
            data.qfrc_constraint @ mean))

    def velocity(self):
        """Return linear and angular velocity of the mount, mount axes: (6,) [m/s, rad/s]."""
        found = np.zeros(6)     # MuJoCo has the angular one first
        mujoco.mj_objectVelocity(self.model, self.data, mujoco.mjtObj.mjOBJ_SITE, self._site.id,
                                 found, 1)
        return np.roll(found, 3)

    def quaternion(self):
        """Return w, x, y, z of the mount over the road."""
        found = np.zeros(4)
        mujoco.mju_mat2Quat(found, self._site.xmat)
        return found
