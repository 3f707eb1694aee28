"""Holding, stepping and resetting a run, as services of the node."""
from importlib.util import find_spec

from std_srvs.srv import SetBool, Trigger

STANDARD = 'simulation_interfaces'  # of other simulators; most installations have it not


class Control:
    """
    Serves ~/pause, ~/step and ~/reset of a driver, and what STANDARD has, where that is installed.

    The executor's thread calls. `stepping` is whether a single chunk runs, of which everything is
    published.
    """

    def __init__(self, node, driver, outputs, *, pacing, look):
        """
        Enter the graph.

        pacing() -> PacingThread, None while the node is not active; look() -> (Chunk, stamp [ns])
        of the last chunk, or None before the first
        """
        self.driver, self.pacing, self.look = driver, pacing, look
        self._outputs, self._node = outputs, node
        self.stepping = False
        self._servers = [node.create_service(type_, name, answer) for type_, name, answer in (
            (SetBool, '~/pause', self._pause), (Trigger, '~/step', self._step),
            (Trigger, '~/reset', self._reset))]
        if find_spec(STANDARD) is not None:
            from .standard_services import serve
            self._servers += serve(node, self)

    def destroy(self):
        """Leave the graph."""
        for server in self._servers:
            self._node.destroy_service(server)

    def pause(self, hold):
        """Hold, or go on; return when no chunk runs that was not asked for."""
        if hold:
            self.driver.pause()
        else:
            self.driver.resume()
        pacing = self.pacing()
        if pacing:
            pacing.wake()
            pacing.settle()
            self._outputs.tell_time(self.driver.total_step)     # what the limited rate held back

    def step(self):
        """Run one chunk; return why that was not possible, or ''."""
        pacing = self.pacing()
        if not pacing:
            return 'the node is not active'
        if not self.driver.paused:
            return 'not paused: call ~/pause first'
        if self.driver.pace.follows and self.driver.pace.time is None:
            return 'no /clock heard yet'
        if self.driver.waits:
            return 'the next chunk waits for its cmd_mount'     # which this thread would hear
        self.stepping = True
        done = pacing.step_once()
        self.stepping = False
        return '' if done else f'the chunk has not run, at {self.time()}'

    def reset(self):
        """Have the scene's start come back with the next chunk."""
        self.driver.reset()

    def time(self):
        """Return the simulation time as a text."""
        return f'{self.driver.total_step * self.driver.its:.6f} s'

    def _pause(self, request, response):
        self.pause(request.data)
        response.success = True
        response.message = f'{"paused" if request.data else "running"} at {self.time()}'
        return response

    def _step(self, request, response):
        reason = self.step()
        response.success = not reason
        response.message = reason or f'at {self.time()}'
        return response

    def _reset(self, request, response):
        self.reset()
        response.success = True
        response.message = f"back to the scene's start with the next chunk, from {self.time()} on"
        return response
