"""The `plot` verb: one page of figures of a run."""
import argparse
import math
from pathlib import Path
import sys

from bristle_ros.command_line import check_place, Parser, WholeFile

FORMATS = ('.png', '.pdf', '.svg')


def default_output(path):
    """Return where the page of `path` goes: beside it, as a PNG of the same name."""
    path = Path(path).expanduser()
    path = path.resolve() if path.name in ('', '.', '..') else path
    stem = Path(path.name.removesuffix('.zstd')).stem
    return path.with_name(f'{path.name if path.is_dir() else stem}.png')


def plot(path, output=None, *, begin=0.0, end=math.inf, overwrite=False):
    """
    Draw tip path, normal force, brush torque, spectrum and timing of a run; return the file.

    path : of a log (.mcap or bag directory), or of the .npz or .csv of `simulate`
    output : .png, .pdf or .svg; default: NAME.png beside it, which is drawn anew
    overwrite : whether another `output` may be replaced
    begin, end : [s] of simulation time to draw
    Raises SceneError.
    """
    overwrite = overwrite or not output
    output = check_place(output or default_output(path), FORMATS, overwrite=overwrite)
    from .series import read
    series = read(path, begin, end)
    from .page import draw  # matplotlib: only when there is something to draw
    with WholeFile(output, overwrite=overwrite, keep=False) as file:
        draw(series, Path(path).name or str(path), file, output.suffix)
    return output


def _seconds(text):
    try:
        value = float(text)
    except ValueError:
        value = math.nan
    if not value >= 0.0:
        raise argparse.ArgumentTypeError(f'{text!r}: must be seconds, 0 or more')
    return value


def main(argv=None):
    """Run the verb; return its exit code."""
    parser = Parser('plot', 'Draws a run to one page: tip path, normal force, brush torque, '
                    'spectrum, timing.')
    parser.add_argument('log', help='an .mcap or .mcap.zstd file, a bag directory, also one '
                        'that was cut off, or the .npz or .csv of simulate')
    parser.add_argument('--output', metavar='FILE',
                        help='.png, .pdf or .svg (default: NAME.png beside the log)')
    parser.add_argument('--overwrite', action='store_true',
                        help='let --output replace a file, once the new one is whole')
    parser.add_argument('--from', dest='begin', type=_seconds, default=0.0, metavar='S',
                        help='first simulation time drawn [s]')
    parser.add_argument('--to', dest='end', type=_seconds, default=math.inf, metavar='S',
                        help='last simulation time drawn [s]')
    options = parser.parse_args(sys.argv[1:] if argv is None else argv)
    page = plot(options.log, options.output, begin=options.begin, end=options.end,
                overwrite=options.overwrite)
    print(f'drawn: {page}')
    return 0
