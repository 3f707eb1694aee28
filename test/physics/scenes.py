"""The scenes that tests of the physics step, and one way of stepping them."""
from functools import cache
import math
from pathlib import Path
from typing import NamedTuple

from bristle_ros.physics.contact.tip import GAP
from bristle_ros.physics.step.energy import INJECTED
from bristle_ros.physics.step.records import SUBSTEPS
from bristle_ros.scene.scene import Scene
from bristle_ros.scene.sections import (Brush, Contact, Damping, Drive, Friction, Road, Solver,
                                        Sweeper)
from bristle_ros.simulation.simulation import Simulation
import numpy as np

REFERENCE = Path(__file__).resolve().parent.parent / 'reference'
RPM = math.pi / 30.0
NO_CONTACT = Contact(enabled=False)
UNDAMPED = Damping(mass=0.0, stiffness=0.0)
UNEVEN = Drive(profile='sine', mean_speed=150.0 * RPM, alternating_speed=4.0 * RPM, frequency=5.0)
MOUNT_ANGLE = math.radians(26.0)


def cantilever_drop(its=2e-4, **solver):
    """S1: horizontal, thin side vertical, let go at rest."""
    return Scene(
        brush=Brush(mount_radius=0.0, mount_angle=math.pi / 2.0), contact=NO_CONTACT,
        damping=UNDAMPED, drive=Drive(profile='constant', mean_speed=0.0),
        solver=Solver(integration_time_step=its, **solver))


def free_rotation(its=2e-4, viscosity=0.0, **solver):
    """S2; with viscosity 0.021 s S5."""
    return Scene(
        brush=Brush(mount_angle=MOUNT_ANGLE), contact=NO_CONTACT,
        damping=Damping(mass=0.0, stiffness=viscosity), drive=UNEVEN,
        solver=Solver(integration_time_step=its, **solver))


def bouncing_sweep(its=2e-5, stiffness=1e4, damping=1.0, friction=(0.5, 0.5), count=1,
                   start_angle=0.0, **solver):
    """S3."""
    return Scene(
        brush=Brush(mount_angle=MOUNT_ANGLE, bristle_count=count, start_angle=start_angle),
        road=Road(penetration=5e-3, approach_time=0.02),
        contact=Contact(normal_stiffness=stiffness, damping=damping),
        friction=Friction(static=friction[0], kinetic=friction[1]),
        damping=Damping(mass=0.1, stiffness=2.1e-5),
        drive=Drive(profile='constant', mean_speed=100.0 * RPM),
        solver=Solver(integration_time_step=its, **solver))


def tilted_sweep(its=2e-5, stiffness=1e4, damping=0.0, viscosity=0.0, friction=(0.5, 0.5),
                 **solver):
    """S4; the references have damping 1."""
    return Scene(
        brush=Brush(mount_angle=MOUNT_ANGLE, start_angle=math.pi),
        road=Road(attack_angle=math.radians(10.0), penetration=0.04, approach_time=0.0),
        contact=Contact(normal_stiffness=stiffness, damping=damping),
        friction=Friction(static=friction[0], kinetic=friction[1]),
        damping=Damping(mass=0.0, stiffness=viscosity), drive=UNEVEN,
        sweeper=Sweeper(velocity=(1.5, 0.0)), solver=Solver(integration_time_step=its, **solver))


def sliding_sweep(its=1e-4, viscosity=1e-3, **solver):
    """Return the scene config/cutting_brush.yaml."""
    return Scene(
        brush=Brush(mount_angle=MOUNT_ANGLE), road=Road(penetration=0.02, approach_time=0.2),
        contact=Contact(normal_stiffness=1e5), damping=Damping(mass=0.1, stiffness=viscosity),
        drive=Drive(profile='constant', mean_speed=100.0 * RPM),
        solver=Solver(integration_time_step=its, **solver))


class Run(NamedTuple):
    """What a run left behind, one row a sample, all of bristle 0."""

    t: np.ndarray           # [s]
    tip: np.ndarray         # [m] (n, 3), brush axes
    force: np.ndarray       # [N] (n, 3), road axes, mean over the step before the sample
    impulse: np.ndarray     # [N s] (n, 3)
    gap: np.ndarray         # [m]
    balance: np.ndarray     # [J] energy + dissipated - work since the start
    injected: float         # [J]
    substeps: int


@cache
def run(scene, duration, every=1e-3):
    """Step the scene with its energy accounts and keep a sample each `every` seconds."""
    simulation = Simulation(scene, energies=True)
    steps = max(1, round(every / simulation.its))
    samples, gaps = [], []
    first = simulation.snapshot()
    for _ in range(round(duration / (steps * simulation.its))):
        simulation.advance(steps)
        samples.append(simulation.snapshot())
        gaps.append(simulation.state.tip[0, GAP])

    def balance(sample):
        return (sample.energy_kinetic + sample.energy_elastic + sample.energy_dissipated
                - sample.work_external)
    return Run(
        np.array([sample.t for sample in samples]),
        np.array([sample.tip_position[0] for sample in samples]),
        np.array([sample.contact_force[0] for sample in samples]),
        np.array([sample.contact_impulse[0] for sample in samples]),
        np.array(gaps), np.array([balance(sample) for sample in samples]) - balance(first),
        float(simulation.state.audit[0, INJECTED]), int(simulation.state.counts[0, SUBSTEPS]))


def path_difference(tip, other, straight):
    """Return the distance between two tip paths relative to how far the second one bends."""
    return math.sqrt(((tip - other) ** 2).sum() / ((other - straight) ** 2).sum())
