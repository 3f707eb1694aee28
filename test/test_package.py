"""What installing with pip leaves behind: what `ros2 run` looks for, and what Python looks for."""
import os
from pathlib import Path
import re
import shutil
import subprocess
import sys
from xml.etree import ElementTree

from bristle_ros import __main__ as command_line, __version__
from bristle_ros.scene.scene import load
import pytest

VERBS = sorted(command_line.VERBS)
# With what mypy finds wrong in it.
TYPED_SCRIPT = """import bristle_ros
scene = bristle_ros.load('scene.yaml')
length: float = scene.bristle.length
simulation = bristle_ros.build(scene)
simulation.command('cmd_brush_speed', 8)
speed: float = simulation.snapshot().omega
scene.bristle.lenght                    # attr-defined
simulation.advance(1.5)                 # arg-type
"""


def clean_environment(**more):
    """Return an environment in which nothing of this checkout or its environment is in the way."""
    dropped = ('PYTHONPATH', 'PYTHONHOME', 'VIRTUAL_ENV', 'AMENT_PREFIX_PATH', 'LD_LIBRARY_PATH',
               '_ROS_WHEELS_BOOTSTRAP_COMPLETE')
    return {name: value for name, value in os.environ.items() if name not in dropped} | more


@pytest.fixture(scope='module')
def prefix(root, tmp_path_factory):
    """
    Install the package into a virtual environment of its own, as `pip install .` does.

    Its dependencies are those of the environment that the tests run in, seen through a .pth file.
    """
    work = tmp_path_factory.mktemp('package')
    source = work / 'source'
    # A copy: pip leaves build/ behind in what it builds.
    shutil.copytree(root, source, ignore=shutil.ignore_patterns(
        '.*', '__pycache__', '*.egg-info', 'build', 'install'))
    prefix = work / 'venv'
    subprocess.run([sys.executable, '-m', 'venv', '--without-pip', prefix], check=True,
                   env=clean_environment())
    [site] = (prefix / 'lib').glob('python3*/site-packages')
    [theirs] = [path for path in map(Path, sys.path) if (path / 'yaml').is_dir()]
    (site / 'dependencies.pth').write_text(f'{theirs}\n', encoding='utf-8')
    done = subprocess.run(
        [sys.executable, '-m', 'pip', '--python', prefix, 'install', '--quiet', '--no-deps',
         '--no-build-isolation', '--no-index', '--disable-pip-version-check', str(source)],
        env=clean_environment(), capture_output=True, text=True, timeout=600)
    assert done.returncode == 0, done.stderr
    return prefix


def test_ros2_run_finds_every_verb(prefix):
    assert (prefix / 'share/ament_index/resource_index/packages/bristle_ros').is_file()
    assert (prefix / 'share/bristle_ros/package.xml').is_file()
    found = sorted(path.name for path in (prefix / 'lib/bristle_ros').iterdir()
                   if path.is_file())
    assert found == VERBS
    for verb in VERBS:
        assert os.access(prefix / 'lib/bristle_ros' / verb, os.X_OK)
        assert os.access(prefix / 'bin' / verb, os.X_OK)


@pytest.mark.parametrize('folder', ['lib/bristle_ros', 'bin'])
def test_an_installed_verb_runs(prefix, folder, tmp_path):
    environment = clean_environment(PATH=f'{prefix / "bin"}:{os.environ["PATH"]}')
    done = subprocess.run([prefix / folder / 'simulate', 'none.yaml', '--duration', '1'],
                          cwd=tmp_path, env=environment, capture_output=True, text=True,
                          timeout=600)
    assert done.returncode == 2
    assert done.stderr == ('simulate: none.yaml: cannot be read (No such file or directory): '
                           'give a scene file\n')


def test_scenes_and_modules_are_installed(root, prefix):
    scenes = sorted(path.name for path in (root / 'config').glob('*.yaml'))
    assert {'cutting_brush.yaml', 'damping_study.yaml', 'free_rotation.yaml',
            'tilted_sweep.yaml'} <= set(scenes)
    for name in scenes:
        assert load(prefix / 'share/bristle_ros/config' / name) == load(root / 'config' / name)
    [site] = (prefix / 'lib').glob('python3*/site-packages')
    installed = {path.relative_to(site) for path in (site / 'bristle_ros').rglob('*.py')}
    assert installed == {path.relative_to(root) for path in (root / 'bristle_ros').rglob('*.py')}


def test_metadata_agrees(root, prefix):
    package = ElementTree.parse(root / 'package.xml').getroot()
    assert package.get('format') == '3'
    assert package.findtext('name') == 'bristle_ros'
    assert package.findtext('version') == __version__
    assert package.findtext('license') == 'Apache-2.0'
    assert package.findtext('export/build_type') == 'ament_python'
    [site] = (prefix / 'lib').glob('python3*/site-packages')
    [installed] = site.glob('bristle_ros-*.dist-info')
    assert installed.name == f'bristle_ros-{__version__}.dist-info'
    points = (installed / 'entry_points.txt').read_text(encoding='utf-8')
    for verb in VERBS:
        assert f'{verb} = bristle_ros.__main__:{verb}\n' in points + '\n'
        assert callable(getattr(command_line, verb))
        assert f'from bristle_ros.__main__ import {verb}\n' in (
            root / 'scripts' / verb).read_text(encoding='utf-8')
    assert points.count('bristle_ros.__main__:') == len(VERBS)


def test_scripts_see_the_types(prefix, tmp_path):
    """A type checker takes an installed package's types only where it finds py.typed."""
    (tmp_path / 'script.py').write_text(TYPED_SCRIPT, encoding='utf-8')
    done = subprocess.run(
        [sys.executable, '-m', 'mypy', '--strict', '--cache-dir', tmp_path / 'cache',
         '--python-executable', prefix / 'bin/python', 'script.py'], cwd=tmp_path,
        env=clean_environment(), capture_output=True, text=True, timeout=600)
    found = re.findall(r'script.py:(\d+): error: .*\[([a-z-]+)\]', done.stdout)
    assert found == [('7', 'attr-defined'), ('8', 'arg-type')], done.stdout + done.stderr


def test_every_package_that_setup_asks_for_is_pinned(root):
    """What pip would install for the package, run.sh installs too."""
    code = (root / 'setup.py').read_text(encoding='utf-8')
    asked = re.search(r'install_requires=\[(.+?)\]', code, re.DOTALL).group(1)
    names = set(re.findall(r"'([a-z0-9-]+)[^']*'", asked))
    pinned = set(re.findall(r'^([a-z0-9-]+)==[0-9.]+', (root / 'requirements.txt').read_text(
        encoding='utf-8'), re.MULTILINE))
    assert {'numba', 'numpy', 'mcap'} <= names <= pinned


@pytest.mark.parametrize('name', ['run.sh', 'test.sh', '.ci/run', 'tools/venv.sh'])
def test_shell_scripts_parse(root, name):
    assert subprocess.run(['sh', '-n', root / name]).returncode == 0
    assert os.access(root / name, os.X_OK) or name == 'tools/venv.sh'


def fake_python(folder, *, version, has_venv):
    """Make a `python3` that answers the two questions of tools/venv.sh."""
    folder.mkdir()
    script = folder / 'python3'
    script.write_text(f"""#!/bin/sh
case "$2" in
    *version_info\\[:2\\]*) exit {0 if version else 1} ;;
    *ensurepip*) exit {0 if has_venv else 1} ;;
    *) echo python3.11 ;;
esac
""", encoding='utf-8')
    script.chmod(0o755)


@pytest.mark.parametrize(('version', 'message'), [
    (True, 'bristle_ros: python3.11 has no venv: apt install python3-venv (or python3.11-venv)\n'),
    (False, 'bristle_ros: needs Python 3.10 to 3.13: apt install python3 python3-venv '
     '(or set PYTHON to one)\n')])
def test_what_is_missing_is_said_in_one_line(root, tmp_path, version, message):
    fake_python(tmp_path / 'bin', version=version, has_venv=False)
    for tool in ('sh', 'cat', 'cksum', 'dirname', 'readlink'):
        (tmp_path / 'bin' / tool).symlink_to(shutil.which(tool))
    checkout = tmp_path / 'checkout'
    (checkout / 'tools').mkdir(parents=True)
    for name in ('run.sh', 'tools/venv.sh', 'requirements.txt'):
        shutil.copy2(root / name, checkout / name)
    done = subprocess.run(['sh', checkout / 'run.sh'], env={'PATH': str(tmp_path / 'bin')},
                          capture_output=True, text=True, timeout=600)
    assert (done.returncode, done.stderr) == (2, message)
