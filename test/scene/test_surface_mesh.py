"""The mesh of the road that viewers draw lies in the surface that wires touch."""
from bristle_ros.physics.contact.surface import gap_at
from bristle_ros.scene.scene import from_parameters
from bristle_ros.scene.surface_mesh import SurfaceMesher
from bristle_ros.simulation.surface import surface_of
import numpy as np
import pytest

SUMS = np.zeros(16)
KERB = {'gutter.enabled': True, 'gutter.kerb_distance': 0.2}
EDGE = {'gutter.enabled': True, 'gutter.kerb_distance': 0.14, 'gutter.channel_slope': 0.0,
        'gutter.kerb_height': -0.08}
SINE = {'profile.kind': 'sine', 'profile.phase': 0.4}
ROUGH = {'profile.kind': 'iso8608', 'profile.shortest': 0.02}
FILE = {'profile.kind': 'file', 'profile.file': 'data:-1,0.01;0,0.0;0.5,0.02;0.6,0.0;2,-0.01'}


@pytest.mark.parametrize('given', [KERB, EDGE, SINE, ROUGH, FILE, KERB | SINE, EDGE | ROUGH])
def test_the_mesh_lies_in_the_surface(given):
    """Where it has just been made, has gone on by a part or back, or is somewhere else."""
    scene = from_parameters(given, 'test')
    mesher, surface = SurfaceMesher(scene, 1.6, 8, 1600), surface_of(scene)
    low, high = 1.0, -1.0
    for x, y in ((0.03, 0.0), (0.25, 0.01), (0.04, 0.4), (7.75, -0.3), (7.95, 0.1), (-3.0, 0.1)):
        mesh, another = mesher.around(x, y)
        assert another
        assert mesh.z.shape == mesher.shape
        assert mesh.z.size < 2 * 1600 + 100
        for places, at in ((mesh.x, x), (mesh.y, y)):
            assert (np.diff(places) > 0.0).all()
            assert places[0] + 0.7 <= at <= places[-1] - 0.7
        gaps = [gap_at(surface, *point, SUMS)[0] for point in mesh.points()[::7]]
        np.testing.assert_allclose(gaps, 0.0, atol=1e-12)
        again, another = mesher.around(x + 0.004, y)
        assert again is mesh
        assert not another
        low, high = min(low, mesh.z.min()), max(high, mesh.z.max())
    if given is KERB:
        assert high - low == pytest.approx(0.125, abs=5e-3)     # but for the fillet of its foot


def test_faces_look_up_and_cover_the_square_once():
    mesh, _ = SurfaceMesher(from_parameters(KERB | SINE, 'test'), 1.6, 8, 400).around(0.0, 0.0)
    a, b, c = mesh.points()[mesh.triangles()].transpose(1, 0, 2)
    up = np.cross(b - a, c - a)
    assert (up[:, 2] > 0.0).all()
    assert 0.5 * up[:, 2].sum() == pytest.approx(1.6 ** 2)


def test_a_face_between_nodes_is_near_the_surface():
    """Fillets of 10 to 50 mm: a chord of 7.5 degrees leaves 0.05 mm at most."""
    scene = from_parameters(KERB, 'test')
    mesh, _ = SurfaceMesher(scene, 1.6, 8, 1600).around(0.0, 0.0)
    for y in np.linspace(-0.5, 0.5, 400):
        height = np.interp(y, mesh.y, mesh.z[0])
        assert abs(gap_at(surface_of(scene), 0.0, y, height, SUMS)[0]) < 5.5e-5
