"""The controls of the page, the same for all who have it open."""
import html
import math
import threading

from bristle_ros.scene import depth_refusal, SceneError
from bristle_ros.simulation import CommandRefused

from . import colours
from .frame import rotation_of

LIFT = 20.0     # [mm] above the road to which the slider lifts the brush
DEEP = 80.0     # [mm] penetration at which it ends, where the wires are long enough
TORQUES = 50.0  # [N m] up to which a torque is set, where the scene has no limit
FORCE, STRESS = 'force on a wire', 'stress at its clamp'
PLAY, PAUSE, RESUME, STEP, RESET = 'Play', 'Pause', 'Go on', 'One chunk', 'Reset'
_STATES = {'compiling': '#8a6d00', 'running': '#1b7f3b', 'paused': '#666666', 'ended': '#b02020',
           'reading': '#8a6d00', 'playing': '#1b7f3b', 'waiting': '#8a6d00', 'gone': '#b02020'}


SPEED, DRIVE, DEPTH, FORWARD, LEFT, TURNING = (
    'brush speed [rad/s]', 'drive torque [N m]', 'penetration [mm]', 'forward [m/s]',
    'to the left [m/s]', 'turning [rad/s]')
# Slider: (command, which of its values, what is shown per SI unit, step)
_SLIDERS = {
    SPEED: ('cmd_brush_speed', 0, 1.0, 0.1), DRIVE: ('cmd_drive_torque', 0, 1.0, 0.1),
    DEPTH: ('cmd_penetration', 0, 1e3, 0.5),
    FORWARD: ('cmd_vel', 0, 1.0, 0.05), LEFT: ('cmd_vel', 1, 1.0, 0.05),
    TURNING: ('cmd_vel', 2, 1.0, 0.05)}


def ranges_of(scene):
    """
    Return (low, high, value at the start) of each slider of a scene, as they are shown.

    Where the speed is a result there is a torque to be set, and where the mount is carried nothing
    else.
    """
    drive, sweeper, road = scene.drive, scene.sweeper, scene.road
    speed = min(drive.max_speed, max(30.0, 2.0 * abs(drive.mean_speed)))
    most = drive.stall_torque or TORQUES
    found = ({DRIVE: (-most, most, 0.0)} if drive.mode == 'torque' else
             {SPEED: (-speed, speed, drive.mean_speed)})
    if scene.run.carried:
        return found
    if scene.contact.enabled:
        deepest, depth = DEEP, road.penetration * 1e3
        while depth_refusal(scene, deepest * 1e-3):
            deepest -= 1.0
        found[DEPTH] = min(-LIFT, depth), max(deepest, depth), depth
    fastest = min(sweeper.max_speed, max(3.0, *(abs(part) for part in sweeper.velocity)))
    side = 0.05 * int(fastest / math.sqrt(2.0) / 0.05)  # both at once stay within the limit
    for label, value in zip((FORWARD, LEFT), sweeper.velocity):
        found[label] = min(-side, value), max(side, value), value
    found[TURNING] = -sweeper.max_yaw_rate, sweeper.max_yaw_rate, 0.0
    return found


class Panel:
    """
    The controls; `act` is called with the name of what a source can do and the arguments.

    act('command', topic, values) may raise CommandRefused, act('change', text) SceneError: the
    panel shows what they say, and sliders go back to where they were. Controls stay through
    changes of the scene: browsers that come later would miss ones that had been there before.
    """

    def __init__(self, server, act, *, scenes=(), plays=False):
        """Lay the controls out. scenes: names to choose from; plays: for a log."""
        self._gui, self._act = server.gui, act
        self._status = self._gui.add_html('')
        self._said = self._gui.add_html('', visible=False)
        self._values = {}       # of each slider: the value that holds
        self._sliders, self._fields, self._folders = {}, {}, []
        self._menu = self._time = self._factor = None
        self._busy = threading.Lock()   # callbacks come in threads of their own
        self._chosen = ''
        if scenes:
            self._menu = menu = self._gui.add_dropdown('scene', tuple(scenes))
            menu.on_update(lambda event: event.client and self._try('choose', menu.value))
        self._colour = self._gui.add_dropdown('colour of wires', (FORCE, STRESS))
        if plays:
            self._put_player()
            return
        self._put_run()
        self._put_sliders()
        self._put_exact()
        if scenes:
            self._put_keys()

    @property
    def by_stress(self):
        """Whether wires are to be coloured by the stress at their clamps."""
        return self._colour.value == STRESS

    def take(self, scene, chosen):
        """Set the controls to a scene at its start; None: there is none yet to be commanded."""
        for folder in self._folders:
            folder.visible = scene is not None
        if self._menu is not None:
            self._menu.value = self._chosen = chosen
        if scene is None or self._time is not None:
            return
        ranges = ranges_of(scene)
        self._factor.value = scene.run.real_time_factor
        self._values = {label: value for label, (_, _, value) in ranges.items()}
        for label, slider in self._sliders.items():
            slider.visible = self._fields[label].visible = label in ranges
            if label in ranges:
                slider.min, slider.max, value = ranges[label]
                slider.value, self._fields[label].value = value, f'{value:.6g}'

    def take_back(self):
        """Show the scene again that is there: the one that was chosen cannot be used."""
        if self._menu is not None:
            self._menu.value = self._chosen

    def _put_run(self):
        with self._folder('Run'):
            buttons = self._gui.add_button_group('', (PAUSE, RESUME, STEP, RESET))
            self._factor = self._gui.add_number(
                'real-time factor', 1.0, min=0.0, step=0.1,
                hint='simulated seconds per second; 0: as fast as it goes')
        orders = {PAUSE: ('pause', True), RESUME: ('pause', False), STEP: ('step',),
                  RESET: ('reset',)}
        buttons.on_click(lambda _: self._try(*orders[buttons.value]))
        self._factor.on_update(
            lambda event: event.client and self._try('set_factor', self._factor.value))

    def _put_player(self):
        with self._folder('Log'):
            self._time = self._gui.add_slider('t [s]', 0.0, 1.0, 1e-3, 0.0)
            buttons = self._gui.add_button_group('', (PLAY, PAUSE))
            rate = self._gui.add_number('speed', 1.0, min=0.01, max=100.0, step=0.1)
        self._time.on_update(lambda event: event.client and self._try('seek', self._time.value))
        buttons.on_click(lambda _: self._try('pause', buttons.value == PAUSE))
        rate.on_update(lambda _: self._try('set_factor', rate.value))

    def _put_sliders(self):
        with self._folder('Commands'):
            for label, (_, _, _, step) in _SLIDERS.items():
                slider = self._gui.add_slider(label, -1.0, 1.0, step, 0.0)
                self._sliders[label] = slider
                slider.on_update(
                    lambda event, label=label: event.client and self._slide(label))

    def _put_exact(self):
        """Values to type, without the sliders' ends: what a scene refuses it says itself."""
        with self._folder('Exact values', open_=False):
            form = self._gui.add_form(None)
            with form:
                self._fields = {label: self._gui.add_text(label, '') for label in _SLIDERS}
                send = self._gui.add_button('Send')

        def submit(_):
            with self._busy:
                if self._send({label: self._fields[label].value for label in self._values}):
                    for label, value in self._values.items():
                        slider = self._sliders[label]
                        slider.value = min(max(value, slider.min), slider.max)

        send.on_click(lambda _: form.submit())
        form.on_submit(submit)

    def _put_keys(self):
        with self._folder('Change a key of the scene', open_=False):
            form = self._gui.add_form(None)
            with form:
                text = self._gui.add_text('key:=value', '', hint='drive.alternating_speed:=0.5')
                build = self._gui.add_button('Start anew with it')
        build.on_click(lambda _: form.submit())
        form.on_submit(lambda _: self._try('change', text.value))

    def _folder(self, label, open_=True):
        folder = self._gui.add_folder(label, expand_by_default=open_)
        self._folders.append(folder)
        return folder

    def _slide(self, label):
        with self._busy:    # else of two callbacks the older one may come last
            slider, before = self._sliders[label], self._values[label]
            value = slider.value
            if value == before:
                return
            if self._send({label: value}):
                self._fields[label].value = f'{value:.6g}'
            else:
                slider.value = before

    def _send(self, given):
        """Send the commands that these sliders (label: number, or text) are; return success."""
        changed = {_SLIDERS[label][0] for label, value in given.items()
                   if value not in (self._values[label], f'{self._values[label]:.6g}')}
        wanted = dict(self._values)
        try:
            wanted.update({label: _number(label, value) for label, value in given.items()})
            for topic in changed:
                parts = [(part, wanted[label] / scale) for label, (of, part, scale, _)
                         in _SLIDERS.items() if of == topic]
                self._act('command', topic, [value for _, value in sorted(parts)])
        except (CommandRefused, SceneError) as refused:
            self.say(str(refused))
            return False
        self._values = wanted
        self.say('')
        return True

    def _try(self, *order):
        try:
            self._act(*order)
        except (CommandRefused, SceneError) as refused:
            self.say(str(refused))
        else:
            self.say('')

    def say(self, text):
        """Show one line in red, or none."""
        self._said.visible = bool(text)
        self._said.content = (
            '<div role="alert" style="color: #b02020; font-size: 13px; margin: 4px 8px">'
            f'{html.escape(text)}</div>')

    def show(self, status, frame, largest, duration):
        """
        Show a Status, and of a Frame, or None, where the mount is.

        largest [N] or [Pa] : where the scale of colours ends; duration [s] : of a log, else None
        """
        scale = f'{largest * 1e-6:.3g} MPa' if self.by_stress else f'{largest:.2g} N'
        self._status.content = _status_html(
            status, frame, self._colour.value, scale if largest else '')
        if self._time is not None and duration:
            self._time.max = duration
            self._time.value = min(status.t, duration)


def _number(label, text):
    try:
        return float(text)
    except ValueError:
        raise SceneError('must be a number', key=label, value=text) from None


def _mount_html(frame):
    """Return height, lean and heading of the mount over the road."""
    rotation = rotation_of(frame.orientation)
    lean = math.degrees(math.atan2(math.hypot(*rotation[:2, 2]), rotation[2, 2]))
    heading = math.degrees(math.atan2(rotation[1, 0], rotation[0, 0]))
    return (f'<span data-value="height">{frame.mount[2] * 1e3:.1f}</span> mm high, leaning '
            f'{lean:.2f}&deg;, heading {heading:.1f}&deg;')


def _status_html(status, frame, coloured, largest):
    """Return the state of a run in a few lines."""
    asked = 'as fast as it goes' if status.asked == 0.0 else f'asked {status.asked:.3g}'
    rows = [('time', f'{status.t:.2f} s'),
            ('brush', f'<span data-value="speed">{status.speed:.2f}</span> rad/s, '
                      f'{status.speed * 30.0 / math.pi:.1f} rpm'),
            ('mount', _mount_html(frame) if frame is not None else ''),
            ('real-time factor', f'{status.reached:.2f}, {asked}'),
            ('late chunks', f'{status.late}' if status.late is not None else ''),
            ('local error', f'{status.error:.1e} lengths' if status.error is not None else '')]
    cells = ''.join(f'<span style="color: #666">{name}</span><span>{value}</span>'
                    for name, value in rows if value)
    notes = ''.join(f'<div style="color: #a05a00; margin-top: 4px">{html.escape(text)}</div>'
                    for text in (status.text, *status.warnings) if text)
    state = (f'<b data-value="state" style="color: {_STATES.get(status.state, "#333")}">'
             f'{status.state}</b>')
    if status.state in ('waiting', 'reading'):
        cells = ''
    scale = '' if not largest else (
        f'<div style="height: 8px; border-radius: 4px; margin-top: 8px; '
        f'background: {colours.ramp()}"></div>'
        '<div style="display: flex; justify-content: space-between; color: #666; '
        f'font-size: 12px"><span>0</span><span>{coloured}</span>'
        f'<span>{largest}</span></div>')
    return ('<div style="font-size: 13px; margin: 4px 8px; font-variant-numeric: tabular-nums">'
            f'{state}{notes}<div style="display: grid; grid-template-columns: auto 1fr; '
            f'column-gap: 14px; margin-top: 2px">{cells}</div>{scale}</div>')
