"""What kernels are compiled for, and kernels that the package carries."""
import os
from pathlib import Path
import shutil
import subprocess
import sys

from bristle_ros.target import level_of, LEVELS, target
import pytest

ROOT = Path(__file__).resolve().parent.parent
PROGRAM = """
import sys
sys.path.insert(0, sys.argv[1])
import bristle_ros.physics.motion.drive as drive
print(sum(drive.profile_at(0.01, drive.SINE, 0.5, 9.0, 0.08)),
      *map(len, drive.profile_at.called.stats[1:]), drive.__file__)
"""


def features(*levels):
    return {name: True for level in levels for name in LEVELS[level]}


def test_levels_are_told_by_all_their_features():
    assert level_of({}) == ''
    assert level_of(features('x86-64-v2')) == 'x86-64-v2'
    assert level_of(features('x86-64-v2', 'x86-64-v3')) == 'x86-64-v3'
    assert level_of(features(*LEVELS)) == 'x86-64-v4'
    assert level_of({**features(*LEVELS), 'fma': False}) == 'x86-64-v2'     # no gap below
    assert level_of(features('x86-64-v3', 'x86-64-v4')) == ''


def test_the_level_is_what_numba_compiles_for():
    from bristle_ros.physics.motion.drive import profile_at
    from numba.core.registry import cpu_target
    assert profile_at
    _, name, instructions = cpu_target.target_context.codegen().magic_tuple()
    assert name == target()
    if name in LEVELS:
        assert instructions == ('-prefer-256-bit' if name == 'x86-64-v4' else '')


@pytest.fixture(scope='module')
def carried(tmp_path_factory):
    """Return a copy of the package that carries a kernel, and its own empty cache."""
    folder = tmp_path_factory.mktemp('carried')
    shutil.copytree(ROOT / 'bristle_ros', folder / 'bristle_ros',
                    ignore=shutil.ignore_patterns('__pycache__', 'kernels'))
    value, hits, misses, _ = load(folder, folder / 'made')[0]
    assert (hits, misses) == ('0', '1')
    shutil.copytree(folder / 'made/bristle_ros', folder / 'bristle_ros/kernels')
    return folder, value


def load(folder, cache, **environment):
    """Load the kernel in a process of its own; return (value, hits, misses, file), stderr."""
    done = subprocess.run([sys.executable, '-c', PROGRAM, str(folder)], text=True, cwd=folder,
                          capture_output=True, timeout=600,
                          env={**os.environ, 'XDG_CACHE_HOME': str(cache), **environment})
    assert done.returncode == 0, done.stderr
    found = done.stdout.split()
    assert found[3].startswith(str(folder))
    return found, done.stderr


def test_what_the_package_carries_is_loaded_and_left_alone(carried, tmp_path):
    folder, value = carried
    (found, told) = load(folder, tmp_path)
    assert (found[:3], told) == ([value, '1', '0'], '')
    assert not list(tmp_path.rglob('*.nbc'))


def test_without_any_cache_of_the_user_it_is_loaded_too(carried, tmp_path):
    folder, value = carried
    (tmp_path / 'file').touch()
    found, told = load(folder, tmp_path / 'file')
    assert found[:3] == [value, '1', '0']
    assert told.startswith('bristle_ros: no cache of compiled kernels')


def test_a_damaged_one_is_compiled_anew(carried, tmp_path):
    folder, value = carried
    [code] = (folder / 'bristle_ros/kernels').rglob('drive.profile_at-*.nbc')
    whole = code.read_bytes()
    at = whole.index(b'\x7fELF') + 64
    code.write_bytes(whole[:at] + bytes(256) + whole[at + 256:])
    try:
        found, told = load(folder, tmp_path)
        assert found[:3] == [value, '0', '1']
        assert 'is damaged: compiling anew' in told
        assert told.count('\n') == 1
        assert load(folder, tmp_path)[0][:3] == [value, '1', '0']   # from the user's cache
    finally:
        code.write_bytes(whole)


def test_one_of_other_sources_is_not_looked_at(carried, tmp_path):
    """A copy of the package in which a kernel's file has been edited."""
    folder, value = carried
    shutil.copytree(folder / 'bristle_ros', tmp_path / 'bristle_ros')
    with open(tmp_path / 'bristle_ros/physics/wire/beam.py', 'a', encoding='utf-8') as file:
        file.write('# edited\n')
    assert load(tmp_path, tmp_path / 'cache')[0][:3] == [value, '0', '1']


def test_one_of_another_target_is_not_loaded(carried, tmp_path):
    folder, value = carried
    found, _ = load(folder, tmp_path, NUMBA_CPU_NAME='generic')
    assert found[1:3] == ['0', '1']
    assert float(found[0]) == pytest.approx(float(value), rel=1e-12)


def test_a_level_that_the_processor_has_not_is_refused(root):
    done = subprocess.run(
        [sys.executable, '-m', 'bristle_ros', 'compile', '--target', 'x86-64-v4'], cwd=root,
        text=True, capture_output=True, timeout=600,
        env={**os.environ, 'NUMBA_CPU_NAME': 'x86-64-v3'})
    assert done.returncode == 2
    assert done.stderr == ('compile: --target = "x86-64-v4": this processor has x86-64-v3: take '
                           'that, or a lower level\n')
