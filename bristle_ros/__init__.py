"""
A rotating brush of flexible bristles on a road, simulated by beam finite elements, for ROS 2.

Three calls serve scripts: `load(path)` reads a Scene, `build(scene)` makes its Simulation, and
`simulate(...)` runs one to its end. They are imported when first asked for: `--help` needs no
numba.
"""
from importlib import import_module

__version__ = '0.1.0'
__all__ = ['__version__', 'build', 'load', 'simulate']

_CALLS = {'load': ('scene', 'load'), 'build': ('simulation', 'Simulation'),
          'simulate': ('offline', 'simulate')}


def __getattr__(name):
    """Import the call when it is first used."""
    if name not in _CALLS:
        raise AttributeError(f'module {__name__!r} has no attribute {name!r}')
    module, attribute = _CALLS[name]
    return getattr(import_module(f'.{module}', __name__), attribute)
