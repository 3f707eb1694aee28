"""The lifecycle node: parameters and commands in, snapshots out. Pacing is `realtime`'s."""
from functools import wraps
import threading

from bristle_ros.log import Log
from bristle_ros.messages import encode as messages
from bristle_ros.realtime import Driver, PacingThread
from bristle_ros.scene import bristle_count, follows_mount, steps
from bristle_ros.simulation import MeanWrench, MountPath, RunWatch, Simulation
from rclpy.clock import Clock, ClockType
from rclpy.lifecycle import LifecycleNode, TransitionCallbackReturn

from . import clocks as node_time, parameters as node_parameters
from .commands import Commands
from .control import Control
from .events import Events
from .run_warnings import RunWarnings
from .topics import Outputs

OK, WARN, ERROR = range(3)  # levels of a DiagnosticStatus
CLOSING = 4.0   # [s] what launch leaves between Ctrl-C and a harder signal is 5


def _told(transition):
    """Say why a transition goes wrong: rclpy swallows what is raised, and nobody would learn."""
    @wraps(transition)
    def tell(self, state):
        try:
            return transition(self, state)
        except Exception as error:
            self.problem = error
            if not self.quiet:
                self.get_logger().error(' '.join(str(error).split()))
            return TransitionCallbackReturn.ERROR  # on_error follows, and unconfigured
    return tell


class BrushNode(LifecycleNode):
    """
    The brush in the loop. Relative names unless they start with `/`.

    Subscribes: cmd_brush_speed, cmd_vel, cmd_penetration, cmd_drive_torque. Publishes:
    contact_wrench, tip_wrench, mount_wrench, tip_pose, joint_states, bristle_markers, /diagnostics
    and, if asked, /clock. Services: ~/pause, ~/step, ~/reset. Configure builds what the parameters
    say by then, compiles and opens the log; activate steps, deactivate holds, cleanup releases;
    what goes wrong in one of them releases too.
    """

    def __init__(self, scene, on_end, *, wall_ns):
        """
        Declare the parameters; nothing is compiled before the node is configured.

        on_end(error) is called from another thread when the run ends by itself; wall_ns() -> int
        [ns] is the time of day, for `run.time_origin: wall`.
        """
        super().__init__('brush_node')
        self._follows = node_time.follows(self, scene.run)
        # rclpy lets a transition that the present state does not have end the executor. Private:
        # tried with 7.1.6, see test/node/test_hooks.py.
        self._change_state = self._service_change_state.callback
        self._service_change_state.callback = self._change_if_possible
        self.scene = scene
        self.problem, self.quiet = None, False  # why configuring failed; whether others say so
        self._on_end, self._wall_ns = on_end, wall_ns
        self._driver = self._log = self._outputs = self._pacing = self._last = None
        self._follower = self._commands = self._events = self._warnings = self._control = None
        self._stopping, self._opening = False, threading.Lock()
        self._log_failed = False
        self._late_before = self._shed_before = self._step_before = 0
        self.normal_force, self.torque = [], []     # filled while `watched`
        self.watched = False
        node_parameters.declare(self, self._set_real_time_factor)
        self.create_timer(1.0, self._diagnose, clock=Clock(clock_type=ClockType.STEADY_TIME))

    # Transitions; the executor's thread runs them.

    @_told
    def on_configure(self, state):
        """Open the log, compile, and enter the graph."""
        scene, self.problem = self.scene, None
        origin = self._wall_ns() if scene.run.time_origin == 'wall' else 0
        with self._opening:
            if self._stopping:
                return TransitionCallbackReturn.FAILURE
            if scene.log.path:
                self._log = Log(scene.log.path, scene, resolve=self._resolve, origin=origin)
        simulation = Simulation(scene)
        sample = steps(scene, scene.run.sample, 'run.sample') if self._log else 0
        self._driver = Driver(simulation, sample=sample, follow=self._follows)
        self._driver.mount, self._driver.watch = MountPath(scene), RunWatch(simulation)
        if follows_mount(scene):
            self._driver.mean = MeanWrench()
        self._warnings = RunWarnings(self._driver, self.get_logger())
        if self._stopping:
            return TransitionCallbackReturn.FAILURE
        if self._follows:
            self._follower = node_time.Follower(self, self._driver, self._wake)
        else:
            self._driver.real_time_factor = self.get_parameter(
                node_parameters.REAL_TIME_FACTOR).value
        with node_parameters.qos_overrides(self):
            self._outputs = Outputs(self, scene, origin)
            self._events = Events(self)
            self._enter_graph()
        self.get_logger().info(
            f'ready: {bristle_count(scene)} bristle(s), step '
            f'{scene.solver.integration_time_step:.6g} s, chunk {scene.run.chunk:.6g} s, compiled '
            f'in {simulation.compile_time:.3g} s')
        return TransitionCallbackReturn.SUCCESS

    @_told
    def on_activate(self, state):
        """Step from here on."""
        result = super().on_activate(state)
        self._pacing = PacingThread(self._driver, self._deliver, self._on_end)
        self._pacing.start()
        if self._driver.paused:
            self.get_logger().info('paused while it was inactive: ~/pause with false goes on')
        return result

    @_told
    def on_deactivate(self, state):
        """Hold at the end of the chunk that is running."""
        self._hold()
        return super().on_deactivate(state)

    @_told
    def on_cleanup(self, state):
        """Complete the log and release everything."""
        self._release()
        return TransitionCallbackReturn.SUCCESS

    @_told
    def on_shutdown(self, state):
        """Complete the log and release everything."""
        self._release()
        return TransitionCallbackReturn.SUCCESS

    def on_error(self, state):
        """Release everything after a transition that went wrong; the node is unconfigured then."""
        self._release()
        return TransitionCallbackReturn.SUCCESS

    def _change_if_possible(self, request, response):
        try:
            return self._change_state(request, response)
        except RuntimeError:  # rclpy's RCLError; rcl has told in the log what is not possible
            response.success = False
            return response

    def finish(self):
        """Hold and complete the log, in whatever state; the process is about to end."""
        opened = self._opening.acquire(timeout=CLOSING / 4)     # a log half made is not seen yet
        self._stopping = True
        if opened:
            self._opening.release()
        self._hold(CLOSING / 4)
        self._close_log()

    def _hold(self, limit=None):
        if self._pacing:
            self._pacing.stop(limit)
            self._pacing = None

    def _close_log(self):
        if self._log:
            if self._warnings:
                self._warnings.close(self._log)
                self._warnings = None
            self._log.close()

    def _release(self):
        self._hold()
        self._close_log()
        for part in (self._control, self._commands, self._follower):
            if part:
                part.destroy()
        if self._outputs:
            self._outputs.destroy(self)
        if self._events:
            self._events.destroy(self)
        self._commands = self._follower = self._outputs = self._events = self._warnings = None
        self._control = self._driver = self._log = self._last = None
        self._log_failed = False
        self._late_before = self._shed_before = self._step_before = 0

    @property
    def unconfigured(self):
        """Whether the scene may still be changed."""
        return self._driver is None

    def _wake(self):
        if self._pacing:
            self._pacing.wake()

    def _resolve(self, name):
        return self.resolve_topic_name(name)

    def _enter_graph(self):
        self._commands = Commands(
            self, self.scene.run, self._driver, active=lambda: self._pacing is not None,
            own_time=lambda: self._outputs.stamp(self._driver.total_step),
            origin=self._outputs.origin, wake=self._wake)
        self._control = Control(self, self._driver, self._outputs, pacing=lambda: self._pacing,
                                look=self._look)

    def _look(self):
        """Return the last chunk and the stamp [ns] of its end, or None."""
        return self._last and (self._last, self._outputs.stamp(self._last.last.step))

    def _time(self):
        return f'{self._driver.total_step * self._driver.its:.6f} s'

    def _set_real_time_factor(self, factor):
        if self._driver:
            self._driver.real_time_factor = factor
        self._wake()

    # What goes out.

    def _deliver(self, chunk):
        """Publish and log a chunk; the pacing thread calls this."""
        driver = self._driver
        self._last, snapshot = chunk, chunk.last
        if self._follows:
            self._keep_origin(chunk)
        self._outputs.publish(snapshot, driver.simulation, driver.now(), chunk.mount,
                              clock=self._control.stepping, wrench=chunk.wrench)
        self._events.tell_all(chunk)
        if self._log and self._log.write(chunk):
            driver.late_chunks += 1  # it waited for the disk
        if self.watched:
            self.normal_force.append(float(snapshot.contact_force[:, 2].sum())
                                     * self.scene.brush.wires_per_bristle)
            self.torque.append(-float(snapshot.brush_torque[2]))

    def _keep_origin(self, chunk):
        origin = self._driver.pace.origin
        if origin != self._outputs.origin:
            self._outputs.origin = origin
            self._events.tell('clock', chunk.start, origin_ns=origin)
            if self._log:  # where simulation time lies on /clock from here on
                self._log.event(chunk.start, 'clock', origin_ns=origin)

    def _diagnose(self):
        driver, log, last = self._driver, self._log, self._last
        if driver is None or self._outputs is None:
            return
        if log and log.failed and not self._log_failed:
            self._log_failed = True
            self.get_logger().error(f'logging ended, the brush goes on: {log.failed}')
        late = driver.late_chunks - self._late_before
        self._late_before = driver.late_chunks
        given_up, self._shed_before = driver.shed - self._shed_before, driver.shed
        chunks = (driver.total_step - self._step_before) / driver.chunk
        self._step_before = driver.total_step
        reached = driver.reached() if self._pacing else 0.0
        still = self._follows and not driver.real_time_factor   # its clock is
        running = self._pacing and not driver.paused and not still
        level, text = OK, 'running' if running else 'holding'
        doubtful, doubts = self._warnings.look() if self._warnings else ([], {})
        if doubtful:
            level, text = WARN, f'{text}, see its values: {", ".join(doubtful)}'
        if given_up or late > max(1.0, 0.01 * chunks):
            level, text = WARN, (f'{late} late chunks in the last second, '
                                 f'{given_up * 1e-9:.3g} s given up')
        news = self._follower.news() if self._follower and self._pacing else ''
        if news:
            level, text = WARN, news
        if log and log.failed:
            level, text = ERROR, f'logging ended: {log.failed}'
        values = {
            'real-time factor asked': f'{driver.real_time_factor:.6g}',
            'real-time factor reached': f'{reached:.4f}',
            'late chunks': driver.late_chunks,
            'wall time given up [s]': f'{driver.shed * 1e-9:.3f}',
            'estimated error': f'{last.last.error_estimate:.3g}' if last else '',
            'Newton failures': getattr(driver.simulation, 'newton_failures', 0),
            'log backlog': log.backlog if log else 0,
            'refused commands': driver.refused,
            'last refusal': self._commands.last_refusal,
            'simulation time [s]': f'{driver.total_step * driver.its:.6f}',
            **(driver.budget.values() if driver.budget else {}),
            **(self._follower.values() if self._follower else {}), **doubts}
        # With its namespace: all brushes of a graph share /diagnostics.
        name = self.get_fully_qualified_name().lstrip('/')
        payload = self._outputs.diagnose(
            driver.total_step, [(level, f'{name}: simulation', text, 'brush', values)])
        if log:
            log.message(driver.total_step, '/diagnostics', messages.DIAGNOSTICS, payload)

    def status(self):
        """Return the status line, over the time since it was last asked for; '' before the run."""
        self.watched = True
        driver = self._driver
        if driver is None or not self._pacing:
            # `quiet` is while the node brings itself up.
            return 'compiling what is not in the cache yet: up to a minute' if self.quiet else ''
        forces, self.normal_force = self.normal_force, []
        torques, self.torque = self.torque, []
        n = max(1, min(len(forces), len(torques)))
        state = 'paused' if driver.paused else f'real-time factor {driver.reached():.3f}'
        return (f'{self._time()}  {state}  normal force {sum(forces) / n:.4g} N  brush torque '
                f'{sum(torques) / n:.4g} N m  late chunks {driver.late_chunks}')
