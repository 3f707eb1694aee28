#!/usr/bin/env python3
"""Draw docs/frames.svg: road, brush_mount, brush, a section's axes, signs. Writes the file."""
from math import cos, pi, radians, sin
from pathlib import Path

from matplotlib import rc_context
from matplotlib.figure import Figure
import numpy as np

OUTPUT = Path(__file__).resolve().parent.parent / 'docs/frames.svg'
RADIUS, LENGTH, LEAN = 0.1125, 0.24, radians(26)    # of the default scene [m, rad]
ATTACK = radians(14)
INK, WIRE, MOUNT, BRUSH, SECTION, FORCE = (
    '#444444', '#777777', '#08519c', '#2a8a2a', '#7a3fa0', '#d94801')
STYLE = {'font.size': 9, 'svg.hashsalt': 'bristle_ros', 'svg.fonttype': 'path'}


def arrow(axes, start, along, colour, text='', offset=(3, 3), width=1.6):
    """Draw an arrow with a text at its end, `offset` in points from it."""
    end = np.add(start, along)
    axes.annotate('', end, start, arrowprops={
        'arrowstyle': '-|>', 'color': colour, 'lw': width, 'shrinkA': 0, 'shrinkB': 0})
    if text:
        axes.annotate(text, end, offset, textcoords='offset points', color=colour)


def arc(axes, centre, radius, first, last, colour, text, offset=(4, 0)):
    """Draw an arc with an arrow head, from angle `first` to `last` [rad]."""
    turn = np.linspace(first, last, 40)
    points = np.column_stack((centre[0] + radius * np.cos(turn),
                              centre[1] + radius * np.sin(turn)))
    axes.plot(*points[:-3].T, color=colour, lw=1.2)
    axes.annotate('', points[-1], points[-4], arrowprops={
        'arrowstyle': '-|>', 'color': colour, 'lw': 1.2, 'shrinkA': 0, 'shrinkB': 0})
    axes.annotate(text, points[20], offset, textcoords='offset points', color=colour)


def side(axes):
    """Draw the view from the right-hand side: x forward to the right, z up."""
    turn = np.array([[cos(ATTACK), sin(ATTACK)], [-sin(ATTACK), cos(ATTACK)]])
    centre = np.array([0.0, 0.247])
    axes.axhline(0.0, color=INK, lw=1.5)
    axes.fill_between([-0.45, 0.5], -0.03, 0.0, color='#dddddd')
    axes.text(-0.44, -0.024, 'road plane', color=INK)
    arrow(axes, (-0.38, 0.0), (0.09, 0.0), INK, 'x', (2, 4))
    arrow(axes, (-0.38, 0.0), (0.0, 0.09), INK, 'z', (3, 0))
    axes.text(-0.43, 0.115, 'road', color=INK, weight='bold')
    for sign in (-1.0, 1.0):
        clamp = centre + turn @ (sign * RADIUS, 0.0)
        tip = clamp + turn @ (sign * LENGTH * sin(LEAN), -LENGTH * cos(LEAN))
        s = np.linspace(0.0, 1.0, 40)
        if sign > 0.0:      # pressed: ends on the road
            bent = tip + (0.05, -tip[1])
            middle = clamp + 0.62 * (tip - clamp)
            points = (np.outer((1 - s) ** 2, clamp) + np.outer(2 * s * (1 - s), middle)
                      + np.outer(s ** 2, bent))
            axes.plot(*np.column_stack((clamp, tip)), ':', color=WIRE, lw=1.0)
            axes.annotate('undeformed', tip, (-62, 12), textcoords='offset points', color=WIRE)
            arrow(axes, bent, (-0.04, 0.1), FORCE, 'tip_wrench:\nroad on tip', (6, -8), 2.0)
            axes.plot(*points.T, color=WIRE, lw=2.5)
            along = points[-1] - points[-2]
            along /= np.hypot(*along)
            arrow(axes, bent, 0.06 * along, SECTION, 'x of tip_pose', (5, -3))
        else:
            axes.plot(*np.column_stack((clamp, tip)), color=WIRE, lw=2.5)
            down = clamp + turn @ (0.0, -0.13)
            axes.plot(*np.column_stack((clamp, down)), '--', color=WIRE, lw=0.8)
            axes.annotate('φ', clamp + turn @ (-0.021, -0.115), color=WIRE)
    ends = [centre + turn @ (sign * 0.13, 0.0) for sign in (-1.0, 1.0)]
    axes.plot(*np.column_stack(ends), color=INK, lw=6, solid_capstyle='butt')
    arrow(axes, centre, turn @ (0.19, 0.0), MOUNT, 'x', (4, -3))
    arrow(axes, centre, turn @ (0.0, 0.15), MOUNT, 'z', (4, -3))
    axes.annotate('brush_mount', centre + turn @ (0.02, 0.075), (0, 0), weight='bold',
                  textcoords='offset points', color=MOUNT)
    axes.plot([0.0, 0.0], [centre[1], centre[1] + 0.17], '--', color=INK, lw=0.8)
    arc(axes, centre, 0.155, pi / 2, pi / 2 - ATTACK, INK, 'β', (-3, 5))
    arrow(axes, centre + turn @ (-0.02, 0.0), (-0.12, 0.06), FORCE,
          'mount_wrench:\nbrush on sweeper', (-60, 4), 2.0)
    axes.set(title='From the side: tilted by road.attack_angle β, azimuth 0', xlim=(-0.45, 0.5),
             ylim=(-0.07, 0.43))


def above(axes):
    """Draw the view from above: x forward to the right, y up the page."""
    theta = radians(35)
    c, s = cos(theta), sin(theta)
    for count in range(12):
        azimuth = theta + count * pi / 6
        rim, reach = RADIUS, RADIUS + LENGTH * sin(LEAN)
        axes.plot([rim * cos(azimuth), reach * cos(azimuth)],
                  [rim * sin(azimuth), reach * sin(azimuth)], color=WIRE,
                  lw=2.5 if count == 0 else 1.0, alpha=1.0 if count == 0 else 0.5)
    turn = np.linspace(0.0, 2.0 * pi, 100)
    axes.fill(0.13 * np.cos(turn), 0.13 * np.sin(turn), color='#eeeeee', ec=INK)
    arrow(axes, (0, 0), (0.18, 0.0), MOUNT, 'x, forward', (-8, -12))
    arrow(axes, (0, 0), (0.0, 0.18), MOUNT, 'y, left', (-36, -2))
    axes.text(-0.098, -0.03, 'brush_mount', color=MOUNT, weight='bold')
    arrow(axes, (0, 0), (0.18 * c, 0.18 * s), BRUSH, 'x', (4, -8))
    arrow(axes, (0, 0), (-0.1 * s, 0.1 * c), BRUSH, 'y', (-10, 0))
    axes.text(0.105, 0.115, 'brush', color=BRUSH, weight='bold')
    arc(axes, (0, 0), 0.09, 0.0, theta, BRUSH, 'θ, brush_joint', (8, -7))
    reach = RADIUS + LENGTH * sin(LEAN)
    tip = np.array([reach * c, reach * s])
    axes.annotate('bristle 0', tip, (4, -12), textcoords='offset points', color=WIRE)
    arrow(axes, tip, (0.06 * c, 0.06 * s), SECTION, 'x, along the wire', (-18, 5))
    arrow(axes, tip, (-0.06 * s, 0.06 * c), SECTION, 'y, breadth t1', (-62, 4))
    arc(axes, (0, 0), 0.245, radians(200), radians(250), BRUSH, 'positive speed', (-78, -8))
    axes.set(title='From above: z points at you', xlim=(-0.3, 0.36), ylim=(-0.3, 0.3))


def main():
    """Write the figure."""
    with rc_context(STYLE):
        figure = Figure(figsize=(10.5, 4.6), layout='constrained')
        left, right = figure.subplots(1, 2, width_ratios=(1.35, 1.0))
        side(left)
        above(right)
        for axes in (left, right):
            axes.set_aspect('equal')
            axes.axis('off')
        figure.savefig(OUTPUT, metadata={'Date': None})


if __name__ == '__main__':
    main()
