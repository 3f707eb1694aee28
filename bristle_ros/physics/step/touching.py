"""
What contact along the wire adds to a step; where the tip alone touches it compiles to nothing.

The compiler leaves out what asks an argument for None, in a condition of its own.
"""
from bristle_ros.physics.compiler import jit
from bristle_ros.physics.contact import (ALIVE, begin_points, carry_points, correct_together,
                                         fill_columns, find_points, finish_points, FORCE, gather,
                                         IMPULSE, is_clear_of_plane, keep_points, keep_rate,
                                         LIVING, NONE_BORN, node_of, restore_points, rotate_back,
                                         rubbed, weights, XI)
from bristle_ros.physics.motion import ROTATION
from bristle_ros.physics.wire import (add_change, eliminate, error_of_changes, fill_changes,
                                      LANES, MASS, substitute)


@jit
def touches(wire, tip):
    """Return whether points along the wire are in use."""
    if wire is None:
        return False
    return tip[LIVING] > 0.0


@jit
def may_touch(surface, wire, nodes, elements, element_length, frame):
    """Return whether more than the tip may be at the road where a step has ended."""
    if wire is None:
        return False
    if surface is None:
        return not is_clear_of_plane(nodes, elements, element_length, frame)
    return True


@jit
def begin_touch(wire, bristle, step, scratch):
    """Keep the points as they are, and let the forces expected of them act in the prediction."""
    if wire is not None:
        keep_points(bristle.points, scratch.room.kept)
        begin_points(bristle, step, scratch.frames[1], scratch.room)


@jit
def correct_points(wire, bristle, law, surface, step, scratch, fresh):
    """
    Find the increments of all nodes where several points touch; whether that could be done.

    fresh : bool    the matrix has just been made
    """
    if wire is None:
        return False
    nodes, room, frames = bristle.nodes, scratch.room, scratch.frames
    gather(bristle, frames[0], room)
    if fresh:
        room.ready[:room.count[0]] = 0
    fill_columns(bristle, step, frames, room)
    elements = bristle.chain.shape[0]
    eliminate(nodes, elements, bristle.mids, bristle.chain)
    substitute(nodes, elements, bristle.mids, bristle.chain)
    return correct_together(bristle, law, surface, step, frames, scratch)


@jit
def points_born(model, law, wire, bristle, scratch):
    """Return how many points the end of a step that has converged needs beside those in use."""
    if wire is None:
        return NONE_BORN
    return find_points(bristle, law, law.surface, wire, model.section.element_length,
                       scratch.frames, scratch)


@jit
def give_up_points(wire, bristle, scratch, living):
    """Put the points back as they were before a step that failed; living: how many they were."""
    if wire is not None:
        restore_points(bristle.points, bristle.tip, scratch.room.kept, living)


@jit
def _force_before(kept, e, living):
    """Return the force of a slot's point before the step [N]; living: points before it."""
    if living == 0.0 or kept[e, ALIVE] == 0.0:
        return 0.0, 0.0, 0.0
    return kept[e, FORCE], kept[e, FORCE + 1], kept[e, FORCE + 2]


@jit
def _error(bristle, h, scheme, middle, kept, living, change):
    """Do what `estimate_error` does where points touch: each changes A as the tip does."""
    points, nodes = bristle.points, bristle.nodes
    elements = points.shape[0]
    total = fill_changes(nodes, h, scheme)
    for e in range(elements + 1):
        f1, f2, f3 = change
        element, xi = e, 0.0
        if e < elements:
            f1 = f2 = f3 = 0.0
            xi = points[e, XI]
            if points[e, ALIVE] > 0.0:
                f1, f2, f3 = points[e, FORCE], points[e, FORCE + 1], points[e, FORCE + 2]
            old1, old2, old3 = _force_before(kept, e, living)
            f1, f2, f3 = f1 - old1, f2 - old2, f3 - old3
        else:
            element, xi = elements - 1, 1.0
        if f1 == 0.0 and f2 == 0.0 and f3 == 0.0:
            continue
        p1, p2, p3 = rotate_back(middle, ROTATION, f1, f2, f3)
        n = weights(xi)
        for i in range(3):
            j, lane = node_of(element, i)
            if j >= 0 and n[i] != 0.0:
                share = n[i] / nodes[j, MASS * LANES + lane]
                total += add_change(nodes, j, lane, share * p1, share * p2, share * p3)
    return error_of_changes(nodes, total, h, scheme)


@jit
def touch_error(model, wire, bristle, scratch, h, living, change):
    """
    Return the local error of a step in which points touch [m].

    living : points before the step; change [N] : (3,)     of the tip's force over it, road axes
    """
    if wire is None:
        return 0.0
    return _error(bristle, h, model.scheme, scratch.frames[1], scratch.room.kept, living, change)


@jit
def end_touch(model, wire, bristle, law, h, living, taken, scratch):
    """
    Finish the points as the tip is finished, add their impulses, carry them on; return the loss.

    living : points before the step; taken [J] : float   what finishing the tip took
    """
    if wire is None:
        return 0.0
    tip, points, end = bristle.tip, bristle.points, scratch.frames[2]
    friction = rubbed(law, points)
    lost = finish_points(bristle, law, law.surface, h, end, scratch.contact)
    for e in range(points.shape[0]):
        if points[e, ALIVE] > 0.0:
            for i in range(3):
                tip[IMPULSE + i] += h * points[e, FORCE + i]
            if model.scheme.tied:
                old1, old2, old3 = _force_before(scratch.room.kept, e, living)
                keep_rate(points[e], old1, old2, old3, h)
    return lost + carry_points(bristle, law, law.surface, h, end, (taken + lost, friction),
                               scratch)
