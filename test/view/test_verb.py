"""The command line of `view`: what cannot be used is one line; a page is served, and ends."""
import os
from pathlib import Path
import signal
import socket
import subprocess
import sys
import time
from urllib.request import urlopen

import pytest

ROOT = Path(__file__).resolve().parents[2]
SCENE = str(ROOT / 'test/small_brush.yaml')
LIMIT = 600.0   # [s] before a wait is a failure


def view(*arguments, code='from bristle_ros.__main__ import main; raise SystemExit(main())'):
    return subprocess.Popen([sys.executable, '-c', code, 'view', *arguments], cwd=ROOT,
                            text=True, stdout=subprocess.PIPE, stderr=subprocess.PIPE,
                            start_new_session=True)


def refusal(*arguments, **how):
    process = view(*arguments, **how)
    printed, said = process.communicate(timeout=LIMIT)
    assert (process.returncode, printed) == (2, '')
    assert said.count('\n') == 1
    return said


def free_port():
    with socket.socket() as probe:
        probe.bind(('127.0.0.1', 0))
        return str(probe.getsockname()[1])


def test_a_port_in_use_is_one_line():
    with socket.socket() as taken:
        taken.bind(('127.0.0.1', 0))
        taken.listen()
        port = str(taken.getsockname()[1])
        said = refusal(SCENE, '--port', port)
    assert said == (f'view: --port = {port}: cannot listen on 127.0.0.1 (Address already in use): '
                    'give another --port or --host\n')


@pytest.mark.parametrize(('arguments', 'reason'), [
    (['nowhere.yaml'], 'nowhere.yaml: cannot be read'),
    ([SCENE, '-p', 'drive.mean_sped:=3'], 'did you mean drive.mean_speed'),
    ([SCENE, '-p', 'drive.mean_speed'], 'write key:=value'),
    ([SCENE, '--node', 'brush_node'], 'a node has its own scene'),
    ([SCENE, '--port', '70000'], '--port = 70000: must be 0 to 65535'),
    ([SCENE, '--host', 'nosuchhost.invalid'], 'cannot listen on nosuchhost.invalid'),
    (['nothing.mcap'], 'nothing.mcap: no such file'),
])
def test_unusable_input_is_one_line(arguments, reason):
    assert reason in refusal(*arguments, '--port', '0', *(
        arguments[-2:] if '--port' in arguments else ()))


def test_a_missing_extra_is_told():
    said = refusal(SCENE, code='import sys; sys.modules["viser"] = None\n'
                   'from bristle_ros.__main__ import main; raise SystemExit(main())')
    assert "pip install 'bristle_ros[view]'" in said
    assert './run.sh view' in said


def test_a_page_is_served_until_ctrl_c():
    port = free_port()
    process = view(SCENE, '--port', port, '--host', '0.0.0.0')
    try:
        assert process.stdout.readline() == f'view: http://0.0.0.0:{port} (Ctrl-C ends it)\n'
        assert 'whoever can reach port' in process.stdout.readline()
        with urlopen(f'http://127.0.0.1:{port}', timeout=LIMIT) as page:
            assert b'<html' in page.read()
        children = children_of(process.pid)
        assert children
        process.send_signal(signal.SIGINT)
        process.send_signal(signal.SIGINT)
        printed, said = process.communicate(timeout=LIMIT)
    finally:
        process.kill()
    assert (process.returncode, said) == (0, ''), printed + said
    end = time.monotonic() + LIMIT
    while any(Path(f'/proc/{child}').exists() for child in children):
        assert time.monotonic() < end, 'the process that simulates is still there'
        time.sleep(0.1)


def children_of(pid):
    """Return the processes that a process has started."""
    tasks = Path(f'/proc/{pid}/task')
    return [child for task in os.listdir(tasks)
            for child in (tasks / task / 'children').read_text().split()]
