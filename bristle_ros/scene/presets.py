"""`solver.preset`: solver keys that go together, for those that a scene leaves out."""
import math
from typing import Any

from .key import Key

# What each costs and gives is measured by tools/measure_presets.py, into docs/presets.json.
PRESETS: dict[str, dict[str, Any]] = {
    'draft': {'elements': 8, 'step': 'adaptive', 'integration_time_step': 1e-3,
              'error_tolerance': 6e-6, 'tolerance': 3e-5},
    'standard': {'elements': 12, 'step': 'fixed', 'integration_time_step': 1e-4,
                 'largest_error': 5e-7},
    'reference': {'elements': 24, 'step': 'fixed', 'integration_time_step': 2e-5,
                  'largest_error': 1e-8, 'tolerance': 1e-9},
}
# of files and -p alone: a scene keeps what came of it
PRESET = Key(
    name='solver.preset', kind='str', default='', unit='', minimum=-math.inf, maximum=math.inf,
    choices=tuple(PRESETS), description='fills keys of solver that are left out, when a scene is '
    'read: draft for means in a hurry, standard, or reference to compare with; an error and a '
    'pace for each are in the reference page')
