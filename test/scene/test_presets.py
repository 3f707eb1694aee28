"""solver.preset fills what a scene leaves out, and nothing else."""
from bristle_ros import load
from bristle_ros.scene import from_parameters, PRESETS, SceneError, to_parameters, to_yaml
import pytest


@pytest.mark.parametrize('name', PRESETS)
def test_a_preset_fills_what_is_left_out(name):
    scene = from_parameters({'solver.preset': name}, 'test')
    for key, value in PRESETS[name].items():
        assert getattr(scene.solver, key) == value
    assert scene != from_parameters({}, 'test')


def test_what_is_given_stays_wherever_it_comes_from(tmp_path):
    path = tmp_path / 'scene.yaml'
    path.write_text('/**:\n  ros__parameters:\n    solver: {elements: 12, preset: draft}\n')
    scene = load(path, {'solver.tolerance': 1e-7})
    assert (scene.solver.elements, scene.solver.tolerance) == (12, 1e-7)    # the default, said
    assert scene.solver.step == 'adaptive'
    assert load(path, {'solver.preset': 'reference'}).solver.integration_time_step == 2e-5


def test_a_scene_keeps_what_came_of_it(tmp_path):
    scene = from_parameters({'solver.preset': 'draft', 'run.sample': 2e-3}, 'test')
    assert 'solver.preset' not in to_parameters(scene)
    (tmp_path / 'again.yaml').write_text(to_yaml(scene))
    assert load(tmp_path / 'again.yaml') == scene


@pytest.mark.parametrize(('value', 'words'), [
    ('fast', 'solver.preset = "fast": must be one of draft, standard, reference'),
    (1.0, 'solver.preset = 1.0: must be one of draft'),
    (['draft'], 'must be one of draft'),
])
def test_another_preset_is_one_line(value, words):
    with pytest.raises(SceneError) as error:
        from_parameters({'solver.preset': value}, 'test')
    assert words in str(error.value)
    assert '\n' not in str(error.value)


def test_a_misspelt_preset_key_is_told():
    with pytest.raises(SceneError, match='did you mean solver.preset'):
        from_parameters({'solver.presett': 'draft'}, 'test')


def test_a_step_that_does_not_fit_is_told():
    with pytest.raises(SceneError, match='run.sample = 0.0005: not a whole multiple'):
        from_parameters({'solver.preset': 'draft', 'run.sample': 5e-4}, 'test')
