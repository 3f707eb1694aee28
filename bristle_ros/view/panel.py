"""The controls of the page, the same for all who have it open."""
import html
import math

from bristle_ros.scene import depth_refusal, SceneError
from bristle_ros.simulation import CommandRefused

from . import colours

LIFT = 20.0     # [mm] above the road to which the slider lifts the brush
DEEP = 80.0     # [mm] penetration at which it ends, where the wires are long enough
PAUSE, RESUME, STEP, RESET = 'Pause', 'Go on', 'One chunk', 'Reset'
_STATES = {'compiling': '#8a6d00', 'running': '#1b7f3b', 'paused': '#666666', 'ended': '#b02020',
           'reading': '#8a6d00', 'playing': '#1b7f3b', 'waiting': '#8a6d00', 'gone': '#b02020'}


class Slider:
    """One commanded quantity: how it is called and shown, and which command it is a part of."""

    def __init__(self, label, topic, part, scale, low, high, step):
        """`scale` : what is shown per SI unit; `part` : which value of the command it is."""
        self.label, self.topic, self.part, self.scale = label, topic, part, scale
        self.low, self.high, self.step = low, high, step


def sliders_of(scene):
    """Return the Sliders of a scene and their values at its start, as they are shown."""
    drive, sweeper, road = scene.drive, scene.sweeper, scene.road
    speed = min(drive.max_speed, max(30.0, 2.0 * abs(drive.mean_speed)))
    found = [(Slider('brush speed [rad/s]', 'cmd_brush_speed', 0, 1.0, -speed, speed, 0.1),
              drive.mean_speed)]
    if scene.contact.enabled:
        deepest = DEEP
        while depth_refusal(scene, deepest * 1e-3):
            deepest -= 1.0
        low = min(-LIFT, road.penetration * 1e3)
        found.append((Slider('penetration [mm]', 'cmd_penetration', 0, 1e3, low,
                             max(deepest, road.penetration * 1e3), 0.5), road.penetration))
    fastest = min(sweeper.max_speed, max(3.0, *(abs(part) for part in sweeper.velocity)))
    side = 0.05 * int(fastest / math.sqrt(2.0) / 0.05)  # both at once stay within the limit
    yaw = sweeper.max_yaw_rate
    found += [(Slider('forward [m/s]', 'cmd_vel', 0, 1.0, -side, side, 0.05), sweeper.velocity[0]),
              (Slider('to the left [m/s]', 'cmd_vel', 1, 1.0, -side, side, 0.05),
               sweeper.velocity[1]),
              (Slider('turning [rad/s]', 'cmd_vel', 2, 1.0, -yaw, yaw, 0.05), 0.0)]
    return [(slider, value * slider.scale) for slider, value in found]


class Panel:
    """
    The controls of one source; `act` is called with a method's name of it and the arguments.

    act('command', topic, values) may raise CommandRefused, act('change', text) SceneError: the
    panel shows what they say, and sliders go back to where they were.
    """

    def __init__(self, server, source, act, scenes=(), chosen=''):
        """Lay the controls out. scenes: names to choose from; chosen: the one that is shown."""
        self._gui, self._act, self._source = server.gui, act, source
        self._status = self._gui.add_html('')
        self._said = self._gui.add_html('', visible=False)
        self._handles = [self._status, self._said]
        self._values = {}       # of each slider: (slider, handle, value that holds)
        self._time = None
        if scenes:
            menu = self._gui.add_dropdown('scene', tuple(scenes), initial_value=chosen)
            menu.on_update(lambda _: self._try('choose', menu.value))
            self._handles.append(menu)
        if source.duration is not None:
            self._put_player(source)
        if source.controls:
            self._put_run(source)
            self._put_sliders(source.scene)
            self._put_exact()
            if scenes:
                self._put_keys()

    def _put_run(self, source):
        with self._folder('Run'):
            buttons = self._gui.add_button_group('', (PAUSE, RESUME, STEP, RESET))
            factor = self._gui.add_number(
                'real-time factor', source.scene.run.real_time_factor, min=0.0, step=0.1,
                hint='simulated seconds per second; 0: as fast as it goes')
        orders = {PAUSE: ('pause', True), RESUME: ('pause', False), STEP: ('step',),
                  RESET: ('reset',)}
        buttons.on_click(lambda _: self._try(*orders[buttons.value]))
        factor.on_update(lambda _: self._try('set_factor', factor.value))

    def _put_player(self, source):
        with self._folder('Log'):
            self._time = self._gui.add_slider(
                't [s]', 0.0, max(source.duration, 1e-3), 1e-3, 0.0)
            buttons = self._gui.add_button_group('', ('Play', PAUSE))
            rate = self._gui.add_number('speed', 1.0, min=0.01, max=100.0, step=0.1)
        self._time.on_update(lambda event: event.client and self._try('seek', self._time.value))
        buttons.on_click(lambda _: self._try('pause', buttons.value == PAUSE))
        rate.on_update(lambda _: self._try('set_factor', rate.value))

    def _put_sliders(self, scene):
        with self._folder('Commands'):
            for slider, value in sliders_of(scene):
                low, high = min(slider.low, value), max(slider.high, value)
                handle = self._gui.add_slider(slider.label, low, high, slider.step, value)
                self._values[slider.label] = [slider, handle, value]
                handle.on_update(
                    lambda event, label=slider.label: event.client and self._slide(label))

    def _put_exact(self):
        """Numbers to type, without the sliders' ends: what a scene refuses it says itself."""
        fields = {}
        with self._folder('Exact values', open_=False):
            form = self._gui.add_form(None)
            with form:
                for label, (_, _, value) in self._values.items():
                    fields[label] = self._gui.add_text(label, f'{value:.6g}')
                send = self._gui.add_button('Send')

        def submit(_):
            texts = {label: field.value for label, field in fields.items()}
            if self._send(texts):
                for _, handle, value in self._values.values():
                    handle.value = min(max(value, handle.min), handle.max)

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
        self._handles.append(folder)
        return folder

    def _slide(self, label):
        _, handle, before = self._values[label]
        if handle.value != before and not self._send({label: handle.value}):
            handle.value = before

    def _send(self, given):
        """Send the commands that these sliders (label: number, or text) are; return success."""
        wanted = {label: value for label, (_, _, value) in self._values.items()}
        changed = {self._values[label][0].topic for label, value in given.items()
                   if str(value) not in (str(wanted[label]), f'{wanted[label]:.6g}')}
        try:
            wanted.update({label: _number(label, value) for label, value in given.items()})
            for topic in changed:
                parts = [(slider.part, wanted[slider.label] / slider.scale)
                         for slider, _, _ in self._values.values() if slider.topic == topic]
                self._act('command', topic, [value for _, value in sorted(parts)])
        except (CommandRefused, SceneError) as refused:
            self.say(str(refused))
            return False
        for label, value in wanted.items():
            self._values[label][2] = value
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

    def show(self, status, largest):
        """Show a Status; largest [N]: force at which the scale of colours ends."""
        self._status.content = _status_html(status, largest)
        if self._time is not None:
            self._time.max = max(self._source.duration, self._time.min + 1e-3)
            self._time.value = min(max(status.t, self._time.min), self._time.max)

    def remove(self):
        """Take the controls away."""
        for handle in self._handles:
            handle.remove()


def _number(label, text):
    try:
        return float(text)
    except ValueError:
        raise SceneError('must be a number', key=label, value=text) from None


def _status_html(status, largest):
    """Return the state of a run in a few lines."""
    asked = 'as fast as it goes' if status.asked == 0.0 else f'asked {status.asked:.3g}'
    rows = [('time', f'{status.t:.2f} s'),
            ('brush', f'<span data-value="speed">{status.speed:.2f}</span> rad/s, '
                      f'{status.speed * 30.0 / math.pi:.1f} rpm'),
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
        f'font-size: 12px"><span>0</span><span>force on a wire</span>'
        f'<span>{largest:.2g} N</span></div>')
    return ('<div style="font-size: 13px; margin: 4px 8px; font-variant-numeric: tabular-nums">'
            f'{state}{notes}<div style="display: grid; grid-template-columns: auto 1fr; '
            f'column-gap: 14px; margin-top: 2px">{cells}</div>{scale}</div>')
