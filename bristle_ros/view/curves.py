"""The curves beside the brush: force, torque, power, stress over the last seconds, with means."""
from collections import deque

import numpy as np

from . import colours
from .frame import COLUMNS

SPAN = 6.0      # [s] of simulation time that is shown
POINTS = 300    # of a curve; each is a mean over what lies between
KEPT = 20000    # rows, at most
HEIGHT = 130    # [px]


class Window:
    """The rows of the last seconds."""

    def __init__(self):
        self._rows = deque(maxlen=KEPT)

    def add(self, rows):
        """Take new rows (k, columns); what is too old is forgotten."""
        self._rows.extend(rows)
        while self._rows and self._rows[0][0] < self._rows[-1][0] - SPAN:
            self._rows.popleft()

    def clear(self):
        """Forget all."""
        self._rows.clear()

    def means(self):
        """Return the mean of each column over the window, NaN where there is none."""
        if not self._rows:
            return dict.fromkeys(COLUMNS, float('nan'))
        return dict(zip(COLUMNS, np.mean(self._rows, axis=0).tolist()))

    def curves(self):
        """Return the columns as few enough points: a dict of arrays of one length, at least 2."""
        if len(self._rows) < 2:
            return dict.fromkeys(COLUMNS, np.zeros(2))
        rows = np.array(self._rows)
        group = -(-len(rows) // POINTS)
        whole = rows[len(rows) % group:].reshape(-1, group, rows.shape[1]).mean(axis=1)
        whole = whole if len(whole) > 1 else rows
        return dict(zip(COLUMNS, whole.T))


class Curves:
    """The charts of a Window."""

    # column, what it is, colour, what is shown per SI unit
    CHARTS = (('normal_force', 'normal force of the road [N]', colours.ARROW, 1.0),
              ('torque', 'torque of the drive [N m]', colours.BRAND, 1.0),
              ('power', 'power of the drive [W]', (35, 130, 90), 1.0),
              ('stress', 'largest stress at a clamp [MPa]', (130, 80, 160), 1e-6))

    def __init__(self, gui):
        """Lay the charts out where `gui` is."""
        self.window = Window()
        self._charts, self._texts = {}, {}
        for name, title, colour, _ in self.CHARTS:
            self._texts[name] = gui.add_html(_caption(title, colour, float('nan')))
            zeros = np.zeros(2)
            self._charts[name] = gui.add_uplot(
                (zeros, zeros, zeros),
                ({'label': 't [s]'},
                 {'label': title, 'stroke': colours.css(colour), 'width': 1.5},
                 {'label': 'mean', 'stroke': 'rgb(90, 90, 90)', 'width': 1, 'dash': (6, 4)}),
                scales={'x': {'time': False}}, legend={'show': False}, height=HEIGHT,
                padding=(8, 12, 0, 0))

    def draw(self):
        """Bring the charts up to date."""
        curves, means = self.window.curves(), self.window.means()
        for name, title, colour, scale in self.CHARTS:
            values = curves[name] * scale
            known = bool(np.isfinite(values).all())     # stress is neither logged nor published
            self._charts[name].visible = self._texts[name].visible = known
            if known:
                self._charts[name].data = (
                    curves['t'], values, np.full(len(values), np.mean(values)))
                self._texts[name].content = _caption(title, colour, means[name] * scale)


def _caption(title, colour, mean):
    value = '' if mean != mean else f'mean <b>{mean:.4g}</b>'
    return (f'<div style="display: flex; justify-content: space-between; font-size: 13px; '
            f'margin: 6px 8px -4px; color: {colours.css(colour)}">'
            f'<span>{title}</span><span>{value}</span></div>')
