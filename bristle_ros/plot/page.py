"""Draws one page of figures of a run. No window, no display: a file is written and that is all."""
from matplotlib import colormaps
from matplotlib.collections import LineCollection
from matplotlib.colors import ListedColormap
from matplotlib.figure import Figure
import numpy as np

RAW, SMOOTH, ACCENT, GREY = '#9ecae1', '#08519c', '#d94801', '#636363'
POINTS = 6000           # of a line: more than the page has pixels
SMOOTHING = 0.05        # [s] least width of the moving mean,
SHARE = 0.05            # and its share of what is drawn
_STYLE = {'font.size': 8.5, 'axes.titlesize': 9.5, 'axes.titlelocation': 'left',
          'axes.grid': True, 'grid.alpha': 0.3, 'grid.linewidth': 0.5, 'axes.axisbelow': True,
          'axes.spines.top': False, 'axes.spines.right': False, 'legend.frameon': False,
          'legend.fontsize': 8, 'lines.linewidth': 0.9, 'svg.hashsalt': 'bristle_ros'}


def draw(series, name, file, kind):
    """Write the page of a Series called `name` to an open file; kind: .png, .pdf or .svg."""
    from matplotlib import rc_context
    with rc_context(_STYLE):
        figure = Figure(figsize=(10.6, 7.4), layout='constrained')
        left, right = figure.subfigures(1, 2, width_ratios=(1.0, 1.75))
        above, side = left.subplots(2, 1, height_ratios=(1.55, 1.0))
        force, torque, timing, spectrum = right.subplots(4, 1)
        lines = _paths(above, side, series)
        if lines is not None:
            left.colorbar(lines, ax=[above, side], location='bottom', shrink=0.8, aspect=40,
                          label='normal force [N]')
        _over_time(force, series, series.normal_force, 'normal force [N]',
                   'Normal force, road on brush')
        _over_time(torque, series, series.torque * 1e3, 'torque [mN m]',
                   'Torque, drive on brush')
        _spectrum(spectrum, series)
        _timing(timing, series)
        for axes in (force, torque, timing):
            axes.set_xlim(series.t[0], series.t[-1])
            axes.tick_params(labelbottom=axes is timing)
        timing.set_xlabel('simulation time [s]')
        figure.suptitle(f'{name}: {series.about}', x=0.01, ha='left', fontsize=10.5)
        if kind == '.png':
            figure.savefig(file, format='png', dpi=95, pil_kwargs={'optimize': True})
        else:
            figure.savefig(file, format=kind[1:], metadata=_no_date(kind))


def _no_date(kind):
    """Return metadata that make the same run the same file."""
    return {'CreationDate': None} if kind == '.pdf' else {'Date': None}


def _paths(above, side, series):
    """Draw the tip's path from above and from the side; return what a colour bar needs."""
    # of a long run the end: thinned, a path would be a polygon that it never was
    x, y, z = series.tip[-POINTS:].T * 1e3
    colour, t = series.normal_force[-POINTS:], series.t[-POINTS:]
    cut = len(t) < len(series.t)
    touches = bool(series.normal_force.any())
    top = max(float(np.quantile(series.normal_force, 0.98)), 1e-9)
    for axes, across, up in ((above, x, y), (side, np.hypot(x, y), z)):
        points = np.column_stack((across, up))
        lines = LineCollection(np.stack((points[:-1], points[1:]), axis=1), linewidths=1.1)
        if touches:
            # The palest end of the map could not be seen on white.
            lines.set(array=colour[1:], cmap=ListedColormap(
                colormaps['plasma_r'](np.linspace(0.2, 1.0, 200))), clim=(0.0, top))
        else:
            lines.set_color(SMOOTH)
        axes.add_collection(lines)
        axes.plot(*points[0], 'o', color='black', markersize=3.5)
        axes.annotate(f'{t[0]:.4g} s' if cut else 'start', points[0], (6, -10),
                      textcoords='offset points')
        axes.autoscale()
    above.set(title="Tip of bristle 0 from above, the mount's axes"
              + (f', last {_spell(t[-1] - t[0])}' if cut else ''), xlabel='x, forward [mm]',
              ylabel='y, left [mm]')
    if series.rest:
        turn = np.linspace(0.0, 2.0 * np.pi, 181)
        for (radius, _), dash, label in zip(series.rest, (':', '--'), ('clamp', 'undeformed tip')):
            above.plot(radius * 1e3 * np.cos(turn), radius * 1e3 * np.sin(turn), dash, color=GREY,
                       linewidth=0.8, label=label)
        above.legend(loc='center')
        side.plot(*(1e3 * value for value in series.rest[1]), 's', color=GREY, markersize=8,
                  fillstyle='none', label='undeformed tip')
        side.legend(loc='lower right')
    above.set_aspect('equal', adjustable='datalim')
    side.set(title='The same from the side', xlabel='distance from the brush axis [mm]',
             ylabel='z [mm]')
    side.margins(0.1)
    return lines if touches else None


def _over_time(axes, series, values, unit, title):
    t, thin = _envelope(series.t, values)
    width = max(SMOOTHING, SHARE * (series.t[-1] - series.t[0]))
    smooth = _moving_mean(series.t, values, width)
    axes.plot(t, thin, color=RAW, label='samples')
    if smooth is not None:
        axes.plot(*_envelope(series.t, smooth), color=SMOOTH, linewidth=1.2,
                  label=f'mean over {_spell(width)}')
    _look_at_the_bulk(axes, series.t, values)
    if len(series.commands):
        axes.plot(series.commands, np.full(len(series.commands), 1.0), 'v', color=ACCENT,
                  markersize=4, clip_on=False, transform=axes.get_xaxis_transform(),
                  label='command or reset')
    axes.set(title=title, ylabel=unit)
    axes.legend(loc='lower right', bbox_to_anchor=(1.0, 0.97), ncols=3, borderpad=0.0)


def _look_at_the_bulk(axes, t, values):
    """Let a few spikes leave the axes where the rest would be flat; say how high they are."""
    usual = 2.0 * float(np.quantile(values, 0.99))
    peak = int(values.argmax())
    if usual > 0.0 and values[peak] > 2.0 * usual:
        axes.set_ylim(min(float(values.min()), -0.05 * usual), usual)
        right = t[peak] < 0.5 * (t[0] + t[-1])
        axes.annotate(f'largest: {values[peak]:.3g} at {t[peak]:.4g} s', (t[peak], usual),
                      (4 if right else -4, -9), textcoords='offset points', color=GREY,
                      ha='left' if right else 'right')


def _spectrum(axes, series):
    if series.normal_force.any():
        curves = ((series.normal_force, 'normal force [N/√Hz]', SMOOTH),
                  (series.torque, 'torque [N m/√Hz]', ACCENT))
    else:
        radius = np.hypot(series.tip[:, 0], series.tip[:, 1])
        curves = ((radius * 1e3, "tip's distance from the axis [mm/√Hz]", SMOOTH),
                  (series.tip[:, 2] * 1e3, "tip's z [mm/√Hz]", ACCENT))
    axes.set(title='Amplitude spectral density', xlabel='frequency [Hz]', ylabel='density')
    drawn = False
    for values, label, colour in curves:
        frequency, density = amplitude_density(series.t, values)
        if density.size and density[1:].any():
            axes.loglog(frequency[1:], density[1:], color=colour, label=label)
            drawn = True
    if drawn:
        axes.set_xlim(frequency[1], frequency[-1])
        axes.legend(loc='lower left')
    else:
        axes.text(0.5, 0.5, 'nothing that varies for long enough', ha='center', va='center',
                  transform=axes.transAxes, color=GREY)


def amplitude_density(t, values):
    """
    Return (frequency [Hz], amplitude spectral density [unit of `values` / sqrt(Hz)]).

    Welch's mean over segments with a Hann window, half overlapping; the square's integral over
    frequency is the variance. Of samples with gaps, the longest part without one is taken. Both
    are empty below 32 samples. Source: Welch (1967), IEEE Trans. Audio Electroacoust. 15, 70-73.
    """
    gaps = np.diff(t)
    step = float(np.median(gaps))
    broken = np.flatnonzero(np.abs(gaps - step) > 1e-3 * step) + 1
    values = max(np.split(values, broken), key=len)
    if len(values) < 32:
        return np.empty(0), np.empty(0)
    length = min(4096, max(32, len(values) // 4))
    window = np.hanning(length + 1)[:-1]
    starts = range(0, len(values) - length + 1, length // 2)
    power = np.zeros(length // 2 + 1)
    for start in starts:
        part = values[start:start + length]
        power += np.abs(np.fft.rfft((part - part.mean()) * window)) ** 2
    power *= 2.0 * step / (len(starts) * np.sum(window ** 2))
    return np.fft.rfftfreq(length, step), np.sqrt(power)


def _timing(axes, series):
    timing = series.timing
    axes.set(title=timing.title, ylabel=timing.unit)
    if not len(timing.t):
        return
    axes.plot(*_envelope(timing.t, timing.value), '.', color=SMOOTH, markersize=2.0)
    real_time = np.nan_to_num(timing.real_time)
    axes.set_ylim(0.0, max(1.15 * float(timing.value.max()), 1.3 * real_time, 1e-9))
    _look_at_the_bulk(axes, timing.t, timing.value)
    if np.isfinite(timing.real_time):
        share = timing.value.sum() / (timing.real_time * len(timing.value))
        axes.axhline(timing.real_time, color=ACCENT, linestyle='--', linewidth=0.9,
                     label=f'real time (run: {1.0 / share:.3g} of it)'
                     + (f', {timing.told}' if timing.told else ''))
        upper = axes
        if timing.told:     # a run that was paced
            upper = late = axes.twinx()
            late.plot(timing.t, timing.delay, color=GREY, linewidth=0.8)
            late.set_ylabel('behind [s]', color=GREY)
            late.grid(False)
        # inside: it is too long beside the title; `largest` has the top
        upper.legend(*axes.get_legend_handles_labels(), loc='center right', frameon=True,
                     facecolor='white', edgecolor='none', framealpha=1.0)


def _moving_mean(t, values, width):
    """Return the mean over `width` [s] around each sample; None where that is too few of them."""
    width = round(width / float(np.median(np.diff(t)))) | 1
    if not 5 <= width <= len(values) // 2:
        return None
    sums = np.cumsum(np.concatenate(([0.0], values)))
    at = np.arange(len(values))
    first, last = np.maximum(at - width // 2, 0), np.minimum(at + width // 2 + 1, len(values))
    return (sums[last] - sums[first]) / (last - first)


def _envelope(t, values):
    """Thin a line without losing a peak: the least and the largest value of each bin."""
    size = -(-len(values) // (POINTS // 2))
    if size <= 2:
        return t, values
    edges = np.arange(0, len(values), size)
    low, high = np.minimum.reduceat(values, edges), np.maximum.reduceat(values, edges)
    return np.repeat(t[edges], 2), np.column_stack((low, high)).ravel()


def _spell(seconds):
    return f'{seconds:.3g} s' if seconds >= 1.0 else f'{seconds * 1e3:.3g} ms'
