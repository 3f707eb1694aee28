"""
Mechanics of a wire on a moving brush, written a second time: in numpy, in the road's axes.

Nothing here is taken from the kernels but where their arrays hold what. Derivatives are those of
complex steps, f'(x) = Im f(x + i e) / e: exact, so that a comparison may be as sharp as round-off.
"""
from bristle_ros.physics.contact.tip import FORCE, GAP, SLIP_MOVED, STATE
from bristle_ros.physics.wire import layout
import numpy as np

STEP = 1e-30
GAUSS = 1.0 / np.sqrt(3.0)


def about_z(angle):
    """Return the rotation about z, of a complex angle too."""
    c, s, o = np.cos(angle), np.sin(angle), 0.0 * angle
    return np.array([[c, -s, o], [s, c, o], [o, o, 1.0 + o]])


def about_y(angle):
    c, s = np.cos(angle), np.sin(angle)
    return np.array([[c, 0.0, s], [0.0, 1.0, 0.0], [-s, 0.0, c]])


def slope(function, t):
    """Return the derivative of a function of time at t."""
    return np.imag(function(t + 1j * STEP)) / STEP


def bend(function, t, h=1e-5):
    """Return the second derivative, fourth-order differences of the first one."""
    return (8.0 * (slope(function, t + h) - slope(function, t - h))
            - (slope(function, t + 2 * h) - slope(function, t - 2 * h))) / (12.0 * h)


def axial(matrix):
    return np.array([matrix[2, 1] - matrix[1, 2], matrix[0, 2] - matrix[2, 0],
                     matrix[1, 0] - matrix[0, 1]]) / 2.0


class Ride:
    """
    Where the brush is at time t after commands at 0: closed forms, analytic in t.

    speed, forward, left, yaw, depth : (value, rate)    linear in time
    """

    def __init__(self, scene, speed, forward, left, yaw, depth, tip_depth):
        self.scene, self.yaw = scene, yaw
        self.speed, self.forward, self.left = speed, forward, left
        self.depth, self.tip_depth = depth, tip_depth

    def theta(self, t):
        """Return the angle of the brush, eq. (5) of the paper with its ramp."""
        drive = self.scene.drive
        w = 2.0 * np.pi * drive.frequency
        swing = drive.alternating_speed / w * (1.0 - np.cos(w * t))
        return (self.scene.brush.start_angle + self.speed[0] * t + 0.5 * self.speed[1] * t * t
                + swing)

    def mount(self, t):
        """Return the rotation from mount to road axes."""
        road = self.scene.road
        heading = self.yaw[0] * t + 0.5 * self.yaw[1] * t * t
        return (about_z(heading) @ about_z(road.tilt_azimuth) @ about_y(road.attack_angle)
                @ about_z(-road.tilt_azimuth))

    def velocity(self, t):
        """Return that of the mount centre, road axes."""
        x, y = self.scene.sweeper.mount_position
        yaw = self.yaw[0] + self.yaw[1] * t
        heading = self.yaw[0] * t + 0.5 * self.yaw[1] * t * t
        return about_z(heading) @ np.array([
            self.forward[0] + self.forward[1] * t - yaw * y,
            self.left[0] + self.left[1] * t + yaw * x, 0.0 * t])

    def height(self, t):
        """Return that of the mount centre over the road."""
        return self.tip_depth - self.depth[0] - self.depth[1] * t

    def axes(self, t, azimuth, displacement):
        """Return the rotation to road axes from those in which a bristle is solved."""
        turned = azimuth if displacement else self.theta(t) + azimuth
        return self.mount(t) @ about_z(turned)


def nodes_of(simulation, bristle):
    """Return a function of (row, count): these rows of the nodes from clamp to tip, (N, count)."""
    model = simulation.model
    rows = simulation.state.nodes[bristle].reshape(model.blocks, layout.ROWS, layout.LANES).copy()
    element = np.arange(model.elements)
    block, lane = element // layout.ELEMENTS, element % layout.ELEMENTS

    def of_nodes(row, count):
        both = np.stack((rows[block, row:row + count, lane],
                         rows[block, row:row + count, layout.ELEMENTS + lane]), axis=1)
        return both.reshape(-1, count)
    return of_nodes     # mid and end of each element; at Gauss points first and second


def conjugate(q):
    return q * [1.0, -1.0, -1.0, -1.0]


def product(p, q):
    """Return products of quaternions (..., 4) w, x, y, z."""
    w = p[..., :1] * q[..., :1] - (p[..., 1:] * q[..., 1:]).sum(axis=-1, keepdims=True)
    v = p[..., :1] * q[..., 1:] + q[..., :1] * p[..., 1:] + np.cross(p[..., 1:], q[..., 1:])
    return np.concatenate((w, v), axis=-1)


def turned(q, vectors):
    """Return vectors (..., 3) turned by quaternions (..., 4) of any length."""
    pure = np.concatenate((0.0 * vectors[..., :1], vectors), axis=-1)
    square = (q * q).sum(axis=-1, keepdims=True)
    return product(product(q, pure), conjugate(q))[..., 1:] / square


def strains(x, q, length):
    """Return the strains at the Gauss points, (2 E, 6), of nodes from the clamp on (2 E + 1)."""
    found = []
    for xi in (-GAUSS, GAUSS):
        shape = np.array([0.5 * xi * (xi - 1.0), 1.0 - xi * xi, 0.5 * xi * (xi + 1.0)])
        slopes = np.array([xi - 0.5, -2.0 * xi, xi + 0.5]) * 2.0 / length
        triples = [(x[i:-1:2] if i < 2 else x[2::2], q[i:-1:2] if i < 2 else q[2::2])
                   for i in range(3)]
        at = sum(n * node[1] for n, node in zip(shape, triples))
        along = sum(d * node[1] for d, node in zip(slopes, triples))
        tangent = sum(d * node[0] for d, node in zip(slopes, triples))
        square = (at * at).sum(axis=-1, keepdims=True)
        bent = 2.0 * product(conjugate(at), along)[..., 1:] / square
        found.append(np.concatenate(
            (turned(conjugate(at), tangent) - [1.0, 0.0, 0.0], bent), axis=-1))
    return np.stack(found, axis=1).reshape(-1, 6)


def internal_forces(x, q, length, stress):
    """
    Return what the section stress does to all nodes, clamp first: (N, 3) force, (N, 3) moment.

    Virtual work: sum over the Gauss points of (length / 2) stress . d strain. Moments are in the
    nodes' own axes, forces in those of x.
    """
    forces = np.zeros((len(x), 6))
    for n in range(len(x)):
        for i in range(6):
            xc, qc = x.astype(complex), q.astype(complex)
            if i < 3:
                xc[n, i] += 1j * STEP
            else:
                nudge = np.zeros(4, complex)
                nudge[0], nudge[i - 2] = 1.0, 0.5j * STEP
                qc[n] = product(qc[n], nudge)
            first = max(0, (n - 1) // 2 * 2)    # elements of the node only
            last = min(len(x), (n // 2 + 1) * 2 + 1)
            change = strains(xc[first:last], qc[first:last], length).imag / STEP
            forces[n, i] = 0.5 * length * (change * stress[first:last - 1]).sum()
    return forces[:, :3], forces[:, 3:]


def tip_record(simulation, bristle):
    """Return state, force, gap and displacement over the step from the tip's record."""
    tip = simulation.state.tip[bristle]
    return (tip[STATE], tip[FORCE:FORCE + 3].copy(), tip[GAP],
            tip[SLIP_MOVED:SLIP_MOVED + 3].copy())
