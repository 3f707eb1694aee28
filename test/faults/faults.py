"""
What is done to a node. Each takes (place, rng, long), keeps its files in `place`, returns figures.

A promise that does not hold raises BrokenPromiseError. `rng` chooses every moment.
"""
import contextlib
import json
import os
import resource
import shutil
import signal
import subprocess
import sys
import time

from bristle_ros.log.recording import Recording
from promises import Brush, count_of, killed, peer, Process, promise, ROOT, same, SCENE, whole

CHUNK = 5_000_000   # [ns]
ON = 400        # [steps] that a brush which goes on is waited for: a busy machine may be slow


def kill(place, rng, long):
    """SIGKILL at a random moment, half the logs split; then read, recover, verify."""
    sizes = ('log.max_size:=0.2', 'log.compression:=none') if rng.random() < 0.5 else ()
    delay = rng.uniform(0.0, 4.0 if long else 1.0)
    with Brush(place, *sizes) as brush:
        brush.ready().run(delay)
        brush.send(signal.SIGKILL)
        moment = time.time_ns()
        brush.ended(-signal.SIGKILL)
    return {'after [s]': delay, 'files': len(list(brush.log.glob('*.mcap'))),
            'lost [s]': killed(brush.log, moment)}


def interrupt_twice(place, rng, long):
    """SIGINT, and again while the log is being completed."""
    with Brush(place) as brush:
        brush.ready().run(rng.uniform(0.0, 1.0))
        brush.send(signal.SIGINT)
        time.sleep(rng.uniform(0.0, 0.05))
        brush.send(signal.SIGINT)
        took = brush.ended(0)
    return {'messages': len(whole(brush.log)), 'ended in [s]': took}


def interrupt_start(place, rng, long):
    """SIGINT while it starts, at any moment from when it has its handlers until it steps."""
    with Brush(place) as brush:
        brush.until(lambda: catches(brush.pid, signal.SIGTERM), 'it had handlers')
        delay = rng.uniform(0.0, 3.0)
        end = time.monotonic() + delay
        while brush.alive and time.monotonic() < end:
            time.sleep(0.01)
        brush.send(signal.SIGINT)
        took = brush.ended(0)
    entries = whole(brush.log, simulate=False) if brush.log.exists() else []
    if any(entry.name == 'tip_pose' for entry in entries):
        same(brush.log)
    return {'after [s]': delay, 'ended in [s]': took, 'messages': len(entries)}


def catches(pid, number):
    """Return whether a process has a handler for a signal; Python has none for SIGTERM."""
    with open(f'/proc/{pid}/status', encoding='ascii', errors='replace') as stream:
        (mask,) = [line.split()[1] for line in stream if line.startswith('SigCgt:')]
    return int(mask, 16) >> (number - 1) & 1


def terminate(place, rng, long):
    """SIGTERM."""
    with Brush(place) as brush:
        brush.ready().run(rng.uniform(0.0, 1.0))
        brush.send(signal.SIGTERM)
        took = brush.ended(0)
    return {'messages': len(whole(brush.log)), 'ended in [s]': took}


def suspend(place, rng, long):
    """SIGSTOP for 10 s (in short: 2 s), then SIGCONT: it goes on, and makes up for little."""
    pause = 10.0 if long else 2.0
    with Brush(place) as brush:
        brush.ready().run(rng.uniform(0.2, 0.7))
        brush.send(signal.SIGSTOP)
        time.sleep(pause)
        before = Recording(brush.log)
        stopped = max(entry.step for entry in before.entries())
        brush.send(signal.SIGCONT)
        brush.run(1.0)
        brush.stop()
    entries = whole(brush.log)
    gained = (entries[-1].step - stopped) * 5e-4
    promise(0.2 < gained < pause + 1.0, f'{gained} s simulated in 1 s after {pause} s of standing')
    return {'messages': len(entries), 'simulated after it [s]': gained}


@contextlib.contextmanager
def small_disk(place, size):
    """Yield (directory of `size` bytes, what to give Popen, how it was made)."""
    disk = place / 'disk'
    disk.mkdir()
    mounted = subprocess.run(['mount', '-t', 'tmpfs', '-o', f'size={size}', 'tmpfs', disk],
                             capture_output=True).returncode == 0
    try:
        if mounted:
            yield disk, {}, 'tmpfs'
        else:
            yield disk, {'preexec_fn': lambda: resource.setrlimit(
                resource.RLIMIT_FSIZE, (size, size))}, 'RLIMIT_FSIZE'
    finally:
        if mounted:
            subprocess.run(['umount', '-l', disk], check=True)


def full_disk(place, rng, long):
    """Fill the disk: the log ends there, complete; the brush goes on."""
    size = rng.randrange(120_000, 900_000) // 4096 * 4096
    with small_disk(place, size) as (disk, options, how), Brush(
            place, 'log.compression:=none', log=disk / 'run', **options) as brush:
        brush.until(lambda: 'logging ended, the brush goes on' in brush.text, 'the disk was full')
        brush.run(0.5)
        brush.stop()
        used = sum(file.stat().st_size for file in brush.log.iterdir())
        entries = whole(brush.log)
    return {'disk [B]': size, 'used [B]': used, 'messages': len(entries), 'by': how}


def gone(place, rng, long):
    """Delete the log's directory: told, and the brush goes on."""
    with Brush(place) as brush:
        brush.ready().run(rng.uniform(0.0, 0.5))
        shutil.rmtree(brush.log)
        brush.until(lambda: 'logging ended, the brush goes on' in brush.text, 'it was noticed')
        brush.run(0.3)
        brush.stop()
    return {}


def hanging_subscriber(place, rng, long):
    """Let a reliable subscriber read nothing any more: the brush keeps its pace."""
    with Brush(place) as brush, peer(place, 'listen') as listener:
        brush.ready()
        listener.until(lambda: count_of(listener) > 100, 'messages came')
        listener.send(signal.SIGSTOP)
        brush.run(20.0 if long else 3.0)
        goes_on(brush)
        took = brush.stop()
    return {'messages': len(whole(brush.log)), 'ended in [s]': took}


def goes_on(brush):
    """Wait until it has stepped on."""
    before = last_step(brush.log)
    brush.until(lambda: last_step(brush.log) > before + ON, 'it went on')


def last_step(path):
    """Return the last step that a log has so far."""
    return max(entry.step for entry in Recording(path).entries())


def flood(place, rng, long):
    """Ten thousand commands a second."""
    figures = _commanded(place, 'flood', 30000 if long else 10000)
    promise(figures['taken'] > 3, f'too few commands were taken: {figures}')
    return figures


def nonsense(place, rng, long):
    """NaN, infinities and 1e308 on every topic: refused, and nothing changes."""
    figures = _commanded(place, 'nonsense', 500 if long else 100)
    promise('refused' in (place / 'node.txt').read_text(), 'nothing was said of what was refused')
    # Of all that is sent only 5e-324 means something: 0.
    wrong = [entry.name for entry in Recording(place / 'run').entries()
             if entry.name.startswith('cmd_') and entry.message.data[4:].strip(b'\0\1')]
    promise(not wrong, f'commands that no brush can follow were taken: {wrong}')
    return figures


def _commanded(place, what, number):
    with Brush(place) as brush, peer(place, what) as sender:
        brush.ready()
        sender.until(lambda: count_of(sender) >= number, f'{number} commands were sent')
        start, before = time.monotonic(), last_step(brush.log)
        goes_on(brush)
        factor = (last_step(brush.log) - before) * 5e-4 / (time.monotonic() - start)
        brush.stop()
        sent = count_of(sender)
    entries = whole(brush.log)
    taken = sum(entry.name.startswith('cmd_') for entry in entries)
    return {'sent': sent, 'taken': taken, 'messages': len(entries), 'real-time factor': factor}


def one_path(place, rng, long):
    """Two nodes with one path for their logs: the second ends with one line."""
    with Brush(place) as first:
        first.ready()
        with Brush(place, name='second') as second:
            second.ended(2)
            promise(second.text.count('\n') == 1 and 'exists already' in second.text,
                    f'not one line: {second.text}')
        first.run(0.2)
        first.stop()
    return {'messages': len(whole(first.log))}


SHIM = """
#define _GNU_SOURCE
#include <dlfcn.h>
#include <time.h>
#include <unistd.h>
int clock_gettime(clockid_t id, struct timespec *now) {
  static int (*real)(clockid_t, struct timespec *);
  if (!real) real = (int (*)(clockid_t, struct timespec *))dlsym(RTLD_NEXT, "clock_gettime");
  int result = real(id, now);
  if (id == CLOCK_REALTIME && access(JUMPED, F_OK) == 0) now->tv_sec -= 3600;
  return result;
}
"""


def wall_clock(place, rng, long):
    """Set the time of day back by an hour: the steady clock paces, so nothing happens."""
    if shutil.which('cc') is None:
        return {'by': 'not done: needs a C compiler'}
    (place / 'shim.c').write_text(SHIM)
    jumped = place / 'jumped'
    subprocess.run(['cc', '-shared', '-fPIC', f'-DJUMPED="{jumped}"', '-o', place / 'shim.so',
                    place / 'shim.c', '-ldl'], check=True)
    with Brush(place, env={**os.environ, 'LD_PRELOAD': str(place / 'shim.so')}) as brush:
        brush.ready().run(rng.uniform(0.1, 0.5))
        jumped.touch()
        start, before = time.monotonic(), last_step(brush.log)
        goes_on(brush)
        brush.stop()
        took = time.monotonic() - start
    entries = whole(brush.log)
    walls = [entry.message.publish_time for entry in entries]
    promise(max(walls) - walls[-1] > 3000e9, 'the clock did not jump: nothing was tried')
    factor = (entries[-1].step - before) * 5e-4 / took
    promise(factor < 1.5, f'real-time factor {factor:.2f} while the clock jumped')
    return {'real-time factor': factor, 'by': 'a shim of clock_gettime'}


def followed_clock(place, rng, long):
    """Let a followed /clock jump ahead, back and to zero, stand still, come at 10 kHz."""
    master = [sys.executable, ROOT / 'test/clock_master.py', rng.uniform(500.0, 2000.0)]
    with Process(master, place / 'clock.txt', stdin=subprocess.PIPE) as clock, Brush(
            place, 'use_sim_time:=true') as brush:

        def tell(command):
            """Give the clock a command; return what it saw: time and last stamp [ns], ahead."""
            before = clock.text.count('\n')
            clock.write(f'{command}\n')
            clock.until(lambda: clock.text.count('\n') > before, f'an answer to {command}')
            return json.loads(clock.text.splitlines()[before])

        def follows():
            told = tell('time')
            return told['count'] and 0 <= told['time'] - told['last'] < CHUNK

        tell('run 1')
        brush.ready()
        # Its log may grow before it has heard the clock; a jump before that is none to it.
        brush.until(lambda: tell('time')['count'], 'it stepped by the clock')
        for jump, said in ((rng.uniform(50.0, 200.0), '/clock ran ahead'),
                           (rng.uniform(-200.0, -50.0), '/clock went back by')):
            tell(f'jump {jump}')
            brush.until(lambda said=said: said in brush.text, f'it said: {said}')
            goes_on(brush)
        tell('zero')    # this is not said again within 5 s
        goes_on(brush)
        tell('run 0')
        brush.until(follows, 'it came to where the clock stands')
        before = tell('time')['count']
        brush.run(5.0 if long else 1.0)
        promise(tell('time')['count'] == before, 'it went on while the clock stood')
        ticks, start = tell('rate 10000')['ticks'], time.monotonic()
        tell('run 1')
        brush.run(20.0 if long else 2.0)
        goes_on(brush)
        ticks = (tell('run 0')['ticks'] - ticks) / (time.monotonic() - start)
        brush.until(follows, 'it came to where the clock stands after the flood')
        told = tell('time')
        took = brush.stop()
    promise(told['ahead'] <= 0, f'a stamp was {told["ahead"] * 1e-9:.6f} s ahead of /clock')
    return {'messages': len(whole(brush.log)), 'nearest to /clock [s]': told['ahead'] * 1e-9,
            'ticks per second': ticks, 'ended in [s]': took}


def network(place, rng, long):
    """Cut and join the wire between two hosts: the brush goes on, the subscriber gets on."""
    if subprocess.run(['unshare', '-n', 'true'], capture_output=True).returncode:
        return {'by': 'not done: network namespaces are not permitted'}
    # Shared memory would carry messages past the cut.
    environment = {**os.environ, 'FASTDDS_BUILTIN_TRANSPORTS': 'UDPv4',
                   'ROS_AUTOMATIC_DISCOVERY_RANGE': 'SUBNET'}
    with contextlib.ExitStack() as stack:
        here, there = (stack.enter_context(host(place, name)) for name in ('here', 'there'))
        here('ip', 'link', 'add', 'wire', 'type', 'veth', 'peer', 'name', 'wire', 'netns',
             there.pid)
        for number, one in ((1, here), (2, there)):
            one('ip', 'address', 'add', f'10.77.0.{number}/24', 'dev', 'wire')
            one('ip', 'link', 'set', 'lo', 'up')
            one('ip', 'link', 'set', 'wire', 'up')
        brush = stack.enter_context(Brush(place, prefix=here.inside, env=environment)).ready()
        listener = stack.enter_context(
            peer(place, 'listen', prefix=there.inside, env=environment))
        listener.until(lambda: count_of(listener) > 100, 'messages came')
        here('ip', 'link', 'set', 'wire', 'down')
        time.sleep(1.0)
        cut = count_of(listener)
        brush.run(8.0 if long else 2.0)
        goes_on(brush)
        during = count_of(listener) - cut
        here('ip', 'link', 'set', 'wire', 'up')
        joined, start = count_of(listener), time.monotonic()
        listener.until(lambda: count_of(listener) > joined + 100, 'messages came again')
        took = time.monotonic() - start
        brush.stop()
    promise(during == 0, f'{during} messages came through the cut: nothing was tried')
    return {'messages': len(whole(brush.log)), 'joined after [s]': took,
            'by': 'two network namespaces, UDP'}


@contextlib.contextmanager
def host(place, name):
    """Yield what runs a command in a network namespace of its own, beginning with no link."""
    with Process(['unshare', '-n', 'sleep', '600'], place / f'{name}.txt') as space:
        # Only when it has left ours: no other link than its own may be touched.
        space.until(lambda: network_of(space.pid) != network_of('self'), 'it had a network')
        inside = ['nsenter', '-n', '-t', str(space.pid)]

        def run(*command):
            subprocess.run([*inside, *map(str, command)], check=True)

        run.inside, run.pid = inside, space.pid
        yield run


def network_of(pid):
    """Return which network namespace a process is in."""
    return os.readlink(f'/proc/{pid}/ns/net')


def core(place, rng, long):
    """One core, shared with four loops that want all of it: late, but whole."""
    loops = [subprocess.Popen(['taskset', '-c', '0', sys.executable, '-c', 'while True: pass'])
             for _ in range(4)]
    try:
        with Brush(place, prefix=['taskset', '-c', '0']) as brush:
            brush.ready().run(10.0 if long else 2.0)
            took = brush.stop()
    finally:
        for loop in loops:
            loop.kill()
            loop.wait()
    return {'messages': len(whole(brush.log)), 'ended in [s]': took}


def mangled(place, rng, long):
    """Parameters, scene files and logs with random bytes in them: one line, or taken."""
    from mangle import mangle
    with Brush(place) as brush:
        brush.ready().run(0.3)
        brush.stop()
    return mangle(place, rng, 1500 if long else 80, SCENE.encode(), brush.file.read_bytes())


FAULTS = [kill, interrupt_twice, interrupt_start, terminate, suspend, full_disk, gone,
          hanging_subscriber, flood, nonsense, one_path, wall_clock, followed_clock, network, core,
          mangled]
TIMES = {'kill': 50, 'interrupt_twice': 5, 'interrupt_start': 20, 'terminate': 3,
         'full_disk': 5}    # in the long form
