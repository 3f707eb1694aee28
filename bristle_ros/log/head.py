"""What a log begins with: the scene, where it was made, and how its topics were called."""
from typing import NamedTuple

from bristle_ros.messages import encode as messages, encode_scene, SCENE
from bristle_ros.scene import to_yaml, with_contents

from .machine import provenance


class Head(NamedTuple):
    """The same thrice: as metadata records, as a file (the scene), and as a message."""

    yaml: str
    machine: dict
    run: dict
    message: bytes      # of `~/scene`


def head_of(scene, origin, resolve):
    """Return the Head of a run; origin [ns], resolve: contract name -> full topic name."""
    yaml, machine = to_yaml(with_contents(scene)), provenance()
    run = {'integration_time_step': repr(scene.solver.integration_time_step),
           'time_origin_ns': str(origin)}
    names = [*(topic.name for topic in messages.TOPICS), *messages.command_types(True),
             messages.MEAN_WRENCH, messages.EVENTS, SCENE, messages.TRANSFORMS, messages.DESCRIPTION, '/diagnostics',
             '/clock']
    topics = {resolve(name): name for name in names}
    return Head(yaml, machine, run, encode_scene(yaml, machine, run, topics))
