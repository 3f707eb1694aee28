"""The colours of the page: light to dark as the force on a wire grows."""
import numpy as np

# Of a wire without force, and up to the largest: steel, straw, orange, red; sRGB, 0 to 255.
_STOPS = np.array([(96, 125, 150), (190, 170, 90), (240, 140, 30), (225, 50, 35), (150, 10, 40)],
                  dtype=float)
_TABLE = np.stack([np.interp(np.linspace(0.0, 1.0, 256), np.linspace(0.0, 1.0, len(_STOPS)), part)
                   for part in _STOPS.T], axis=1).astype(np.uint8)

_LINEAR = np.round(255.0 * (np.arange(256) / 255.0) ** 2.2).astype(np.uint8)

BRIGHT = 3.0    # means of what touches: where the scale ends
SLOWLY = 0.05   # of a change of it is followed by each frame

BRAND = (30, 110, 165)
STEEL, UNKNOWN = (96, 125, 150), (90, 95, 100)
BOARD, SHAFT, BOLT = (45, 55, 65), (120, 130, 138), (235, 175, 40)
ARROW, TRAIL = (200, 30, 60), (20, 90, 160)
RELIEF, RELIEF_LINE = (188, 186, 182), (228, 228, 226)
ROAD, ROAD_DARK, ROAD_LINE = (206, 207, 208), (186, 188, 190), (226, 227, 228)


def shade(values, largest):
    """Return the colours (n, 3) of values >= 0 on a scale that ends at `largest` > 0."""
    return _TABLE[np.clip(255.0 * values / largest, 0, 255).astype(np.uint8)]


def of_wires(values, largest, exact):
    """Return the colours (n, 3) uint8 of wires by their values; one grey if they are guessed."""
    if not exact:
        return np.tile(np.array(UNKNOWN, np.uint8), (len(values), 1))
    return shade(values, max(largest, 1e-9))


def scale_end(before, values):
    """
    Return where the scale ends for the values (n,) of a frame; `before`, or 0, for the one before.

    It follows slowly: a single impact must not turn all others grey.
    """
    if not len(values):
        return before
    wanted = BRIGHT * float(values.mean())
    return before + (SLOWLY if before else 1.0) * (wanted - before)


def of_lines(colours):
    """Return what lines must be given to show colours: viser takes theirs as linear light."""
    return _LINEAR[np.asarray(colours, dtype=np.uint8)]


def css(colour):
    """Return a colour as style sheets write it."""
    return f'rgb({", ".join(str(int(part)) for part in colour)})'


def ramp():
    """Return the scale as a CSS gradient."""
    return f'linear-gradient(to right, {", ".join(css(stop) for stop in _STOPS)})'
