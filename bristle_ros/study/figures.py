"""Pages of a few plots below what they say in words, legible on narrow screens."""
import html

from .page_script import STYLE


def page_of(title, lines, figures):
    """Return a page as HTML that needs no network: a title, lines of text, plotly Figures."""
    from plotly.offline import get_plotlyjs
    said = ''.join(f'<p class="answer">{html.escape(line)}</p>' for line in lines)
    plots = ''
    for figure in figures:
        heading = figure.layout.title.text
        figure.update_layout(
            height=400, margin={'l': 60, 'r': 12, 't': 32, 'b': 50}, template='plotly_white',
            legend={'orientation': 'h', 'y': -0.2, 'yanchor': 'top'}, title=None)
        drawn = figure.to_html(full_html=False, include_plotlyjs=False,
                               config={'responsive': True, 'displaylogo': False})
        plots += f'<div><h2>{html.escape(heading)}</h2>{drawn}</div>'
    return f"""<!DOCTYPE html>
<html lang="en"><head><meta charset="utf-8"><title>{html.escape(title)}</title>
<meta name="viewport" content="width=device-width, initial-scale=1"><style>{STYLE}</style>
<script>{get_plotlyjs()}</script></head><body>
<h1>{html.escape(title)}</h1>
{said}
<div class="plots">{plots}</div>
<script>document.querySelectorAll('.js-plotly-plot').forEach(Plotly.Plots.resize)</script>
</body></html>
"""
