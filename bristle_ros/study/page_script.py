"""Style and script of a study's page: plots by Plotly, a table that sorts and filters."""

STYLE = """
body {font: 15px/1.45 system-ui, sans-serif; max-width: 1280px; margin: 1.5em auto;
      padding: 0 1em; color: #1a1a1a; background: #fff}
h1 {font-size: 1.5em} h2 {font-size: 1.15em; margin-top: 1.8em; border-bottom: 1px solid #ccc}
.answer {font-size: 1.1em; margin: .4em 0} .note {color: #555; font-size: 13px}
.plots {display: flex; flex-wrap: wrap; gap: 8px} .plots > div {flex: 1 1 420px; min-width: 0}
#response, #map {height: 400px} #parallel {height: 430px; overflow-x: auto}
.controls label {margin-right: .8em; white-space: nowrap} select {max-width: 100%}
.scroll {overflow: auto; max-height: 480px} pre {overflow-x: auto; background: #f6f6f6}
table {border-collapse: collapse; font-size: 13px} td, th {border: 1px solid #ccc;
  padding: .2em .5em; text-align: right; white-space: nowrap}
th {background: #f1f3f5; position: sticky; top: 0; cursor: pointer} tr.bad {color: #b00}
tr.best {background: #e8f4e8} @media (max-width: 600px) {body {padding: 0 .5em}
  .controls label {display: block; margin: .3em 0}}
"""

SCRIPT = r"""
const C = DATA.columns, N = C.run.length, $ = id => document.getElementById(id);
const unit = m => DATA.units[m] && DATA.units[m] !== '1' ? ` [${DATA.units[m]}]` : '';
const narrow = () => innerWidth < 620;
const layout = more => Object.assign({margin: {l: 62, r: 12, t: 34, b: 48}, autosize: true,
  font: {size: narrow() ? 11 : 13}, showlegend: false, hovermode: 'closest'}, more);
const title = text => ({text, font: {size: 14}, x: 0.01, xanchor: 'left'});
const options = {responsive: true, displaylogo: false, displayModeBar: narrow() ? false : 'hover'};
const fill = (id, names, at) => names.forEach((name, i) =>
  $(id).add(new Option(name, name, i === at, i === at)));
const at = (key, rows) => rows.map(i => C[key][i]);
const done = [], bad = [];
for (let i = 0; i < N; i++) (C.status[i] === 'finished' ? done : bad).push(i);

function groups(key, rows) {    // level -> rows; many numbers in 12 bins
  const values = at(key, rows), levels = new Set(values), found = new Map();
  let name = v => v;
  if (levels.size > 12 && typeof values[0] === 'number') {
    const low = values.reduce((a, b) => Math.min(a, b));
    const high = values.reduce((a, b) => Math.max(a, b));
    name = v => low + (Math.min(11, Math.floor(12 * (v - low) / (high - low))) + 0.5)
      * (high - low) / 12;
  }
  rows.forEach((row, i) => {
    const level = name(values[i]);
    if (!found.has(level)) found.set(level, []);
    found.get(level).push(row);
  });
  return new Map([...found].sort((a, b) => a[0] < b[0] ? -1 : 1));
}
const mean = list => { const l = list.filter(v => v !== null);
  return l.length ? l.reduce((a, b) => a + b, 0) / l.length : null; };

function draw() {
  const m = $('measure').value, x = $('first').value, y = $('second').value;
  const text = rows => rows.map(
    i => `row ${C.run[i]}` + (C.message[i] ? ': ' + C.message[i] : ''));
  const ci = C[m + '_ci95'], per = groups(x, done), floor = Math.min(0, ...at(m, done));
  Plotly.react('response', [
    {x: at(x, done), y: at(m, done), mode: 'markers', text: text(done), marker: {size: 6,
     opacity: 0.55, color: y === x ? '#08519c' : at(y, done), colorscale: 'Viridis',
     showscale: y !== x && typeof C[y][0] === 'number', colorbar: {title: {text: y, side: 'right'},
     thickness: 10}}, error_y: {array: ci ? at(m + '_ci95', done) : [], visible: !!ci,
     thickness: 0.7, color: '#999'}},
    {x: [...per.keys()], y: [...per.values()].map(rows => mean(at(m, rows))), mode: 'lines',
     line: {color: '#d94801', width: 2}, name: 'mean'},
    {x: at(x, bad), y: bad.map(() => floor), mode: 'markers', text: text(bad),
     marker: {symbol: 'x', size: 9, color: '#b00'}}],
    layout({title: title(`${m} over ${x}`), xaxis: {title: {text: x}},
            yaxis: {title: {text: m + unit(m)}, automargin: true}}), options);
  $('map').style.display = x === y ? 'none' : '';
  if (x !== y) {
    const columns = groups(x, [...done, ...bad]), lines = groups(y, [...done, ...bad]);
    const z = [...lines.values()].map(line => { const set = new Set(line);
      return [...columns.values()].map(column =>
        mean(column.filter(i => set.has(i) && C.status[i] === 'finished').map(i => C[m][i]))); });
    Plotly.react('map', [{type: 'heatmap', x: [...columns.keys()], y: [...lines.keys()], z,
      colorscale: 'Viridis', colorbar: {title: {text: m + unit(m), side: 'right'}, thickness: 12}},
      {x: at(x, bad), y: at(y, bad), mode: 'markers', text: text(bad),
       marker: {symbol: 'x', size: 9, color: '#b00'}}],
      layout({title: title(`${m}, mean of rows; red: not finished`),
              xaxis: {title: {text: x}}, yaxis: {title: {text: y}, automargin: true}}), options);
  }
  const axes = [...DATA.keys, m].map(name => { const v = at(name, done);
    if (typeof v[0] === 'number') return {label: name, values: v};
    const levels = [...new Set(v)];
    return {label: name, values: v.map(each => levels.indexOf(each)), ticktext: levels,
            tickvals: levels.map((_, i) => i)}; });
  if (done.length) Plotly.react('parallel', [{type: 'parcoords', dimensions: axes,
    line: {color: at(m, done).map(v => v === null ? 0 : v), colorscale: 'Viridis',
           showscale: !narrow()},
    labelangle: narrow() ? -25 : -12, labelfont: {size: narrow() ? 9 : 12}}],
    layout({margin: {l: 70, r: 50, t: 90, b: 20}, height: 410, autosize: !narrow(),
    // room for each key's name: it scrolls sideways
    width: narrow() ? Math.max(innerWidth - 20, 100 * axes.length) : undefined}), options);
  bars(m);
}

function bars(m) {
  const found = DATA.indices[m];
  $('sobol').style.display = found ? '' : 'none';
  if (!found) return;
  const bar = (name, color) => ({type: 'bar', orientation: 'h', y: found.map(f => f.key),
    x: found.map(f => f[name]), name: name === 'S1' ? 'alone (S1)' : 'with others (ST)',
    marker: {color}, error_x: {array: found.map(f => f[name + '_ci95'])}});
  Plotly.react('sobol', [bar('S1', '#9ecae1'), bar('ST', '#08519c')], layout({showlegend: true,
    height: 120 + 46 * found.length, yaxis: {automargin: true},
   legend: {orientation: 'h', y: -0.25}, title: title(`share of the variance of ${m}`)}), options);
}

const HEADS = ['run', ...DATA.keys, 'status', 'settled', ...DATA.measures];
let order = [...Array(N).keys()], sorted = 'run', up = true;
function keep(i) {
  return $('filter').value.split(',').every(part => {
    const found = part.match(/^\s*([\w.]+)\s*(>=|<=|>|<|=)\s*(.+?)\s*$/);
    if (!found || !(found[1] in C)) return true;
    const value = C[found[1]][i], limit = isNaN(found[3]) ? found[3] : +found[3];
    if (found[2] === '=') return String(value) === String(limit);
    if (value === null) return false;
    return {'>': value > limit, '<': value < limit, '>=': value >= limit,
            '<=': value <= limit}[found[2]]; });
}
function rows() {
  order.sort((a, b) => { const u = C[sorted][a], v = C[sorted][b];
    if (u === null || v === null) return (u === null) - (v === null);
    return (u < v ? -1 : u > v ? 1 : 0) * (up ? 1 : -1); });
  const shown = order.filter(keep), best = new Set(DATA.best);
  $('shown').textContent = `${shown.length} of ${N} rows` +
    (shown.length > 500 ? ', the first 500 shown' : '');
  const table = $('rows'); table.textContent = '';
  const head = table.insertRow();
  HEADS.forEach(name => { const cell = document.createElement('th');
    cell.textContent = name + (name === sorted ? up ? ' ▲' : ' ▼' : '');
    cell.onclick = () => { up = name === sorted ? !up : true; sorted = name; rows(); };
    head.append(cell); });
  shown.slice(0, 500).forEach(i => { const line = table.insertRow();
    line.className = C.status[i] !== 'finished' ? 'bad' : best.has(C.run[i]) ? 'best' : '';
    line.title = C.message[i] || '';
    HEADS.forEach(name => { const v = C[name][i];
      line.insertCell().textContent = v === null ? '' : typeof v === 'number'
        ? +v.toPrecision(4) : v; }); });
}
fill('measure', DATA.measures, Math.max(0, DATA.measures.findIndex(m => DATA.indices[m])));
fill('first', DATA.keys, 0); fill('second', DATA.keys, Math.min(1, DATA.keys.length - 1));
['measure', 'first', 'second'].forEach(id => $(id).onchange = draw);
$('filter').oninput = rows;
draw(); rows();
"""
