"""
The frozen matrix of Newton's method: when it is made, and what is known of how it contracts.

It is factorised in the nodes' own axes.
"""
from bristle_ros.physics.compiler import inlined, jit
from bristle_ros.physics.contact import CONTRACTION, EXTRA, MATRIX_STEP, USUAL
from bristle_ros.physics.wire import factorise, OK

from .records import FACTORISATIONS

SLOW = 0.4      # contraction above which it is made anew at once
WORTH = 5.0     # iterations that cost what a matrix costs: 11,000 instructions each, 58,000
WORTH_ONCE = 3.0    # was taken for it; bits of old logs need it
# what the second correction is of the first one, where there is no second one to tell
UNKNOWN = 0.1   # after a new matrix
NEW = 0.02      # that a new one can be trusted with in smooth motion: seen are 1e-3 to 1e-2
LEAST = 1e-3
AGEING = 1.5    # growth in each step that does not measure it


@jit
def expected_rate(tip, renewed):
    """Return what the second correction is expected to be of the first one."""
    return UNKNOWN if renewed else min(AGEING * tip[CONTRACTION], 0.5)


@inlined
def renew_matrix(model, bristle, scratch, step):
    """Factorise the matrix of the present state, and return whether that could be done."""
    tip = bristle.tip
    tip[MATRIX_STEP] = 0.0
    bristle.counts[FACTORISATIONS] += 1
    if factorise(bristle.nodes, model.elements, model.section, step, scratch.frames[2],
                 bristle.mids, bristle.chain, scratch.work) != OK:
        return False
    tip[MATRIX_STEP] = step.h
    return True


@jit
def judge_matrix(tip, found, tied):
    """
    Give the matrix up for the next step where it has cost what a new one costs.

    What an ageing matrix costs are the iterations beyond those of the first step made with it, or
    beyond the one that would do if it were new. Giving it up when they reach the price of a new
    one takes at most twice what knowing the future would (the ski rental problem).

    found : Corrections;  tied : bool   as in Scheme; False: by rules that bits of old logs need
    """
    if found.renewed:
        tip[USUAL] = 0.0
        tip[EXTRA] = 0.0
    elif tip[USUAL] == 0.0:
        tip[USUAL] = found.iterations
    else:
        enough = 1.0 if tied and found.single else tip[USUAL]
        tip[EXTRA] += max(found.iterations - enough, 0.0)
    worth = WORTH if tied else WORTH_ONCE
    if tip[EXTRA] >= worth or found.refresh and not tied:
        tip[MATRIX_STEP] = 0.0
