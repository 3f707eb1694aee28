"""The command line: exit codes, errors on one line, and what a question must not import."""
import json
import os
import signal
import subprocess
import sys
import time

from bristle_ros import __main__ as command_line, __version__
from bristle_ros.scene.error import SceneError
from bristle_ros.scene.scene import keys
import pytest


def run(root, *arguments, **options):
    return subprocess.run([sys.executable, '-m', 'bristle_ros', *arguments], cwd=root, text=True,
                          capture_output=True, timeout=600, **options)


@pytest.mark.parametrize('arguments', [
    ('--help',), ('--version',), ('scene', '--keys'), ('scene', 'config/tilted_sweep.yaml'),
    ('scene', '--help'), ('simulate', '--help')], ids=' '.join)
def test_questions_import_nothing_heavy(root, arguments):
    code = ('import sys\nfrom bristle_ros.__main__ import main\n'
            'try:\n    code = main(sys.argv[1:])\n'
            'except SystemExit as left:\n    code = left.code\n'
            'import json\nprint(json.dumps([code, sorted(sys.modules)]), file=sys.stderr)')
    done = subprocess.run([sys.executable, '-c', code, *arguments], cwd=root, text=True,
                          capture_output=True, timeout=600)
    exit_code, modules = json.loads(done.stderr.splitlines()[-1])
    assert exit_code == 0
    assert done.stdout
    assert not {'numba', 'rclpy', 'mcap', 'matplotlib', 'rosbags'} & set(modules)
    assert ('numpy' in modules) <= (arguments[0] == 'simulate')


def test_keys_lists_every_key(root):
    listed = run(root, 'scene', '--keys').stdout
    for key in keys():
        line = next(line for line in listed.splitlines()
                    if line.split(' ')[0].rstrip(':') == key.name)
        assert key.unit in ('', '1') or f'[{key.unit}]' in line
        assert key.description in listed
        assert key.range in listed


def test_version(root):
    assert run(root, '--version').stdout == f'bristle_ros {__version__}\n'


@pytest.mark.parametrize(('arguments', 'message'), [
    ([], 'bristle_ros: no verb (--help lists them)'),
    (['simulat'], "bristle_ros: 'simulat' is no verb, did you mean simulate? (--help lists them)"),
    (['scene'],
     'bristle_ros scene: give either --keys or a scene file (--help tells the arguments)'),
    (['scene', '--key'],
     'bristle_ros scene: unrecognized arguments: --key (--help tells the arguments)'),
    (['scene', 'none.yaml'],
     'scene: none.yaml: cannot be read (No such file or directory): give a scene file'),
    (['scene', 'config/tilted_sweep.yaml', '-p', 'gravity'],
     "scene: -p: 'gravity' is not an override: write key:=value"),
    (['scene', 'config/tilted_sweep.yaml', '-p', 'gravity:=-1'],
     'scene: -p: gravity = -1: must be a number from 0 to 1000 m/s^2'),
], ids=lambda value: ' '.join(value) if isinstance(value, list) else '')
def test_unusable_input_is_one_line_and_exit_2(root, arguments, message):
    done = run(root, *arguments)
    assert (done.returncode, done.stderr, done.stdout) == (2, message + '\n', '')


class StepFailure(RuntimeError):
    """Stands for the one of simulation.py, which is known by its name."""


class CommandRefused(ValueError):
    """Likewise."""


@pytest.mark.parametrize(('error', 'code', 'line'), [
    (SceneError('bad', key='gravity', value=-1.0, source='a.yaml:3'), 2,
     'bench: a.yaml:3: gravity = -1.0: bad'),
    (StepFailure('t = 0.1 s, step 1000:\n the tip diverged'), 3,
     'bench: t = 0.1 s, step 1000: the tip diverged'),
    (CommandRefused('cmd_vel = [nan]'), 2, 'bench: cmd_vel = [nan]'),
    (KeyboardInterrupt(), 130, 'bench: interrupted'),
    (PermissionError(13, 'Permission denied', 'out.npz'), 2, 'bench: out.npz: Permission denied'),
    (ModuleNotFoundError("No module named 'rclpy'", name='rclpy'), 2,
     "bench: needs the Python package 'rclpy', which is not installed: see README.md, Installing"),
], ids=lambda value: type(value).__name__ if isinstance(value, BaseException) else '')
def test_errors_become_exit_codes(monkeypatch, capsys, error, code, line):
    class Verb:
        @staticmethod
        def main(arguments):
            raise error
    monkeypatch.setattr(command_line, 'import_module', lambda *name: Verb)
    assert command_line.main(['bench', 'x']) == code
    assert capsys.readouterr().err == line + '\n'


def test_errors_of_our_own_are_not_hidden(monkeypatch):
    class Verb:
        @staticmethod
        def main(arguments):
            raise ValueError('a mistake in the program')
    monkeypatch.setattr(command_line, 'import_module', lambda *name: Verb)
    with pytest.raises(ValueError, match='a mistake'):
        command_line.main(['bench'])


def test_a_reader_that_leaves_is_no_error(root):
    read, write = os.pipe()
    os.close(read)
    done = subprocess.run([sys.executable, '-m', 'bristle_ros', 'scene', '--keys'], cwd=root,
                          stdout=write, stderr=subprocess.PIPE, timeout=600)
    os.close(write)
    assert (done.returncode, done.stderr) == (0, b'')


def test_interrupt_is_one_line_and_exit_130(root, tmp_path):
    pipe = tmp_path / 'scene.yaml'
    os.mkfifo(pipe)  # reading it waits for a writer: the verb hangs until it is interrupted
    process = subprocess.Popen(
        [sys.executable, '-m', 'bristle_ros', 'scene', str(pipe)], cwd=root, text=True,
        stderr=subprocess.PIPE,
        # A suite run in the background has SIGINT ignored, and its children too.
        preexec_fn=lambda: signal.signal(signal.SIGINT, signal.default_int_handler))
    try:
        writer = _open_when_read(pipe)
        assert _interrupted(process) == 'scene: interrupted\n'
        assert process.returncode == 130
        os.close(writer)
    finally:
        process.kill()
        process.wait()


def _interrupted(process):
    """Send SIGINT until the process ends; return its stderr."""
    for _ in range(10):
        process.send_signal(signal.SIGINT)
        try:    # Python sleeps over a signal that comes just before it asks the kernel to read
            return process.communicate(timeout=20)[1]
        except subprocess.TimeoutExpired:
            continue
    raise AssertionError('SIGINT did not end it')


def _open_when_read(pipe):
    deadline = time.monotonic() + 600
    while True:
        try:
            return os.open(pipe, os.O_WRONLY | os.O_NONBLOCK)
        except OSError:  # nobody reads it yet
            assert time.monotonic() < deadline
            time.sleep(0.01)


def shell(root, command, **environment):
    """Run a command line of `bristle_ros` as a shell does, with its redirections."""
    return subprocess.run(['bash', '-c', f'"{sys.executable}" -m bristle_ros {command}'], cwd=root,
                          capture_output=True, text=True, timeout=600,
                          env={**os.environ, **environment})


@pytest.mark.parametrize('command', [
    'scene --keys', 'scene --help', '--help', 'static test/small_brush.yaml'])
def test_a_closed_stdout_is_one_line(root, command):
    done = shell(root, f'{command} >&-')
    verb = 'bristle_ros' if command == '--help' else command.split()[0]
    assert (done.returncode, done.stderr) == (2, f'{verb}: stdout: Bad file descriptor\n')


def test_a_closed_stdout_takes_no_file(root, tmp_path):
    """The next file that is opened would get its number, and all that C code prints."""
    done = shell(root, f'simulate test/small_brush.yaml --duration 0.01 --output {tmp_path}/a.csv '
                 '>&- 2>&- <&-')
    assert (done.returncode, done.stdout, done.stderr) == (2, '', '')
    first, *rows = (tmp_path / 'a.csv').read_text().splitlines()
    assert first.startswith('t,theta,')
    assert {row.count(',') for row in rows} == {first.count(',')}


def test_a_closed_stderr_does_no_harm(root):
    done = shell(root, 'scene none.yaml 2>&-')
    assert (done.returncode, done.stdout, done.stderr) == (2, '', '')


def test_a_terminal_without_the_letter_gets_an_escape(root, tmp_path):
    path = f'{tmp_path}/b\u00fc.csv'
    done = shell(root, f'simulate test/small_brush.yaml --duration 0.01 --output {path}',
                 LC_ALL='C', PYTHONIOENCODING='ascii')
    assert (done.returncode, done.stderr) == (0, '')
    assert done.stdout.endswith(f'written: {tmp_path}/b\\xfc.csv\n')
    assert os.path.exists(path)


# A compiler's callback drops what a handler raises; the program must not go on as if it had not.
SWALLOWED = """
import signal, sys
signal.signal(signal.SIGINT, signal.default_int_handler)    # in the background it is ignored
import numba
from numba.extending import overload
def asked():
    pass
@overload(asked)
def compile_asked():
    try:
        signal.raise_signal(signal.SIGINT)
    except KeyboardInterrupt:
        pass
    return lambda: 1
from bristle_ros import __main__
from bristle_ros.verbs import static
static.main = lambda arguments: print(numba.njit(lambda: asked())())
sys.argv[1:] = []
__main__.static()
"""


def test_interrupt_while_compiling_ends_at_once(root):
    done = subprocess.run([sys.executable, '-c', SWALLOWED], cwd=root, text=True,
                          capture_output=True, timeout=600)
    assert (done.returncode, done.stdout, done.stderr) == (130, '', 'static: interrupted\n')


@pytest.mark.parametrize(('arguments', 'code', 'line'), [
    (('simulate', 'test/small_brush.yaml', '--duration', '1.0'), 130, 'simulate: interrupted\n'),
    (('brush_node', '--ros-args', '--params-file', 'test/small_brush.yaml'), 0,
     'stopped while kernels were compiled: nothing was run\n')])
def test_interrupt_of_a_first_start_is_quiet(root, tmp_path, environment, arguments, code, line):
    process = subprocess.Popen(
        [sys.executable, '-m', 'bristle_ros', *arguments], cwd=root, text=True,
        stdout=subprocess.PIPE, stderr=subprocess.PIPE,
        env={**os.environ, 'XDG_CACHE_HOME': str(tmp_path)},
        preexec_fn=lambda: signal.signal(signal.SIGINT, signal.default_int_handler))
    try:
        deadline = time.monotonic() + 300
        while not list(tmp_path.rglob('*.nbc')):    # from then on it compiles
            assert time.monotonic() < deadline
            assert process.poll() is None
            time.sleep(0.01)
        process.send_signal(signal.SIGINT)
        out, err = process.communicate(timeout=300)
    finally:
        process.kill()
        process.wait()
    assert (process.returncode, err.count('\n')) == (code, 1)
    assert err.endswith(line)
    assert 'simulated' not in out
    assert len(list(tmp_path.rglob('*.nbc'))) < 15      # of some thirty
