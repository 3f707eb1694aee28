"""One wire: where its numbers lie, its strains and forces, and the matrix of its chain."""
# flake8: noqa: F401  what other rooms may use
from .air import add_air, Air, clamp_air, node_air
from .beam import clamp_reaction, internal_forces, Section, stiffness
from .chain import chain_work, CORNER, eliminate, factorise, INVERSE, MIDS, OK, RECORD, substitute
from .coefficients import pseudo_step, StepCoefficients
from .damping import accept_damping, keep_strains, predict_damping, strains
from .dynamics import (add_change, error_constant, error_of_changes, fill_changes, local_error,
                       residual)
from .history import accept_step, begin_step, rescale_memory
from .increments import largest_turn, move_nodes
from .layout import (A0, ACC0, BLOCK, block_count, ELEMENTS, HA, HV, INERTIA, JUMP, LANES, LR,
                     MASS, NODE_FORCE, Q, Q0, R, RATE0, RATEACC0, ROWS, SECTION_FORCE,
                     SECTION_FORCE0, STRAIN, STRAIN0, STRAIN_BEFORE, STRESS, STRESS0, tip_lane, V0,
                     W0, WEIGHT, X, X0)
from .section_force import (accept_section_forces, add_excess, begin_section_forces,
                            update_section_forces)
