"""The page of a study: the answer first, then plots to look around in, and a table."""
import html
import json
import math
from pathlib import Path

from bristle_ros.command_line import WholeFile
import numpy as np

from . import store
from .answer import answer
from .measure import MEASURES
from .page_script import SCRIPT, STYLE
from .study_file import restored

DRAWN = 4000            # rows that the page holds, evenly taken from a larger study
CSV_ROWS = 200_000      # up to which the table is there as CSV too


def write_page(folder):
    """Write index.html, and runs.csv of not too many rows, into a study's directory."""
    folder = Path(folder)
    found = store.description(folder)
    study = restored(found['study'])
    rows = store.count(folder)
    every = max(1, -(-rows // DRAWN))
    table = store.table(folder)
    told = answer(study, folder, table)
    if rows <= CSV_ROWS:
        with WholeFile(folder / 'runs.csv', overwrite=True, key='DIR') as file:
            store.write_csv(table, file)
    shown = table.take(np.arange(0, rows, every))
    keys = table.column_names[1:table.column_names.index('status')]
    measures = [name for name in MEASURES if any(
        value is not None and math.isfinite(value) for value in shown[name].to_pylist())]
    data = {'keys': keys, 'measures': measures, 'units': MEASURES, 'columns': {
        name: _json(shown[name].to_pylist())
        for name in ('run', *keys, 'status', 'message', 'settled', *measures,
                     *(f'{name}_ci95' for name in measures
                       if f'{name}_ci95' in table.column_names))},
        'indices': told.indices, 'best': [row['run'] for row in told.best]}
    text = _html(folder.resolve().name, told, data, found, rows, every, rows <= CSV_ROWS)
    place = folder / 'index.html'
    with WholeFile(place, text=True, overwrite=True, key='DIR') as file:
        file.write(text)
    return place


def _json(values):
    """Return values with which JSON can do: no NaN, and six digits."""
    return [None if value is None or (isinstance(value, float) and not math.isfinite(value))
            else float(f'{value:.6g}') if isinstance(value, float) else value
            for value in values]


def _html(title, told, data, found, rows, every, has_csv):
    from plotly.offline import get_plotlyjs
    escape = html.escape
    taken = '' if every == 1 else f' Plots and table show every {every}th of {rows} rows.'
    links = ['<a href="study.json">study.json</a> (study file, scene, versions)',
             '<a href="runs.parquet/">runs.parquet</a> (all rows)']
    if has_csv:
        links.insert(0, '<a href="runs.csv">runs.csv</a>')
    notes = ''.join(f'<li>{escape(note)}</li>' for note in told.notes)
    head = ''.join(f'<p class="answer">{escape(line)}</p>' for line in told.lines)
    machine = found['machine']
    payload = json.dumps(data).replace('</', '<\\/')
    return f"""<!DOCTYPE html>
<html lang="en"><head><meta charset="utf-8"><title>{escape(title)}</title>
<meta name="viewport" content="width=device-width, initial-scale=1"><style>{STYLE}</style>
<script>{get_plotlyjs()}</script></head><body>
<h1>{escape(title)}</h1>
{head}
<ul>{notes}</ul>
<div id="sobol"></div>
<h2>Measures over keys</h2>
<p class="controls"><label>measure <select id="measure"></select></label>
<label>over <select id="first"></select></label>
<label>and <select id="second"></select></label></p>
<div class="plots"><div id="response"></div><div id="map"></div></div>
<h2>All keys at once</h2><div id="parallel"></div>
<h2>Rows</h2>
<p class="controls"><label>filter <input id="filter" size="30"
placeholder="drive.mean_speed > 10, settled = yes"></label> <span id="shown"></span></p>
<div class="scroll"><table id="rows"></table></div>
<p>{escape(taken.strip())} {" · ".join(links)}</p>
<p class="note">bristle_ros {escape(found["version"])} on {escape(machine["cpu"].split(",")[0])},
numba {escape(machine["numba"])}, numpy {escape(machine["numpy"])}. Intervals are 95 %, by batch
means over turns.</p>
<details><summary>study file</summary><pre>{escape(found["file"])}</pre></details>
<script>const DATA = {payload};
{SCRIPT}</script></body></html>
"""
