"""Names of a room that are imported when first asked for: `--help` needs no numba, say."""
from collections.abc import Callable
from importlib import import_module
import sys


def lazily(package: str, places: dict[str, list[str]]
           ) -> tuple[Callable[[str], object], Callable[[], list[str]]]:
    """
    Return `__getattr__` and `__dir__` (PEP 562) of a package.

    places : module of the package to the names that others may use of it
    """
    owner = {name: module for module, names in places.items() for name in names}

    def get(name: str) -> object:
        if name not in owner:
            raise AttributeError(f'module {package!r} has no attribute {name!r}')
        value: object = getattr(import_module(f'{package}.{owner[name]}'), name)
        setattr(sys.modules[package], name, value)
        return value

    return get, lambda: sorted({*vars(sys.modules[package]), *owner})
