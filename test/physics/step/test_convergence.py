"""Orders of convergence in time and space, as numbers; energy balance without contact."""
from functools import cache

from bristle_ros.physics.motion.drive import SINE
from bristle_ros.physics.motion import SPEED
from bristle_ros.scene.scene import Scene
from bristle_ros.scene.sections import Brush, Damping, Drive, Solver
from bristle_ros.simulation.simulation import Simulation
import numpy as np
from physics.scenes import MOUNT_ANGLE, NO_CONTACT
import pytest

DURATION = 0.1


@cache
def spun_up(its, viscosity=0.0, mass=0.0, **solver):
    """
    Return the tip's path [m] and the energy balance [J] of a brush that starts smoothly.

    speed = a (t - T sin(2 pi t / T) / (2 pi)), a = 150 rad/s^2, T = 0.2 s: a sudden load would
    excite modes that no step resolves, and what those do converges more slowly.
    """
    scene = Scene(
        brush=Brush(mount_angle=MOUNT_ANGLE), contact=NO_CONTACT, gravity=0.0,
        damping=Damping(mass=mass, stiffness=viscosity),
        drive=Drive(profile='constant', mean_speed=0.0),
        solver=Solver(integration_time_step=its, tolerance=1e-11, **solver))
    simulation = Simulation(scene, energies=True)
    drive = simulation.model.drive._replace(
        profile=SINE, frequency=5.0, alternating_speed=-150.0 * 0.2 / (2.0 * np.pi))
    simulation.model = simulation.model._replace(drive=drive, exact=drive)
    simulation.state.motion[SPEED:SPEED + 5] = 0.0, 0.0, 30.0, 0.2, 0.0
    tips, balance = [], []
    for _ in range(round(DURATION / 2e-3)):
        simulation.advance(round(2e-3 / its))
        now = simulation.snapshot()
        tips.append(now.tip_position[0])
        balance.append(now.energy_kinetic + now.energy_elastic + now.energy_dissipated
                       - now.work_external)
    return np.array(tips), abs(np.array(balance)).max() / now.work_external


def distance(one, other):
    return np.sqrt(((one - other) ** 2).mean())


def order(sizes, errors, floor=1e-12):
    assert min(errors) > floor, 'the finest error is round-off: start coarser'
    return np.polyfit(np.log(sizes), np.log(errors), 1)[0]


SIZES = np.array([1e-3, 5e-4, 2e-4, 1e-4])


@pytest.mark.parametrize(('changes', 'wanted'), [
    pytest.param({}, 2, id='generalized_alpha'),
    pytest.param({'spectral_radius': 0.0}, 2, id='generalized_alpha annihilating'),
    pytest.param({'viscosity': 2e-4, 'mass': 0.1}, 2, id='generalized_alpha damped'),
    pytest.param({'integrator': 'hht', 'amplitude_decay': 0.05}, 2, id='hht'),
    pytest.param({'integrator': 'hht', 'amplitude_decay': 0.05, 'viscosity': 2e-4}, 2,
                 id='hht damped'),
    pytest.param({'integrator': 'newmark', 'amplitude_decay': 0.0}, 2, id='newmark'),
    pytest.param({'integrator': 'newmark', 'amplitude_decay': 0.3}, 1, id='newmark with decay')])
def test_order_in_time(changes, wanted):
    exact = spun_up(2.5e-5, **{**changes, 'amplitude_decay': 0.0} if wanted == 1 else changes)[0]
    errors = [distance(spun_up(its, **changes)[0], exact) for its in SIZES]
    assert order(SIZES, errors) == pytest.approx(wanted, abs=0.1)


def test_order_with_viscosity_of_21_ms():
    # so stiff that errors reach round-off early
    sizes = SIZES[:3]
    exact = spun_up(2.5e-5, viscosity=0.021)[0]
    errors = [distance(spun_up(its, viscosity=0.021)[0], exact) for its in sizes]
    assert order(sizes, errors) == pytest.approx(2.0, abs=0.1)


def test_order_in_space():
    # corner nodes of 3-node elements, superconvergent: order 4
    elements = np.array([3, 4, 6, 8])
    exact = spun_up(2e-4, elements=32)[0]
    errors = [distance(spun_up(2e-4, elements=int(n))[0], exact) for n in elements]
    assert order(1.0 / elements, errors) == pytest.approx(4.0, abs=0.25)


def test_energy_balance_without_contact():
    # What is left at small steps is the frames' work on the rotary inertia of the sections, not
    # accounted: (width / length)^2 = 4e-6 of the rest.
    for its in (1e-3, 5e-4, 2e-4):
        assert spun_up(its, integrator='newmark', amplitude_decay=0.0)[1] < 8e-6
        assert spun_up(its, viscosity=0.021)[1] < 8e-6
    # Numerical dissipation of the annihilating scheme falls with the square of the step or faster.
    coarse, fine = (spun_up(its, spectral_radius=0.0)[1] for its in (1e-3, 5e-4))
    assert np.log2(coarse / fine) > 1.9
