"""The records that the kernels share: what stays (Model), what changes (State), scratch."""
from typing import NamedTuple

from bristle_ros.physics.compiler import inlined
from bristle_ros.physics.motion import Drive
from bristle_ros.physics.wire import Air, Section
import numpy as np
from numpy.typing import NDArray

from .scheme import Scheme

# running counts
NEWTON = 0
SUBSTEPS = 1
FACTORISATIONS = 2
FAILURES = 3
SPLIT = 4       # integration steps taken in sub-steps
AT_FINEST = 5   # of these, in sub-steps as short as the error estimate may ask for
COUNTS = 6


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
    azimuth: NDArray[np.float64]    # (B, 4) cosine and sine of each azimuth, and of half of it
    clamp: NDArray[np.float64]      # (7,) position and quaternion of the clamp, bristle's own axes
    corners: NDArray[np.float64]    # (4, 6) stress at the clamp's corners: see stress.py
    clamp_mass: float           # [kg] of the clamped node
    wires: float                # real wires per bristle
    displacement: bool          # load case: solved in mount axes with the clamp driven
    local_error: float          # [m] above which a step is taken in halves,
    halved_to: float            # [s] if it is longer than that
    worst_error: float          # [m] above which any is, down to the finest sub-steps
    air: Air | None             # None: left out


class State(NamedTuple):
    """What a step changes, in place; all of it decides what the next step does."""

    nodes: NDArray[np.float64]      # (B, blocks, BLOCK) wire/layout.py
    mids: NDArray[np.float64]       # (B, blocks, MIDS) wire/chain.py: the frozen matrix, mid nodes
    chain: NDArray[np.float64]      # (B, elements, RECORD) and corners
    tip: NDArray[np.float64]        # (B, TIP) contact/tip.py
    points: NDArray[np.float64]     # (B, elements or 0, POINT) contact/point.py
    counts: NDArray[np.int64]       # (B, COUNTS) int64, the running counts above
    motion: NDArray[np.float64]     # (MOTION,) motion/records.py: the ramps that commands change
    step: NDArray[np.int64]         # (1,) int64: steps done
    audit: NDArray[np.float64]      # (B, AUDIT) energy accounts, where they are kept


class Turn(NamedTuple):
    """What a step of a brush whose drive feels its load needs to be made again: driven.py."""

    hub: NDArray[np.float64]        # (HUB,) the hub's record before the step
    torques: NDArray[np.float64]    # (B,) [N m] of each bristle's wires on the board
    kept: State                     # what bristles are before the step; without their matrices


class Bristle(NamedTuple):
    """One bristle's part of State, and its azimuth."""

    azimuth: NDArray[np.float64]    # (4,)
    nodes: NDArray[np.float64]      # (blocks, BLOCK)
    mids: NDArray[np.float64]       # (blocks, MIDS)
    chain: NDArray[np.float64]      # (elements, RECORD)
    tip: NDArray[np.float64]        # (TIP,)
    points: NDArray[np.float64]     # (elements or 0, POINT)
    counts: NDArray[np.int64]       # (COUNTS,)


@inlined
def bristle_of(model, state, number):
    """Return the Bristle of that number; for kernels, whose views Python would not see as such."""
    return Bristle(model.azimuth[number], state.nodes[number], state.mids[number],
                   state.chain[number], state.tip[number], state.points[number],
                   state.counts[number])


class Room(NamedTuple):
    """Where the contact of several points is worked out; M of them at most, the tip among them."""

    slots: NDArray[np.int64]        # (M,) elements of those that take part; `elements`: the tip
    count: NDArray[np.int64]        # (1,) how many
    ready: NDArray[np.int64]        # (M,) 1 where columns and w are those of the present matrix
    begin: NDArray[np.float64]      # (M, 3) [m] places at the step's start, surface axes
    moved: NDArray[np.float64]      # (M, 3) [m] from there to its end
    w: NDArray[np.float64]          # (M, M, 9) [m/N] what a force at the second moves the first
    columns: NDArray[np.float64]    # (M, 3, blocks, COLUMN) what a force does to the nodes
    nodes: NDArray[np.float64]      # (blocks, BLOCK)
    records: NDArray[np.float64]    # (M, CONTACT) their records, to work in
    change: NDArray[np.float64]     # (M, 3) [N] by which the last sweep changed each force
    left: NDArray[np.float64]       # (1,) part that it left of the change before it
    line: NDArray[np.float64]       # (2 elements + 1, 3) [m] nodes from clamp to tip, surface axes
    begun: NDArray[np.float64]      # (2 elements + 1, 3) [m] the same at the step's start
    near: NDArray[np.int64]         # (elements,) 1: may be at the road
    kept: NDArray[np.float64]       # (elements, POINT) the points before the step
    places: NDArray[np.int64]       # (2^k,) which place of the profile's waves is kept; or (0,)
    heights: NDArray[np.float64]    # (2^k,) [m] height of the profile there


class Scratch(NamedTuple):
    """Room that a step works in; nothing in it outlives the call but heights of the road."""

    work: NDArray[np.float64]       # (CHAIN_WORK,)
    contact: NDArray[np.float64]    # (9, 16)
    frames: NDArray[np.float64]     # (3, FRAME) of the present sub-step: start, middle and end
    frame: NDArray[np.float64]      # (FRAME,)
    turned: NDArray[np.float64]     # (2, FRAME)
    basics: NDArray[np.float64]     # (2, BASICS)
    parts: NDArray[np.float64]      # (BATCH PARTS + 1, FRAME) at parts of steps, where known
    known: NDArray[np.int64]        # (BATCH PARTS + 1,) int64: 1 where they are
    saved: NDArray[np.float64]      # (blocks, BLOCK)
    saved_tip: NDArray[np.float64]  # (TIP,)
    saved_points: NDArray[np.float64]   # as Bristle.points
    saved_audit: NDArray[np.float64]  # (AUDIT,)
    table: NDArray[np.float64]      # (2 BATCH + 1, FRAME) at azimuth 0, at the ends and middles of
    #                               a call's steps: whoever shares a queue shares it
    failed: NDArray[np.int64]       # (3,) int64: step of a failure; step and bristle of the first
    room: Room | None               # None where the tip alone touches
