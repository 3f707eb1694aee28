"""Simulates the scene of a log again, with its commands, and compares with its outputs."""
import math
from typing import NamedTuple

from bristle_ros.log import (differences, in_order, is_event, load_tolerance, provenance,
                             Recording, scene_of)
from bristle_ros.messages import (decode_scene, encode as messages, robot_description, SCENE,
                                  transforms_topic)
from bristle_ros.simulation import MeanWrench, MountPath

TOLERANCE = 1e-9        # relative, where other instructions may have been used


class Verdict(NamedTuple):
    """What `verify` found."""

    difference: str     # the first one, '' when there is none
    compared: int       # messages
    applied: int        # commands, resets and load decisions
    end: float          # [s] of simulation compared
    elsewhere: list     # how this machine differs from the log's, one text each
    cut: str            # where the log was cut off, ''


def verify(path, simulation_of=None):
    """
    Simulate a log's scene with its commands again and compare with its outputs.

    Every message bit by bit; on another machine (see Verdict.elsewhere) every value to TOLERANCE
    of the largest that its vector has had. `simulation_of`: Scene -> Simulation.
    Raises SceneError when the log holds no usable scene.
    """
    recording = Recording(path).from_start()
    elsewhere = differences(recording.machine, provenance())
    scene = recording.scene
    if simulation_of is None:
        from bristle_ros.simulation import Simulation
        simulation_of = Simulation
    again = _Again(simulation_of(scene), recording, _limits(recording) if elsewhere else None)
    difference = ''
    for entry in in_order(recording) if recording.recorded else recording.entries():
        difference = again.follow(entry)
        if difference:
            break
    else:
        if recording.damage:
            difference = f'the log is damaged: {recording.damage[0]}'
        elif not again.compared:
            difference = 'the log holds no outputs'
    return Verdict(difference, again.compared, again.applied, again.time, elsewhere, recording.cut)


class _Again:
    """The run, done once more along its log."""

    def __init__(self, simulation, recording, limits):
        self.compared = self.applied = 0
        self._simulation = simulation
        self._base = -simulation.step       # run step = base + simulation.step
        self._its, self._origin = recording.integration_time_step, recording.origin
        self._recorded = recording.recorded
        self._limits = limits               # topic -> largest differences allowed; None: no bit
        self._scene = scene = recording.scene
        prefix, path, self._resets = scene.run.frame_prefix, MountPath(scene), 0
        mean = MeanWrench()
        self._topics = {topic.name: topic for topic in (
            *messages.topics(prefix),
            transforms_topic(prefix, lambda: path.follow(simulation, self._resets)),
            messages.mean_wrench_topic(prefix, lambda: mean.follow(simulation, self._resets)))}
        self._snapshot = None

    @property
    def time(self):
        """[s] since the run's start."""
        return self._step * self._its

    @property
    def _step(self):
        return self._base + self._simulation.step

    def follow(self, entry):
        """Do what the entry says or compare with it; returns the difference, or ''."""
        # Imported when the simulation is there anyway: it brings the compiler with it.
        from bristle_ros.simulation import CommandRefused, StepFailure
        try:
            if entry.name in self._topics:
                return self._goto(entry.step) or self._compare(entry)
            if entry.name == SCENE:
                return self._compare_scene(entry)
            if entry.name == messages.DESCRIPTION:
                return self._compare_description(entry)
            if entry.name in messages.command_types(True):
                return self._goto(entry.step) or self._command(entry)
            if entry.name == messages.EVENTS and (
                    event := messages.decode_event(entry.message.data)).get('values'):
                return self._goto(entry.step) or self._apply(event.get('topic'), event['values'])
            if entry.name == messages.EVENTS and is_event(entry, 'reset'):
                return self._goto(entry.step) or self._reset(entry)
            if entry.name == messages.EVENTS and is_event(entry, 'load'):
                return self._goto(entry.step) or self._budget(entry)
            if entry.name == messages.EVENTS and is_event(entry, 'failure'):
                return self._goto(entry.step) or self._fail(entry)
        except StepFailure as error:
            return f'{self._place(entry)}: the simulation cannot go on, the log does: {error}'
        except CommandRefused as error:
            return f'{self._place(entry)}: the logged command is refused: {error}'
        except (TypeError, ValueError) as error:
            return f'{self._place(entry)}: {error}'
        return ''

    def _place(self, entry):
        return f't = {entry.step * self._its:.9g} s (step {entry.step}), {entry.name}'

    def _goto(self, step):
        if step < self._step:
            return f'step {step} comes after step {self._step} in the log'
        if step > self._step:
            self._simulation.advance(step - self._step)
            self._snapshot = None
        return ''

    def _command(self, entry):
        return self._apply(entry.name, messages.decode_command(
            entry.message.channel.schema, entry.message.data))

    def _apply(self, topic, values):
        self._simulation.command(topic, values)
        self._snapshot = None
        self.applied += 1
        return ''

    def _reset(self, entry):
        self._simulation.reset()
        self._base = entry.step - self._simulation.step
        self._resets += 1
        self._snapshot = None
        self.applied += 1
        return ''

    def _budget(self, entry):
        self._simulation.set_error_tolerance(load_tolerance(entry))
        self.applied += 1
        return ''

    def _fail(self, entry):
        from bristle_ros.simulation import StepFailure
        try:
            self._simulation.advance(1)
        except StepFailure:
            return ''
        return f'{self._place(entry)}: the log ends because a step failed, which it does not here'

    def _compare_scene(self, entry):
        self.compared += 1
        source = f'{entry.message.channel.topic}: scene'
        yaml = decode_scene(entry.message.data).get('scene', {}).get('yaml', '')
        same = scene_of(yaml, source) == self._scene
        return '' if same else f'{self._place(entry)}: not the scene that the log begins with'

    def _compare_description(self, entry):
        self.compared += 1
        # It is drawn, not simulated: another version may draw it otherwise.
        expected = messages.encode_string(robot_description(self._scene))
        same = self._limits or entry.message.data == expected
        return '' if same else f'{self._place(entry)}: not what the scene gives'

    def _compare(self, entry):
        topic = self._topics[entry.name]
        if self._snapshot is None:
            self._snapshot = self._simulation.snapshot()
        stamp = (messages.stamp_ns(entry.step, self._its, self._origin) if self._recorded
                 else entry.message.log_time)
        payload = topic.encode(self._snapshot, stamp)
        self.compared += 1
        if payload == entry.message.data:
            return ''
        try:
            logged = topic.decode(entry.message.data)
        except ValueError:
            return f'{self._place(entry)}: the message has {len(entry.message.data)} bytes'
        here = topic.decode(payload)
        limits = self._limits[topic.name] if self._limits else [0.0] * len(logged)
        for field, old, new, limit in zip(topic.fields, logged, here, limits):
            same = old == new or abs(old - new) <= limit or old != old and new != new
            if not same:
                return f'{self._place(entry)}.{field}: log {old!r}, simulated {new!r}'
        # No value differs: on the same machine what is left are stamps, names and signs of zero.
        return '' if self._limits else f'{self._place(entry)}: bytes beside its values'


def _limits(recording):
    """
    Return topic -> the largest difference allowed of each of its values.

    Relative to the largest that its vector has in the log: in the air a force is round-off alone.
    """
    topics = {topic.name: topic for topic in (
        *messages.TOPICS, transforms_topic(), messages.mean_wrench_topic())}
    limits = {name: [0.0] * len(topic.fields) for name, topic in topics.items()}
    for entry in recording.entries():
        topic = topics.get(entry.name)
        try:
            values = topic.decode(entry.message.data) if topic else ()
        except ValueError:
            continue  # said when it is compared
        at = 0
        for length in topic.groups if values else ():
            limit = TOLERANCE * math.hypot(*values[at:at + length])
            if limit < math.inf:
                limits[topic.name][at:at + length] = [
                    max(limit, old) for old in limits[topic.name][at:at + length]]
            at += length
    return limits
