"""The verb `view`: a page with the brush in 3-D, its forces, and controls."""
from pathlib import Path
import signal

from bristle_ros.command_line import Parser, scene_files
from bristle_ros.scene import load, SceneError

LOCAL = ('127.0.0.1', 'localhost', '::1')
DEFAULT = 'full_brush'


def main(arguments):
    """Run the verb until Ctrl-C; return its exit code."""
    options = _options(arguments)
    if options.video is not None:
        if not _is_log(options.what):
            raise SceneError('is no log, and of nothing else a video is made: simulate it into '
                             'one first', key='--video', value=options.what)
        from .video import film
        film(options.what, options.video)
        return 0
    try:
        import viser  # noqa: F401
    except ModuleNotFoundError:
        raise SceneError('needs viser, which is not installed: ./run.sh view installs it in a '
                         "checkout, pip install 'bristle_ros[view]' elsewhere") from None
    chooser = Chooser(options)
    chooser.check()
    from .page import Page
    page = Page(options.host, options.port, chooser.open, scenes=chooser.names,
                plays=chooser.plays)
    try:
        page.start(('first',))
        host = f'[{options.host}]' if ':' in options.host else options.host
        print(f'view: http://{host}:{page.port} (Ctrl-C ends it)', flush=True)
        if options.host not in LOCAL:
            print(f'view: whoever can reach port {page.port} of this machine at {options.host} '
                  'can watch and command it: there is no password', flush=True)
        page.run(lambda: False)
    except KeyboardInterrupt:
        pass
    finally:
        signal.signal(signal.SIGINT, signal.SIG_IGN)    # a second Ctrl-C, as launch sends it
        page.close()
    return 0


def _options(arguments):
    parser = Parser('view', 'Show a scene, a log or a running node on a page, with controls.')
    parser.add_argument('what', metavar='SCENE.yaml | LOG', nargs='?',
                        help=f'a scene file, or a log; default: the scene {DEFAULT}')
    parser.add_argument('-p', '--param', metavar='KEY:=VALUE', action='append', default=[],
                        dest='overrides', help='override a key of the scene; may be given often')
    parser.add_argument('--node', metavar='NAME', help='show and command a running node, such as '
                        '/brush_node')
    parser.add_argument('--video', metavar='FILE.mp4 | FOLDER', help='of a log: make a video '
                        'instead of a page (wants ffmpeg), or a folder of PNGs')
    parser.add_argument('--port', type=int, default=8080, help='default: 8080')
    parser.add_argument('--host', default='127.0.0.1',
                        help='address to listen on; default: 127.0.0.1, this machine alone')
    options = parser.parse_args(arguments)
    if not 0 <= options.port <= 65535:
        raise SceneError('must be 0 to 65535', key='--port', value=options.port)
    if options.node is not None and (options.what or options.overrides):
        raise SceneError('a node has its own scene: leave SCENE.yaml, LOG and -p out',
                         key='--node', value=options.node)
    if options.video is not None and (options.overrides or not options.what):
        raise SceneError('shows a log as it is: name one, and leave all else out', key='--video',
                         value=options.video)
    return options


class Chooser:
    """What can be shown, and what is: opens the source of it."""

    def __init__(self, options):
        self._node = options.node
        self._scenes = {path.stem: path for path in scene_files()}
        self._overrides = dict(_pair(rule) for rule in options.overrides)
        self._log = self._name = None
        given = options.what
        if given is None:
            self._name = DEFAULT
            if DEFAULT not in self._scenes and self._node is None:
                raise SceneError('no scenes are installed here: name a scene file, or a log')
        elif _is_log(given):
            self._log = given
            if self._overrides:
                raise SceneError('a log has its own scene: leave it out', key='-p',
                                 value=options.overrides[0])
        else:
            known = self._scenes.get(Path(given).stem)
            same = known is None or known == Path(given).resolve()
            self._name = Path(given).stem if same else given
            self._scenes[self._name] = Path(given)

    @property
    def names(self):
        """Return the names of scenes that can be chosen."""
        return () if self._node is not None or self._log is not None else tuple(self._scenes)

    @property
    def plays(self):
        """Whether a log is shown."""
        return self._log is not None

    def check(self):
        """Raise SceneError where the first choice cannot be used, before a page is there."""
        if self._node is None and self._log is None:
            load(self._scenes[self._name], self._overrides)

    def open(self, chosen):  # noqa: A003
        """Return (source, name of the scene); raise SceneError, and nothing has changed."""
        if self._node is not None:
            from .from_node import NodeSource
            return NodeSource(self._node), ''
        if self._log is not None:
            from .logged import LogSource
            return LogSource(self._log), ''
        from .source import SceneSource
        name, overrides = self._name, self._overrides
        if chosen[0] == 'choose':
            name, overrides = chosen[1], {}
        elif chosen[0] == 'change':
            key, value = _pair(chosen[1])
            overrides = {**overrides, key: value}
        source = SceneSource(load(self._scenes[name], overrides))
        self._name, self._overrides = name, overrides
        return source, name


def _pair(rule):
    key, assigned, value = rule.partition(':=')
    if not assigned or not key.strip() or not value.strip():
        raise SceneError(f'{rule!r} is not an override: write key:=value', source='-p')
    return key.strip(), value.strip()


def _is_log(given):
    return given.endswith(('.mcap', '.mcap.zstd')) or Path(given).expanduser().is_dir()
