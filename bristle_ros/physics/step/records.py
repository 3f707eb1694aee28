"""The records that the kernels share: what stays (Model), what changes (State), scratch."""
from typing import NamedTuple

from bristle_ros.physics.compiler import inlined
from bristle_ros.physics.motion import Drive
from bristle_ros.physics.wire import Section
import numpy as np

from .scheme import Scheme


class Model(NamedTuple):
    """What a run never changes; B bristles."""

    elements: int
    blocks: int
    bristles: int
    its: float                  # integration time step [s]
    section: Section
    scheme: Scheme
    drive: Drive                # with its load steps
    exact: Drive                # the same without, for output
    mass_damping: float         # alpha_D [1/s]
    azimuth: np.ndarray         # (B, 4) cosine and sine of each azimuth, and of half of it
    clamp: np.ndarray           # (7,) position and quaternion of the clamp, bristle's own axes
    clamp_mass: float           # [kg] of the clamped node
    wires: float                # real wires per bristle
    displacement: bool          # load case: solved in mount axes with the clamp driven
    local_error: float          # [m] above which a step is taken in halves


class State(NamedTuple):
    """What a step changes, in place; all of it decides what the next step does."""

    nodes: np.ndarray           # (B, blocks, BLOCK) wire/layout.py
    mids: np.ndarray            # (B, blocks, MIDS) wire/chain.py: the frozen matrix, mid nodes
    chain: np.ndarray           # (B, elements, RECORD) and corners
    tip: np.ndarray             # (B, TIP) contact/tip.py
    counts: np.ndarray          # (B, COUNTS) int64, running counts of newton.py
    motion: np.ndarray          # (MOTION,) motion/frame.py: the ramps that commands change
    step: np.ndarray            # (1,) int64: steps done
    audit: np.ndarray           # (B, AUDIT) energy accounts, where they are kept


class Bristle(NamedTuple):
    """One bristle's part of State, and its azimuth."""

    azimuth: np.ndarray         # (4,)
    nodes: np.ndarray           # (blocks, BLOCK)
    mids: np.ndarray            # (blocks, MIDS)
    chain: np.ndarray           # (elements, RECORD)
    tip: np.ndarray             # (TIP,)
    counts: np.ndarray          # (COUNTS,)


@inlined
def bristle_of(model, state, number):
    """Return the Bristle of that number; for kernels, whose views Python would not see as such."""
    return Bristle(model.azimuth[number], state.nodes[number], state.mids[number],
                   state.chain[number], state.tip[number], state.counts[number])


class Scratch(NamedTuple):
    """Room that a step works in; nothing in it outlives the call."""

    work: np.ndarray            # (CHAIN_WORK,)
    contact: np.ndarray         # (5, 3)
    frames: np.ndarray          # (3, FRAME) of the present sub-step: start, middle and end
    frame: np.ndarray           # (FRAME,)
    turned: np.ndarray          # (2, FRAME)
    basics: np.ndarray          # (2, BASICS)
    parts: np.ndarray           # (BATCH PARTS + 1, FRAME) at parts of steps, where known
    known: np.ndarray           # (BATCH PARTS + 1,) int64: 1 where they are
    saved: np.ndarray           # (blocks, BLOCK)
    saved_tip: np.ndarray       # (TIP,)
    saved_audit: np.ndarray     # (AUDIT,)
    table: np.ndarray           # (2 BATCH + 1, FRAME) at azimuth 0, at the ends and middles of
    #                             a call's steps: whoever shares a queue shares it
    failed: np.ndarray          # (3,) int64: step of a failure; step and bristle of the first
