"""What the road does to the wire: the laws, the one-point problem, points along the wire."""
# flake8: noqa: F401  what other rooms may use
from .carry import (carry_points, find_points, keep_points, NONE_BORN, restore_points, rubbed,
                    TOO_MANY)
from .coupled import (begin_points, COLUMN, correct_together, fill_columns, finish_points, gather)
from .curved import correct_contact, finish_on_surface, is_clear, place_of
from .law import ContactLaw, OPEN, SLIP, spring_energy, Wire
from .point import ALIVE, MOST, node_of, POINT, position, weights, whole_force, XI
from .search import gap_on, is_clear_of_plane
from .surface import gap_at, Gutter, Profile, SINE, SPLINE, Surface, WAVES
from .tip import (BEFORE, begin_contact, CONTACT, CONTRACTION, ESTIMATE, ESTIMATED, EXTRA, FORCE,
                  GAP, IMPULSE, keep_rate, LEVEL, LIVING, MATRIX_STEP, rotate, rotate_back,
                  SLIP_MOVED, STATE, STEP, TIP, TREND, USUAL)
