"""
Two processes that compile what a scene needs, where the cache has it not and a core is free.

The compiler holds a lock, so that threads would wait for each other. Another process compiles
parts of a step, and leaves them in the cache, while this one compiles the rest: whoever comes to
a part first compiles it. What is compiled does not depend on who does it.
"""
from collections.abc import Iterator
from contextlib import contextmanager
import json
import math
import os
from pathlib import Path
import subprocess
import sys

from bristle_ros.physics.compiler import Call, compile_for, is_cached
from bristle_ros.physics.step import parts_of_step
from bristle_ros.scene import from_parameters, Scene, to_parameters, with_contents

from .model import build_models, build_state, contact_law, new_scratch, viscosity_of

_known: set[object] = set()     # kinds of scenes that this process has looked up

HELPING = 'BRISTLE_ROS_COMPILING_AHEAD'     # in the environment of the other process
PROGRAM = 'from bristle_ros.simulation.ahead import main; main()'
LOAD = Path('/proc/loadavg')
PACKAGE = Path(__file__).resolve().parents[2]


def parts_of(scene: Scene) -> list[Call]:
    """Return the parts of a scene's step that are compiled by themselves."""
    models = build_models(scene)
    law = contact_law(scene)
    return parts_of_step(models[0], law, viscosity_of(scene), build_state(scene, models[0]),
                         new_scratch(models[0], law))


def kind_of(scene: Scene) -> tuple[object, ...]:
    """
    Return what decides which functions a scene needs, as a tuple that can be compared.

    Its choices, and which of its numbers are zero or infinite.
    """
    return tuple((value == 0.0, math.isinf(value)) if isinstance(value, float) else str(value)
                 for value in to_parameters(scene).values())


def _is_new(scene: Scene) -> bool:
    """Whether a scene may need functions that none of this process has needed."""
    kind = kind_of(scene)
    new = kind not in _known
    _known.add(kind)
    return new


def _has_room() -> bool:
    """Whether a core is free for another process."""
    cores = len(os.sched_getaffinity(0))
    return HELPING not in os.environ and running() < cores


def running() -> int:
    """Return how many threads of this machine run or wait for a core, this one among them."""
    try:
        return int(LOAD.read_text().split()[3].partition('/')[0])   # averages lag by a minute
    except (OSError, ValueError, IndexError):
        return sys.maxsize


@contextmanager
def compiling_ahead(scene: Scene) -> Iterator[None]:
    """Have another process compile, while the block does, what both are going to need."""
    helper = None
    if _is_new(scene) and _has_room() and not all(map(is_cached, parts_of(scene))):
        helper = _start(scene)
    try:
        yield
    finally:
        if helper:
            helper.kill()       # what it has not done is done here by now
            helper.wait()


def _start(scene: Scene) -> subprocess.Popen[str] | None:
    path = os.pathsep.join(filter(None, (str(PACKAGE), os.environ.get('PYTHONPATH'))))
    try:
        helper = subprocess.Popen(
            [sys.executable, '-c', PROGRAM], text=True, stdin=subprocess.PIPE,
            stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL,
            env={**os.environ, HELPING: '1', 'PYTHONPATH': path})
        assert helper.stdin is not None
        with helper.stdin as pipe:
            json.dump(to_parameters(with_contents(scene)), pipe)
    except OSError:
        return None     # it would only have been quicker
    return helper


def main() -> None:
    """Compile the parts of the scene that stdin gives; in the other process."""
    for call in parts_of(from_parameters(json.load(sys.stdin), 'stdin')):
        compile_for(call)
