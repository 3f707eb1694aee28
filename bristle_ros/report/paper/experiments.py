"""
The runs behind the paper's figures 3 to 5 and its sensitivities; each function runs in a worker.

Paper: comparison of two finite element models of bristles of gutter brushes. The displacement load
case moves the clamp along a polygon with corners at multiples of TS; the inertia load case turns
the frame. ITS is the integrator's step in both.
"""
from dataclasses import replace
import math

from bristle_ros.report.peers.scenes import our_scene, RPM
from bristle_ros.report.runs import prepare_run, run
from bristle_ros.scene import Contact, Damping, Drive, Road, Run, Scene, Solver
import numpy as np

MU_S, MU_K, DECAY = 0.70, 0.27, 0.40    # the paper's fit, section 3
INTEGRATORS = {
    'Newmark 0.005': {'integrator': 'newmark', 'amplitude_decay': 0.005},
    'HHT 0.005': {'integrator': 'hht', 'amplitude_decay': 0.005},
    'spectral radius 0': {'integrator': 'generalized_alpha', 'spectral_radius': 0.0},
    'spectral radius 0.8': {'integrator': 'generalized_alpha', 'spectral_radius': 0.8}}
FIGURE4 = ('Newmark 0.005', 'HHT 0.005', 'spectral radius 0')
# What the paper's program has by default (ANSYS: TINTP, GAMMA = 0.005); it names no other.
LIKE_PAPER = ('Newmark 0.005', 'HHT 0.005')
POLYGON = (     # TS [s], ITS [s] of figure 4: TS is a whole multiple of ITS
    *((time_step, its) for time_step in (1e-3, 1e-4, 5e-5, 1e-5) for its in (1e-5, 5e-6, 1e-6)),
    (5e-6, 5e-6), (5e-6, 2.5e-6), (5e-6, 1e-6), (2e-6, 2e-6), (2e-6, 1e-6), (1e-6, 1e-6))
WINDOW = 0.01       # [s] from the start: about what figure 4 shows
COARSE_DT = 1e-5    # [s] of the series that are drawn


def law(slip):
    """Return the coefficient of friction of eq. (1) with the paper's fit."""
    return MU_K + (MU_S - MU_K) * np.exp(-DECAY * np.asarray(slip))


def friction(rpm):
    """Return how far sliding tips deviate from eq. (1), and points (slip, coefficient)."""
    from bristle_ros.simulation import Simulation
    scene = Scene(
        road=Road(penetration=0.02, approach_time=0.05), damping=Damping(stiffness=1e-3),
        drive=Drive(profile='constant', mean_speed=rpm * RPM),
        solver=Solver(integration_time_step=1e-4), run=Run(chunk=1e-3, sample=1e-4))
    simulation = Simulation(scene)
    simulation.advance(1000)
    points, worst = [], 0.0
    before = simulation.snapshot()
    for i in range(1000):
        simulation.advance(1)
        now = simulation.snapshot()
        tangent, normal = np.hypot(*now.contact_force[0, :2]), now.contact_force[0, 2]
        moved = now.tip_position_road[0, :2] - before.tip_position_road[0, :2]
        speed = float(np.hypot(*moved)) / scene.solver.integration_time_step
        if normal > 1e-3 and now.substeps == before.substeps and speed > 1e-6:
            worst = max(worst, abs(float(tangent / normal) - float(law(speed))))
            if i % 25 == 0:
                points.append((speed, float(tangent / normal)))
        before = now
    return {'rpm': rpm, 'worst': worst, 'points': points}


def figure4_scene(time_step, its, load_case, integrator):
    """Return the Scene of figure 4."""
    return Scene(
        contact=Contact(enabled=False), damping=Damping(mass=0.1, stiffness=0.021),
        drive=Drive(profile='vap', mean_speed=100 * RPM, alternating_speed=5 * RPM, frequency=9.0,
                    shape=0.08),
        solver=Solver(load_case=load_case, time_step=time_step, integration_time_step=its,
                      **INTEGRATORS[integrator]),
        run=Run(chunk=its, sample=its))


def histories(scene, duration):
    """Return t [s], radial damping force and clamp force [N], tip [m] after every step."""
    from bristle_ros.simulation import Simulation
    simulation = Simulation(scene)
    count = round(duration / simulation.its)
    damping, whole, tip = np.empty(count), np.empty(count), np.empty((count, 3))
    for i in range(count):
        simulation.advance(1)
        now = simulation.snapshot()
        damping[i] = now.mount_damping_force[0, 0]
        whole[i] = now.mount_force[0, 0]
        tip[i] = now.tip_position[0]
    return simulation.its * np.arange(1, count + 1), damping, whole, tip


def _extreme(values):
    return float(values[np.argmax(np.abs(values))])


def damping(time_step, its, load_case, integrator, duration):
    """Return what figure 4 is about, of one run."""
    scene = figure4_scene(time_step, its, load_case, integrator)
    t, force, whole, tip = histories(scene, duration)
    every = max(1, round(COARSE_DT / its))
    early = t <= WINDOW + 1e-12
    marks = slice(round(1e-4 / its) - 1 if its <= 1e-4 else 0, None, max(1, round(1e-4 / its)))
    return {'TS': time_step, 'ITS': its, 'load_case': load_case, 'integrator': integrator,
            'extreme': _extreme(force), 'low': float(force.min()), 'high': float(force.max()),
            'early_low': float(force[early].min()), 'early_high': float(force[early].max()),
            'whole': whole[marks].tolist(), 'tip': tip[marks].ravel().tolist(),
            'positive_share': float((force > 0.0).mean()), 'duration': duration,
            'series': (t[early][::every].tolist(), force[early][::every].tolist())}


def force_path(time_step, its, load_case, integrator, duration):
    """Return the radial damping force at the clamp [N] after every step."""
    return histories(figure4_scene(time_step, its, load_case, integrator), duration)[1]


def prepare_force(time_step, its, load_case, integrator, duration):
    """Return what runs a scene of figure 4 and tells its wall time."""
    return prepare_run(figure4_scene(time_step, its, load_case, integrator), duration)


def tilted(its, load_case='inertia', time_step=0.0, *, depth=0.04, kn=1e4, beta=0.0, turn=0.0,
           **solver):
    """Return the paper's sweeping run (figures 5 to 7) as a Scene."""
    scene = our_scene('S4', its, load_case=load_case, time_step=time_step, **solver)
    return replace(scene, road=replace(scene.road, penetration=depth),
                   contact=Contact(normal_stiffness=kn),
                   damping=Damping(mass=0.0, stiffness=beta),
                   brush=replace(scene.brush, start_angle=scene.brush.start_angle + turn))


def sweep(load_case, time_step, depth, turn, its=1e-5, duration=0.24):
    """Return the Path of figure 5, sampled every 0.1 ms."""
    return run(tilted(its, load_case, time_step, depth=depth, turn=turn), duration, sample=1e-4)


def sensitivity(its, keys, duration):
    """Return the Path of the sweeping run with 1 ms of damping: without it impacts scatter."""
    keys = dict(keys)
    return run(tilted(its, keys.pop('load_case', 'inertia'), keys.pop('time_step', 0.0),
                      beta=1e-3, **keys), duration)


def rotation(its, load_case, time_step, duration, elements=12):
    """Return the Path of the free rotation (S2)."""
    return run(our_scene('S2', its, load_case=load_case, time_step=time_step, elements=elements),
               duration)


def prepare_rotation(its, load_case, time_step, duration):
    """Return what runs the free rotation and tells its wall time."""
    return prepare_run(our_scene('S2', its, load_case=load_case, time_step=time_step), duration)


def relative_force_error(force, its, reference, reference_its):
    """Return the rms of a force's deviation over the rms of the reference, each step."""
    t = its * np.arange(1, len(force) + 1)
    exact = np.interp(t, reference_its * np.arange(1, len(reference) + 1), reference)
    return float(math.sqrt(((force - exact) ** 2).mean() / (exact ** 2).mean()))
