#!/usr/bin/env python3
"""Draw docs/lying.png, gutter.png and rough_road.png from runs of these scenes in config/."""
from pathlib import Path
import sys

ROOT = Path(__file__).resolve().parent.parent
sys.path.insert(0, str(ROOT))

from matplotlib import pyplot as plt  # noqa: E402
import numpy as np  # noqa: E402

from bristle_ros.physics.contact.surface import gap_at, profile_height  # noqa: E402
from bristle_ros.scene.rows import brush_rows, tip_depth  # noqa: E402
from bristle_ros.scene.scene import load  # noqa: E402
from bristle_ros.simulation.mount_path import MountPath  # noqa: E402
from bristle_ros.simulation.simulation import Simulation  # noqa: E402
from bristle_ros.simulation.surface import surface_of  # noqa: E402

FORCE_SCALE = 0.05      # [m/N] length of the arrows
SUMS = np.zeros(16)


def draw_gutter(path):
    """Look along x at the wires over the channel and against the kerb."""
    scene = load(ROOT / 'config/gutter.yaml')
    simulation, way = Simulation(scene), MountPath(scene)
    simulation.advance(round(0.5 / simulation.its))
    mount = way.follow(simulation, 0)
    wires = simulation.centreline() @ mount.rotation.T + mount.position
    force = simulation.snapshot().contact_force
    figure, axes = plt.subplots(figsize=(8.0, 4.0), layout='constrained')
    y, z = np.meshgrid(np.linspace(-0.3, 0.4, 701), np.linspace(-0.08, 0.28, 361))
    surface = surface_of(scene)
    gap = np.array([gap_at(surface, 0.0, a, b, SUMS)[0] for a, b in zip(y.flat, z.flat)])
    axes.contourf(y, z, gap.reshape(y.shape), [-1.0, 0.0], colors=['0.8'])
    rows = np.repeat(np.arange(len(brush_rows(scene))), [row.count for row in brush_rows(scene)])
    for row, colour in enumerate(('tab:blue', 'tab:green', 'tab:purple')):
        axes.plot(wires[rows == row, :, 1].T, wires[rows == row, :, 2].T, color=colour,
                  linewidth=0.7)
    tips = wires[:, -1]
    axes.quiver(tips[:, 1], tips[:, 2], FORCE_SCALE * force[:, 1], FORCE_SCALE * force[:, 2],
                color='tab:red', angles='xy', scale_units='xy', scale=1.0, width=0.003)
    axes.set(xlabel='y [m]', ylabel='z [m]', aspect='equal',
             title='gutter, seen from behind at 0.5 s: three rows; forces 50 mm/N')
    figure.savefig(path, dpi=110)


def draw_rough_road(path):
    """Show the tip's way over the profile, and the normal force on it."""
    scene = load(ROOT / 'config/rough_road.yaml')
    simulation = Simulation(scene)
    surface = surface_of(scene)
    rows = []
    for _ in range(1200):
        simulation.advance(1)
        now = simulation.snapshot()
        height, *_ = simulation.sweeper_motion()
        tip = now.tip_position_road[0]
        rows.append((now.t, now.base_pose[0] + tip[0], height + tip[2], now.contact_force[0, 2]))
    t, x, z, force = np.array(rows).T
    ground = np.array([profile_height(surface.profile, at, SUMS)[0] for at in x])
    figure, (upper, lower) = plt.subplots(2, 1, sharex=True, figsize=(8.0, 4.0),
                                          layout='constrained')
    upper.fill_between(t, 1e3 * ground, 1e3 * ground.min(), color='0.8',
                       label='road below the tip')
    upper.plot(t, 1e3 * z, color='tab:blue', linewidth=1.0, label='tip')
    upper.set(ylabel='height [mm]', title='rough_road', ylim=(1e3 * ground.min(), 25.0))
    upper.legend(loc='upper right')
    lower.plot(t, force, color='tab:red', linewidth=0.8)
    lower.set(xlabel='t [s]', ylabel='vertical force [N]')
    figure.savefig(path, dpi=110)


def draw_lying(path):
    """Show a wire that is pressed down, and the force on it beside that of its tip alone."""
    scene = load(ROOT / 'config/lying.yaml')
    every, samples = round(0.005 / scene.solver.integration_time_step), 100
    shown = {16: 'tab:blue', 22: 'tab:green', 28: 'tab:orange', 40: 'tab:red'}
    figure, (side, forces) = plt.subplots(1, 2, figsize=(9.0, 3.6), layout='constrained')
    for points, style in (('wire', '-'), ('tip', '--')):
        simulation = Simulation(load(ROOT / 'config/lying.yaml', {'contact.points': points}))
        impulse = [0.0]
        for sample in range(1, samples + 1):
            simulation.advance(every)
            impulse.append(float(simulation.snapshot().contact_impulse[0, 2]))
            height = simulation.sweeper_motion()[0]
            if sample in shown and points == 'wire':
                x, _, z = (1e3 * simulation.centreline_own()[0]).T
                side.plot(x, z + 1e3 * height, color=shown[sample], marker='.', markersize=3.0,
                          label=f'{1e3 * (tip_depth(scene) - height):.0f} mm')
        t = 0.005 * np.arange(1, samples + 1)
        forces.plot(t, np.diff(impulse) / 0.005, 'k' + style, linewidth=1.0, label=points)
    side.axhspan(-12.0, 0.0, color='0.8')
    side.set(xlabel='from the brush axis [mm]', ylabel='height [mm]', aspect='equal',
             ylim=(-12.0, 165.0), title='lying: the wire at four penetrations')
    side.legend()
    forces.set(xlabel='t [s]', ylabel='normal force, means of 5 ms [N]',
               title='160 mm from 0.2 s on', ylim=(0.0, 0.5))
    forces.legend(title='contact.points')
    figure.savefig(path, dpi=110)


if __name__ == '__main__':
    draw_lying(ROOT / 'docs/lying.png')
    draw_gutter(ROOT / 'docs/gutter.png')
    draw_rough_road(ROOT / 'docs/rough_road.png')
