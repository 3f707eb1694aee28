"""A log as a video, or a folder of pictures, for who cannot open a page: drawn by matplotlib."""
from collections import deque
from contextlib import contextmanager
from pathlib import Path
import sys
import time

from bristle_ros.command_line import WholeFile
from bristle_ros.scene import (bristle_count, brush_rows, is_uneven, reach, SceneError,
                               SurfaceMesher, widest)
import numpy as np

from . import colours
from .frame import rotation_of, straight
from .ground import grid, TILE
from .log_run import frames, read, straight_frame
from .stage import arrows_of, TRAIL

RATE = 25.0         # [Hz] of pictures, about; a whole number of chunks apart
SIZE, DPI = (12.8, 7.2), 100
QUADS = 1500        # faces of a road that is not level
SAID = 5.0          # [s] between lines that say how far it is


def film(log, target):
    """
    Make a video of a log, at real time, or a folder of PNGs where `target` does not end in .mp4.

    Its wires are simulated again; where that cannot be they are drawn straight, and a line says
    so. Raises SceneError where the log or the target cannot be used.
    """
    logged = read(log)
    chunk = logged.scene.run.chunk
    stride = max(1, round(1.0 / (RATE * chunk)))
    count = round(logged.duration / chunk) // stride
    if not count:
        raise SceneError(f'lasts {logged.duration:g} s, shorter than one picture', source=str(log))
    picture, said, number = Picture(logged), time.monotonic(), 0
    with _writer(target, 1.0 / (stride * chunk), picture.figure) as write:
        for number, (frame, trail) in enumerate(_frames(log, logged, stride, chunk), 1):
            picture.show(frame, trail)
            write()
            if sys.stderr.isatty() and time.monotonic() - said > SAID:
                said = time.monotonic()
                print(f'view: {number} of {count} pictures', file=sys.stderr, flush=True)
    print(f'view: {target}: {number} pictures, {1.0 / (stride * chunk):.4g} a second')


def _frames(log, logged, stride, chunk):
    """Yield (Frame, trail or None), of wires that are simulated or straight."""
    try:
        yield from frames(log, logged, stride)
    except SceneError as error:
        print(f'view: wires are drawn straight: {error.problem}', file=sys.stderr)
        for t in np.arange(stride * chunk, logged.duration + 1e-9, stride * chunk):
            row = logged.at(t)
            yield straight_frame(
                logged, row, straight(logged.scene, float(logged.theta[row]))), None


@contextmanager
def _writer(target, rate, figure):
    """Yield what writes the figure, once for each picture."""
    if not target.endswith('.mp4'):
        yield _to_folder(Path(target).expanduser(), figure)
        return
    from matplotlib.animation import FFMpegWriter
    if not FFMpegWriter.isAvailable():
        raise SceneError('needs ffmpeg, which is not installed: name a folder, for PNGs',
                         key='--video', value=target)
    writer = FFMpegWriter(fps=rate, extra_args=['-f', 'mp4', '-pix_fmt', 'yuv420p'])
    with WholeFile(Path(target).expanduser(), key='--video', keep=False) as file, writer.saving(
            figure, file.name, DPI):
        yield writer.grab_frame


def _to_folder(folder, figure):
    """Return what writes one PNG after the other."""
    if folder.exists() and (not folder.is_dir() or any(folder.iterdir())):
        raise SceneError('exists already: name a new or an empty folder, or FILE.mp4',
                         key='--video', value=str(folder))
    folder.mkdir(parents=True, exist_ok=True)
    numbers = iter(range(1, 10**9))
    return lambda: figure.savefig(folder / f'{next(numbers):05d}.png', dpi=DPI)


def _rgb(colour):
    return np.asarray(colour) / 255.0


class Picture:
    """
    One picture: the brush on the road, and the force and torque of the whole log.

    Axes are the road's, the origin is on the road below the mount centre, as on the page.
    """

    def __init__(self, logged):
        """Put there what stays."""
        import matplotlib
        matplotlib.use('Agg')
        from matplotlib import pyplot
        from mpl_toolkits.mplot3d.art3d import Line3DCollection, Poly3DCollection
        self._scene, self._rows = logged.scene, logged.rows
        self.figure = pyplot.figure(figsize=SIZE)
        self._put_stage(Line3DCollection, Poly3DCollection)
        self._cursors = [self._put_curve(place, column, title, colour) for place, column, title,
                         colour in ((2, 2, 'normal force of the road [N]', colours.ARROW),
                                    (4, 3, 'torque of the drive [N m]', colours.BRAND))]
        self._words = self.figure.text(0.02, 0.95, '', fontsize=13)
        self._trail, self._largest, self._mesher = deque(maxlen=TRAIL), 0.0, None
        if is_uneven(self._scene.gutter, self._scene.profile):
            self._mesher = SurfaceMesher(self._scene, self._side, 6, QUADS)

    def _put_stage(self, lines, faces):
        scene = self._scene
        around = reach(scene)
        deepest = max(row.tip_depth for row in brush_rows(scene))
        self._side = TILE * max(4, round(2.6 * around / TILE))
        stage = self.figure.add_axes((-0.08, -0.12, 0.8, 1.2), projection='3d',
                                     computed_zorder=False)
        stage.set(xlim=(-around, around), ylim=(-around, around),
                  zlim=(-0.3 * deepest, 1.5 * deepest))
        stage.set_box_aspect((2.0 * around, 2.0 * around, 1.8 * deepest), zoom=1.0)
        stage.view_init(elev=20.0, azim=-55.0)
        stage.set_axis_off()
        nothing = np.zeros((1, 2, 3))

        def put(order, width, colour):
            return stage.add_collection3d(lines(nothing, linewidths=width, colors=[_rgb(colour)],
                                                zorder=order))

        self._ground = stage.add_collection3d(faces(
            [np.zeros((3, 3))], facecolors=[_rgb(colours.RELIEF)], alpha=0.7, zorder=1))
        self._lines = put(2, 0.8, colours.SHAFT)
        self._trails = put(3, 0.8, colours.TRAIL)
        self._wires = put(5, 1.1, colours.STEEL)
        self._arrows = put(6, 1.8, colours.ARROW)
        self._board = stage.add_collection3d(faces(
            [np.zeros((3, 3))], facecolors=[_rgb(colours.BOARD)], zorder=7))

    def _put_curve(self, place, column, title, colour):
        axes = self.figure.add_axes((0.70, 1.04 - 0.225 * place, 0.28, 0.34))
        axes.plot(self._rows[:, 0], self._rows[:, column], color=_rgb(colour), linewidth=0.8)
        axes.set_title(title, fontsize=10, loc='left')
        axes.set_xlabel('t [s]', fontsize=9)
        axes.tick_params(labelsize=8)
        axes.margins(x=0.0)
        return axes.axvline(0.0, color='black', linewidth=0.8)

    def show(self, frame, trail):
        """Draw a Frame, and the tips (tips, 3) on the road that go with it, if they are known."""
        rotation, x, y = rotation_of(frame.orientation), *frame.mount.tolist()[:2]
        above = np.array((0.0, 0.0, frame.mount[2]))
        self._show_ground(x, y, frame.kerb)
        line = above + frame.centreline @ rotation.T
        size = np.linalg.norm(frame.force, axis=1)
        self._largest = colours.scale_end(self._largest, size[size > 0.0])
        self._wires.set_segments(line)
        self._wires.set_colors(_rgb(colours.of_wires(size, self._largest, frame.exact)))
        self._arrows.set_segments(above + arrows_of(self._scene, frame) @ rotation.T)
        around = np.linspace(0.0, 2.0 * np.pi, 48)
        disc = 1.06 * max(widest(self._scene), 0.02) * np.stack(
            (np.cos(around), np.sin(around), np.zeros(48)), axis=1)
        self._board.set_verts([above + disc @ rotation.T])
        self._show_trail(trail, (x, y, 0.0))
        for cursor in self._cursors:
            cursor.set_xdata([frame.t, frame.t])
        speed = float(np.interp(frame.t, self._rows[:, 0], self._rows[:, 1]))
        self._words.set_text(f't = {frame.t:.2f} s   {speed:.2f} rad/s   '
                             f'{bristle_count(self._scene)} bristles'
                             + ('' if frame.exact else ', drawn straight'))

    def _show_ground(self, x, y, kerb):
        if self._mesher is None:
            half = 0.5 * self._side
            corners = half * np.array(((-1, -1, 0), (1, -1, 0), (1, 1, 0), (-1, 1, 0.0)))
            self._ground.set_verts([corners])
            marks = TILE * np.arange(1, round(self._side / TILE))
            self._lines.set_segments(
                [((mark - half - x % TILE, -half, 0.0), (mark - half - x % TILE, half, 0.0))
                 for mark in marks]
                + [((-half, mark - half - y % TILE, 0.0), (half, mark - half - y % TILE, 0.0))
                   for mark in marks])
            return
        mesh, _ = self._mesher.around(x, y - kerb)
        shift = np.array((-x, kerb - y, 0.0))
        self._ground.set_verts((mesh.points() + shift)[mesh.triangles()])
        self._lines.set_segments(grid(mesh) + shift)

    def _show_trail(self, trail, place):
        if trail is None:
            return
        self._trail.append(trail)
        points = np.array(self._trail)
        pairs = np.stack((points[:-1], points[1:]), axis=2).reshape(-1, 2, 3) - place
        self._trails.set_segments(pairs[np.isfinite(pairs).all(axis=(1, 2))])
