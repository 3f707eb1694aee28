"""The report's page: one HTML file with text, tables and figures; the tables also as CSV."""
import csv
import html
import math
import re

from .style import SCRIPT, STYLE
from .verdict import Measured

ICON = 'data:image/svg+xml,%3Csvg xmlns=%22http://www.w3.org/2000/svg%22/%3E'


def show_number(value):
    """Return a value as a short text."""
    if value is None or (isinstance(value, float) and math.isnan(value)):
        return ''
    if isinstance(value, bool):
        return 'yes' if value else 'no'
    if isinstance(value, float):
        return f'{value:.3g}' if abs(value) < 1000 or abs(value) >= 1e6 else f'{value:.0f}'
    return str(value)


def _key_value(value):
    """Return what a cell is sorted by, or None for text."""
    if isinstance(value, Measured):
        return value.value
    return value if isinstance(value, (int, float)) and not isinstance(value, bool) else None


class Page:
    """
    Collects parts in order; `write` makes the page, its tables as CSV, and a README of them.

    `explain` takes what was asked and how; `says` what came out, which is never a constant text.
    """

    def __init__(self, title):
        """Start an empty page."""
        self.title = title
        self._parts = []
        self._contents = []     # (level, anchor, text)
        self.tables = {}        # name: (rows, columns, caption)

    def heading(self, text, level=2):
        """Add a heading with an anchor, which the contents list leads to."""
        anchor = re.sub(r'[^a-z0-9]+', '-', text.lower()).strip('-')
        taken = {name for _, name, _ in self._contents}
        while anchor in taken:
            anchor += '-'
        self._contents.append((level, anchor, text))
        self._parts.append(f'<h{level} id="{anchor}"><a href="#{anchor}">{html.escape(text)}</a>'
                           f'</h{level}>')

    def explain(self, text):
        """Add a paragraph that says what is asked, or how it is measured."""
        self._parts.append(f'<p>{html.escape(text)}</p>')

    def says(self, text, *, marked=False):
        """Add a paragraph that says what came out."""
        kind = ' class="marked"' if marked else ''
        self._parts.append(f'<p{kind}>{html.escape(text)}</p>')

    def answer(self, lines):
        """Add the lines that answer what the page asks."""
        items = ''.join(f'<li>{html.escape(line)}</li>' for line in lines)
        self._parts.append(f'<ol class="answer">{items}</ol>')

    def code(self, text):
        """Add preformatted text."""
        self._parts.append(f'<pre>{html.escape(text)}</pre>')

    def fold(self, summary):
        """Begin a part that is folded; `unfold` ends it."""
        self._parts.append(f'<details><summary>{html.escape(summary)}</summary>')

    def unfold(self):
        """End what `fold` began."""
        self._parts.append('</details>')

    def table(self, name, rows, columns, caption):
        """
        Add a table, and keep its rows for `NAME.csv`.

        rows : list of dict;  columns : dict key to heading with its unit, `integration step [us]`
        caption : what to see in it
        """
        if not rows:
            return
        self.data(name, rows, columns, caption)
        label = html.escape(caption, quote=True)
        out = [f'<p class="caption">{html.escape(caption)}</p>',
               f'<div class="scroll"><table aria-label="{label}"><thead><tr>',
               *(f'<th scope="col"><button>{html.escape(c)}</button></th>'
                 for c in columns.values()), '</tr></thead><tbody>']
        for row in rows:
            out.append('<tr>')
            for key in columns:
                value = row.get(key)
                sort = _key_value(value)
                kind = '' if sort is None else f' class="n" data-value="{sort!r}"'
                out.append(f'<td{kind}>{html.escape(show_number(_plain(value)))}</td>')
            out.append('</tr>')
        out.append('</tbody></table></div>')
        self._parts.append(''.join(out))

    def data(self, name, rows, columns, caption):
        """Keep rows for `NAME.csv` without showing them."""
        self.tables[name] = rows, columns, caption

    def figure(self, panels, caption, legend=()):
        """
        Add a figure of one or more panels side by side.

        panels : SVG texts;  legend : (label, colour, character) of each mark
        """
        marks = ''.join(f'<span><b style="color:{colour}">{mark}</b> {html.escape(label)}</span>'
                        for label, colour, mark in legend)
        body = ''.join(f'<div>{panel}</div>' for panel in panels)
        self._parts.append(f'<figure><div class="legend">{marks}</div><div class="panels">{body}'
                           f'</div><figcaption>{html.escape(caption)}</figcaption></figure>')

    def raw(self, markup):
        """Add markup as it is."""
        self._parts.append(markup)

    def _navigation(self):
        out = ['<nav aria-label="contents"><ul>']
        for level, anchor, text in self._contents:
            if level == 2:
                out.append(f'<li><a href="#{anchor}">{html.escape(text)}</a></li>')
        out.append('</ul></nav>')
        return ''.join(out)

    def content(self):
        """Return the page."""
        return (f'<!DOCTYPE html>\n<html lang="en"><head><meta charset="utf-8">'
                f'<meta name="viewport" content="width=device-width, initial-scale=1">'
                f'<link rel="icon" href="{ICON}"><title>{html.escape(self.title)}</title>'
                f'<style>{STYLE}</style></head>\n<body><h1>{html.escape(self.title)}</h1>\n'
                + self._navigation() + '\n' + '\n'.join(self._parts)
                + f'\n<script>{SCRIPT}</script></body></html>\n')

    def write(self, folder):
        """Write index.html, the tables and their README; return the page's path."""
        folder.mkdir(parents=True, exist_ok=True)
        for name, (rows, columns, _) in self.tables.items():
            _write_table(folder / f'{name}.csv', rows, columns)
        lines = ['What is drawn on the page index.html, and results.json with all of it.',
                 'An interval has columns of its own, from and to.', '']
        lines += [f'{name}.csv: {caption}' for name, (_, _, caption) in self.tables.items()]
        (folder / 'README.txt').write_text('\n'.join(lines) + '\n', encoding='utf-8')
        path = folder / 'index.html'
        path.write_text(self.content(), encoding='utf-8')
        return path


def _plain(value):
    return str(value) if isinstance(value, Measured) else value


def _write_table(path, rows, columns):
    wide = {key for key in columns for row in rows if isinstance(row.get(key), Measured)}
    with open(path, 'w', newline='', encoding='utf-8') as file:
        writer = csv.writer(file)
        writer.writerow([name for key, heading in columns.items() for name in (
            (heading, f'{heading}, from', f'{heading}, to') if key in wide else (heading,))])
        for row in rows:
            cells = []
            for key in columns:
                value = row.get(key)
                if key in wide:
                    cells += list(value) if isinstance(value, Measured) else [value, '', '']
                else:
                    cells.append('' if value is None else value)
            writer.writerow(cells)
