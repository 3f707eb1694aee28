"""
A measured time series over a simulated one: its shift, its scale, and where it differs.

Of all shifts of the measured series the one with the largest correlation counts (parabola through
it and its neighbours), then a scale and an offset by least squares; the error in each octave is
the rms of the difference there, by Fourier sums, over that of the measured series.
"""
from typing import NamedTuple

import numpy as np

LEAST = 16              # samples


class Comparison(NamedTuple):
    """measured(t) = scale * simulated(t - shift) + offset, as nearly as it goes."""

    shift: float            # [s] by which the measured series comes later
    scale: float
    offset: float
    correlation: float
    error: float            # rms of the difference over that of the measured series' variation
    bands: list             # (low, high [Hz], share of the measured variance, error)
    t: np.ndarray           # [s] (n,) simulated time
    measured: np.ndarray    # (n,) there
    simulated: np.ndarray   # (n,) scaled and offset


def compare(simulated, measured, most_shift):
    """
    Return the Comparison of two series, each (t [s], value).

    most_shift [s] : either way. Raises ValueError where they do not overlap by LEAST samples.
    """
    step = max(float(np.median(np.diff(series[0]))) for series in (simulated, measured))
    grid = np.arange(simulated[0][0], simulated[0][-1] + 0.5 * step, step)
    model = np.interp(grid, *simulated)
    most = int(most_shift / step)

    def at(shift):
        inside = (grid + shift >= measured[0][0]) & (grid + shift <= measured[0][-1])
        return inside, np.interp(grid[inside] + shift, *measured)

    def likeness(shift):
        inside, values = at(shift)
        if len(values) < LEAST:
            return -1.0
        a, b = values - values.mean(), model[inside] - model[inside].mean()
        size = float(np.sqrt((a @ a) * (b @ b)))
        return float(a @ b) / size if size > 0.0 else -1.0

    found = np.array([likeness(i * step) for i in range(-most, most + 1)])
    if found.max() <= -1.0:
        raise ValueError
    best = int(found.argmax())
    shift = (best - most + _vertex(found, best)) * step
    inside, values = at(shift)
    scale, offset = np.linalg.lstsq(
        np.column_stack((model[inside], np.ones(len(values)))), values, rcond=None)[0]
    fitted = scale * model[inside] + offset
    varies = float(np.std(values))
    error = float(np.sqrt(np.mean((values - fitted) ** 2)))
    return Comparison(shift, float(scale), float(offset), likeness(shift),
                      error / varies if varies else np.inf, _bands(values, fitted, step),
                      grid[inside], values, fitted)


def _vertex(values, at):
    if not 0 < at < len(values) - 1:
        return 0.0
    before, here, after = values[at - 1:at + 2]
    curve = before - 2.0 * here + after
    return 0.5 * (before - after) / curve if curve < 0.0 else 0.0


def _bands(measured, fitted, step):
    """Return (low, high, share, error) of octaves from the lowest frequency up."""
    window = np.hanning(len(measured) + 2)[1:-1]
    frequency = np.fft.rfftfreq(len(measured), step)
    power = np.abs(np.fft.rfft((measured - measured.mean()) * window)) ** 2
    wrong = np.abs(np.fft.rfft((measured - fitted) * window)) ** 2
    total = float(power[1:].sum())
    found, low = [], float(frequency[1])
    while low < frequency[-1]:
        high = min(2.0 * low, float(frequency[-1]) * 1.0001)
        inside = (frequency >= low) & (frequency < high)
        here = float(power[inside].sum())
        if here > 0.0 and total > 0.0:
            found.append((low, high, here / total,
                          float(np.sqrt(wrong[inside].sum() / here))))
        low = high
    return found
