"""The verb `plot`: what it reads from logs and arrays, what it draws, what it refuses."""
import math
import re
import subprocess
import sys

from bristle_ros.log import writer as logs
from bristle_ros.plot import main as plot, page as plot_page, series as plot_series
from bristle_ros.scene.error import SceneError
from bristle_ros.scene.scene import load
from bristle_ros.verbs.simulate import simulate
from matplotlib.figure import Figure
import numpy as np
import pytest

DURATION = 0.3


@pytest.fixture(scope='module')
def run(root, tmp_path_factory):
    """Record a tilted brush that meets the road: run.mcap with a command, run.npz, the scene."""
    folder = tmp_path_factory.mktemp('plot')
    overrides = {'road.tilt_azimuth': 2.1, 'road.approach_time': 0.05, 'solver.elements': 4,
                 'brush.bristle_count': 2, 'brush.wires_per_bristle': 3}
    scene = load(root / 'config/tilted_sweep.yaml', overrides)
    commands = [(0.2, 'cmd_brush_speed', (17.0,))]
    simulate(scene, DURATION, commands=commands, output=folder / 'run.npz')
    simulate(scene, DURATION, commands=commands, output=folder / 'run.mcap')
    return folder, scene


def test_log_and_arrays_tell_the_same(run):
    folder, scene = run
    log, arrays = (plot_series.read(folder / name) for name in ('run.mcap', 'run.npz'))
    assert len(log.t) == round(DURATION / scene.run.sample)
    assert log.normal_force.max() > 0.1  # it meets the road
    assert log.t == pytest.approx(arrays.t, rel=1e-12)
    assert log.tip == pytest.approx(arrays.tip, rel=1e-9, abs=1e-12)
    assert log.torque == pytest.approx(arrays.torque, rel=1e-12)
    # The arrays hold one wire of each bristle, the log the whole brush.
    assert log.normal_force == pytest.approx(
        scene.brush.wires_per_bristle * arrays.normal_force, rel=1e-9, abs=1e-12)


def test_commands_and_geometry_come_from_the_log(run):
    folder, scene = run
    log = plot_series.read(folder / 'run.mcap')
    assert log.commands == pytest.approx([0.2], rel=1e-9)
    (clamp, _), (radius, z) = log.rest
    assert clamp == scene.brush.mount_radius
    assert math.hypot(radius - clamp, z) == pytest.approx(scene.bristle.length, rel=1e-12)
    assert log.timing.real_time == pytest.approx(scene.run.chunk * 1e3)
    assert len(log.timing.t) == round(DURATION / scene.run.chunk) - 1
    assert (log.timing.value > 0.0).all()


def test_a_part_of_the_run(run):
    folder, _ = run
    whole, part = (plot_series.read(folder / 'run.mcap', *span) for span in ((), (0.1, 0.15)))
    kept = (whole.t >= 0.1) & (whole.t <= 0.15)
    assert 0 < len(part.t) == np.count_nonzero(kept)
    assert (part.tip == whole.tip[kept]).all()
    assert part.timing.t.max() <= 0.15
    assert not len(part.commands)


def test_a_log_that_was_cut_off(run, tmp_path):
    folder, _ = run
    whole = (folder / 'run.mcap').read_bytes()
    cut = tmp_path / 'cut.mcap'
    cut.write_bytes(whole[:len(whole) * 2 // 3])
    part = plot_series.read(cut)
    assert 10 < len(part.t) < round(DURATION / 1e-3)
    assert len(part.t) == len(part.tip) == len(part.normal_force) == len(part.torque)
    assert plot.plot(cut) == tmp_path / 'cut.png'


@pytest.mark.parametrize(('output', 'begins'), [
    ('page.png', b'\x89PNG'), ('page.pdf', b'%PDF'), ('page.svg', b'<?xml')])
@pytest.mark.parametrize('name', ['run.mcap', 'run.npz'])
def test_pages(run, tmp_path, name, output, begins):
    folder, _ = run
    page = plot.plot(folder / name, tmp_path / output)
    content = page.read_bytes()
    assert content.startswith(begins)
    assert len(content) > 20_000  # more than empty axes


def test_every_axis_has_a_label_with_a_unit(run, tmp_path, monkeypatch):
    from matplotlib.figure import Figure
    figures = []
    save = Figure.savefig
    monkeypatch.setattr(Figure, 'savefig', lambda self, *arguments, **options: (
        figures.append(self), save(self, *arguments, **options)))
    plot.plot(run[0] / 'run.mcap', tmp_path / 'page.png')
    [figure] = figures
    titles = [axes.get_title(loc='left') for axes in figure.axes]
    for word in ('Tip', 'side', 'Normal force', 'Torque', 'spectral', 'Wall time'):
        assert sum(word in title for title in titles) == 1, word
    for axes in figure.axes:
        shown = [axes.get_xlabel()] if axes.get_xlabel() else []
        if axes.get_ylabel() and axes.get_ylabel() != 'density':  # its units are in the legend
            shown.append(axes.get_ylabel())
        assert shown
        for label in shown:
            assert re.search(r' \[.+\]$', label), label


def test_without_contact_and_too_short_for_a_spectrum(root, tmp_path):
    simulate(root / 'config/free_rotation.yaml', 0.01, output=tmp_path / 'free.npz')
    assert plot.plot(tmp_path / 'free.npz').stat().st_size > 20_000


def test_the_spectrum_is_that_of_a_sine():
    """A sine of amplitude a has the variance a^2 / 2, all of it at its frequency."""
    t = np.arange(1, 16001) * 1e-3
    frequency, density = plot_page.amplitude_density(t, 3.0 + 0.5 * np.sin(2 * np.pi * 26.0 * t))
    assert frequency[density.argmax()] == pytest.approx(26.0, abs=1.5 * frequency[1])
    assert np.sum(density ** 2) * frequency[1] == pytest.approx(0.5 ** 2 / 2, rel=0.02)
    assert frequency[-1] == pytest.approx(500.0)


def test_the_spectrum_takes_the_longest_part_without_a_gap():
    t = np.concatenate((np.arange(100), np.arange(200, 1200))) * 1e-3
    values = np.where(t < 0.15, 1e6 * t, np.sin(2 * np.pi * 100.0 * t))
    frequency, density = plot_page.amplitude_density(t, values)
    assert frequency[density.argmax()] == pytest.approx(100.0, abs=2 * frequency[1])
    assert density.max() < 1.0


def test_thinning_keeps_every_peak():
    t = np.arange(100_000) * 1e-3
    values = np.zeros(100_000)
    values[[17, 54321]] = 5.0, -7.0
    thin_t, thin = plot_page._envelope(t, values)
    assert len(thin) <= plot_page.POINTS + 2
    assert (thin.max(), thin.min()) == (5.0, -7.0)
    assert thin_t[thin.argmax()] == pytest.approx(0.017, abs=0.05)


def test_a_long_path_is_its_end_and_no_polygon():
    t = np.arange(20_000) * 1e-3
    tip = np.column_stack((np.cos(t), np.sin(t), np.zeros_like(t)))
    above, side = Figure().subplots(2, 1)
    plot_page._paths(above, side, plot_series.Series(
        t, tip, np.ones_like(t), np.zeros_like(t), None, np.empty(0), (), ''))
    chords = np.array(above.collections[0].get_segments())
    np.testing.assert_allclose(chords[:, 1], 1e3 * tip[-len(chords):, :2])
    assert np.hypot(*(chords[:, 1] - chords[:, 0]).T).max() < 1.001     # [mm] as sampled
    assert above.get_title().endswith('axes, last 6 s')


def test_where_the_page_goes(tmp_path):
    (tmp_path / 'run1').mkdir()
    assert plot.default_output(tmp_path / 'run1') == tmp_path / 'run1.png'
    assert plot.default_output(tmp_path / 'run1/run1_0.mcap') == tmp_path / 'run1/run1_0.png'


@pytest.mark.parametrize(('arguments', 'message'), [
    (['none.mcap'], 'none.mcap: no such file or directory; name a log'),
    (['none.npz'], 'none.npz: cannot be read (No such file or directory)'),
    (['run.mcap', '--output', 'page.gif'],
     '--output = "page.gif": must end in one of .png, .pdf, .svg'),
    (['run.mcap', '--output', 'no/page.png'],
     '--output = "no/page.png": there is no directory \'no\': make it first'),
    (['run.mcap', '--output', 'folder.png'], '--output = "folder.png": is a directory: name '
     'another place'),
    (['run.mcap', '--from', '0.2', '--to', '0.1'], '--from = 0.2: must come before --to 0.1'),
    (['run.mcap', '--from', '7'],
     'run.mcap: fewer than two samples from 7 s to inf s: it has 300 from 0.001 s to 0.3 s'),
    (['run.mcap', '--from', 'x'],
     "bristle_ros plot: argument --from: 'x': must be seconds, 0 or more (--help tells the "
     'arguments)'),
    (['text.npz'], 'text.npz: is no .npz file that can be read'),
    (['other.npz'], 'other.npz: holds no array t: name a file that `simulate --output` wrote'),
    (['odd.npz'], 'odd.npz: its arrays do not fit together'),
    (['text.mcap'], 'text.mcap: not an MCAP file; name a .mcap file or a bag directory'),
    (['empty.mcap'], 'empty.mcap: fewer than two samples from 0 s to inf s: it has 0'),
], ids=lambda value: ' '.join(value) if isinstance(value, list) else '')
def test_unusable_input_is_one_line_and_exit_2(run, root, arguments, message):
    folder, scene = run
    (folder / 'folder.png').mkdir(exist_ok=True)
    for name in ('text.npz', 'text.mcap'):
        (folder / name).write_text('neither arrays nor a log')
    np.savez(folder / 'other.npz', x=np.zeros(3))
    arrays = dict(np.load(folder / 'run.npz'))
    np.savez(folder / 'odd.npz', **{**arrays, 'theta': arrays['theta'][1:]})
    if not (folder / 'empty.mcap').exists():
        logs.Log(folder / 'empty.mcap', scene).close()
    done = subprocess.run([sys.executable, '-m', 'bristle_ros', 'plot', *arguments], cwd=folder,
                          capture_output=True, text=True, timeout=600)
    assert done.returncode == 2, done.stderr
    assert done.stdout == ''
    assert done.stderr.count('\n') == 1
    assert message in done.stderr


def test_mangled_files_raise_nothing_else(run, tmp_path):
    rng = np.random.default_rng(5)
    for name in ('run.npz', 'run.mcap'):
        content = bytearray((run[0] / name).read_bytes())
        for i in range(20):
            mangled = content.copy()
            for at in rng.integers(0, len(mangled), 30):
                mangled[at] ^= int(rng.integers(1, 256))
            path = tmp_path / f'{i}{name[-5:]}'
            path.write_bytes(mangled)
            try:
                series = plot_series.read(path)
                assert len(series.t) == len(series.tip) == len(series.normal_force)
            except SceneError as error:
                assert '\n' not in str(error)


def test_a_table_is_drawn_as_the_arrays_are(root, tmp_path):
    scene = load(root / 'test/small_brush.yaml')
    found = {}
    for suffix in ('.npz', '.csv'):
        path = tmp_path / f'run{suffix}'
        simulate(scene, 0.05, output=path)
        found[suffix] = plot_series.read(path)
    for name in ('t', 'tip', 'normal_force', 'torque'):
        np.testing.assert_array_equal(getattr(found['.csv'], name), getattr(found['.npz'], name))
    np.testing.assert_array_equal(found['.csv'].timing.value, found['.npz'].timing.value)
    assert plot.plot(tmp_path / 'run.csv').stat().st_size > 10_000
    short = tmp_path / 'short.csv'
    short.write_text('t,theta\n0.1,0.2\n')
    with pytest.raises(SceneError, match='has no column newton_iterations'):
        plot_series.read(short)


def test_another_page_is_replaced_only_when_asked(root, tmp_path):
    run = tmp_path / 'run.npz'
    simulate(load(root / 'test/small_brush.yaml'), 0.02, output=run)
    page = tmp_path / 'page.pdf'
    page.write_bytes(b'before')
    with pytest.raises(SceneError, match='exists already'):
        plot.plot(run, page)
    assert page.read_bytes() == b'before'
    assert plot.plot(run, page, overwrite=True).read_bytes()[:5] == b'%PDF-'
    assert plot.plot(run) == plot.plot(run)     # its own page is drawn anew
