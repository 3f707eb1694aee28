"""The verb `compare`: lays a measured time series over a simulated one."""
from bristle_ros.command_line import Parser, WholeFile
from bristle_ros.plot import read
from bristle_ros.scene import SceneError
import numpy as np

from .comparing import compare
from .figures import page_of
from .table_file import read_table

QUANTITIES = {'normal_force': 'N', 'torque': 'N m'}


def _parse(arguments):
    parser = Parser('compare', 'Lays a measured time series over a simulated one: shift, scale, '
                    'error by octave, and a plot. The CSV has columns t [s] and normal_force [N] '
                    '(whole brush, along the road normal) or torque [N m] (drive on brush).')
    parser.add_argument('log', metavar='LOG|FILE.npz|FILE.csv', help='what was simulated')
    parser.add_argument('measured', metavar='MEASURED.csv')
    parser.add_argument('--most-shift', type=float, metavar='S',
                        help='largest shift either way [s]; default: half of the shorter series')
    parser.add_argument('--output', default='compare.html', metavar='FILE.html')
    return parser.parse_args(arguments)


def main(arguments):
    """Run the verb `compare`; return its exit code."""
    options = _parse(arguments)
    table = read_table(options.measured, least=16)
    quantities = [name for name in table if name in QUANTITIES]
    if 't' not in table or not quantities:
        raise SceneError(f'must have columns t and {" or ".join(QUANTITIES)}',
                         source=options.measured)
    if not (np.diff(table['t']) > 0.0).all():
        raise SceneError('must increase', key='t', source=options.measured)
    series = read(options.log)
    shortest = min(float(np.ptp(series.t)), float(np.ptp(table['t'])))
    most = options.most_shift if options.most_shift is not None else 0.5 * shortest
    if not 0.0 <= most <= 1e6:
        raise SceneError('must be a time of at least 0 s', key='--most-shift', value=most)
    found = {}
    for name in quantities:
        try:
            found[name] = compare((series.t, getattr(series, name)), (table['t'], table[name]),
                                  most)
        except ValueError:
            raise SceneError('does not overlap with what was simulated, or does not vary',
                             key=name, source=options.measured) from None
        print(_told(name, found[name]))
    with WholeFile(options.output, text=True, overwrite=True) as file:
        file.write(_page(found))
    print(f'written: {options.output}')
    return 0


def _told(name, one):
    bands = '; '.join(f'{low:.3g} to {high:.3g} Hz ({share:.0%} of the variance): {error:.0%}'
                      for low, high, share, error in one.bands if share > 0.005)
    return (f'{name}: measured comes {one.shift:.4g} s later, is {one.scale:.4g} times the '
            f'simulated and {one.offset:.3g} {QUANTITIES[name]}; correlation '
            f'{one.correlation:.3f}, error {one.error:.1%} of what varies\n  by band: {bands}')


def _page(found):
    from plotly import graph_objects as go
    figures = []
    for name, one in found.items():
        series = go.Figure(layout={'title': f'{name} [{QUANTITIES[name]}]',
                                   'xaxis': {'title': 't [s]'}})
        for values, label in ((one.measured, 'measured'), (one.simulated, 'simulated, scaled')):
            series.add_scatter(x=one.t, y=values, name=label)
        figures += [series, go.Figure(
            go.Bar(x=[f'{low:.3g} to {high:.3g}' for low, high, _, _ in one.bands],
                   y=[error for *_, error in one.bands]),
            {'title': f'{name}: error over measured, by octave',
             'xaxis': {'title': 'frequency [Hz]', 'type': 'category'}})]
    lines = [line for name, one in found.items() for line in _told(name, one).split('\n')]
    return page_of('compare', lines, figures)
