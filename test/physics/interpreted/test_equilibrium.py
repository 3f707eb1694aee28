"""The static equilibrium against the balance of forces, written a second time."""
from bristle_ros.physics.contact.tip import FORCE, GAP
from bristle_ros.physics.motion import HEIGHT
from bristle_ros.physics.step import equilibrium
from bristle_ros.physics.wire import layout
from bristle_ros.simulation.simulation import Simulation
import numpy as np
from physics.interpreted.test_motion import case, stiffness
from physics.mechanics import internal_forces, nodes_of, Ride, strains, turned
import pytest


@pytest.mark.parametrize(('road', 'load_case'), [(2e3, 'displacement'), (np.inf, 'inertia')])
def test_forces_balance(road, load_case):
    scene = case(solver={'start': 'steady', 'elements': 2, 'load_case': load_case},
                 brush={'start_angle': -0.9}, contact={'enabled': True, 'normal_stiffness': road},
                 road={'penetration': 0.02})
    simulation = Simulation(scene)
    model = simulation.model
    ride = Ride(scene, (scene.drive.mean_speed, 0.0), (1.5, 0.0), (-0.3, 0.0), (0.0, 0.0),
                (0.02, 0.0), model.drive.tip_depth)
    forces = []
    for bristle in range(2):
        rows = nodes_of(simulation, bristle)
        azimuth = np.pi * bristle
        turn = ride.axes(0.0, azimuth, False)
        x, q = rows(layout.X0, 3), rows(layout.Q0, 4)
        if load_case == 'displacement':     # nodes are in the mount's axes there
            back = -ride.theta(0.0)
            half = np.array([np.cos(back / 2), 0.0, 0.0, np.sin(back / 2)])
            x = turned(half[None], x)
            q = np.array([np.concatenate((
                [half[0] * p[0] - half[3] * p[3]],
                half[0] * p[1:] + p[0] * half[1:] + np.cross(half[1:], p[1:]))) for p in q])
        x, q = np.vstack((model.clamp[:3], x)), np.vstack((model.clamp[3:], q))
        length = model.section.element_length
        stress = stiffness(model) * strains(x, q, length)
        force, torque = internal_forces(x, q, length, stress)
        spin = np.array([0.0, 0.0, scene.drive.mean_speed])
        mass, inertia = rows(layout.MASS, 1), rows(layout.INERTIA, 3)
        loads = mass * (turn.T @ [0.0, 0.0, -scene.gravity]
                        - np.cross(spin, np.cross(spin, x[1:])))
        tip = simulation.state.tip[bristle]
        loads[-1] += turn.T @ tip[FORCE:FORCE + 3]
        assert abs(force[1:] - loads).max() < 1e-7 * abs(loads).max()
        own = turned(q[1:] * [1.0, -1.0, -1.0, -1.0], spin + np.zeros(x[1:].shape))
        gyroscopic = np.cross(own, inertia * own)
        assert abs(torque[1:] + gyroscopic).max() < 1e-9
        assert abs(gyroscopic).max() > 1e-7
        gap = (turn @ x[-1])[2] + ride.height(0.0)
        assert tip[GAP] == pytest.approx(gap, abs=1e-10)
        normal = tip[FORCE + 2]
        assert not tip[FORCE:FORCE + 2].any()
        if normal == 0.0:
            assert gap > 0.0
        elif np.isinf(road):
            assert gap == pytest.approx(0.0, abs=1e-10)
        else:
            assert normal == pytest.approx(-road * gap, rel=1e-7)
        forces.append(normal)
    # the tilt presses one side and lifts the other
    assert forces[0] > 0.1
    assert forces[1] == 0.0


def test_the_road_rises_from_the_straight_tip_to_its_height(monkeypatch):
    # elsewhere the search would find the same, later or not at all
    scene = case(solver={'start': 'steady', 'elements': 2},
                 brush={'start_angle': -0.4, 'bristle_count': 1},
                 contact={'enabled': True, 'normal_stiffness': 2e3}, road={'penetration': 0.03})
    heights = []
    contact = equilibrium._contact

    def watched(bristle, elements, law, frame):
        heights.append(frame[HEIGHT])
        contact(bristle, elements, law, frame)
    monkeypatch.setattr(equilibrium, '_contact', watched)
    model = Simulation(scene).model
    ride = Ride(scene, (scene.drive.mean_speed, 0.0), (1.5, 0.0), (-0.3, 0.0), (0.0, 0.0),
                (0.03, 0.0), model.drive.tip_depth)
    lean = scene.brush.mount_angle
    straight = model.clamp[:3] + scene.bristle.length * np.array(
        [np.sin(lean), 0.0, -np.cos(lean)])
    tip = (ride.axes(0.0, 0.0, False) @ straight)[2]
    assert tip + ride.height(0.0) < -0.01
    assert heights[0] == pytest.approx(-tip, abs=1e-14)
    assert heights[-1] == ride.height(0.0)
    rises = -np.diff(heights)
    assert (rises >= 0.0).all()
    assert rises.max() <= equilibrium.RISE * model.section.element_length * (1.0 + 1e-12)
