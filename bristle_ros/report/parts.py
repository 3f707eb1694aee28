"""The parts of the report in the order of the page: what measures each, and what shows it."""
from importlib import import_module
from typing import NamedTuple


class Part(NamedTuple):
    """A part: modules with measure(context) -> data and show(page, data, results)."""

    measure: str
    show: str
    quick: float    # [s] that it usually takes on two cores, for the time that is left
    full: float     # [s]


PARTS = {
    'precision': Part('precision.measure', 'precision.show', 25, 100),
    'road': Part('road.measure', 'road.show', 25, 500),
    'estimate': Part('precision.estimate', 'precision.estimate', 6, 5),
    'peers': Part('peers.comparison', 'peers.show', 1, 1600),
    'stability': Part('stability.campaign', 'stability.show', 25, 1200),
    'cost': Part('lean.measure', 'lean.show', 20, 90),
    'paper': Part('paper.measure', 'paper.show', 25, 110),
    'theory': Part('paper.theory', 'paper.theory', 10, 10),
}


def measure(name, context):
    """Return the data of a part."""
    return import_module(f'{__package__}.{PARTS[name].measure}').measure(context)


def show(name, page, data, results):
    """Put a part on the page."""
    import_module(f'{__package__}.{PARTS[name].show}').show(page, data, results)
