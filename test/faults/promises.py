"""A node that faults are done to, and what must hold after each of them."""
from collections import Counter
import contextlib
import os
from pathlib import Path
import re
import signal
import subprocess
import sys
import time

from bristle_ros.log.recording import Recording
from bristle_ros.verbs.recover import recover
from bristle_ros.verbs.verify import verify
from mcap.reader import make_reader
from mcap_ros2.decoder import DecoderFactory
from rosbags.highlevel import AnyReader

ROOT = Path(__file__).resolve().parents[2]
PEER = Path(__file__).with_name('peer.py')
LIMIT = 300.0   # [s] before a wait is a hang: a busy machine is slow
ENDING = 60.0   # [s] that an end may take: 5 s are promised on a machine that is free
SCENE = (ROOT / 'test/small_brush.yaml').read_text()


class BrokenPromiseError(AssertionError):
    """Something that is promised did not hold."""


def promise(held, what):
    """Raise unless it was held."""
    if not held:
        raise BrokenPromiseError(what)


class Process:
    """A process whose output goes to a file; killed when it is left."""

    def __init__(self, command, output, **options):
        self.output = output
        with open(output, 'w') as stream:
            self._process = subprocess.Popen(
                list(map(str, command)), cwd=ROOT, stdout=stream, stderr=subprocess.STDOUT,
                start_new_session=True, **options)
        self.pid = self._process.pid

    def write(self, text):
        """Give it a line of input."""
        self._process.stdin.write(text.encode())
        self._process.stdin.flush()

    def send(self, number):
        self._process.send_signal(number)

    @property
    def text(self):
        return self.output.read_text(errors='replace')

    @property
    def alive(self):
        return self._process.poll() is None

    def until(self, condition, what):
        """Wait until it is so."""
        end = time.monotonic() + LIMIT
        while not condition():
            promise(self.alive, f'ended with {self._process.poll()} before {what}: {self.text}')
            promise(time.monotonic() < end, f'{what}: not within {LIMIT} s')
            time.sleep(0.02)

    def ended(self, code):
        """Wait for its end; check exit code and output; return the seconds that took."""
        start = time.monotonic()
        try:
            found = self._process.wait(ENDING)
        except subprocess.TimeoutExpired:
            raise BrokenPromiseError(f'hangs: no end within {ENDING} s') from None
        promise(found == code, f'exit code {found} instead of {code}: {self.text}')
        promise('Traceback' not in self.text, f'a traceback: {self.text}')
        return time.monotonic() - start

    def __enter__(self):
        return self

    def __exit__(self, *_):
        if self.alive:
            with contextlib.suppress(ProcessLookupError):
                os.killpg(self.pid, signal.SIGKILL)
        self._process.wait()


class Brush(Process):
    """A brush_node with a log, in a directory of its own."""

    def __init__(self, place, *parameters, log=None, prefix=(), name='node', **options):
        self.log = log or place / 'run'
        scene = place / 'scene.yaml'
        scene.write_text(SCENE)
        given = [word for parameter in (*parameters, f'log.path:={self.log}')
                 for word in ('-p', parameter)]
        super().__init__(
            [*prefix, sys.executable, '-m', 'bristle_ros', 'brush_node', '--ros-args',
             '--params-file', scene, *given], place / f'{name}.txt', **options)

    @property
    def file(self):
        """Return the first file of the log."""
        return self.log if self.log.suffix == '.mcap' else self.log / f'{self.log.name}_0.mcap'

    def ready(self):
        """Wait until it steps and its log grows."""
        self.until(lambda: 'ready' in self.text, 'it was ready')
        before = self.file.stat().st_size
        self.until(lambda: self.file.stat().st_size > before, 'its log grew')
        return self

    def run(self, seconds):
        """Let it run."""
        end = time.monotonic() + seconds
        while time.monotonic() < end:
            promise(self.alive, f'ended by itself: {self.text}')
            time.sleep(0.01)

    def stop(self, code=0):
        """End it as Ctrl-C does."""
        self.send(signal.SIGINT)
        return self.ended(code)


def peer(place, what, prefix=(), **options):
    """Start another ROS node."""
    return Process([*prefix, sys.executable, PEER, what], place / f'{what}.txt', **options)


def count_of(process):
    """Return the last number that a peer has printed."""
    numbers = re.findall(r'^\d+$', process.text, re.MULTILINE)
    return int(numbers[-1]) if numbers else 0


def readers(path):
    """Return reader of others -> messages that it finds."""
    counts = Counter()
    files = sorted(path.glob('*.mcap')) if path.is_dir() else [path]
    for file in files:
        with open(file, 'rb') as stream:
            counts['mcap'] += sum(1 for _ in make_reader(
                stream, validate_crcs=True).iter_messages())
        with open(file, 'rb') as stream:
            counts['mcap-ros2-support'] += sum(1 for _ in make_reader(
                stream, decoder_factories=[DecoderFactory()]).iter_decoded_messages())
    with AnyReader([path]) as reader:
        for connection, _, raw in reader.messages():
            reader.deserialize(raw, connection.msgtype)
            counts['rosbags'] += 1
    return dict(counts)


def whole(path, *, simulate=True):
    """Check a complete log by all readers, and that it can be simulated again; its entries."""
    entries = following(path)
    for name, count in readers(path).items():
        promise(count == len(entries), f'{name} reads {count} messages of {len(entries)}')
    if simulate:
        same(path)
    return entries


def following(path, cut=False):
    """Check that no sample is missing in between; return the entries."""
    recording = Recording(path)
    entries = list(recording.entries())
    promise(not recording.damage, f'damage: {recording.damage}')
    promise(bool(recording.cut) == cut, f'cut off: {recording.cut!r}')
    steps = [entry.step for entry in entries if entry.name == 'tip_pose']
    promise(steps == list(range(2, 2 * len(steps) + 2, 2)), f'samples are missing in {path}')
    return entries


def same(path):
    """Check that simulating it again gives its outputs."""
    verdict = verify(path)
    promise(not verdict.difference, f'replay --verify: {verdict.difference}')


def killed(path, moment):
    """Check and recover the log of a node killed at `moment` [ns]; return the seconds lost."""
    entries = following(path, cut=True)
    lost = (moment - entries[-1].message.publish_time) * 1e-9
    promise(lost <= 1.0, f'kill -9 cost {lost:.3f} s')
    result = recover(path)
    promise(result.messages == len(entries), f'recover saved {result.messages} messages of '
                                             f'{len(entries)}')
    promise(len(whole(result.output)) == len(entries), 'the recovered log is shorter')
    return lost
