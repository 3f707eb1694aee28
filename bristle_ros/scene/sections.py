"""The sections of a scene: every key with default, unit, range and meaning. SI, radians."""
from dataclasses import dataclass, fields
import math
from typing import Literal

from .error import SceneError
from .key import (choice, count, counts, Key, key_of, number, numbers, pair, switch, text)
from .rows import check_rows

INF = math.inf
MEAN_SPEED = 10.472  # [rad/s]
WITH_TABLE = 'drive.file has the speeds of a table: leave this out'
MOST_BRISTLES = 1000
ANY_ANGLE = 1e6  # [rad] far beyond what a start needs, and 1e-10 rad of it is still resolved


@dataclass(frozen=True, kw_only=True)
class SceneSection:
    """Checks its fields when made, so that a section that exists is one that can be used."""

    def __post_init__(self) -> None:
        """Store each field in its declared type; raise SceneError for one out of bounds."""
        for key in self.keys():
            name = key.name.rpartition('.')[2]
            object.__setattr__(self, name, key.check(getattr(self, name)))

    @classmethod
    def keys(cls) -> tuple[Key, ...]:
        """Return the section's Keys in the order of its fields."""
        section = cls.__name__.lower()
        return tuple(key_of(f'{section}.{item.name}', item) for item in fields(cls))


@dataclass(frozen=True, kw_only=True)
class Bristle(SceneSection):
    """A straight wire of rectangular section, clamped at one end."""

    length: float = number(0.240, 'm', 1e-3, 10.0, 'length of the wire')
    breadth: float = number(0.002, 'm', 1e-6, 0.1, 't1, the side of the section along the tangent')
    width: float = number(0.0005, 'm', 1e-6, 0.1, 't2, the side of the section across it')
    youngs_modulus: float = number(2.07e11, 'Pa', 1e3, 1e16, "Young's modulus")
    poissons_ratio: float = number(0.3, '1', -0.99, 0.5, "Poisson's ratio")
    density: float = number(7800.0, 'kg/m^3', 1.0, 1e5, 'density')
    yield_stress: float = number(
        1.5e9, 'Pa', 0.0, 1e12, 'a run is warned of when the clamp has more (drawn spring steel); '
        '0: never')


@dataclass(frozen=True, kw_only=True)
class Brush(SceneSection):
    """How the wires stand on the mount board."""

    mount_radius: float = number(0.1125, 'm', 0.0, 10.0, 'radius of the circle of clamps')
    mount_angle: float = number(
        0.4537856, 'rad', 0.0, math.pi / 2, 'phi: lean of the wire from the brush axis, outward')
    mount_orientation: float = number(
        0.0, 'rad', -ANY_ANGLE, ANY_ANGLE,
        'gamma: right-hand turn of the section about the clamp-to-tip direction; 0 cuts')
    bristle_count: int = count(
        1, 1, MOST_BRISTLES, 'bristles simulated, equally spaced in azimuth')
    wires_per_bristle: int = count(
        1, 1, 100000, 'real wires that one simulated bristle stands for')
    start_angle: float = number(
        0.0, 'rad', -ANY_ANGLE, ANY_ANGLE, 'azimuth of bristle 0 from mount +x at t = 0')
    row_radii: tuple[float, ...] = numbers(
        'm', 0.0, 10.0, 'mount_radius of each row, where there are several; the rows of a list '
        'that is left out have the one value; bristles are numbered row by row')
    row_angles: tuple[float, ...] = numbers('rad', 0.0, math.pi / 2, 'mount_angle of each row')
    row_lengths: tuple[float, ...] = numbers('m', 1e-3, 10.0, 'bristle.length of each row')
    row_orientations: tuple[float, ...] = numbers(
        'rad', -ANY_ANGLE, ANY_ANGLE, 'mount_orientation of each row')
    row_counts: tuple[int, ...] = counts(1, MOST_BRISTLES, 'bristle_count of each row')
    row_offsets: tuple[float, ...] = numbers(
        'rad', -ANY_ANGLE, ANY_ANGLE, "azimuth of each row's first bristle from bristle 0; the "
        "first row's is 0; left out: all 0")

    def __post_init__(self) -> None:
        """Check that the lists of rows fit together; raise SceneError."""
        super().__post_init__()
        check_rows(self, MOST_BRISTLES)


@dataclass(frozen=True, kw_only=True)
class Road(SceneSection):
    """The plane that the tips sweep."""

    attack_angle: float = number(
        0.0, 'rad', 0.0, 1.5, 'beta: tilt of the brush axis from the road normal')
    tilt_azimuth: float = number(
        0.0, 'rad', -ANY_ANGLE, ANY_ANGLE, 'where the low side of the brush faces; 0: forward')
    penetration: float = number(
        0.005, 'm', -10.0, 10.0, 'Delta: depth of the undeformed tip below the road at its lowest')
    approach_time: float = number(
        0.02, 's', 0.0, 1e4, 'time in which the penetration grows from zero; 0: there at once')
    max_rate: float = number(
        0.2, 'm/s', 1e-6, 1e3, 'fastest rise or fall of the road on a penetration command')
    grade: float = number(0.0, 'rad', -0.5, 0.5, 'the road climbs along +x: tilts gravity')
    cross_slope: float = number(0.0, 'rad', -0.5, 0.5, 'the road climbs along +y: tilts gravity')


@dataclass(frozen=True, kw_only=True)
class Contact(SceneSection):
    """Normal contact between wire and road."""

    enabled: bool = switch(True, 'whether there is a road at all')
    normal_stiffness: float = number(
        1e5, 'N/m', 1.0, INF, 'Kn: contact stiffness; .inf: rigid road')
    damping: float = number(
        0.0, 's/m', 0.0, 1e6, 'Hunt-Crossley: force times (1 + damping * penetration rate)')
    points: Literal['wire', 'tip'] = choice(
        'wire', 'what of a wire the road touches: any place along it, or its tip')


@dataclass(frozen=True, kw_only=True)
class Friction(SceneSection):
    """Friction kinetic + (static - kinetic) exp(-decay * slip speed)."""

    static: float = number(0.70, '1', 0.0, 100.0, 'mu_s: coefficient of friction at rest')
    kinetic: float = number(0.27, '1', 0.0, 100.0, 'mu_k: coefficient at high slip speed')
    decay: float = number(0.40, 's/m', 0.0, 1e6, 'c_v: how fast it falls with the slip speed')


@dataclass(frozen=True, kw_only=True)
class Damping(SceneSection):
    """Rayleigh damping of the wire, in the brush frame."""

    mass: float = number(0.1, '1/s', 0.0, 1e6, 'alpha_D: damping force per momentum')
    stiffness: float = number(0.0, 's', 0.0, 100.0, 'beta_D: damping stress per stress rate')


@dataclass(frozen=True, kw_only=True)
class Air(SceneSection):
    """Still air, through which the wires are moved."""

    density: float = number(0.0, 'kg/m^3', 0.0, 100.0, 'rho: of air 1.2; 0: no air')
    drag_coefficient: float = number(
        1.2, '1', 0.0, 10.0, 'Cd: force per length is 1/2 rho Cd w v_n^2, v_n the velocity across '
        "the wire, w the section's width seen from there")


@dataclass(frozen=True, kw_only=True)
class Drive(SceneSection):
    """The speed of the brush about its axis; positive is counter-clockwise seen from above."""

    profile: Literal['constant', 'sine', 'vap', 'table'] = choice('sine', 'speed function')
    mean_speed: float = number(
        MEAN_SPEED, 'rad/s', -1e4, 1e4, 'omega_m: mean speed; not with a table')
    alternating_speed: float = number(0.0, 'rad/s', 0.0, 1e4, 'omega_a: amplitude of sine and vap')
    frequency: float = number(5.0, 'Hz', 1e-6, 1e5, 'frequency of the profile')
    shape: float = number(0.08, '1', 0.001, 0.99, 'b: how sharp VAP is')
    max_acceleration: float = number(
        50.0, 'rad/s^2', 1e-6, 1e9, 'limit on commanded changes of the mean speed')
    max_speed: float = number(
        320.0, 'rad/s', 0.0, 1e4, 'largest speed, set, in a table or commanded')
    file: str = text(
        '', 'table: CSV t,speed [s, rad/s], t increasing, relative to the scene file; monotone '
        'cubics through the points, held at the ends, the commanded speed comes on top; or '
        'data:t,speed;t,speed itself')
    mode: Literal['speed', 'motor', 'torque'] = choice(
        'speed', 'whether the speed is given, or a motor or a torque (cmd_drive_torque) drives')
    inertia: float = number(
        0.0, 'kg m^2', 0.0, 1e6, 'motor, torque: of hub, board and gearbox, without the wires')
    loss: float = number(
        0.0, 'N m s/rad', 0.0, 1e6, 'motor, torque: what the drive loses, per speed')
    stall_torque: float = number(
        0.0, 'N m', 0.0, 1e6, 'motor: its torque at standstill, and the most it gives; torque: '
        'the most that may be commanded, 0: any')
    rated_speed: float = number(
        0.0, 'rad/s', 0.0, 1e6, 'motor: by how much the stall torque would slow it down')

    def __post_init__(self) -> None:
        """Let a table's brush have no other speed than commanded ones, which begin at 0."""
        super().__post_init__()
        self._check_mode()
        if self.profile != 'table':
            return
        for name, usual in (('mean_speed', MEAN_SPEED), ('alternating_speed', 0.0)):
            if getattr(self, name) not in (0.0, usual):
                raise SceneError(WITH_TABLE, key='drive.' + name, value=getattr(self, name))
            object.__setattr__(self, name, 0.0)

    def _check_mode(self) -> None:
        needed = {'speed': (), 'torque': ('inertia',),
                  'motor': ('inertia', 'stall_torque', 'rated_speed')}[self.mode]
        for name in needed:
            if getattr(self, name) == 0.0:
                raise SceneError(f'drive.mode: {self.mode} needs it above 0', key='drive.' + name,
                                 value=0.0)
        if self.mode == 'torque' and (self.profile == 'table' or self.alternating_speed != 0.0):
            raise SceneError('a torque follows no speeds: take profile: constant, or mode: motor',
                             key='drive.profile', value=self.profile)


@dataclass(frozen=True, kw_only=True)
class Sweeper(SceneSection):
    """The vehicle that carries the brush over the road."""

    velocity: tuple[float, float] = pair(
        (0.0, 0.0), 'm/s', -1e3, 1e3, 'forward and sideways velocity at the start, no ramp')
    max_acceleration: float = number(2.0, 'm/s^2', 1e-6, 1e6, 'limit on commanded changes of it')
    max_speed: float = number(20.0, 'm/s', 0.0, 1e3, 'largest speed, set or commanded')
    max_yaw_rate: float = number(2.0, 'rad/s', 0.0, 1e3, 'largest commanded yaw rate')
    max_yaw_acceleration: float = number(
        2.0, 'rad/s^2', 1e-6, 1e6, 'limit on commanded changes of the yaw rate')
    mount_position: tuple[float, float] = pair(
        (0.0, 0.0), 'm', -100.0, 100.0, "mount centre from the sweeper's base: forward, left")


@dataclass(frozen=True, kw_only=True)
class Mount(SceneSection):
    """How the mount may be carried, by cmd_mount."""

    enabled: bool = switch(
        False, 'whether all is ready for cmd_mount from the start, and mount_wrench_mean kept, '
        'which costs up to a fifth more time; without, what it needs is compiled when the first '
        'one comes. With run.carried, and where the commands of simulate have one, it is true')
    max_speed: float = number(20.0, 'm/s', 0.0, 1e3, 'a way that is faster is refused')
    max_rate: float = number(10.0, 'rad/s', 0.0, 1e3, 'and one that turns faster')
    max_acceleration: float = number(500.0, 'm/s^2', 1e-6, 1e6, 'or accelerates more')
    max_angular_acceleration: float = number(
        5000.0, 'rad/s^2', 1e-6, 1e8, 'or more so in turning')


@dataclass(frozen=True, kw_only=True)
class Solver(SceneSection):
    """Space and time discretisation."""

    load_case: Literal['inertia', 'displacement'] = choice(
        'inertia', 'solve in the brush frame, or move the clamp')
    elements: int = count(12, 1, 500, '3-node elements along a wire')
    time_step: float = number(
        0.0, 's', 0.0, 10.0, 'TS: loads are sampled at it, ramped between; 0: exact at every ITS')
    integration_time_step: float = number(1e-4, 's', 1e-8, 0.1, 'ITS: step of the integrator')
    integrator: Literal['generalized_alpha', 'newmark', 'hht'] = choice(
        'generalized_alpha', 'time integrator')
    spectral_radius: float = number(
        0.8, '1', 0.0, 1.0, 'of generalized_alpha, at infinite frequency; 0 annihilates, 1 keeps')
    amplitude_decay: float = number(0.005, '1', 0.0, 1.0 / 3.0, 'gamma of newmark and hht')
    newton: Literal['estimate', 'tolerance'] = choice(
        'estimate', "what the last correction is held to: a tenth of the step's local error, at "
        'most `tolerance`; or `tolerance`, as in logs of earlier versions')
    tolerance: float = number(
        1e-6, '1', 1e-14, 1e-2, "Newton's, relative to the element's length and to 1 rad; in "
        'steps below 0.2 ms it falls with their square. 1e-8 is never too much')
    step: Literal['fixed', 'adaptive'] = choice(
        'fixed', 'step control; marks are met by both. Fixed steps are halved too '
        'where Newton fails or their local error is above `largest_error`')
    error_tolerance: float = number(
        1e-3, '1', 1e-12, 1.0, "local error of adaptive steps, relative to the bristle's length; "
        'no step has more than 2e-4')
    largest_error: float = number(
        0.0, '1', 0.0, 2e-4, 'local error above which a fixed step is taken in up to 16 parts, '
        "relative to the bristle's length; 0: 2e-4, where the road is not level 5e-7")
    start: Literal['straight', 'steady'] = choice(
        'straight', 'straight and at rest, or from the static equilibrium')


@dataclass(frozen=True, kw_only=True)
class Run(SceneSection):
    """How the node runs the scene."""

    real_time_factor: float = number(
        1.0, '1', 0.0, 1e6, 'simulated seconds per second of wall time; 0: as fast as it goes')
    chunk: float = number(0.005, 's', 1e-8, 10.0, 'simulated time between commands and messages')
    sample: float = number(0.001, 's', 1e-8, 1e3, 'simulated time between logged samples')
    autostart: bool = switch(True, 'whether the node configures and activates itself')
    publish_clock: bool = switch(False, 'whether to publish /clock')
    time_origin: Literal['zero', 'wall'] = choice(
        'zero', 'what stamps count from: 0 or the start')
    frame_prefix: str = text('', 'goes before every frame_id, such as left/; empty: none')
    publish_tf: Literal['all', 'mount', 'none'] = choice(
        'all', 'transforms on /tf: road to brush_mount to brush, the first alone '
        '(robot_state_publisher gives the second), or none')
    marker_rate: float = number(
        20.0, 'Hz', 0.0, math.inf, 'most messages of bristle_markers per second of wall time, '
        'at chunk ends; 0: none')
    stamped_cmd_vel: bool = switch(True, 'cmd_vel is a TwistStamped; false: a Twist')
    command_timeout: float = number(
        0.0, 's', 0.0, 1e6, 'wall time without cmd_vel, or cmd_mount once there was one, after '
        'which the sweeper stops; 0: never')
    max_load: float = number(
        0.0, '1', 0.0, 1.0, 'share of a core that adaptive steps may take; 0: no budget')
    carried: bool = switch(
        False, 'lockstep: each chunk waits for the cmd_mount that is stamped with its end')


@dataclass(frozen=True, kw_only=True)
class Log(SceneSection):
    """Where the node's log goes."""

    path: str = text('', 'directory of the log, or a file when it ends in .mcap; empty: no log')
    compression: Literal['zstd', 'lz4', 'none'] = choice('zstd', 'of the log')
    max_size: float = number(
        0.0, 'MB', 0.0, 1e9, 'of a file of the log, before the next is begun; 0: one file')
    tf: bool = switch(True, 'whether the log has /tf, for each run.chunk, and robot_description')
