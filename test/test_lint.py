"""The linters, on the whole checkout: style by ruff, types of what scripts import by mypy."""
import subprocess
import sys

import pytest

COMMANDS = [
    'ruff check .',
    'mypy --strict --follow-imports=silent bristle_ros/scene bristle_ros/simulation '
    'bristle_ros/messages bristle_ros/__init__.py bristle_ros/lazy.py']


@pytest.mark.parametrize('command', COMMANDS, ids=lambda command: command.partition(' ')[0])
def test_the_linter_is_silent(root, tmp_path, command):
    cache = ['--cache-dir', str(tmp_path)]
    done = subprocess.run([sys.executable, '-m', *command.split(), *cache], cwd=root, text=True,
                          capture_output=True, timeout=600)
    assert done.returncode == 0, done.stdout + done.stderr


@pytest.mark.parametrize('command', COMMANDS, ids=lambda command: command.partition(' ')[0])
def test_contributors_are_told_the_command(root, command):
    assert f'`{command}`' in ' '.join((root / 'CONTRIBUTING.md').read_text('utf-8').split())
