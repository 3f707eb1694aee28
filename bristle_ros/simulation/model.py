"""
From a Scene to the arrays that the kernels step: Models and State.

To the kernels each row of a brush is a brush of its own, with a Model of its own and its part of
the State; a brush of one row costs what it would without rows.
"""
from itertools import accumulate, pairwise
import math

from bristle_ros.physics.contact import (COLUMN, CONTACT, ContactLaw, MOST, POINT, TIP,
                                         WAVES, Wire)
from bristle_ros.physics.motion import (ADDED, APPROACHING, BASICS, CONSTANT, Drive, END, FORWARD,
                                        FRAME, HUB, Hub, LASTS, LEFT, MOVED, new_motion, SINE,
                                        SPEED, START, STARTED, TURNING, VAP)
from bristle_ros.physics.step import (AUDIT, BATCH, corner_factors, COUNTS, generalized_alpha, hht,
                                      Model, newmark, PARTS, Room, Scheme, Scratch, State, Turn)
from bristle_ros.physics.wire import (Air, BLOCK, block_count, chain_work, ELEMENTS, INERTIA,
                                      LANES, MASS, MIDS, Q, Q0, RECORD, ROWS, Section, WEIGHT, X,
                                      X0)
from bristle_ros.scene import (brush_rows, follows_mount, is_uneven, longest, Row, Scene,
                               SceneError, speed_table, start_speed, tip_depth)
import numpy as np
from numpy.typing import NDArray

from .surface import surface_of

SHEAR_CORRECTION = 5.0 / 6.0    # rectangle
CACHE_LINE = 64     # [bytes]
FILLER = 1e-30      # mass [kg] and inertia [kg m^2] of nodes that only fill the last block
# local error [bristle lengths] that no step may have, of fixed length or not: a motion that
# would be resolved worse can gain energy from nowhere (report's campaign: from 1e-3 on)
WORST_ERROR = 2e-4
# of fixed steps where the road is not level: wires meet it at any moment of a step, and what an
# impact is off by decides about the next one. Measured at 0.1 ms: impulses a tenth as far off, for
# 7 to 20 % more time
WORST_UNEVEN = 5e-7
HALVINGS = 4            # for the sake of that, at most: what rings within a step stays affordable
SAMPLES = 4             # parts of an element in which the nearest place to the road is looked for
MOST_SAMPLES = 32
PLACES = 1 << 14        # of the road at which heights of its waves are kept
NOWHERE = -(1 << 62)    # no place
PROFILES = {'constant': CONSTANT, 'sine': SINE, 'vap': VAP}


def torsion_constant(a: float, b: float) -> float:
    """
    Return St Venant's torsion constant of a rectangle with sides a, b [m], in m^4.

    Source: Timoshenko, Goodier, Theory of Elasticity, art. 109: the series in tanh.
    """
    long, short = max(a, b), min(a, b)
    total = sum(math.tanh(n * math.pi * long / (2.0 * short)) / n ** 5 for n in range(1, 40, 2))
    return long * short ** 3 / 3.0 * (1.0 - 192.0 * short / (math.pi ** 5 * long) * total)


def section_of(scene: Scene, length: float) -> Section:
    """Return the Section of a bristle of that length [m]: y along the breadth, z the width."""
    b = scene.bristle
    area = b.breadth * b.width
    shear_modulus = b.youngs_modulus / (2.0 * (1.0 + b.poissons_ratio))
    shear = SHEAR_CORRECTION * shear_modulus * area
    return Section(
        axial=b.youngs_modulus * area, shear_y=shear, shear_z=shear,
        torsion=shear_modulus * torsion_constant(b.breadth, b.width),
        bending_y=b.youngs_modulus * b.breadth * b.width ** 3 / 12.0,
        bending_z=b.youngs_modulus * b.width * b.breadth ** 3 / 12.0,
        element_length=length / scene.solver.elements)


def scheme_of(scene: Scene) -> Scheme:
    """Return the integrator's coefficients."""
    solver = scene.solver
    tied = solver.newton == 'estimate'
    if solver.integrator == 'generalized_alpha':
        return generalized_alpha(solver.spectral_radius, solver.tolerance, tied)
    make = newmark if solver.integrator == 'newmark' else hht
    return make(solver.amplitude_decay, solver.tolerance, tied)


def local_error_of(scene: Scene, tolerance: float, length: float) -> float:
    """
    Return the local error [m] that a step of a bristle of that length [m] may have.

    tolerance : float    that of adaptive steps
    """
    if scene.solver.step != 'adaptive':
        uneven = scene.contact.enabled and is_uneven(scene.gutter, scene.profile)
        tolerance = scene.solver.largest_error or (WORST_UNEVEN if uneven else WORST_ERROR)
    return min(tolerance, WORST_ERROR) * length


def halved_to(scene: Scene) -> float:
    """Return the step [s] that has its local error, if it is not worse than any may be."""
    if scene.solver.step == 'adaptive':
        return 0.0
    return 1.5 * scene.solver.integration_time_step / (1 << HALVINGS)


def contact_law(scene: Scene) -> ContactLaw | None:
    """Return the ContactLaw, or None where the scene has no contact."""
    if not scene.contact.enabled:
        return None
    stiffness = scene.contact.normal_stiffness
    return ContactLaw(0.0 if math.isinf(stiffness) else stiffness, scene.contact.damping,
                      scene.friction.static, scene.friction.kinetic, scene.friction.decay,
                      surface_of(scene), wire_of(scene),
                      older=scene.solver.newton == 'tolerance')


def wire_of(scene: Scene) -> Wire | None:
    """Return how contact is looked for along the wire, or None where the tip alone touches."""
    if not touches_anywhere(scene):
        return None
    profile, parts = scene.profile, SAMPLES
    waves = {'sine': profile.wavelength, 'iso8608': profile.shortest}
    if profile.kind in waves:   # a minimum between two places that are looked at is not missed
        element = longest(scene) / scene.solver.elements
        parts = max(parts, min(math.ceil(SAMPLES * element / waves[profile.kind]), MOST_SAMPLES))
    return Wire(parts)


def touches_anywhere(scene: Scene) -> bool:
    """Return whether the road may touch the wire anywhere, not the tip alone."""
    return scene.contact.enabled and scene.contact.points == 'wire'


def air_of(scene: Scene) -> Air | None:
    """Return the Air, or None where the scene has none."""
    if scene.air.density == 0.0 or scene.air.drag_coefficient == 0.0:
        return None
    b = scene.bristle
    half = 0.5 * scene.air.density * scene.air.drag_coefficient / b.density
    return Air(half / b.width, half / b.breadth)


def viscosity_of(scene: Scene) -> float | None:
    """Return beta_D [s], or None where it is zero."""
    return scene.damping.stiffness or None


def gravity_of(scene: Scene) -> tuple[float, float, float]:
    """
    Return gravity in road axes [m/s^2]: a climbing road tilts it backwards.

    Pitch by the grade, then roll by the cross slope: up is (sin a, cos a sin b, cos a cos b).
    """
    a, b = scene.road.grade, scene.road.cross_slope
    return (-scene.gravity * math.sin(a), -scene.gravity * math.cos(a) * math.sin(b),
            -scene.gravity * (math.cos(a) * math.cos(b)))


def drive_of(scene: Scene, time_step: float) -> Drive:
    """Return the Drive with load steps of `time_step` [s]."""
    d, road = scene.drive, scene.road
    x, y = scene.sweeper.mount_position
    profile = PROFILES[d.profile] if d.alternating_speed else CONSTANT
    table = speed_table(d) if d.profile == 'table' else None
    return Drive(
        profile, d.alternating_speed, d.frequency, d.shape, scene.brush.start_angle,
        math.cos(road.attack_angle), math.sin(road.attack_angle), road.tilt_azimuth,
        *gravity_of(scene), tip_depth(scene), road.penetration, road.approach_time, x, y,
        time_step, scene.gutter.approach if scene.gutter.enabled else 0.0, table, hub_of(scene),
        True if follows_mount(scene) else None)


def ready_to_carry(model: Model) -> Model:
    """Return a Model whose mount may be carried, with all else as it is."""
    return model._replace(drive=model.drive._replace(carrier=True),
                          exact=model.exact._replace(carrier=True))


def hub_of(scene: Scene) -> Hub | None:
    """Return the Hub, or None where the speed is given."""
    d, b = scene.drive, scene.bristle
    if d.mode == 'speed':
        return None
    wires = 0.0
    for row in brush_rows(scene):   # a rod from radius r to R: (r^2 + r R + R^2) / 3
        mean = (row.radius ** 2 + row.radius * row.tip_radius + row.tip_radius ** 2) / 3.0
        wires += row.count * row.length * mean
    wires *= scene.brush.wires_per_bristle * b.density * b.breadth * b.width
    rated = d.rated_speed if d.mode == 'motor' else 0.0
    return Hub(d.inertia, d.loss, d.stall_torque, rated, wires)


def clamp_of(row: Row) -> NDArray[np.float64]:
    """Return position and quaternion (w, x, y, z) of the clamp in the bristle's own axes: (7,)."""
    phi, gamma = row.angle, row.orientation
    # x to (sin phi, 0, -cos phi) with y kept: a turn about y by pi/2 - phi; then gamma about x
    tilt = 0.5 * (math.pi / 2.0 - phi)
    lean = np.array([math.cos(tilt), 0.0, math.sin(tilt), 0.0])
    c, s = math.cos(0.5 * gamma), math.sin(0.5 * gamma)
    quaternion = np.array([c * lean[0], s * lean[0], c * lean[2], -s * lean[2]])
    return np.concatenate(([row.radius, 0.0, 0.0], quaternion))


def _axes(q: NDArray[np.float64]) -> NDArray[np.float64]:
    """Return the rotation matrix of a unit quaternion w, x, y, z: its columns are section axes."""
    twice = 2.0 * np.cross(q[1:], np.eye(3))
    matrix: NDArray[np.float64] = np.eye(3) + q[0] * twice + np.cross(q[1:], twice)
    return matrix.T


def build_models(scene: Scene) -> tuple[Model, ...]:
    """Return the Models of a scene, one for each row of its brush."""
    return tuple(build_model(scene, row) for row in brush_rows(scene))


def build_model(scene: Scene, row: Row | None = None) -> Model:
    """Return the Model of a row of a scene's brush, by default of the first one."""
    row = row or brush_rows(scene)[0]
    angles = np.array(row.azimuths)
    azimuth = np.column_stack((np.cos(angles), np.sin(angles), np.cos(angles / 2.0),
                               np.sin(angles / 2.0)))
    clamp = clamp_of(row)
    # of the two quaternions of each azimuth the one with which the tip's own starts with w >= 0
    azimuth[azimuth[:, 2] * clamp[3] - azimuth[:, 3] * clamp[6] < 0.0, 2:] *= -1.0
    section = section_of(scene, row.length)
    b = scene.bristle
    return Model(
        scene.solver.elements, block_count(scene.solver.elements), row.count,
        scene.solver.integration_time_step, section, scheme_of(scene),
        drive_of(scene, scene.solver.time_step), drive_of(scene, 0.0), scene.damping.mass, azimuth,
        clamp, corner_factors(b.breadth, b.width, _axes(clamp[3:])),
        b.density * b.breadth * b.width * section.element_length / 6.0,
        float(scene.brush.wires_per_bristle), scene.solver.load_case == 'displacement',
        local_error_of(scene, scene.solver.error_tolerance, row.length), halved_to(scene),
        WORST_ERROR * row.length, air_of(scene))


def _aligned(*shape: int) -> NDArray[np.float64]:
    """
    Return zeros of a shape whose first byte is at a multiple of CACHE_LINE.

    numpy gives 16: a vector of eight numbers then lies across two cache lines at each access.
    """
    size = math.prod(shape)
    room = np.zeros(size + CACHE_LINE // 8)
    first = -room.ctypes.data % CACHE_LINE // 8
    return room[first:first + size].reshape(shape)


def new_room(model: Model, places: int = 0) -> Room:
    """
    Return the room in which the contact of several points is worked out.

    places : int    of the road at which heights are kept, a power of two, or 0
    """
    most, elements = min(model.elements + 1, MOST), model.elements
    return Room(
        np.zeros(most, np.int64), np.zeros(1, np.int64), np.zeros(most, np.int64),
        np.zeros((most, 3)), np.zeros((most, 3)), np.zeros((most, most, 9)),
        _aligned(most, 3, model.blocks, COLUMN), _aligned(model.blocks, BLOCK),
        np.zeros((most, CONTACT)), np.zeros((most, 3)), np.zeros(1),
        np.zeros((2 * elements + 1, 3)),
        np.zeros((2 * elements + 1, 3)), np.zeros(elements, np.int64),
        np.zeros((elements, POINT)), np.full(places, NOWHERE), np.zeros(places))


def new_scratch(model: Model, law: ContactLaw | None = None) -> Scratch:
    """
    Return the room that kernels work in; threads that share a queue share one's table.

    law : ContactLaw, or None where only what the contact does not need is called for
    """
    wire = law is not None and law.wire is not None
    profile = law.surface.profile if law is not None and law.surface is not None else None
    places = PLACES if profile is not None and profile.kind == WAVES else 0
    return Scratch(_aligned(chain_work().size), np.zeros((9, 16)), np.zeros((3, FRAME)),
                   np.zeros(FRAME), np.zeros((2, FRAME)), np.zeros((2, BASICS)),
                   np.zeros((BATCH * PARTS + 1, FRAME)), np.zeros(BATCH * PARTS + 1, np.int64),
                   _aligned(model.blocks, BLOCK),
                   np.zeros(TIP), np.zeros((model.elements if wire else 0, POINT)),
                   np.zeros(AUDIT), np.zeros((2 * BATCH + 1, FRAME)), np.zeros(3, np.int64),
                   new_room(model, places) if wire else None)


def straight_nodes(scene: Scene, row: Row, model: Model) -> NDArray[np.float64]:
    """Return the node array of one straight bristle at rest: (blocks, BLOCK), see layout.py."""
    nodes = np.zeros((model.blocks, ROWS, LANES))
    nodes[:, Q] = nodes[:, Q0] = 1.0
    # fillers: next to nothing, so that no sum over lanes has to know of them
    nodes[:, MASS] = FILLER
    nodes[:, INERTIA:INERTIA + 3] = FILLER
    b = scene.bristle
    length = model.section.element_length
    mass = b.density * b.breadth * b.width * length
    about_y = b.density * b.breadth * b.width ** 3 / 12.0 * length
    about_z = b.density * b.width * b.breadth ** 3 / 12.0 * length
    inertia = np.array([about_y + about_z, about_y, about_z])
    phi = row.angle
    along = np.array([math.sin(phi), 0.0, -math.cos(phi)])
    for element in range(model.elements):
        block, lane = divmod(element, ELEMENTS)
        tip = element == model.elements - 1
        for column, share, distance in (
                (lane, 4.0 / 6.0, element + 0.5),
                (ELEMENTS + lane, 1.0 / 6.0 if tip else 2.0 / 6.0, element + 1.0)):
            nodes[block, X:X + 3, column] = model.clamp[:3] + distance * length * along
            nodes[block, Q:Q + 4, column] = model.clamp[3:]
            nodes[block, MASS, column] = share * mass
            nodes[block, INERTIA:INERTIA + 3, column] = share * inertia
        nodes[block, WEIGHT, [lane, ELEMENTS + lane]] = 0.5 * length
    nodes[:, X0:X0 + 7] = nodes[:, X:X + 7]
    return nodes.reshape(model.blocks, BLOCK)


def start_motion(scene: Scene) -> NDArray[np.float64]:
    """Return the ramps at the start: mean speed, the sweeper's velocity, the approach."""
    motion = new_motion()
    motion[SPEED + 1:SPEED + 3] = scene.drive.mean_speed
    for at, value in zip((FORWARD, LEFT), scene.sweeper.velocity):
        motion[at + 1:at + 3] = value
    motion[APPROACHING] = 1.0
    motion[MOVED:MOVED + 2] = scene.sweeper.mount_position
    if scene.gutter.enabled and scene.road.approach_time > 0.0:
        motion[MOVED + 1] -= scene.gutter.approach
    hub = hub_of(scene)
    if hub is not None:
        its, speed = scene.solver.integration_time_step, start_speed(scene.drive)
        record = motion[TURNING:]
        record[STARTED], record[LASTS], record[ADDED] = -its, its, hub.wires
        record[START + 1] = record[END + 1] = speed
        record[END] = scene.brush.start_angle
        record[START] = record[END] - its * speed
    return motion


def turn_nodes(state: State, angle: float) -> None:
    """Turn all nodes of a state about the brush axis by `angle` [rad], in place."""
    rows = state.nodes.reshape(-1, ROWS, LANES)
    c, s = math.cos(angle), math.sin(angle)
    x, y = rows[:, X].copy(), rows[:, X + 1].copy()
    rows[:, X], rows[:, X + 1] = c * x - s * y, s * x + c * y
    c, s = math.cos(0.5 * angle), math.sin(0.5 * angle)
    w, i, j, k = (rows[:, Q + row].copy() for row in range(4))
    rows[:, Q], rows[:, Q + 1], rows[:, Q + 2], rows[:, Q + 3] = (
        c * w - s * k, c * i - s * j, c * j + s * i, c * k + s * w)
    rows[:, X0:X0 + 7] = rows[:, X:X + 7]


def build_state(scene: Scene, *models: Model) -> State:
    """
    Return the State before the start: straight, at theta = 0, accelerations not filled yet.

    models : Model    of all rows of the scene's brush, or of its first ones
    """
    bristles, blocks = sum(model.bristles for model in models), models[0].blocks
    state = State(
        _aligned(bristles, blocks, BLOCK), _aligned(bristles, blocks, MIDS),
        _aligned(bristles, models[0].elements, RECORD),
        np.zeros((bristles, TIP)),
        np.zeros((bristles, models[0].elements if touches_anywhere(scene) else 0, POINT)),
        np.zeros((bristles, COUNTS), np.int64),
        start_motion(scene), np.zeros(1, np.int64), np.zeros((bristles, AUDIT)))
    for row, model, part in zip(brush_rows(scene), models, states_of(state, models)):
        part.nodes[...] = straight_nodes(scene, row, model)
    return state


def new_turn(state: State) -> Turn:
    """Return the room for a step of a brush whose drive feels its load to be made again."""
    kept = state._replace(
        nodes=_aligned(*state.nodes.shape), tip=np.zeros_like(state.tip),
        points=np.zeros_like(state.points), counts=np.zeros_like(state.counts),
        audit=np.zeros_like(state.audit))
    return Turn(np.zeros(HUB), np.zeros(len(state.nodes)), kept)


def rows_of(models: tuple[Model, ...]) -> list[slice]:
    """Return which bristles each of the models has."""
    ends = accumulate((model.bristles for model in models), initial=0)
    return [slice(first, end) for first, end in pairwise(ends)]


def states_of(state: State, models: tuple[Model, ...]) -> tuple[State, ...]:
    """Return each model's part of a State: the same memory; motion and step are common."""
    return tuple(state._replace(
        **{name: getattr(state, name)[part]
           for name in ('nodes', 'mids', 'chain', 'tip', 'points', 'counts', 'audit')})
        for part in rows_of(models))


def check_start(scene: Scene, gaps: NDArray[np.float64]) -> None:
    """Raise SceneError where a tip starts inside the road; gaps [m] : (B,)."""
    lowest = int(np.argmin(gaps))
    if scene.contact.enabled and gaps[lowest] < -1e-12:
        raise SceneError(
            f'bristle {lowest} would start {-gaps[lowest]:.3g} m inside the road: give '
            'road.approach_time > 0, a smaller penetration or another brush.start_angle',
            key='road.penetration', value=scene.road.penetration)
