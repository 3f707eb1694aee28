"""The cache of compiled kernels: damaged, not writable, full; and settings numba chokes on."""
import os
import pickle
import resource
import shutil
import subprocess
import sys

import pytest

# The smallest program that loads a kernel, or compiles it.
PROGRAM = """
from bristle_ros.physics.motion.drive import profile_at, SINE
print(sum(profile_at(0.01, SINE, 0.5, 9.0, 0.08)), *map(len, profile_at.called.stats[1:]))
"""


def run(home, program=PROGRAM, *, room=None, **environment):
    """Run a program with its cache in `home`; `room`: the bytes that a file may have."""
    def limit():
        resource.setrlimit(resource.RLIMIT_FSIZE, (room, room))
    done = subprocess.run(
        [sys.executable, '-c', program], text=True, capture_output=True, timeout=600,
        env={**os.environ, 'XDG_CACHE_HOME': str(home), **environment},
        preexec_fn=limit if room is not None else None)
    assert done.returncode == 0, done.stderr
    return done


def files(home):
    """Return the index and the code of the kernel."""
    return [next(home.rglob(f'drive.profile_at-*.{kind}')) for kind in ('nbi', 'nbc')]


@pytest.fixture(scope='module')
def filled(tmp_path_factory):
    """Return a cache that holds the kernel, and what the program prints."""
    home = tmp_path_factory.mktemp('cache')
    done = run(home)
    assert done.stderr == ''
    value, hits, misses = done.stdout.split()
    assert (hits, misses) == ('0', '1')
    return home, value


def test_a_warm_start_prepares_nothing_that_only_compiling_needs(filled):
    home, value = filled
    needed = '\nimport sys\nprint({"numba.np.arraymath", "scipy.linalg"} & {*sys.modules})'
    assert run(home, PROGRAM + needed).stdout.splitlines() == [f'{value} 1 0', 'set()']


def test_what_was_loaded_first_does_not_keep_others_from_compiling(filled, tmp_path):
    home, value = filled
    done = run(shutil.copytree(home, tmp_path / 'home'), PROGRAM + """
import numba
import numpy as np
print(sum(profile_at(0.01, SINE, 0.5, 9, 0.08)), *map(len, profile_at.called.stats[1:]))
print(numba.njit(lambda a, b: np.dot(a, b))(np.eye(2), np.ones((2, 2))).sum())
""")
    assert done.stdout.splitlines() == [f'{value} 1 0', f'{value} 1 1', '4.0']


def machine_code(path):
    """Return the object file in what numba keeps of a kernel."""
    (_, kind, (code, bitcode)), *_ = pickle.loads(path.read_bytes())
    assert kind == 'object'
    assert b'vap_quarter' in bitcode
    return code


def test_a_kernel_that_python_does_not_call_is_kept_without_machine_code(filled, tmp_path):
    home, value = filled
    (inner,) = home.rglob('drive.vap_quarter-*.nbc')
    assert len(machine_code(inner)) < 1000 < len(machine_code(files(home)[1]))
    home = shutil.copytree(home, tmp_path / 'home')
    for file in files(home):
        file.unlink()
    assert run(home).stdout.split() == [value, '0', '1']    # of what was kept of the inner one


def half(content):
    return content[:len(content) // 2]


def zeros_inside(content):
    """Return what a crash of the machine may leave: the right length, and zeros in the code."""
    at = content.index(b'\x7fELF') + 64
    return content[:at] + bytes(256) + content[at + 256:]


@pytest.mark.parametrize('damage', [
    lambda index, code: code.write_bytes(half(code.read_bytes())),
    lambda index, code: code.write_bytes(zeros_inside(code.read_bytes())),
    lambda index, code: index.write_bytes(b''),
    lambda index, code: index.write_bytes(b'garbage\n'),
], ids=['code cut', 'zeros in code', 'index empty', 'index garbage'])
def test_a_damaged_cache_is_compiled_anew(filled, damage):
    home, value = filled
    damage(*files(home))
    done = run(home)
    assert done.stdout.split() == [value, '0', '1']
    assert done.stderr.count('\n') == 1
    assert 'is damaged: compiling anew' in done.stderr
    done = run(home)    # it is whole again
    assert (done.stdout.split(), done.stderr) == ([value, '1', '0'], '')


def test_a_damaged_index_leaves_no_code_that_another_may_name(filled):
    home, _ = filled
    index, code = files(home)
    stale = code.with_name(code.name.replace('.1.nbc', '.2.nbc'))
    stale.write_bytes(code.read_bytes())
    index.write_bytes(b'')
    run(home)
    assert code.exists()
    assert not stale.exists()


def test_a_full_disk_compiles_in_memory(filled, tmp_path):
    _, value = filled
    done = run(tmp_path, room=0)
    assert done.stdout.split()[0] == value
    assert done.stderr.count('\n') == 1
    assert 'cannot be written (File too large): compiling in memory' in done.stderr
    assert run(tmp_path).stderr == ''       # once there is room again


def test_a_home_that_cannot_be_made_compiles_in_memory(filled, tmp_path):
    _, value = filled
    (tmp_path / 'file').touch()
    done = run(tmp_path / 'file')
    assert done.stdout.split()[0] == value
    assert done.stderr == ('bristle_ros: no cache of compiled kernels (Not a directory): '
                           'compiling in memory, at each start\n')


@pytest.mark.parametrize('text', ['0', 'two'])
def test_threads_that_numba_chokes_on_are_refused_in_one_line(root, filled, text):
    done = subprocess.run(
        [sys.executable, '-m', 'bristle_ros', 'static', 'config/cutting_brush.yaml'], cwd=root,
        text=True, capture_output=True, timeout=600,
        env={**os.environ, 'XDG_CACHE_HOME': str(filled[0]), 'NUMBA_NUM_THREADS': text})
    assert done.returncode == 2
    assert done.stderr == (f'static: NUMBA_NUM_THREADS = {text!r}: must be a whole number above '
                           '0: give one, or unset it\n')
