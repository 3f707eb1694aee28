"""What the road does to the tip: the laws, the one-point problem, its place in a step."""
# flake8: noqa: F401  what other rooms may use
from .curved import correct_contact, finish_on_surface, is_clear
from .law import ContactLaw, OPEN, SLIP, spring_energy
from .surface import gap_at, Gutter, Profile, SINE, SPLINE, Surface, WAVES
from .tip import (BEFORE, begin_contact, CONTRACTION, ESTIMATE, EXTRA, FORCE, GAP, IMPULSE, LEVEL,
                  MATRIX_STEP, rotate, rotate_back, SLIP_MOVED, STATE, STEP, TIP, TREND, USUAL)
