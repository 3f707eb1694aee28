"""Beams made node by node, and what the kernels say about them, in plain arrays."""
from bristle_ros.physics.motion import CLAMP, FRAME
from bristle_ros.physics.step.equilibrium import settle
from bristle_ros.physics.wire import layout
from bristle_ros.physics.wire.beam import internal_forces, stiffness
from bristle_ros.scene.scene import Scene
from bristle_ros.scene.sections import Bristle, Brush, Contact, Damping, Drive, Solver
from bristle_ros.simulation.model import build_model, build_state, new_scratch
import numpy as np


def product(a, b):
    """Return the product of two quaternions w, x, y, z."""
    return np.concatenate(([a[0] * b[0] - a[1:] @ b[1:]],
                           a[0] * b[1:] + b[0] * a[1:] + np.cross(a[1:], b[1:])))


def turn(vector):
    """Return the quaternion of a rotation vector."""
    angle = np.linalg.norm(vector)
    return np.concatenate(([np.cos(angle / 2.0)],
                           np.sinc(angle / (2.0 * np.pi)) / 2.0 * np.asarray(vector)))


def matrix(q):
    """Return the rotation matrix of a unit quaternion."""
    w, x, y, z = q
    return np.array([[1 - 2 * (y * y + z * z), 2 * (x * y - w * z), 2 * (x * z + w * y)],
                     [2 * (x * y + w * z), 1 - 2 * (x * x + z * z), 2 * (y * z - w * x)],
                     [2 * (x * z - w * y), 2 * (y * z + w * x), 1 - 2 * (x * x + y * y)]])


class Beam:
    """
    Nodes of one bristle in the layout of the kernels.

    nodes : list of (position (3,), quaternion (4,)), the clamped one first; two for each element
    """

    def __init__(self, nodes, section):
        self.elements = (len(nodes) - 1) // 2
        self.blocks = layout.block_count(self.elements)
        self.section = section
        self.s = np.zeros((self.blocks, layout.BLOCK))
        self.rows = self.s.reshape(self.blocks, layout.ROWS, layout.LANES)
        self.rows[:, layout.Q] = self.rows[:, layout.Q0] = 1.0
        self.rows[:, layout.MASS] = self.rows[:, layout.INERTIA:layout.INERTIA + 3] = 1.0
        for element in range(self.elements):
            block, lane = divmod(element, layout.ELEMENTS)
            self.rows[block, layout.WEIGHT, [lane, layout.ELEMENTS + lane]] = (
                0.5 * section.element_length)
        self.place(nodes)

    def place(self, nodes):
        """Move the nodes and evaluate the internal forces."""
        self.nodes = list(nodes)
        for n in range(1, len(nodes)):
            self.put(n, nodes[n])
        self.evaluate()

    def put(self, node, value):
        """Move one node to (position, quaternion)."""
        self.nodes[node] = value
        self.at(node, layout.X, 3)[:], self.at(node, layout.Q, 4)[:] = value

    def evaluate(self):
        """Evaluate strains and internal forces."""
        internal_forces(self.s, self.blocks, np.concatenate(self.nodes[0]), self.section, 1.0, 0.0)

    def at(self, node, row, count):
        """Return `count` rows of a node (1 is the first mid node)."""
        element, corner = divmod(node - 1, 2)
        block, lane = divmod(element, layout.ELEMENTS)
        return self.rows[block, row:row + count, lane + layout.ELEMENTS * corner]

    def points(self, row, count=6):
        """Return rows of the Gauss points that count: (2 * elements, count)."""
        used = self.rows[:, layout.WEIGHT] > 0.0
        return np.moveaxis(self.rows[:, row:row + count], 1, 2)[used]

    def energy(self):
        """Return the strain energy [J]."""
        density = 0.5 * self.points(layout.STRAIN) ** 2 @ np.array(stiffness(self.section))
        return 0.5 * self.section.element_length * density.sum()

    def forces(self, axes=None):
        """Return internal force and moment of the nodes but the clamp, in their axes: (2 E, 6)."""
        result = []
        for n in range(1, len(self.nodes)):
            q = self.at(n, layout.Q, 4)
            turned = matrix(q) if axes is None else axes[n - 1]
            moment = product(q * [1, -1, -1, -1], self.at(n, layout.TORQUE, 4))[1:]
            result.append(np.concatenate((turned.T @ self.at(n, layout.NODE_FORCE, 3), moment)))
        return np.array(result)


def derivative(beam, function, step=1e-6):
    """Return the central difference of function() by each node's increment in its own axes."""
    columns = []
    for node in range(1, len(beam.nodes)):
        x, q = beam.nodes[node]
        axes = matrix(q)
        for i in range(6):
            sides = []
            for change in (step * np.eye(6)[i], -step * np.eye(6)[i]):
                beam.put(node, (x + axes @ change[:3], product(q, turn(change[3:]))))
                beam.evaluate()
                sides.append(function())
            columns.append((sides[0] - sides[1]) / (2.0 * step))
        beam.put(node, (x, q))
    beam.evaluate()
    return np.array(columns).T


def scene_along_x(elements=12, speed=0.0, orientation=0.0, tolerance=1e-12, **bristle):
    """Return the scene of a wire that lies along x, its weak axis y (orientation 0)."""
    return Scene(
        bristle=Bristle(**bristle),
        brush=Brush(mount_radius=0.0, mount_angle=np.pi / 2.0, mount_orientation=orientation),
        contact=Contact(enabled=False), damping=Damping(mass=0.0, stiffness=0.0),
        gravity=0.0, drive=Drive(profile='constant', mean_speed=speed),
        solver=Solver(elements=elements, tolerance=tolerance))


class Cantilever:
    """A wire along x that settles under a load at its tip."""

    def __init__(self, scene):
        self.model = build_model(scene)
        self.state = build_state(scene, self.model)
        self.scratch = new_scratch(self.model)
        self.s = self.state.nodes[0]
        self.rows = self.s.reshape(self.model.blocks, layout.ROWS, layout.LANES)

    def settle(self, load, spin=(0.0, 0.0, 0.0)):
        """Return position and quaternion of the tip in equilibrium; load (6,) as in `settle`."""
        frame = np.zeros(FRAME)
        frame[[0, 4, 8]] = 1.0
        frame[9:12] = spin
        frame[CLAMP:CLAMP + 7] = self.model.clamp
        self.frame = frame
        status = settle(self.model, None, self.state, 0, frame, np.asarray(load, float),
                        self.scratch)
        assert status == 0
        block, lane = layout.tip_lane(self.model.elements)
        return self.rows[block, layout.X:layout.X + 3, lane], (
            self.rows[block, layout.Q:layout.Q + 4, lane])
