"""
The scenes S1 to S5 in exudyn: its geometrically exact beam, solved in the rotating frame.

What exudyn's beam lacks is added as its documentation shows: frame forces, gravity and the contact
law as one user function with its Jacobian over all nodes, beta_D as dampers between nodes.
The clamp is fixed; a generalised-alpha method with spectral radius 0.6 steps it.
"""
from contextlib import redirect_stdout
import io
from itertools import pairwise
import math
import time

import numpy as np

from .scenes import BREADTH, E, LENGTH, NU, RHO, TORSION, WIDTH

SPECTRAL_RADIUS = 0.6


def version():
    """Return exudyn's version, or None where it is not installed."""
    try:
        import exudyn
    except ImportError:
        return None
    return exudyn.__version__


def _rotation_vector(matrix):
    """Return the rotation vector of a rotation matrix."""
    angle = math.acos(max(-1.0, min(1.0, 0.5 * (np.trace(matrix) - 1.0))))
    if angle < 1e-12:
        return np.zeros(3)
    axis = np.array([matrix[2, 1] - matrix[1, 2], matrix[0, 2] - matrix[2, 0],
                     matrix[1, 0] - matrix[0, 1]])
    return axis * (0.5 * angle / math.sin(angle))


def _about_z(angle):
    c, s = math.cos(angle), math.sin(angle)
    return np.array([[c, -s, 0.0], [s, c, 0.0], [0.0, 0.0, 1.0]])


def solve(scene, elements, step, *, sample=1e-3):
    """
    Solve a PeerScene; return (t, tip path in the brush frame, normal impulse [N s], wall [s]).

    elements : int, 2-node elements;  step, sample : [s]
    Raises RuntimeError where exudyn stops early. Wall time is the solver's alone.
    """
    # At zero rotation its rotation-vector nodes lose digits and Newton stalls: turn S1 about z.
    aside = _about_z(0.0 if scene.mean else 0.5)
    mbs, sensors, *kept = _model(scene, elements, aside)     # kept: alive while it solves
    settings = _settings(scene, elements, step, sample)
    began = time.perf_counter()
    try:
        with redirect_stdout(io.StringIO()):    # it prints where it fails
            mbs.SolveDynamic(settings)
    except Exception as error:  # its SolverError is no subclass of anything named
        raise RuntimeError(f'exudyn: {error}') from None
    wall = time.perf_counter() - began
    del kept
    data, velocity = (np.array(mbs.GetSensorStoredData(sensor)) for sensor in sensors)
    impulse = 0.0
    if scene.by_impulse:
        normal = [float(scene.forces(row[0], row[None, 1:4], rate[None, 1:4])[1][0])
                  for row, rate in zip(data, velocity)]
        impulse = float(np.trapezoid(normal, data[:, 0]))
    return data[:, 0], data[:, 1:4] @ aside, impulse, wall


def _model(scene, elements, aside):
    """
    Return the assembled system, sensors of the tip's position and velocity, and what these need.

    aside : (3, 3)    by which everything is turned
    """
    import exudyn
    from exudyn import itemInterface as items  # noqa: N813

    container = exudyn.SystemContainer()
    mbs = container.AddSystem()
    h = LENGTH / elements
    along, across = aside @ scene.along, aside @ scene.across
    turn = _rotation_vector(np.column_stack([along, across, np.cross(along, across)]))
    start = [np.array(scene.clamp) + i * h * along for i in range(elements + 1)]
    nodes = [mbs.AddNode(items.NodeRigidBodyRotVecLG(
        referenceCoordinates=[*position, *turn])) for position in start]
    _add_beam(mbs, items, nodes, h, scene.damping)
    mass = np.full(elements + 1, RHO * BREADTH * WIDTH * h)
    mass[[0, -1]] *= 0.5
    loads = _Loads(scene, np.array(start), mass)
    size = 6 * (elements + 1)
    mbs.AddObject(items.ObjectGenericODE2(
        nodeNumbers=nodes, massMatrix=np.zeros((size, size)),
        stiffnessMatrix=np.zeros((size, size)), dampingMatrix=np.zeros((size, size)),
        forceVector=np.zeros(size), forceUserFunction=loads.force,
        jacobianUserFunction=loads.jacobian))
    sensors = [mbs.AddSensor(items.SensorNode(
        nodeNumber=nodes[-1], storeInternal=True, outputVariableType=what)) for what in (
            exudyn.OutputVariableType.Position, exudyn.OutputVariableType.Velocity)]
    mbs.Assemble()
    return mbs, sensors, container, loads


def _add_beam(mbs, items, nodes, h, damping):
    """Add the wire's elements, its clamp, and dampers of beta_D [s]."""
    import exudyn
    area, weak, strong = BREADTH * WIDTH, BREADTH * WIDTH ** 3 / 12, WIDTH * BREADTH ** 3 / 12
    shear = 5.0 / 6.0 * E / (2.0 * (1.0 + NU)) * area
    section = exudyn.BeamSection()
    section.massPerLength = RHO * area
    section.inertia = np.diag([RHO * (weak + strong), RHO * weak, RHO * strong])
    stiffness = [E * area, shear, shear, E / (2.0 * (1.0 + NU)) * TORSION, E * weak, E * strong]
    section.stiffnessMatrix = np.diag(stiffness)
    for left, right in pairwise(nodes):
        mbs.AddObject(items.ObjectBeamGeometricallyExact(
            nodeNumbers=[left, right], length=h, sectionData=section))
    ground = mbs.AddNode(items.NodePointGround())
    fixed = mbs.AddMarker(items.MarkerNodeCoordinate(nodeNumber=ground, coordinate=0))
    for coordinate in range(6):
        clamp = mbs.AddMarker(items.MarkerNodeCoordinate(nodeNumber=nodes[0],
                                                         coordinate=coordinate))
        mbs.AddObject(items.ObjectConnectorCoordinate(markerNumbers=[fixed, clamp]))
    if damping:
        _add_dampers(mbs, items, nodes, h, damping, stiffness)


def _settings(scene, elements, step, sample):
    """Return exudyn's settings of a run."""
    import exudyn
    settings = exudyn.SimulationSettings()
    integration = settings.timeIntegration
    integration.numberOfSteps = round(scene.duration / step)
    integration.endTime = scene.duration
    integration.generalizedAlpha.spectralRadius = SPECTRAL_RADIUS
    integration.newton.relativeTolerance = 1e-8
    integration.newton.absoluteTolerance = 1e-7     # of a residual that rounds off at 1e-9 N
    integration.newton.useModifiedNewton = True
    integration.adaptiveStep = scene.contact     # without it impacts stop the Newton iteration
    integration.verboseMode = 0
    settings.solution.file.write = False
    settings.solution.sensors.writePeriod = step if scene.by_impulse else max(sample, step)
    settings.linearSolver.solverType = exudyn.LinearSolverType.EXUdense if elements <= 24 else (
        exudyn.LinearSolverType.EigenSparse)
    return settings


def _add_dampers(mbs, items, nodes, h, beta, stiffness):
    """Add beta times the section stiffness as dampers: rotations, and along the chord."""
    for left, right in pairwise(nodes):
        both = [mbs.AddMarker(items.MarkerNodeRigid(nodeNumber=node)) for node in (left, right)]
        mbs.AddObject(items.ObjectConnectorRigidBodySpringDamper(
            markerNumbers=both, stiffness=np.zeros((6, 6)),
            damping=np.diag([0.0, 0.0, 0.0, *(beta / h * np.array(stiffness[3:]))])))
        ends = [mbs.AddMarker(items.MarkerNodePosition(nodeNumber=node)) for node in (left, right)]
        mbs.AddObject(items.ObjectConnectorSpringDamper(
            markerNumbers=ends, referenceLength=h, stiffness=0.0,
            damping=beta * stiffness[0] / h))


class _Loads:
    """Frame forces, gravity, alpha_D and the contact law on all nodes, and their Jacobian."""

    def __init__(self, scene, start, mass):
        self.scene, self.start, self.mass = scene, start, mass
        self._field = math.nan, None
        count = len(mass)
        self.size = 6 * count

    def _at(self, t):
        # the same for all iterations of a step
        if self._field[0] != t:
            self._field = t, self.scene.field(t)
        return self._field[1]

    def force(self, mbs, t, item, q, v):
        q, v = np.asarray(q), np.asarray(v)
        position = self.start + q.reshape(-1, 6)[:, :3]
        velocity = v.reshape(-1, 6)[:, :3]
        field, by_position, by_velocity = self._at(t)
        f = np.zeros((len(self.mass), 6))
        f[:, :3] = self.mass[:, None] * (field + position @ by_position.T
                                         + velocity @ by_velocity.T)
        if self.scene.contact:
            touch = self.scene.touching
            f[touch, :3] += self.scene.forces(t, position[touch], velocity[touch])[0]
        return f.ravel()

    def jacobian(self, mbs, t, item, q, v, by_q, by_v):
        _, by_position, by_velocity = self._at(t)
        small = -(by_q * by_position + by_v * by_velocity)   # of the left-hand side
        full = np.zeros((self.size, self.size))
        count = len(self.mass)
        blocks = full.reshape(count, 6, count, 6)
        index = np.arange(count)
        blocks[index, :3, index, :3] = self.mass[:, None, None] * small
        if self.scene.contact:
            self._add_contact(blocks, t, np.asarray(q), np.asarray(v), by_q, by_v)
        return full

    def _add_contact(self, blocks, t, q, v, by_q, by_v):
        """Take the contact's derivatives, by differences, from the diagonal blocks."""
        touch = self.scene.touching
        position = (self.start + q.reshape(-1, 6)[:, :3])[touch]
        velocity = v.reshape(-1, 6)[touch, :3]
        here, _ = self.scene.forces(t, position, velocity)
        if not here.any():
            return
        index = np.arange(len(self.mass))[touch]
        for k in range(3):
            dx, dv = np.zeros(3), np.zeros(3)
            dx[k], dv[k] = 1e-9, 1e-6
            column = by_q * (self.scene.forces(t, position + dx, velocity)[0] - here) / 1e-9
            column += by_v * (self.scene.forces(t, position, velocity + dv)[0] - here) / 1e-6
            blocks[index, :3, index, k] -= column
