"""Keys of the road's surface: what cannot be is refused, on one line."""
import math

from bristle_ros.log.head import head_of
from bristle_ros.log.recording import scene_of
from bristle_ros.scene.error import SceneError
from bristle_ros.scene.points_file import PROFILE, read_points
from bristle_ros.scene.scene import from_parameters, load
from bristle_ros.scene.surface import cross_section, Gutter
import pytest
import itertools

GUTTER, SINE = {'gutter.enabled': True}, {'profile.kind': 'sine'}
ROUGH, FILE = {'profile.kind': 'iso8608'}, {'profile.kind': 'file'}


@pytest.mark.parametrize(('given', 'key', 'words'), [
    (GUTTER | {'gutter.foot_radius': 0.2}, 'gutter.foot_radius', 'the face higher'),
    (GUTTER | {'gutter.lip_radius': 3.0}, 'gutter.lip_radius', 'the channel wider'),
    (GUTTER | {'gutter.kerb_batter': 0.1}, 'gutter.kerb_batter', 'from 0.175'),
    (GUTTER | {'gutter.kerb_batter': 0.0}, 'gutter.kerb_batter', 'from 0.175'),
    (GUTTER | {'gutter.kerb_height': 0.0}, 'gutter.kerb_height', 'above 0 m'),
    (GUTTER | {'gutter.kerb_height': -0.1, 'gutter.kerb_batter': 1.45}, 'gutter.channel_slope',
     'steeper than the face'),
    (GUTTER | {'gutter.friction_static': -0.5}, 'gutter.friction_static', "-1.0 for the road's"),
    (GUTTER | {'gutter.friction_kinetic': 0.9}, 'gutter.friction_kinetic', 'raise'),
    (SINE | {'profile.amplitude': 0.1}, 'profile.amplitude', '80 are the most'),
    (SINE | {'profile.wavelength': 0.0}, 'profile.wavelength', 'from 0.0001'),
    (ROUGH | {'profile.roughness_class': 'H'}, 'profile.roughness_class', '80 are the most'),
    (ROUGH | {'profile.roughness_class': 'I'}, 'profile.roughness_class', 'one of A, B'),
    (ROUGH | {'profile.shortest': 2.0}, 'profile.shortest', 'profile.longest'),
    (FILE, 'profile.file', 'give a CSV file'),
    (FILE | {'profile.file': '/nowhere.csv'}, 'profile.file', 'cannot be read'),
    ({'road.grade': 0.6}, 'road.grade', 'from -0.5 to 0.5'),
])
def test_surfaces_that_cannot_be_are_refused(given, key, words):
    with pytest.raises(SceneError) as refusal:
        from_parameters(given, 'here')
    assert refusal.value.key == key
    assert words in str(refusal.value)
    assert '\n' not in str(refusal.value)


@pytest.mark.parametrize(('content', 'words'), [
    ('0,0\n', '1 point:'),
    ('', '0 points'),
    ('x,z\n0,0\n1,nan\n', 'line 3: 1,nan'),
    ('0,0\n1,0\n0.5,0\n', 'line 3: x = 0.5 does not go on from 1'),
    ('0,0\n0,1\n', 'line 2'),
    ('0,0\n1,0,2\n', 'line 2: must be two numbers'),
    ('0,0\n0.1,1\n0.2,0\n', 'degrees behind x = '),
    ('0,0\n1,inf\n', 'must be finite'),
    ('\0', 'must be two numbers'),
])
def test_profile_files_that_cannot_be_used_are_refused(tmp_path, content, words):
    file = tmp_path / 'road.csv'
    file.write_text('x,z\n' * (content == '\0') + content)
    with pytest.raises(SceneError) as refusal:
        from_parameters(FILE | {'profile.file': str(file)}, 'here')
    assert refusal.value.key == 'profile.file'
    assert words in str(refusal.value)
    assert '\n' not in str(refusal.value)


def test_profile_with_too_many_points_is_refused_without_reading_on(tmp_path):
    file = tmp_path / 'road.csv'
    file.write_text('\n'.join(f'{i},0' for i in range(200_001)) + '\nnonsense')
    with pytest.raises(SceneError, match='more than 200000 points'):
        from_parameters(FILE | {'profile.file': str(file)}, 'here')


def test_profile_file_is_relative_to_the_scene_file(tmp_path, monkeypatch):
    (tmp_path / 'road.csv').write_text('0,0\n1,0.01\n')
    (tmp_path / 'scene.yaml').write_text(
        '/**:\n  ros__parameters:\n    profile: {kind: file, file: road.csv}\n')
    monkeypatch.chdir('/')
    assert load(tmp_path / 'scene.yaml').profile.file == str(tmp_path / 'road.csv')


def test_log_carries_the_points_of_a_profile(tmp_path):
    """To the last bit, after the file itself is gone."""
    file = tmp_path / 'road.csv'
    file.write_text('x,z\n0,0\n0.1,0.0012345678901234567\n1e1,-3e-3\n')
    scene = from_parameters(FILE | {'profile.file': str(file)}, 'here')
    yaml = head_of(scene, 0, str).yaml
    points = read_points(str(file), PROFILE)
    file.unlink()
    again = scene_of(yaml, 'log')
    assert all((a == b).all() for a, b in zip(points, read_points(again.profile.file, PROFILE)))
    assert scene_of(head_of(again, 0, str).yaml, 'log') == again


@pytest.mark.parametrize('height', [0.125, -0.08])
def test_pieces_join_in_place_and_direction(height):
    """Each piece begins where the one before it ends, and as it is directed there."""
    pieces = cross_section(Gutter(enabled=True, kerb_height=height))

    def ends(piece):
        if piece.side == 0.0:
            return [(piece.y + at * piece.along_y, piece.z + at * piece.along_z,
                     piece.along_y, piece.along_z) for at in (piece.end_y, piece.end_z)]
        return [(piece.y - piece.side * piece.radius * s, piece.z + piece.side * piece.radius * c,
                 c, s) for c, s in ((piece.along_y, piece.along_z), (piece.end_y, piece.end_z))]
    for before, after in itertools.pairwise(pieces):
        assert ends(before)[1] == pytest.approx(ends(after)[0], abs=1e-12)
    assert len(pieces) == 7
    assert math.hypot(pieces[3].along_y, pieces[3].along_z) == pytest.approx(1.0)
