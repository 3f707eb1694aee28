"""Parts of a step that can be compiled by themselves: about half of what there is to compile."""
from bristle_ros.physics.compiler import Call, called, plain
from bristle_ros.physics.contact import ContactLaw
from bristle_ros.physics.wire import factorise
import numpy as np

from . import output
from .records import bristle_of, Model, Scratch, State
from .scheme import step_coefficients
from .touching import correct_points, end_touch, points_born, touch_error


def parts_of_step(model: Model, law: ContactLaw | None, viscosity: float | None, state: State,
                  scratch: Scratch) -> list[Call]:
    """
    Return kernels that a step of a scene calls, with arguments of the types it calls them with.

    In the order in which a process that compiles the whole step comes to them.
    """
    bristle = plain(bristle_of)(model, state, 0)
    step = plain(step_coefficients)(model.scheme, model.mass_damping, viscosity, model.its)
    seen = (called(output.observe), (model, law, viscosity, state, scratch,
                             np.zeros((1, output.BRISTLE_COLUMNS)), np.zeros(output.TOTALS)))
    matrix = (factorise, (bristle.nodes, model.elements, model.section, step, scratch.frames[2],
                          bristle.mids, bristle.chain, scratch.work))
    if law is None or law.wire is None:
        return [matrix, seen]
    wire, h = law.wire, model.its
    return [matrix, (correct_points, (wire, bristle, law, law.surface, step, scratch, True)),
            (points_born, (model, law, wire, bristle, scratch)),
            (touch_error, (model, wire, bristle, scratch, h, 0.0, (0.0, 0.0, 0.0))),
            (end_touch, (model, wire, bristle, law, h, 0.0, 0.0, scratch)), seen]
