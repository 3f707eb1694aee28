"""What lies under the brush of a drawn case: slopes, kerbs, edges, waves, and sums of them."""
import math

from bristle_ros.scene import brush_rows, from_parameters, SceneError, tip_depth
import numpy as np

from bristle_ros.report.ground import Ground, mount_to_road

TRIES = 100         # draws of a surface, until one can be and no wire starts inside it
ALONG = 25          # points of a straight wire that have to be outside
OUTSIDE = 1e-12     # [m]
SHARE = 0.55        # of the drawn cases with a road that are on a surface
LISTED = (
    {'gutter.enabled': True, 'gutter.kerb_distance': 0.19},
    {'gutter.enabled': True, 'gutter.kerb_distance': 0.14, 'gutter.approach': 0.1},
    {'gutter.enabled': True, 'gutter.kerb_distance': 0.19, 'gutter.friction_static': 5.0,
     'gutter.friction_kinetic': 0.2},
    {'gutter.enabled': True, 'gutter.kerb_distance': 0.14, 'gutter.channel_slope': 0.0,
     'gutter.kerb_height': -0.08},
    {'profile.kind': 'sine', 'profile.amplitude': 0.0025, 'profile.wavelength': 0.08},
    {'profile.kind': 'iso8608', 'profile.roughness_class': 'C', 'profile.shortest': 0.02,
     'profile.seed': 5},
    {'profile.kind': 'iso8608', 'profile.roughness_class': 'F', 'profile.shortest': 0.005,
     'gutter.enabled': True, 'gutter.kerb_distance': 0.2},
    {'road.grade': 0.3, 'road.cross_slope': -0.3},
)
EXTREMES = (
    {}, {'contact.normal_stiffness': math.inf}, {'contact.normal_stiffness': 1e8},
    {'solver.integration_time_step': 1e-3}, {'solver.integration_time_step': 2e-5},
    {'friction.static': 5.0, 'friction.kinetic': 5.0}, {'friction.static': 0.0},
    {'damping.stiffness': 0.0}, {'solver.step': 'adaptive'}, {'drive.mean_speed': -40.0},
    {'solver.load_case': 'displacement'}, {'sweeper.velocity': (0.0, 1.0)},
)


def surface_name(parameters):
    """Return in few words what road the keys of a scene make."""
    found = [kind for kind in (parameters.get('profile.kind', 'none'),) if kind != 'none']
    if parameters.get('gutter.enabled'):
        found.append('edge' if parameters.get('gutter.kerb_height', 1.0) < 0.0 else 'kerb')
    if parameters.get('road.grade') or parameters.get('road.cross_slope'):
        found.append('slope')
    return ' and '.join(found) or 'level'


def start_gap(scene):
    """Return the least gap of any wire of a scene, straight at its start [m]."""
    ground, share = Ground(scene), np.linspace(0.0, 1.0, ALONG)
    wires = []
    for row in brush_rows(scene):
        out = row.radius + share * row.length * math.sin(row.angle)
        for azimuth in row.azimuths:
            angle = scene.brush.start_angle + azimuth
            wires.append(np.stack((math.cos(angle) * out, math.sin(angle) * out,
                                   -share * row.length * math.cos(row.angle)), axis=-1))
    place = np.array((*scene.sweeper.mount_position, tip_depth(scene) - ground.height(0.0)))
    place[1] -= ground.beside(0.0)
    turn = mount_to_road(scene.road, 0.0)
    return -float(ground.inside(np.array(wires) @ turn.T + place).max())


def starts_inside(scene):
    """Whether a scene is one that is refused: a wire would start inside the road."""
    return (scene.contact.enabled and scene.solver.start == 'straight'
            and start_gap(scene) < -OUTSIDE)


def put_on_surface(draw, parameters):
    """
    Return the keys of a drawn surface that the scene of `parameters` can start on; {} for none.

    What the scene refuses and what a wire would start in is drawn again. Equilibria are sought on
    the level plane alone.
    """
    if parameters.get('solver.start') == 'steady':
        return {}
    for _ in range(TRIES):
        keys = _draw_surface(draw, parameters)
        try:
            scene = from_parameters({**parameters, **keys}, 'drawn')
        except SceneError:
            continue
        if not starts_inside(scene):
            return keys
    return {}


def _draw_surface(draw, parameters):
    kind = draw.choice(('slope', 'kerb', 'kerb', 'edge', 'sine', 'iso8608', 'file', 'sum', 'sum'))
    keys = {}
    if kind == 'slope' or draw.random() < 0.2:
        keys['road.grade'] = round(draw.uniform(-0.4, 0.4), 3)
        keys['road.cross_slope'] = round(draw.uniform(-0.4, 0.4), 3)
    if kind in ('kerb', 'edge') or kind == 'sum':
        keys |= _gutter(draw, parameters, kind == 'edge' or kind == 'sum' and draw.random() < 0.3)
    if kind in ('sine', 'iso8608', 'file'):
        keys |= _profile(draw, kind)
    elif kind == 'sum':
        keys |= _profile(draw, draw.choice(('sine', 'iso8608')))
    return keys


def _gutter(draw, parameters, falls):
    reach = 0.1125 + parameters.get('bristle.length', 0.24) * math.sin(0.4537856)
    keys = {
        'gutter.enabled': True,
        'gutter.kerb_distance': round(draw.uniform(0.6, 1.4) * reach, 4),
        'gutter.channel_width': round(draw.uniform(0.12, 0.4), 3),
        'gutter.channel_slope': round(draw.choice((0.0, draw.uniform(0.0, 0.35))), 3),
        'gutter.kerb_height': round(-draw.uniform(0.03, 0.2) if falls
                                    else draw.uniform(0.03, 0.3), 3),
        'gutter.kerb_batter': round(draw.choice((0.175, draw.uniform(0.175, 0.9))), 3),
        'gutter.lip_radius': _between(draw, 0.01, 0.2), 'gutter.foot_radius':
        _between(draw, 1e-3, 0.03), 'gutter.edge_radius': _between(draw, 1e-3, 0.03)}
    if draw.random() < 0.5:
        keys['gutter.approach'] = round(draw.uniform(0.0, 0.15), 3)
        keys['road.approach_time'] = draw.choice((0.05, 0.1))
    if draw.random() < 0.3:
        keys['gutter.friction_static'] = keys['gutter.friction_kinetic'] = draw.choice(
            (0.0, 0.1, 1.0, 3.0))
    return keys


def _profile(draw, kind):
    keys = {'profile.kind': kind}
    if kind == 'sine':
        length = _between(draw, 0.01, 1.0)
        return {**keys, 'profile.wavelength': length, 'profile.phase': round(
            draw.uniform(0.0, 2.0 * math.pi), 3), 'profile.amplitude': float(
                f'{length * _between(draw, 0.003, 0.25):.4g}')}
    if kind == 'iso8608':
        return {**keys, 'profile.roughness_class': draw.choice('ABCDEFGH'),
                'profile.shortest': draw.choice((0.005, 0.02, 0.1)), 'profile.bands':
                draw.choice((1, 20, 400)), 'profile.seed': draw.randrange(1000)}
    x, points = -1.0, []
    for _ in range(draw.randint(2, 40)):
        points.append(f'{x:.4f},{draw.uniform(-0.02, 0.02):.5f}')
        x += _between(draw, 0.01, 0.3)
    return {**keys, 'profile.file': 'data:' + ';'.join(points)}


def _between(draw, low, high):
    return float(f'{math.exp(draw.uniform(math.log(low), math.log(high))):.4g}')
