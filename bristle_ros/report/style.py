"""How the page looks, and the script that sorts its tables."""
STYLE = """
:root {color-scheme: light}
* {box-sizing: border-box}
body {font: 16px/1.5 system-ui, sans-serif; max-width: 1120px; margin: 0 auto; padding: 0 16px 4em;
      color: #1a1a1a; background: #fff; overflow-wrap: break-word}
h1 {font-size: 1.5em; line-height: 1.2} h2 {margin-top: 2.4em; border-bottom: 1px solid #bbb}
h3 {margin-top: 1.8em}
h2 a, h3 a {color: inherit; text-decoration: none}
nav ul {columns: 2; padding-left: 1.2em} nav ul ul {columns: 1}
.answer {border: 2px solid #1f77b4; border-radius: 6px; padding: .2em 1em .2em 2.2em}
.answer li {margin: .35em 0}
.marked {background: #fff3cd; border-left: 4px solid #e0a800; padding: .4em .8em}
table {border-collapse: collapse; font-size: 14px} .caption {color: #444; margin: 1em 0 .2em}
td, th {border: 1px solid #ccc; padding: .25em .5em; text-align: left; vertical-align: top}
td {min-width: 3.2em; max-width: 34em} td.n {text-align: right; min-width: 5em}
th {background: #f1f3f5} th button {all: unset; cursor: pointer; font-weight: bold}
th button:focus-visible {outline: 2px solid #1f77b4}
th button::after {content: ' \\2195'; color: #888}
th[aria-sort=ascending] button::after {content: ' \\2191'}
th[aria-sort=descending] button::after {content: ' \\2193'}
.scroll {overflow-x: auto; margin: 0 0 .8em; max-width: 100%}
figure {margin: 1.2em 0} figcaption {color: #444; margin-top: .3em}
.panels {display: flex; flex-wrap: wrap; gap: 12px}
.panels > div {flex: 1 1 320px; max-width: 356px; min-width: 0}
.panels svg {width: 100%; height: auto; display: block}
.legend span {display: inline-block; margin-right: 1.2em} .legend b {font-size: 1.15em}
pre {padding: .6em; overflow-x: auto; background: #f6f6f6; font-size: 13px}
details {border: 1px solid #ccc; border-radius: 4px; padding: .3em .8em; margin: .8em 0}
summary {cursor: pointer; font-weight: 600}
.map {font-size: 12px; line-height: 1.25} .map div {margin: 2px 0}
.map b {display: inline-block; min-width: 15em; font-weight: normal}
.map span {display: inline-block; border: 1px solid #999; border-radius: 3px; padding: 0 4px;
           margin: 1px}
@media (max-width: 600px) {
  body {padding: 0 10px 3em} nav ul {columns: 1} td, th {padding: .2em .35em; font-size: 13px}
  .map b {display: block} .panels > div {max-width: 520px}
}
@media print {
  body {max-width: none; font-size: 11pt} .scroll {overflow: visible} nav {display: none}
  figure, tr {break-inside: avoid} h2, h3 {break-after: avoid} table {font-size: 8.5pt}
  th button::after {content: ''} td.n {white-space: normal}
}
"""

# Opens what is folded before printing; sorts a table by the column whose heading is pressed.
SCRIPT = """
addEventListener('beforeprint', () => {
  document.querySelectorAll('details').forEach(folded => folded.open = true);
});
document.querySelectorAll('th button').forEach(button => button.addEventListener('click', () => {
  const th = button.parentElement, table = th.closest('table'), body = table.tBodies[0];
  const down = th.getAttribute('aria-sort') === 'ascending';
  table.querySelectorAll('th').forEach(other => other.removeAttribute('aria-sort'));
  th.setAttribute('aria-sort', down ? 'descending' : 'ascending');
  const value = row => {
    const cell = row.cells[th.cellIndex];
    return cell.dataset.value === undefined ? cell.textContent : parseFloat(cell.dataset.value);
  };
  const rows = [...body.rows].sort((a, b) => {
    const x = value(a), y = value(b);
    const both = typeof x === 'number' && typeof y === 'number';
    if (both && !isNaN(x) && !isNaN(y)) return x - y;
    if (both) return isNaN(x) - isNaN(y);
    return String(x).localeCompare(String(y));
  });
  (down ? rows.reverse() : rows).forEach(row => body.append(row));
}));
"""
