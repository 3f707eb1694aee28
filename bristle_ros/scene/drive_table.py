"""
A table of brush speeds over time: monotone cubics (PCHIP) through its points, held at its ends.

Source: Fritsch, Butland (1984), SIAM J. Sci. Stat. Comput. 5, 300-304: the slope at a point is the
weighted harmonic mean of those of its chords, or 0 where these differ in sign. At the ends three
points give it, bounded so that the shape is kept (Moler, Numerical Computing with Matlab, 3.6).
"""
import numpy as np

from .error import SceneError
from .points_file import read_points, SPEEDS
from .sections import Drive

COLUMNS = 6     # of a table: t, speed there, three coefficients, angle there


def speed_table(drive: Drive) -> np.ndarray:
    """
    Return the cubics of the drive's file: (n, 6); raise SceneError.

    A row holds t [s]; from there on, tau later, the speed is c0 + tau (c1 + tau (c2 + tau c3))
    [rad/s]; then the angle turned since t = 0 [rad]. In the last one c1 to c3
    are 0.
    """
    t, speed = read_points(drive.file, SPEEDS)
    if abs(speed).max() > drive.max_speed:
        worst = int(abs(speed).argmax())
        raise SceneError(
            f'has {speed[worst]:.6g} rad/s at t = {t[worst]:.6g} s, beyond drive.max_speed = '
            f'{drive.max_speed:g} rad/s: lower it or raise the limit', key='drive.file',
            value=drive.file)
    slope = slopes(t, speed)
    step = np.diff(t)
    chord = np.diff(speed) / step
    table = np.zeros((len(t), COLUMNS))
    table[:, 0], table[:, 1] = t, speed
    table[:-1, 2] = slope[:-1]
    table[:-1, 3] = (3.0 * chord - 2.0 * slope[:-1] - slope[1:]) / step
    table[:-1, 4] = (slope[:-1] + slope[1:] - 2.0 * chord) / step ** 2
    table[1:, 5] = np.cumsum(_turned(table[:-1], step))
    row, tau = _row_at(table, 0.0)
    table[:, 5] -= row[5] + _turned(row, tau)
    return table


def start_speed(drive: Drive) -> float:
    """Return the brush's speed at t = 0 [rad/s], whatever gives it; raise SceneError."""
    if drive.profile != 'table':
        return drive.mean_speed
    row, tau = _row_at(speed_table(drive), 0.0)
    return float(row[1] + tau * (row[2] + tau * (row[3] + tau * row[4])))


def slopes(t: np.ndarray, speed: np.ndarray) -> np.ndarray:
    """Return the slope of the monotone cubics at each point: (n,)."""
    step = np.diff(t)
    chord = np.diff(speed) / step
    if len(t) == 2:
        return np.full(2, chord[0])
    slope = np.zeros(len(t))
    before, after = chord[:-1], chord[1:]
    alike = before * after > 0.0
    one, two = 2.0 * step[1:] + step[:-1], step[1:] + 2.0 * step[:-1]
    slope[1:-1][alike] = (one + two)[alike] / (one[alike] / before[alike]
                                               + two[alike] / after[alike])
    slope[0] = _end_slope(step[0], step[1], chord[0], chord[1])
    slope[-1] = _end_slope(step[-1], step[-2], chord[-1], chord[-2])
    return slope


def _end_slope(step: float, next_step: float, chord: float, next_chord: float) -> float:
    slope = ((2.0 * step + next_step) * chord - step * next_chord) / (step + next_step)
    if slope * chord <= 0.0:
        return 0.0
    if chord * next_chord < 0.0 and abs(slope) > 3.0 * abs(chord):
        return 3.0 * chord
    return slope


def _turned(rows: np.ndarray, tau: np.ndarray | np.float64) -> np.ndarray:
    turned: np.ndarray = tau * (rows[..., 1] + tau * (
        rows[..., 2] / 2.0 + tau * (rows[..., 3] / 3.0 + tau * rows[..., 4] / 4.0)))
    return turned


def _row_at(table: np.ndarray, t: float) -> tuple[np.ndarray, np.float64]:
    """Return the cubic that holds at time t [s], and how long it has done so."""
    if t < table[0, 0]:
        return table[0] * [1.0, 1.0, 0.0, 0.0, 0.0, 1.0], np.float64(t - table[0, 0])
    row = table[np.searchsorted(table[:, 0], t, side='right') - 1]
    return row, np.float64(t - row[0])
