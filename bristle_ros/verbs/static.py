"""The `static` verb: the bristles' static equilibrium in the turning brush frame."""
import json
import math

from bristle_ros.command_line import add_scene, load_scene, Parser
from bristle_ros.scene import start_speed
from bristle_ros.simulation import static_equilibrium


def main(argv):
    """Run the `static` verb; return its exit code."""
    parser = Parser('static', 'static equilibrium with theta frozen at brush.start_angle')
    add_scene(parser)
    parser.add_argument('--json', action='store_true', help='print one JSON object')
    options = parser.parse_args(argv)
    scene = load_scene(options)
    found = static_equilibrium(scene)
    if options.json:
        print(json.dumps({name: value.tolist() for name, value in found._asdict().items()}))
        return 0
    spin = start_speed(scene.drive)
    print(f'static equilibrium at theta = {scene.brush.start_angle:g} rad, {spin:g} rad/s '
          f'({spin * 30.0 / math.pi:.4g} rpm), friction off')
    for bristle in range(len(found.normal_force)):
        x, y, z = found.tip_position[bristle] * 1e3
        moment = found.root_moment[bristle] * 1e3
        print(f'bristle {bristle}: tip ({x:.4f}, {y:.4f}, {z:.4f}) mm in brush axes, '
              f'normal force {found.normal_force[bristle]:.6g} N, '
              f'root moment ({moment[0]:.5g}, {moment[1]:.5g}, {moment[2]:.5g}) mN m')
    return 0
