"""A scene's brush for robot_state_publisher: the board and some of its wires, undeformed."""
from collections.abc import Iterable
from math import cos, pi, sin
from xml.etree import ElementTree

from bristle_ros.scene import brush_rows, Scene, widest

from .encode import BRUSH_FRAME, JOINT, MOUNT_FRAME

WIRES = 12              # drawn of each row; a brush has more
BOARD_THICKNESS = 0.02  # [m]


def robot_description(scene: Scene) -> str:
    """
    Return the URDF of a scene's brush: `brush_mount`, and `brush` that `brush_joint` turns.

    Lengths in m. Frames have no prefix: robot_state_publisher has a parameter for it.
    """
    bristle, radius = scene.bristle, max(widest(scene), 0.02)
    robot = ElementTree.Element('robot', name='brush')
    mount = ElementTree.SubElement(robot, 'link', name=MOUNT_FRAME)
    _visual(mount, (0.0, 0.0, 1.5 * BOARD_THICKNESS), (0.0, 0.0, 0.0), 'grey', 'cylinder',
            radius=0.25 * radius, length=2.0 * BOARD_THICKNESS)
    turning = ElementTree.SubElement(robot, 'link', name=BRUSH_FRAME)
    _visual(turning, (0.0, 0.0, 0.5 * BOARD_THICKNESS), (0.0, 0.0, 0.0), 'grey', 'cylinder',
            radius=radius, length=BOARD_THICKNESS)
    for row in brush_rows(scene):
        middle = 0.5 * (row.radius + row.tip_radius)
        for wire in range(WIRES):
            azimuth = row.offset + 2.0 * pi * wire / WIRES
            _visual(turning, (middle * cos(azimuth), middle * sin(azimuth), -0.5 * row.tip_depth),
                    (0.0, -row.angle, azimuth), 'wire', 'box',
                    size=_numbers((max(bristle.width, 1e-3), max(bristle.breadth, 1e-3),
                                   row.length)))
    joint = ElementTree.SubElement(robot, 'joint', name=JOINT, type='continuous')
    ElementTree.SubElement(joint, 'parent', link=MOUNT_FRAME)
    ElementTree.SubElement(joint, 'child', link=BRUSH_FRAME)
    ElementTree.SubElement(joint, 'axis', xyz='0 0 1')
    for name, rgba in (('grey', '0.4 0.4 0.4 1'), ('wire', '0.6 0.6 0.7 0.4')):
        ElementTree.SubElement(ElementTree.SubElement(robot, 'material', name=name), 'color',
                               rgba=rgba)
    ElementTree.indent(robot)
    return ElementTree.tostring(robot, encoding='unicode') + '\n'


def _visual(link: ElementTree.Element, position: Iterable[float], turn: Iterable[float],
            material: str, shape: str, **sizes: float | str) -> None:
    visual = ElementTree.SubElement(link, 'visual')
    ElementTree.SubElement(visual, 'origin', xyz=_numbers(position), rpy=_numbers(turn))
    ElementTree.SubElement(ElementTree.SubElement(visual, 'geometry'), shape, {
        name: value if isinstance(value, str) else f'{value:.6g}'
        for name, value in sizes.items()})
    ElementTree.SubElement(visual, 'material', name=material)


def _numbers(values: Iterable[float]) -> str:
    return ' '.join(f'{round(value, 9):.6g}' for value in values)
