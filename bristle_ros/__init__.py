"""
A rotating brush of flexible bristles on a road, simulated by beam finite elements, for ROS 2.

Four calls serve scripts: `load(path)` reads a Scene, `build(scene)` makes its Simulation,
`simulate(...)` runs one to its end, and `open_study(folder)` opens what the verb `study` made.
What they raise is here too: SceneError (unusable input), StepFailure (it could not go on),
CommandRefused, CompilerRefused; RunWarning is what they warn of. All are imported when first asked
for: `--help` needs no numba.
"""
from importlib import import_module
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from .physics.compiler import CompilerRefused as CompilerRefused
    from .scene import load as load, SceneError as SceneError
    from .simulation import CommandRefused as CommandRefused, StepFailure as StepFailure
    from .simulation import Simulation as build  # noqa: N813
    from .study import open_study as open_study
    from .verbs.simulate import simulate as simulate

__version__ = '0.3.0'
__all__ = ['CommandRefused', 'CompilerRefused', 'RunWarning', 'SceneError', 'StepFailure',
           '__version__', 'build', 'load', 'open_study', 'simulate']

_PLACES = {'load': ('scene', 'load'), 'build': ('simulation', 'Simulation'),
           'open_study': ('study', 'open_study'),
           'simulate': ('verbs.simulate', 'simulate'), 'SceneError': ('scene', 'SceneError'),
           'StepFailure': ('simulation', 'StepFailure'),
           'RunWarning': ('simulation', 'RunWarning'),
           'CommandRefused': ('simulation', 'CommandRefused'),
           'CompilerRefused': ('physics.compiler', 'CompilerRefused')}


def __getattr__(name: str) -> object:
    """Import the call or the error when it is first used."""
    if name not in _PLACES:
        raise AttributeError(f'module {__name__!r} has no attribute {name!r}')
    module, attribute = _PLACES[name]
    return getattr(import_module(f'.{module}', __name__), attribute)


def __dir__() -> list[str]:
    """List what can be asked for, too."""
    return sorted({*globals(), *__all__})
