#!/usr/bin/env python3
"""
Draw what viewers are sent: ./run.sh tools/render_markers.py [--after S] [--output FILE.png].

Subscribes to `bristle_markers` of a node that runs, and draws the first array in which a tip
touches, or the last of a minute. docs/markers.png is config/cutting_brush.yaml, --after 0.5, with
-p brush.bristle_count:=12 -p solver.elements:=6 -p solver.integration_time_step:=5.0e-4
-p road.approach_time:=0.1 -p road.penetration:=0.03.
"""
import argparse
import time

from matplotlib.figure import Figure
from mpl_toolkits.mplot3d.art3d import Line3DCollection
import numpy as np
import rclpy
from visualization_msgs.msg import Marker, MarkerArray

WAITING = 60.0  # [s]


def hear(namespace, after):
    """Return a MarkerArray from `after` [s] on, with forces if there are any."""
    rclpy.init()
    node = rclpy.create_node('render_markers')
    heard = []
    node.create_subscription(MarkerArray, f'{namespace}/bristle_markers'.lstrip('/'),
                             heard.append, 1)
    end = time.monotonic() + WAITING
    while time.monotonic() < end:
        rclpy.spin_once(node, timeout_sec=0.1)
        if heard and seconds(heard[-1]) >= after and forces(heard[-1]):
            break
    node.destroy_node()
    rclpy.shutdown()
    if not heard:
        raise SystemExit(f'no bristle_markers within {WAITING:g} s: is a node running?')
    return heard[-1]


def seconds(array):
    """Return the simulation time [s] of an array."""
    stamp = array.markers[0].header.stamp
    return stamp.sec + stamp.nanosec * 1e-9


def forces(array):
    """Return the arrows of the tips that touch."""
    return [marker for marker in array.markers
            if marker.ns == 'contact_force' and marker.action == Marker.ADD]


def points(marker):
    """Return a marker's points [m] as (n, 3)."""
    return np.array([(point.x, point.y, point.z) for point in marker.points])


def draw(array, output):
    """Draw the array in the mount's axes; the mount is level where the road is given."""
    by_name = {marker.ns: marker for marker in array.markers}
    figure = Figure(figsize=(8.0, 4.6), layout='constrained')
    axes = figure.add_subplot(projection='3d', computed_zorder=False)
    lines = points(by_name['bristles'])
    axes.add_collection3d(Line3DCollection(
        lines.reshape(-1, 2, 3), colors=[colour(by_name['bristles'])], linewidths=1.5, zorder=3))
    bottom = lines[:, 2].min()
    if 'road' in by_name and by_name['road'].type == Marker.CUBE:   # and not a surface's faces
        half = 0.3 * by_name['road'].scale.x     # not all of it: the brush is what counts
        x, y = np.meshgrid((-half, half), (-half, half))
        axes.plot_surface(x, y, np.full_like(x, bottom), color=colour(by_name['road']), zorder=1)
    for arrow in forces(array):
        start, end = points(arrow)
        axes.quiver(*start, *(end - start), color=colour(arrow), linewidth=1.5, zorder=4)
    reach = 1.1 * np.abs(lines[:, :2]).max()
    axes.set(xlim=(-reach, reach), ylim=(-reach, reach), zlim=(bottom, 0.02), xlabel='x [m]',
             ylabel='y [m]', zlabel='z [m]')
    axes.set_box_aspect((2.0 * reach, 2.0 * reach, 0.02 - bottom), zoom=1.15)
    axes.view_init(elev=18, azim=-55)
    axes.set_title(f'bristle_markers in brush_mount: {len(forces(array))} tips touch', fontsize=9)
    figure.savefig(output, dpi=90)


def colour(marker):
    """Return a marker's colour as matplotlib takes it."""
    return marker.color.r, marker.color.g, marker.color.b, marker.color.a


def main():
    """Hear, draw, say where."""
    parser = argparse.ArgumentParser(description='draw the markers of a node that runs')
    parser.add_argument('--namespace', default='')
    parser.add_argument('--after', type=float, default=0.0, help='simulation time [s]')
    parser.add_argument('--output', default='bristle_markers.png')
    options = parser.parse_args()
    draw(hear(options.namespace, options.after), options.output)
    print(f'drawn: {options.output}')


if __name__ == '__main__':
    main()
