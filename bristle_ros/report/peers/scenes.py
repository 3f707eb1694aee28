"""
The five scenes that other programs are compared on, as equations for them and as Scenes for us.

S1 cantilever dropped from the horizontal; S2 free rotation; S3 bouncing sweep; S4 tilted deep
sweep; S5 free rotation with beta_D = 21 ms. For the other programs the contact is a penalty law:
normal force Kn d (1 + d' s/m), friction regularised at 1 cm/s. Ours keeps exact Coulomb friction.
"""
import math
from typing import NamedTuple

from bristle_ros.scene import (Brush, Contact, Damping, Drive, Friction, Road, Run, Scene, Solver,
                               Sweeper)
import numpy as np

RPM = math.pi / 30.0
LENGTH, BREADTH, WIDTH = 0.240, 0.002, 0.0005
E, NU, RHO, G = 2.07e11, 0.3, 7800.0, 9.81
TORSION = 7.02e-14      # [m^4] St Venant
RADIUS, PHI = 0.1125, math.radians(26.0)
KN, HUNT_CROSSLEY, SLIP = 1e4, 1.0, 0.01
NAMES = ('S1', 'S2', 'S3', 'S4', 'S5')


class PeerScene(NamedTuple):
    """A scene as a peer needs it: brush frame, clamp at rest, forces as functions of time."""

    name: str
    duration: float                 # [s]
    clamp: tuple                    # [m]
    along: tuple                    # clamp to tip
    across: tuple                   # direction of the 2 mm side
    mean: float = 0.0               # [rad/s] brush speed
    alternating: float = 0.0        # [rad/s], at 5 Hz
    tilt: float = 0.0               # [rad] attack angle
    start_angle: float = 0.0        # [rad]
    mass_damping: float = 0.0       # [1/s]
    damping: float = 0.0            # [s] beta_D
    friction: float = 0.0
    velocity: float = 0.0           # [m/s] of the sweeper
    depth: float = 0.0              # [m] penetration
    approach: float = 0.0           # [s]
    contact: bool = False

    def motion(self, t):
        """Return angle, speed and acceleration of the brush."""
        w = 2.0 * math.pi * 5.0
        return (self.start_angle + self.mean * t + self.alternating / w * (1.0 - math.cos(w * t)),
                self.mean + self.alternating * math.sin(w * t),
                self.alternating * w * math.cos(w * t))

    def axes(self, t):
        """Return the matrix from brush axes to road axes."""
        angle = self.motion(t)[0]
        c, s = math.cos(angle), math.sin(angle)
        cb, sb = math.cos(self.tilt), math.sin(self.tilt)
        return np.array([[cb * c, -cb * s, sb], [s, c, 0.0], [-sb * c, sb * s, cb]])

    def field(self, t):
        """Return acceleration = field + A x + B v in the brush frame: (3,), A, B (3, 3)."""
        _, w, dw = self.motion(t)
        gravity = -G * self.axes(t)[2]
        by_position = np.array([[w * w, dw, 0.0], [-dw, w * w, 0.0], [0.0, 0.0, 0.0]])
        by_velocity = np.array([[0.0, 2.0 * w, 0.0], [-2.0 * w, 0.0, 0.0], [0.0, 0.0, 0.0]])
        return gravity, by_position, by_velocity - self.mass_damping * np.eye(3)

    def ground(self, t):
        """Return height [m] and rise [m/s] of the road, road axes, from the mount centre."""
        lowest = -(LENGTH * math.cos(PHI) * math.cos(self.tilt)
                   + (RADIUS + LENGTH * math.sin(PHI)) * math.sin(self.tilt))
        if self.approach == 0.0:
            return lowest + self.depth, 0.0
        s = min(1.0, t / self.approach)
        return (lowest + self.depth * s * s * (3.0 - 2.0 * s),
                self.depth * 6.0 * s * (1.0 - s) / self.approach)

    def tip_force(self, t, x, v):
        """Return the contact force on the tip in brush axes [N] and its normal part [N]."""
        axes = self.axes(t)
        height, rise = self.ground(t)
        inside = height - axes[2] @ x
        if inside <= 0.0:
            return np.zeros(3), 0.0
        w = self.motion(t)[1]
        absolute = axes @ np.array([v[0] - w * x[1], v[1] + w * x[0], v[2]])
        absolute[0] += self.velocity
        normal = max(0.0, KN * inside * (1.0 + HUNT_CROSSLEY * (rise - absolute[2])))
        slip = math.hypot(absolute[0], absolute[1])
        drag = -self.friction * normal / math.hypot(slip, SLIP)
        return axes.T @ np.array([drag * absolute[0], drag * absolute[1], normal]), normal


def peer_scene(name):
    """Return the PeerScene of a name of NAMES."""
    if name == 'S1':
        return PeerScene('S1', 0.5, (0.0, 0.0, 0.0), (1.0, 0.0, 0.0), (0.0, 1.0, 0.0))
    usual = {'clamp': (RADIUS, 0.0, 0.0), 'along': (math.sin(PHI), 0.0, -math.cos(PHI)),
             'across': (0.0, 1.0, 0.0)}
    if name == 'S3':
        return PeerScene('S3', 0.3, **usual, mean=100 * RPM, mass_damping=0.1, damping=2.1e-5,
                         friction=0.5, depth=5e-3, approach=0.02, contact=True)
    usual.update(mean=150 * RPM, alternating=4 * RPM)
    if name == 'S4':
        return PeerScene('S4', 0.4, **usual, tilt=math.radians(10.0), start_angle=math.pi,
                         friction=0.5, velocity=1.5, depth=0.04, contact=True)
    return PeerScene(name, 0.5, **usual, damping=0.021 if name == 'S5' else 0.0)


def our_scene(name, its, **solver):
    """Return the same as our Scene; solver: keys of its solver section."""
    peer = peer_scene(name)
    solver = {'integration_time_step': its, **solver}
    chunk = max(1, round(5e-3 / its)) * its
    sample = max(1, round(1e-3 / its)) * its
    return Scene(
        brush=Brush(mount_radius=peer.clamp[0], start_angle=peer.start_angle,
                    mount_angle=math.pi / 2 if name == 'S1' else PHI),
        road=Road(attack_angle=peer.tilt, penetration=peer.depth, approach_time=peer.approach),
        contact=Contact(enabled=peer.contact, normal_stiffness=KN,
                        damping=HUNT_CROSSLEY if peer.contact else 0.0),
        friction=Friction(static=peer.friction, kinetic=peer.friction),
        damping=Damping(mass=peer.mass_damping, stiffness=peer.damping),
        drive=Drive(profile='sine', mean_speed=peer.mean, alternating_speed=peer.alternating),
        sweeper=Sweeper(velocity=(peer.velocity, 0.0)), solver=Solver(**solver),
        run=Run(chunk=chunk, sample=sample))
