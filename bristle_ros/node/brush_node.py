"""The verb `brush_node`: brings the node up, waits for its end, and leaves a complete log."""
import os
import select
import signal
import sys
import threading
import time

from bristle_ros.command_line import is_compiling
from bristle_ros.scene import from_arguments, SceneError

_HELP = """usage: bristle_ros brush_node [--ros-args --params-file SCENE.yaml -p key:=value ...]

The ROS 2 node: steps the brush in real-time-scaled chunks, subscribes, publishes, logs. A scene
file is a ROS 2 parameter file; `python3 -m bristle_ros scene --keys` lists every parameter.
Remappings, namespaces and log levels are given as to any node. Ctrl-C ends it, log complete."""
_STOP = (signal.SIGINT, signal.SIGTERM)
LEAVING = 3.0   # [s] a thread may take to end; launch kills 5 s after Ctrl-C


class _Bell:
    """
    Wakes the main thread for a signal or for another thread.

    A pipe and no lock, so that it can be rung from a signal handler at any moment; and a handler
    throws nothing, so that a second Ctrl-C cannot tear a log that is being completed. As long as
    `begun` is false there is nothing to complete, and a signal ends the process where it is.
    """

    def __init__(self):
        self._read, self._write = os.pipe()
        os.set_blocking(self._read, False)
        os.set_blocking(self._write, False)
        self.rung = self.begun = False
        signal.set_wakeup_fd(self._write, warn_on_full_buffer=False)
        for number in _STOP:
            signal.signal(number, self._take)

    def _take(self, number, frame):
        if not self.begun:
            os._exit(0)  # importing takes seconds, on a busy machine many
        self.rung = True

    def ring(self):
        """Have `wait` return now and from now on."""
        self.rung = True
        try:
            os.write(self._write, b'!')
        except BlockingIOError:
            pass  # full of rings already

    def wait(self, limit):
        """Return whether it has rung, after `limit` [s] at the latest."""
        if not self.rung:
            select.select([self._read], [], [], limit)
        return self.rung


def main(arguments):
    """Run the verb `brush_node` until it is told to end; return its exit code."""
    ours = arguments[:arguments.index('--ros-args')] if '--ros-args' in arguments else arguments
    if '-h' in ours or '--help' in ours:
        print(_HELP)
        return 0
    if ours:
        raise SceneError(f'{ours[0]!r} is no argument of brush_node: write --ros-args '
                         '--params-file SCENE.yaml')
    bell = _Bell()
    notes = []
    scene = from_arguments(arguments, notes=notes)
    import rclpy
    from rclpy.signals import SignalHandlerOptions
    try:
        rclpy.init(args=['brush_node', *arguments], signal_handler_options=SignalHandlerOptions.NO)
    except Exception as error:  # rclpy has no common class for what rcl finds wrong in arguments
        raise SceneError(f'not understood by ROS: {str(error).partition(", at ")[0]}',
                         source='--ros-args') from None
    run = _Run(scene, bell, notes)
    try:
        run.until_rung()
    finally:
        run.finish()
    if run.failure:
        raise run.failure
    return 0


class _Run:
    """One node with its executor's thread. `failure` says why it ended, if not by a signal."""

    def __init__(self, scene, bell, notes):
        from .lifecycle import BrushNode
        from rclpy.clock import Clock, ClockType
        from rclpy.executors import SingleThreadedExecutor
        self.failure = None
        self._bell = bell
        self._terminal = sys.stderr.isatty()
        bell.begun = True
        self._node = BrushNode(scene, self._end, wall_ns=time.time_ns)
        for note in notes:
            self._node.get_logger().warning(note)
        self._executor = SingleThreadedExecutor()
        self._executor.add_node(self._node)
        if scene.run.autostart:
            # In the executor's thread, so that a transition from outside cannot come between.
            self._timer = self._node.create_timer(
                0.0, self._bring_up, clock=Clock(clock_type=ClockType.STEADY_TIME))
        self._thread = threading.Thread(target=self._spin, name='executor', daemon=True)
        self._thread.start()

    def _bring_up(self):
        from rclpy.lifecycle import TransitionCallbackReturn
        self._timer.cancel()
        if self._bell.rung:
            return
        self._node.quiet = True  # what goes wrong now ends the process, with a line of its own
        for transition in (self._node.trigger_configure, self._node.trigger_activate):
            if transition() != TransitionCallbackReturn.SUCCESS:
                # told to end on the way there, it fails to start because of that
                if self._node.problem or not self._bell.rung:
                    self._end(self._node.problem or RuntimeError('the node could not start'))
                return
        self._node.quiet = False

    def _spin(self):
        from rclpy.executors import ExternalShutdownException
        try:
            self._executor.spin()
        except ExternalShutdownException:
            pass
        except Exception as unexpected:
            if not self._bell.rung:  # else the graph was left while something still used it
                self._end(unexpected)

    def _end(self, error):
        self.failure = self.failure or error
        self._bell.ring()

    def until_rung(self):
        """Wait; show a status line each second on a terminal."""
        while not self._bell.wait(1.0):
            if self._terminal:
                text = self._node.status()
                # The cursor goes back, so that a log line takes the status line's place.
                print(f'\x1b[K{text}', end='\r', file=sys.stderr, flush=True)

    def finish(self):
        """Complete the log and leave the graph, within the time that launch leaves."""
        import rclpy
        self._node.finish()
        if is_compiling(self._thread):
            self._node.get_logger().info('stopped while kernels were compiled: nothing was run')
        if self._terminal:
            print('\x1b[K', end='', file=sys.stderr, flush=True)
        rclpy.try_shutdown()
        self._thread.join(0.0 if is_compiling(self._thread) else LEAVING)
        if self._thread.is_alive():
            # It is compiling, which nothing can interrupt; the log is complete, so leave it there.
            sys.stdout.flush()
            sys.stderr.flush()
            os._exit(0)
