"""The page: a server for browsers, and the loop that brings what a source has to them."""
import contextlib
import io
import socket
import threading
import time

from bristle_ros.scene import SceneError
import viser

from . import colours
from .curves import Curves
from .panel import Panel
from .stage import Stage

PERIOD = 1.0 / 60.0     # [s] between looks at the source, which makes 30 frames a second
SLOW = 0.25             # [s] between changes of text and curves


class Page:
    """
    What browsers show; the same for all of them.

    open_source(chosen) -> (source, the chosen scene's name); scenes: names to choose from; plays:
    whether the source is a log
    """

    def __init__(self, host, port, open_source, *, scenes=(), plays=False):
        """Listen; raises SceneError where the port is in use."""
        check_port(host, port)
        self._open = open_source
        with contextlib.redirect_stdout(io.StringIO()):     # viser's own greeting
            self.server = viser.ViserServer(host=host, port=port, label='bristle_ros',
                                            verbose=False)
        self.port = self.server.get_port()
        gui = self.server.gui
        gui.configure_theme(show_logo=False, show_share_button=False, brand_color=colours.BRAND)
        gui.main_panel.dock_right()
        panel = gui.add_panel()
        with panel.add_tab('Curves'):
            self._curves = Curves(gui)
        panel.dock_left()
        panel.set_width(300)
        self._panel = Panel(self.server, self._act, scenes=scenes, plays=plays)
        self._source = self._scene = self._stage = None
        self._lock = threading.Lock()   # held while the source is another one
        self._slow_due = 0.0
        self._status = self._frame = None

    def start(self, chosen):
        """Show what is chosen; raises SceneError."""
        source, name = self._open(chosen)
        with self._lock:
            self._close_source()
            self._source = source
            self._lay_out(name)

    def _lay_out(self, name=''):
        """Put there what depends on the scene, in the place of what was there."""
        if self._stage is not None:
            self._stage.remove()
        self._scene = self._source.scene
        self._stage = Stage(self.server, self._scene) if self._scene is not None else None
        self._curves.window.clear()
        self._frame = None
        self._panel.take(self._scene, name)

    def _close_source(self):
        if self._source is not None:
            self._source.close()
        self._source = None

    def _act(self, order, *values):
        """Do what a control asks for; callbacks of any browser call this."""
        if order in ('choose', 'change'):
            try:
                self.start((order, *values))
            except SceneError:
                self._panel.take_back()
                raise
        elif order == 'reset' and self._status and self._status.state == 'ended':
            self.start(('again',))
        elif self._source is not None:
            getattr(self._source, order)(*values)

    def show(self):
        """Bring what is new to the browsers."""
        with self._lock:
            if self._source is None:
                return
            update = self._source.update()
            self._status = update.status
            if self._source.scene is not self._scene:   # a node has told it, or has another one
                self._lay_out()
            self._frame = update.frame or self._frame
            if self._stage is not None:
                self._keep(update)
            slow = time.monotonic() >= self._slow_due
            if not slow and not self.server.get_clients():
                return      # nobody looks: four frames a second are there for who comes
            with self.server.atomic():
                if update.frame is not None:
                    self._stage.colour_by(self._panel.by_stress)
                    self._stage.show(update.frame)
                if slow:
                    self._slow_due = time.monotonic() + SLOW
                    self._panel.show(update.status, self._frame,
                                     self._stage.largest if self._stage else 0.0,
                                     self._source.duration)
                    self._curves.draw()

    def _keep(self, update):
        """Take what curves and trails are made of."""
        if update.afresh:
            self._curves.window.clear()
            self._stage.forget_trail()
        self._curves.window.add(update.rows)
        self._stage.add_trail(update.trail)

    def run(self, stopped):
        """Show until stopped() is true."""
        while not stopped():
            began = time.monotonic()
            self.show()
            time.sleep(max(0.0, began + PERIOD - time.monotonic()))

    def close(self):
        """End the source and the server."""
        with self._lock:
            self._close_source()
        with contextlib.redirect_stdout(io.StringIO()):
            self.server.stop()


def check_port(host, port):
    """Raise SceneError where nobody can listen at this address."""
    family = socket.AF_INET6 if ':' in host else socket.AF_INET
    try:
        with socket.socket(family) as probe:
            probe.setsockopt(socket.SOL_SOCKET, socket.SO_REUSEADDR, 1)
            probe.bind((host, port))
    except (OSError, UnicodeError, OverflowError) as error:
        reason = getattr(error, 'strerror', None) or error
        raise SceneError(f'cannot listen on {host} ({reason}): give another --port or --host',
                         key='--port', value=port) from None
