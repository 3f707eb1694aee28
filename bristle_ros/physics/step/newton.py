"""
One step by Newton's method with a frozen matrix, which either converges or leaves all as it was.

The matrix is kept as long as it pays: see matrix.py. With the section force as an unknown of its
own (wire/section_force) that is for many steps.
"""
from typing import NamedTuple

from bristle_ros.physics.compiler import inlined, jit
from bristle_ros.physics.contact import (begin_contact, CONTRACTION, correct_contact, ESTIMATE,
                                         ESTIMATED, finish_on_surface, FORCE, GAP, IMPULSE,
                                         keep_rate, LIVING, MATRIX_STEP, NONE_BORN, rotate_back,
                                         STATE, STEP, TOO_MANY, TREND)
from bristle_ros.physics.motion import CLAMP, ROTATION
from bristle_ros.physics.wire import (accept_damping, accept_section_forces, accept_step,
                                      add_air, add_excess, begin_section_forces, begin_step,
                                      eliminate, internal_forces, LANES, largest_turn,
                                      local_error, MASS, move_nodes, OK, predict_damping,
                                      rescale_memory, residual, strains, substitute, tip_lane,
                                      update_section_forces)

from .energy import account_step, DISSIPATED
from .matrix import expected_rate, judge_matrix, LEAST, NEW, renew_matrix, SLOW, UNKNOWN
from .records import FAILURES, NEWTON
from .scheme import newton_tolerance, step_coefficients
from .stress import note_stress
from .touching import (begin_touch, correct_points, end_touch, give_up_points, may_touch,
                       points_born, touch_error, touches)

MAX_ITERATIONS = 20     # of Newton in one attempt, matrix refreshed when they shrink slowly
FARTHEST = 1.0          # [rad] that a node may turn in a step in the brush's axes
SUSPECT = 6             # iterations after which what they end in may be another solution

# status of a step; 0 is done
SINGULAR_MATRIX = 1
NO_CONVERGENCE = 2
NOT_FINITE = 3
TOO_INACCURATE = 4      # the local error is above what it may be: never the last word, since the
#                         finest sub-steps are taken whatever theirs
UNFINISHED = 5          # attempts ran out
CLAMP_INSIDE = 6        # a clamp is at the surface of the road
TOO_MANY_POINTS = 7     # of contact on one wire at one time


class Corrections(NamedTuple):
    """How Newton's method went in a step."""

    status: int             # OK, or why it failed
    iterations: int
    contraction: float      # what the second correction was of the first one
    renewed: bool           # the matrix was made in this step
    single: bool            # one correction would have done with a matrix as it is when new
    refresh: bool           # it contracted too slowly in the last iteration


@inlined
def predict(model, law, viscosity, bristle, scratch, step):
    """Fill the step's histories, and put what it is expected to end in into the positions."""
    nodes, tip = bristle.nodes, bristle.tip
    begin_step(nodes, model.blocks, step.h, model.scheme, tip[TREND], tip[TREND + 1])
    begin_section_forces(nodes, model.blocks)
    if viscosity is not None:
        predict_damping(nodes, model.blocks, model.section, viscosity, step.cv, step.keep,
                        step.drift)
    if law is not None:
        block, lane = tip_lane(model.elements)
        begin_contact(nodes, block, lane, step, scratch.frames[1], tip)
        if touches(law.wire, tip):
            begin_touch(law.wire, bristle, step, scratch)


@inlined
def find_correction(model, law, bristle, scratch, step, fresh):
    """Solve for the increments and the contact; return whether that problem could be solved."""
    nodes, mids, chain = bristle.nodes, bristle.mids, bristle.chain
    solved = True
    add_excess(nodes, mids)
    if law is not None:
        if touches(law.wire, bristle.tip):
            return correct_points(law.wire, bristle, law, law.surface, step, scratch, fresh)
        eliminate(nodes, model.elements, mids, chain)
        solved = correct_contact(bristle, law, law.surface, step, scratch.frames,
                                 scratch.contact)
    else:
        eliminate(nodes, model.elements, mids, chain)
    substitute(nodes, model.elements, mids, chain)
    return solved


@inlined
def points_missed(model, law, bristle, scratch):
    """Return how many points a step that has converged needs beside those in use."""
    born = NONE_BORN
    if law is not None:
        section, end = model.section, scratch.frames[2]
        if may_touch(law.surface, law.wire, bristle.nodes, model.elements,
                     section.element_length, end):
            born = points_born(model, law, law.wire, bristle, scratch)
    return born


@inlined
def apply_correction(model, bristle, step):
    """Move the nodes by the increments; return the size as `move_nodes` does."""
    nodes, mids = bristle.nodes, bristle.mids
    update_section_forces(nodes, mids, model.section, step.factor)
    bristle.counts[NEWTON] += 1
    return move_nodes(nodes, model.blocks, model.section.element_length)


@jit
def has_flipped(nodes, model):
    """
    Return whether a node has turned further in a step than any wire does.

    A step has more than one solution: in another one an element is turned inside out. Where axes
    turn with the brush alone: in the displacement load case it turns nodes as far as it likes.
    """
    return not model.displacement and largest_turn(nodes, model.blocks) > FARTHEST


@jit
def expected_error(tip, h):
    """Return the local error [m] that a step of length h will have, by the last one's: ~ h^3."""
    if tip[ESTIMATED] == 0.0:
        return 0.0
    return tip[ESTIMATE] * (h / tip[ESTIMATED]) ** 3


@inlined
def solve_step(model, law, bristle, scratch, step):
    """Correct the prediction until the correction to come is within the tolerance."""
    nodes, tip = bristle.nodes, bristle.tip
    end = scratch.frames[2]
    tolerance = newton_tolerance(model.scheme, step.h,
                                 expected_error(tip, step.h) / model.section.element_length)
    refresh = tip[MATRIX_STEP] != step.h
    rate = contraction = expected_rate(tip, refresh)
    renewed = False
    single = False
    iterations = 0
    before = 0.0
    first = 0   # iteration from which the present points take part
    status = NO_CONVERGENCE
    for iteration in range(MAX_ITERATIONS):
        internal_forces(nodes, model.blocks, end[CLAMP:], model.section, step.factor, 1.0)
        residual(nodes, model.blocks, step.ca, step.cv, model.mass_damping, end)
        add_air(nodes, model.blocks, step.cv, model.air, end)
        fresh = refresh
        if fresh:
            if not renew_matrix(model, bristle, scratch, step):
                status = SINGULAR_MATRIX
                break
            renewed = True
        solved = find_correction(model, law, bristle, scratch, step, fresh)
        if fresh and not solved:
            break
        refresh = not solved
        size = apply_correction(model, bristle, step)
        iterations += 1
        if not size < 1e29:
            status = NOT_FINITE
            break
        if iteration == 0:
            single = size * NEW <= tolerance
        if iteration > first:
            rate = size / before
            if iteration == 1:
                contraction = UNKNOWN if fresh else min(max(rate, LEAST), 0.5)
            if rate > SLOW:
                if fresh and rate > 2.0 and iteration > first + 2:
                    break
                refresh = True
        elif size > 1.0:
            refresh = True
        before = size
        if solved and (size <= tolerance and rate < 1.0
                       or size * rate <= tolerance * (1.0 - rate)):
            if iterations > SUSPECT and has_flipped(nodes, model):
                break
            born = points_missed(model, law, bristle, scratch)
            if born == NONE_BORN:
                status = OK
                break
            if born == TOO_MANY:
                status = TOO_MANY_POINTS
                break
            first = iteration + 1
            rate = max(rate, UNKNOWN)
    return Corrections(status, iterations, contraction, renewed, single, refresh)


@inlined
def estimate_error(model, law, bristle, scratch, h, living, change1, change2, change3):
    """
    Return the step's local error.

    living : points in use before it;  change [N]: of the tip's force over it, road axes
    """
    if law is not None:  # noqa: SIM102
        if living > 0.0 or touches(law.wire, bristle.tip):
            return touch_error(model, law.wire, bristle, scratch, h, living,
                               (change1, change2, change3))
    block, lane = tip_lane(model.elements)
    p1, p2, p3 = rotate_back(scratch.frames[1], ROTATION, change1, change2, change3)
    inverse = 1.0 / bristle.nodes[block, MASS * LANES + lane]
    return local_error(bristle.nodes, model.elements, h, model.scheme,
                       (p1 * inverse, p2 * inverse, p3 * inverse))


@inlined
def accept(model, law, viscosity, audit, bristle, scratch, step, living):
    """
    Carry a converged step over into what the next one starts from, and keep its accounts.

    living : points in use before it
    """
    nodes, tip, scheme, h = bristle.nodes, bristle.tip, model.scheme, step.h
    end = scratch.frames[2]
    if audit is not None:
        internal_forces(nodes, model.blocks, end[CLAMP:], model.section, step.factor, 0.0)
        account_step(model, law, viscosity, audit, bristle, scratch, step)
        note_stress(model, audit, nodes, scratch)
    if viscosity is not None:
        strains(nodes, model.blocks, end[CLAMP:], model.section.element_length)
        accept_damping(nodes, model.blocks, step.cv, step.keep, step.drift,
                       1.0 / (scheme.beta * h * h), 1.0 / (scheme.beta * h),
                       0.5 / scheme.beta - 1.0)
    accept_section_forces(nodes, model.blocks)
    tip[TREND], tip[TREND + 1] = accept_step(nodes, model.blocks, h, scheme)
    if law is not None:
        lost = finish_on_surface(bristle, law, law.surface, h, end, scratch.contact)
        for i in range(3):
            tip[IMPULSE + i] += h * tip[FORCE + i]
        if touches(law.wire, tip):
            lost += end_touch(model, law.wire, bristle, law, h, living, lost, scratch)
        if audit is not None:
            audit[DISSIPATED] += lost


@inlined
def try_step(model, law, viscosity, audit, bristle, scratch, h, shortest):
    """
    Advance one bristle by one step of length h; return OK, or why it failed and stays as it was.

    model : Model             constants; law : ContactLaw or None; viscosity [s] : float or None
    audit : (AUDIT,)          energy accounts, or None
    scratch.frames            at the step's start, middle and end, in the bristle's own axes
    shortest [s] : float      step that is accepted whatever its local error
    """
    tip = bristle.tip
    if tip[STEP] != h and tip[STEP] > 0.0:
        rescale_memory(bristle.nodes, model.blocks, h / tip[STEP])
        tip[STEP] = h
    step = step_coefficients(model.scheme, model.mass_damping, viscosity, h)
    old1, old2, old3 = tip[FORCE], tip[FORCE + 1], tip[FORCE + 2]
    old_state, old_gap, living = tip[STATE], tip[GAP], tip[LIVING]
    predict(model, law, viscosity, bristle, scratch, step)
    found = solve_step(model, law, bristle, scratch, step)
    status = found.status
    if status == OK:
        tip[ESTIMATE] = estimate_error(model, law, bristle, scratch, h, living, tip[FORCE] - old1,
                                       tip[FORCE + 1] - old2, tip[FORCE + 2] - old3)
        tip[ESTIMATED] = h
        if h > shortest and tip[ESTIMATE] > (
                model.local_error if h > model.halved_to else model.worst_error):
            status = TOO_INACCURATE
    if status != OK:
        tip[MATRIX_STEP] = 0.0
        tip[FORCE], tip[FORCE + 1], tip[FORCE + 2] = old1, old2, old3
        tip[STATE], tip[GAP] = old_state, old_gap
        if law is not None:  # noqa: SIM102
            if living > 0.0 or touches(law.wire, tip):
                give_up_points(law.wire, bristle, scratch, living)
        if status != TOO_INACCURATE:
            bristle.counts[FAILURES] += 1
        return status
    tip[CONTRACTION] = found.contraction
    judge_matrix(tip, found, model.scheme.tied)
    tip[STEP] = h
    accept(model, law, viscosity, audit, bristle, scratch, step, living)
    if law is not None and model.scheme.tied:
        keep_rate(tip, old1, old2, old3, h)
    return OK
