"""The report's page: text, tables and figures in one HTML file, and the tables as CSV."""
import base64
import csv
import html
import io
import math
import sys
import time

STYLE = """
body {font: 15px/1.45 system-ui, sans-serif; max-width: 1080px; margin: 2em auto; padding: 0 1em;
      color: #1a1a1a; background: #fff}
h1 {font-size: 1.6em} h2 {margin-top: 2.2em; border-bottom: 1px solid #ccc} h3 {margin-top: 1.6em}
table {border-collapse: collapse; margin: .8em 0; font-size: 13px}
td, th {border: 1px solid #ccc; padding: .25em .55em; text-align: left; vertical-align: top}
td.n {text-align: right; font-variant-numeric: tabular-nums} th {background: #f1f3f5}
img {max-width: 100%; display: block; margin: 1em 0} pre, code {background: #f6f6f6}
pre {padding: .6em; overflow-x: auto} .scroll {overflow-x: auto} .note {color: #555}
"""


def show_number(value):
    """Return a value as a short text."""
    if value is None or (isinstance(value, float) and math.isnan(value)):
        return ''
    if isinstance(value, float):
        return f'{value:.4g}'
    return str(value)


class Page:
    """Collects sections; `write` makes the page and its tables."""

    def __init__(self, title):
        """Start an empty page."""
        self.title = title
        self._parts = []
        self.tables = {}        # name: rows

    def heading(self, text, level=2):
        """Add a heading."""
        self._parts.append(f'<h{level}>{html.escape(text)}</h{level}>')

    def text(self, text, note=False):
        """Add a paragraph."""
        kind = ' class="note"' if note else ''
        self._parts.append(f'<p{kind}>{html.escape(text)}</p>')

    def code(self, text):
        """Add preformatted text."""
        self._parts.append(f'<pre>{html.escape(text)}</pre>')

    def table(self, name, rows, columns=None):
        """
        Add a table and keep its rows for `NAME.csv`.

        rows : list of dict;  columns : dict key to heading, or None for all keys as they are
        """
        if not rows:
            return
        self.tables[name] = rows
        columns = columns or {key: key.replace('_', ' ') for row in rows for key in row}
        out = ['<div class="scroll"><table><tr>', *(f'<th>{html.escape(c)}</th>'
                                                    for c in columns.values()), '</tr>']
        for row in rows:
            out.append('<tr>')
            for key in columns:
                value = row.get(key)
                kind = ' class="n"' if isinstance(value, (int, float)) else ''
                out.append(f'<td{kind}>{html.escape(show_number(value))}</td>')
            out.append('</tr>')
        out.append('</table></div>')
        self._parts.append(''.join(out))

    def figure(self, figure, alt):
        """Add a matplotlib figure as an embedded PNG and close it."""
        from matplotlib import pyplot
        buffer = io.BytesIO()
        figure.savefig(buffer, format='png', dpi=110)
        pyplot.close(figure)
        data = base64.b64encode(buffer.getvalue()).decode()
        self._parts.append(f'<img alt="{html.escape(alt)}" src="data:image/png;base64,{data}">')

    def write(self, folder):
        """Write index.html and one CSV for each table; return the page's path."""
        folder.mkdir(parents=True, exist_ok=True)
        for name, rows in self.tables.items():
            keys = list(dict.fromkeys(key for row in rows for key in row))
            with open(folder / f'{name}.csv', 'w', newline='', encoding='utf-8') as file:
                writer = csv.DictWriter(file, keys)
                writer.writeheader()
                writer.writerows(rows)
        path = folder / 'index.html'
        path.write_text(
            f'<!DOCTYPE html>\n<html lang="en"><meta charset="utf-8">'
            f'<title>{html.escape(self.title)}</title><style>{STYLE}</style>\n'
            f'<h1>{html.escape(self.title)}</h1>\n' + '\n'.join(self._parts) + '\n</html>\n',
            encoding='utf-8')
        return path


def new_figure(columns=1, rows=1, width=9.0, height=3.6):
    """Return a matplotlib figure and its axes (rows, columns), as every page draws them."""
    import matplotlib
    matplotlib.use('Agg')
    from matplotlib import pyplot
    pyplot.rcParams.update({
        'font.size': 9, 'axes.grid': True, 'grid.alpha': 0.3, 'axes.axisbelow': True,
        'legend.fontsize': 8, 'figure.constrained_layout.use': True})
    return pyplot.subplots(rows, columns, figsize=(width, height * rows), squeeze=False)


def whole_decades(panel):
    """Let both logarithmic axes of a panel end at decades, and label these alone."""
    from matplotlib.ticker import LogLocator, NullFormatter
    for axis, (low, high), limit in ((panel.xaxis, panel.get_xlim(), panel.set_xlim),
                                     (panel.yaxis, panel.get_ylim(), panel.set_ylim)):
        limit(10.0 ** math.floor(math.log10(low) + 0.02), 10.0 ** math.ceil(
            math.log10(high) - 0.02))
        axis.set_major_locator(LogLocator(numticks=12))
        axis.set_minor_formatter(NullFormatter())


class Progress:
    """Says on stderr what is going on: one line that changes on a terminal, else a line each."""

    def __init__(self, stream=None):
        """Write to a stream, by default stderr."""
        self.stream = stream or sys.stderr
        self.began = time.monotonic()

    def __call__(self, text):
        """Show what is done now."""
        line = f'[{time.monotonic() - self.began:6.1f} s] {text}'
        if self.stream.isatty():
            self.stream.write('\r\x1b[K' + line[:100])
        else:
            self.stream.write(line + '\n')
        self.stream.flush()

    def close(self):
        """End the line."""
        if self.stream.isatty():
            self.stream.write('\r\x1b[K')
