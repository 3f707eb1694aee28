"""The records that the kernels share: what stays (Model), what changes (State), scratch."""
from typing import NamedTuple

from bristle_ros.physics.motion import Drive
from bristle_ros.physics.wire import Section
import numpy as np
from numpy.typing import NDArray

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
    azimuth: NDArray[np.float64]    # (B, 4) cosine and sine of each azimuth, and of half of it
    clamp: NDArray[np.float64]      # (7,) position and quaternion of the clamp, bristle's own axes
    clamp_mass: float           # [kg] of the clamped node
    wires: float                # real wires per bristle
    displacement: bool          # load case: solved in mount axes with the clamp driven
    local_error: float          # [m] above which a step is taken in halves


class State(NamedTuple):
    """What a step changes, in place; all of it decides what the next step does."""

    nodes: NDArray[np.float64]      # (B, blocks, BLOCK) layout.py
    mids: NDArray[np.float64]       # (B, blocks, MIDS) chain.py: the frozen matrix, mid nodes
    chain: NDArray[np.float64]      # (B, elements, RECORD) and corners
    tip: NDArray[np.float64]        # (B, TIP) tip.py
    counts: NDArray[np.int64]       # (B, COUNTS) int64, running counts of stepping.py
    motion: NDArray[np.float64]     # (MOTION,) frame.py: the ramps that commands change
    step: NDArray[np.int64]         # (1,) int64: steps done
    audit: NDArray[np.float64]      # (B, AUDIT) energy accounts, where they are kept


class Scratch(NamedTuple):
    """Room that a step works in; nothing in it outlives the call."""

    work: NDArray[np.float64]       # (CHAIN_WORK,)
    contact: NDArray[np.float64]    # (5, 3)
    frames: NDArray[np.float64]     # (3, FRAME)
    frame: NDArray[np.float64]      # (FRAME,)
    turned: NDArray[np.float64]     # (2, FRAME)
    basics: NDArray[np.float64]     # (2, BASICS)
    parts: NDArray[np.float64]      # (BATCH PARTS + 1, FRAME) at parts of steps, where known
    known: NDArray[np.int64]        # (BATCH PARTS + 1,) int64: 1 where they are
    saved: NDArray[np.float64]      # (blocks, BLOCK)
    saved_tip: NDArray[np.float64]  # (TIP,)
    saved_audit: NDArray[np.float64]  # (AUDIT,)
    failed: NDArray[np.int64]       # (3,) int64: step of a failure; step and bristle of the first
