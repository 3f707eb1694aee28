"""
The scenes that other programs are compared on, as equations for them and as Scenes for us.

S1 cantilever dropped from the horizontal; S2 free rotation; S3 bouncing sweep; S4 tilted deep
sweep; S5 free rotation with beta_D = 21 ms; and those of road/subjects.py. For the other programs
the contact is a penalty law: normal force Kn d (1 + c d'), friction regularised at 1 cm/s, at the
tip, or on the scenes of the road at every node. Ours keeps exact Coulomb friction.
"""
import math
from typing import NamedTuple

from bristle_ros.report.road.subjects import NAMES as NAMES_OF_ROAD, road_duration, road_scene
from bristle_ros.scene import (Brush, Contact, Damping, Drive, Friction, is_uneven, Road, Run,
                               Scene, Solver, Sweeper)
import numpy as np

from .surface import surface_gaps

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
    stiffness: float = KN           # [N/m] of a node's contact
    rate: float = HUNT_CROSSLEY     # [s/m] c
    whole: bool = False             # whether all nodes touch, or the tip alone
    gaps: object = None             # places [m] to gaps [m] and normals; None: the plane

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

    @property
    def by_impulse(self):
        """Whether programs are judged by the impulse and not by the tip's path."""
        return self.contact and not self.whole

    @property
    def touching(self):
        """Return which nodes may touch, as a slice."""
        return slice(None) if self.whole else slice(-1, None)

    def forces(self, t, x, v, most=math.inf):
        """
        Return the contact forces on nodes in brush axes and their normal parts [N].

        x [m], v [m/s] : (n, 3)    of the nodes, brush axes;  returns (n, 3), (n,)
        most [kg/s] : (n,)         friction per slip speed, such as what stops a node in a step
        """
        axes = self.axes(t)
        height, rise = self.ground(t)
        places = x @ axes.T
        places[:, 2] -= height
        if self.gaps is None:
            gaps, normals = places[:, 2], np.broadcast_to((0.0, 0.0, 1.0), places.shape)
        else:
            places[:, 0] += self.velocity * t
            gaps, normals = self.gaps(places)
        if not (gaps < 0.0).any():
            return np.zeros(x.shape), np.zeros(len(x))
        w = self.motion(t)[1]
        over = v @ axes.T + w * (np.stack((-x[:, 1], x[:, 0], np.zeros(len(x))), axis=1) @ axes.T)
        over += (self.velocity, 0.0, -rise)
        leaving = (over * normals).sum(axis=1)
        normal = self.stiffness * np.maximum(-gaps, 0.0) * np.maximum(
            0.0, 1.0 - self.rate * leaving)
        slip = over - leaving[:, None] * normals
        drag = np.minimum(most, self.friction * normal / np.sqrt(
            (slip ** 2).sum(axis=1) + SLIP ** 2))
        return (normal[:, None] * normals - drag[:, None] * slip) @ axes, normal


def peer_scene(name):
    """Return the PeerScene of a name of NAMES."""
    if name in NAMES_OF_ROAD:
        return _on_road(name)
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


def _on_road(name):
    """Return a scene of the road as a peer needs it; its kerb stands from the start."""
    scene = road_scene(name, 1e-4)
    phi, contact = scene.brush.mount_angle, scene.contact
    return PeerScene(
        name, road_duration(name), (scene.brush.mount_radius, 0.0, 0.0),
        (math.sin(phi), 0.0, -math.cos(phi)), (0.0, 1.0, 0.0), mean=scene.drive.mean_speed,
        tilt=scene.road.attack_angle, start_angle=scene.brush.start_angle,
        mass_damping=scene.damping.mass, damping=scene.damping.stiffness,
        friction=scene.friction.static, velocity=scene.sweeper.velocity[0],
        depth=scene.road.penetration, approach=scene.road.approach_time, contact=True,
        stiffness=contact.normal_stiffness, rate=contact.damping, whole=True,
        gaps=surface_gaps(scene) if is_uneven(scene.gutter, scene.profile) else None)


def our_scene(name, its, **solver):
    """Return the same as our Scene; solver: keys of its solver section."""
    if name in NAMES_OF_ROAD:
        return road_scene(name, its, **solver)
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
