"""How a bristle gets from one moment to the next, and what is seen of it there."""
# flake8: noqa: F401  what other rooms may use
from .energy import AUDIT
from .equilibrium import settle
from .newton import (COUNTS, FACTORISATIONS, FAILURES, move_nodes, NEWTON, NO_CONVERGENCE,
                     NOT_FINITE, SINGULAR_MATRIX, SUBSTEPS, UNFINISHED)
from .records import Model, Scratch, State
from .scheme import generalized_alpha, hht, newmark, Scheme
from .start import initialise
from .stepping import advance, advance_alone, BATCH, fill_frames, own_frame, PARTS
