"""Roads, rows and tables that cannot be: exit 2 and one line with file, key and a way out."""
from bristle_ros.__main__ import main
import pytest

GUTTER = 'gutter: {{enabled: true, {}}}'
PROFILE = 'profile: {{kind: file, file: points.csv}}'
TABLE = 'drive: {{profile: table, file: points.csv}}'


@pytest.mark.parametrize(('section', 'points', 'key', 'words'), [
    (GUTTER.format('foot_radius: 0.2'), '', 'gutter.foot_radius', 'make them smaller'),
    (GUTTER.format('kerb_batter: 0.0'), '', 'gutter.kerb_batter', 'from 0.175'),
    (GUTTER.format('kerb_height: 0.0'), '', 'gutter.kerb_height', 'give one above 0 m'),
    (GUTTER.format('kerb_distance: .nan'), '', 'gutter.kerb_distance', 'must be a number'),
    (PROFILE, '0,0\n1,0\n0.5,0\n', 'profile.file', 'line 3: x = 0.5 does not go on from 1'),
    (PROFILE, '0,0\n1,nan\n', 'profile.file', 'line 2: 1,nan: must be finite'),
    (PROFILE, '0,0\n', 'profile.file', '1 point: a profile needs at least two'),
    (PROFILE, '0,0\n0.1,1\n0.2,0\n', 'profile.file', 'degrees behind x = '),
    (PROFILE, '\n'.join(f'{i},0' for i in range(300_000)), 'profile.file',
     'more than 200000 points'),
    ('profile: {kind: sine, amplitude: 0.5}', '', 'profile.amplitude', '80 are the most'),
    ('brush: {row_radii: [0.1, 0.12], row_counts: [4, 4, 4]}', '', 'brush.row_counts',
     '3 rows, but brush.row_radii has 2: give one entry a row'),
    ('brush: {row_radii: [0.1, -0.12]}', '', 'brush.row_radii', 'a list of numbers from 0'),
    ('brush: {mount_radius: 0.2, row_radii: [0.1, 0.12]}', '', 'brush.mount_radius',
     'leave this out'),
    (TABLE, '0,1\n1,2\n1,3\n', 'drive.file', 'line 3: t = 1 does not go on from 1'),
    (TABLE, '0,1\n1,nan\n', 'drive.file', 'line 2: 1,nan: must be finite'),
    ('air: {density: -1.0}', '', 'air.density', 'from 0 to 100'),
    ('air: {drag_coefficient: .nan}', '', 'air.drag_coefficient', 'from 0 to 10'),
    # known only when the brush stands on the road
    ('brush: {row_lengths: [0.24, 0.25]}\n    road: {penetration: 0.02, approach_time: 0.0}', '',
     'road.penetration', 'bristle 1 would start 0.02 m inside the road'),
])
def test_what_cannot_be_is_refused_on_one_line(tmp_path, capsys, section, points, key, words):
    (tmp_path / 'points.csv').write_text(points)
    scene = tmp_path / 'scene.yaml'
    text = section.replace('{{', '{').replace('}}', '}')
    scene.write_text(f'/**:\n  ros__parameters:\n    {text}\n')
    assert main(['simulate', str(scene), '--duration', '0.01']) == 2
    said = capsys.readouterr()
    assert said.out == ''
    [line] = said.err.splitlines()
    assert words in line
    assert key in line
    assert str(scene) in line or key == 'road.penetration'
