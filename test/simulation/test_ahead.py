"""The process that compiles parts of a step while the one that wants them compiles the rest."""
import json
import os
import subprocess
import sys

from bristle_ros.physics.compiler import is_cached
from bristle_ros.scene import from_parameters, load, to_parameters
from bristle_ros.simulation import ahead, Simulation
import pytest


@pytest.mark.parametrize('changes', [{}, {'contact.points': 'tip'}, {'contact.enabled': False}])
def test_what_it_compiles_is_what_a_step_calls(root, changes):
    scene = load(root / 'config/cutting_brush.yaml', changes)
    Simulation(scene)
    parts = ahead.parts_of(scene)
    assert len(parts) == (2 if changes else 6)
    for call in parts:
        assert is_cached(call), call[0].py_func.__name__


def test_what_has_not_been_compiled_is_told(root):
    scene = load(root / 'config/cutting_brush.yaml')
    kernel, arguments = ahead.parts_of(scene)[0]
    assert not is_cached((kernel, (*arguments, 1.0)))


def test_the_other_process_does_it(root):
    scene = from_parameters({'contact.enabled': False, 'solver.elements': 4}, 'test')
    Simulation(scene)   # it has it from the cache
    done = subprocess.run([sys.executable, '-c', ahead.PROGRAM], text=True, capture_output=True,
                          cwd=root, input=json.dumps(to_parameters(scene)), timeout=600,
                          env={**os.environ, ahead.HELPING: '1'})
    assert (done.returncode, done.stdout, done.stderr) == (0, '', '')


def test_it_is_started_where_a_core_is_free_and_something_is_missing(monkeypatch):
    scene, started = from_parameters({}, 'test'), []
    monkeypatch.setattr(ahead, '_start', started.append)
    monkeypatch.delenv(ahead.HELPING, raising=False)
    monkeypatch.setattr(ahead, 'parts_of', lambda scene: [()])
    monkeypatch.setattr(ahead, 'is_cached', lambda call: False)
    monkeypatch.setattr(os, 'sched_getaffinity', lambda process: {0, 1})
    cases = ((1, {}, 1), (2, {}, 0), (1, {ahead.HELPING: '1'}, 0))
    for running, others, count in cases:
        monkeypatch.setattr(ahead, 'running', lambda running=running: running)
        for name, value in others.items():
            monkeypatch.setenv(name, value)
        started.clear()
        ahead._known.clear()
        for _ in range(2):      # the second time it is not asked
            with ahead.compiling_ahead(scene):
                pass
        assert len(started) == count


def test_running_threads_are_counted(monkeypatch, tmp_path):
    assert 1 <= ahead.running() < 1000
    (tmp_path / 'load').write_text('0.47 1.24 1.51 3/77 18207\n')
    monkeypatch.setattr(ahead, 'LOAD', tmp_path / 'load')
    assert ahead.running() == 3
    monkeypatch.setattr(ahead, 'LOAD', tmp_path / 'none')
    assert ahead.running() > 1000   # where nothing says it, no process is started


def test_one_that_cannot_be_started_is_done_without(monkeypatch):
    monkeypatch.setattr(sys, 'executable', '/nowhere/python')
    assert ahead._start(from_parameters({}, 'test')) is None
