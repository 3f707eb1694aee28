#!/usr/bin/env python3
"""
Measure what looking at a brush costs: ./run.sh tools/measure_view.py [SCENE.yaml ...] [--pages N].

Shows each scene as `view` does, to nobody, to pages that only receive, and to one that draws: for
each, how many frames a second the scene's process made and how many updates a second reached a
page, how many pictures a second it drew, the real-time factor reached and how many chunks were
late. The page that draws is Debian's chromium without a graphics card, on the same cores as the
brush. Wants what ./test.sh installs.
"""
import argparse
from pathlib import Path
import sys
import tempfile
import threading
import time

ROOT = Path(__file__).resolve().parent.parent
sys.path[:0] = [str(ROOT), str(ROOT / 'test')]

from bristle_ros.scene import load  # noqa: E402
from bristle_ros.view.page import Page  # noqa: E402
from bristle_ros.view.source import SceneSource  # noqa: E402
from browser import Browser  # noqa: E402
import msgspec  # noqa: E402
import viser  # noqa: E402
from websockets.sync.client import connect  # noqa: E402

SIZE = 1280, 900
SETTLED = 3.0   # [s] of wall time between a change of who looks and the measurement
# what makes a connection a page to viser: where its camera is
CAMERA = {'type': 'ViewerCameraMessage', 'wxyz': (1.0, 0.0, 0.0, 0.0), 'position': (1.0, 1.0, 1.0),
          'fov': 0.8, 'near': 0.1, 'far': 100.0, 'image_height': 900, 'image_width': 1280,
          'look_at': (0.0, 0.0, 0.0), 'up_direction': (0.0, 0.0, 1.0)}
COUNT_PICTURES = ('window.pictures = 0; (function count() { window.pictures++;'
                  'requestAnimationFrame(count); })()')


class Counting(Page):
    """A page that counts the frames it was given."""

    frames = 0

    def show(self):
        """Bring what is new to the browsers."""
        before = self._frame
        super().show()
        self.frames += self._frame is not before

    @property
    def status(self):
        """What the source last said of the run."""
        return self._status


class Receiver:
    """What a browser receives, without drawing it."""

    def __init__(self, port):
        """Connect as viser's page does."""
        self.updates = 0
        self._socket = connect(f'ws://127.0.0.1:{port}', max_size=None, compression=None,
                               subprotocols=[f'viser-v{viser.__version__}'])
        self._socket.send(msgspec.msgpack.encode(CAMERA))
        threading.Thread(target=self._count, daemon=True).start()

    def _count(self):
        for _ in self._socket:
            self.updates += 1

    def close(self):
        """Leave."""
        self._socket.close()


def measure(page, seconds, receivers, browser):
    """Return frames, updates, pictures a second, the real-time factor, and late chunks."""
    time.sleep(SETTLED)
    began, status, frames = time.monotonic(), page.status, page.frames
    updates = sum(one.updates for one in receivers)
    if browser:
        browser.driver.execute_script(COUNT_PICTURES)
    time.sleep(seconds)
    pictures = browser.driver.execute_script('return window.pictures') if browser else None
    took, now = time.monotonic() - began, page.status
    return ((page.frames - frames) / took,
            (sum(one.updates for one in receivers) - updates) / took / len(receivers)
            if receivers else None, None if pictures is None else pictures / took,
            (now.t - status.t) / took, (now.late or 0) - (status.late or 0))


def open_browser(profile, port):
    """Return a window that shows the brush."""
    browser = Browser(profile, *SIZE)
    browser.open(f'http://127.0.0.1:{port}')
    browser.until(lambda: browser.value('state') == 'running', 'the brush running')
    return browser


def look(page, options):
    """Print a row for each kind of company."""
    while page.status is None or page.status.state != 'running':
        time.sleep(0.1)
    for pages, draws in ((0, False), (1, False), (options.pages, False), (0, True)):
        receivers = [Receiver(page.port) for _ in range(pages)]
        with tempfile.TemporaryDirectory() as profile:
            browser = open_browser(profile, page.port) if draws else None
            row = measure(page, options.seconds, receivers, browser)
            for one in receivers:
                one.close()
            if browser:
                browser.close()
        print(f'{pages:9d} {"one" if draws else "none":>5s}' + ''.join(
            f'{"-" if value is None else format(value, form):>12s}'
            for value, form in zip(row, ('.1f', '.1f', '.1f', '.2f', 'd'))), flush=True)


def main():
    """Measure every scene that is named."""
    parser = argparse.ArgumentParser(description=__doc__,
                                     formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument('scenes', nargs='*', type=Path,
                        default=[ROOT / 'config/full_brush.yaml', ROOT / 'config/gutter.yaml'])
    parser.add_argument('--pages', type=int, default=3)
    parser.add_argument('--seconds', type=float, default=20.0)
    options = parser.parse_args()
    for path in options.scenes:
        scene = load(path)
        print(f'{path.stem}, asked for {scene.run.real_time_factor:g} times real time\n'
              'receiving draws frames [1/s] updates [1/s] pictures [1/s] real time  late',
              flush=True)
        page = Counting('127.0.0.1', 0, lambda chosen, scene=scene: (SceneSource(scene), ''))
        page.start(('first',))
        looking = threading.Thread(target=look, args=(page, options))
        looking.start()
        page.run(lambda looking=looking: not looking.is_alive())
        page.close()


if __name__ == '__main__':
    main()
