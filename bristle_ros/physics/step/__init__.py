"""How a bristle gets from one moment to the next, and what is seen of it there."""
# flake8: noqa: F401  what other rooms may use
from .clearance import lowest_node
from .board import board_wrench
from .driven import advance_driven, attempt_share, begin_turn, end_turn
from .energy import AUDIT, STRESS_MAX, STRESS_MIN, WRENCH
from .equilibrium import settle
from .newton import (CLAMP_INSIDE, NO_CONVERGENCE, NOT_FINITE, SINGULAR_MATRIX, TOO_MANY_POINTS,
                     UNFINISHED)
from .parts import parts_of_step
from .records import (AT_FINEST, COUNTS, FACTORISATIONS, FAILURES, Model, NEWTON, Room, Scratch,
                      SPLIT, State, SUBSTEPS, Turn)
from .scheme import generalized_alpha, hht, newmark, Scheme
from .start import initialise
from .stepping import advance, BATCH, fill_frames, FINEST, own_frame, PARTS
from .stress import corner_factors
