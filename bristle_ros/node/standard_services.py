"""
The services that simulators have in common (package simulation_interfaces), for a brush.

Imported only where that package is installed; written against 2.1.0, nothing in it is younger than
1.0.0.
"""
import bristle_ros
from bristle_ros.messages import encode as messages
from geometry_msgs.msg import Accel, Vector3
import numpy as np
from simulation_interfaces.msg import Result, SimulationState, SimulatorFeatures
from simulation_interfaces.srv import (GetEntityState, GetSimulationState, GetSimulatorFeatures,
                                       ResetSimulation, SetSimulationState, StepSimulation)

_FEATURES = ('ENTITY_STATE_GETTING', 'SIMULATION_RESET', 'SIMULATION_RESET_STATE',
             'SIMULATION_STATE_GETTING', 'SIMULATION_STATE_SETTING', 'SIMULATION_STATE_PAUSE',
             'STEP_SIMULATION_SINGLE', 'STEP_SIMULATION_MULTIPLE')
_NAMES = {SimulationState.STATE_STOPPED: 'stopped', SimulationState.STATE_PLAYING: 'playing',
          SimulationState.STATE_PAUSED: 'paused'}
_INACTIVE = 'the node is not active'


def serve(node, control):
    """Return the services of a node, made of what its Control does."""
    standard = _Standard(node, control)
    return [node.create_service(type_, f'~/{name}', answer) for type_, name, answer in (
        (StepSimulation, 'step_simulation', standard.step),
        (ResetSimulation, 'reset_simulation', standard.reset),
        (SetSimulationState, 'set_simulation_state', standard.set_state),
        (GetSimulationState, 'get_simulation_state', standard.get_state),
        (GetSimulatorFeatures, 'get_simulator_features', standard.get_features),
        (GetEntityState, 'get_entity_state', standard.get_entity))]


def _result(code=Result.RESULT_OK, text=''):
    return Result(result=code, error_message=text)


class _Standard:
    """Answers; the executor's thread calls."""

    def __init__(self, node, control):
        self._control, self._run = control, node.scene.run
        prefix = node.scene.run.frame_prefix
        self._road = prefix + messages.ROAD_FRAME
        self._mount, self._brush = prefix + messages.MOUNT_FRAME, prefix + messages.BRUSH_FRAME
        self._stopped_at = None     # total step at which it was stopped, not only paused

    def _state(self):
        driver = self._control.driver
        if not driver.paused and self._control.pacing():
            return SimulationState.STATE_PLAYING
        stopped = driver.paused and self._stopped_at == driver.total_step
        return SimulationState.STATE_STOPPED if stopped else SimulationState.STATE_PAUSED

    def step(self, request, response):
        """Run chunks one by one: what ~/step does, several times."""
        response.result = _result()
        for done in range(request.steps):
            reason = self._control.step()
            if reason:
                response.result = _result(
                    Result.RESULT_OPERATION_FAILED, f'{reason}; {done} of {request.steps} done')
                break
        return response

    def reset(self, request, response):
        """Go back to the scene's start; time goes on, and nothing is ever spawned."""
        if request.scope not in (ResetSimulation.Request.SCOPE_DEFAULT,
                                 ResetSimulation.Request.SCOPE_STATE):
            response.result = _result(
                Result.RESULT_FEATURE_UNSUPPORTED,
                'simulation time goes on, and nothing is spawned: ask for SCOPE_STATE, or for '
                'SCOPE_DEFAULT, which is the same here')
            return response
        self._control.reset()
        response.result = _result(text=f'with the next chunk, from {self._control.time()} on')
        return response

    def set_state(self, request, response):
        """Hold, go on, or stop: hold and reset."""
        wanted, kind = request.state.state, SetSimulationState.Response
        if wanted not in _NAMES:
            response.result = _result(
                Result.RESULT_FEATURE_UNSUPPORTED,
                f'state {wanted}: a brush is stopped, playing or paused; a signal ends its '
                'process')
        elif wanted == self._state():
            response.result = _result(
                kind.ALREADY_IN_TARGET_STATE, f'{_NAMES[wanted]} already')
        elif wanted == SimulationState.STATE_PLAYING and not self._control.pacing():
            response.result = _result(kind.STATE_TRANSITION_ERROR, _INACTIVE)
        else:
            self._control.pause(wanted != SimulationState.STATE_PLAYING)
            self._stopped_at = None
            if wanted == SimulationState.STATE_STOPPED:
                self._control.reset()
                self._stopped_at = self._control.driver.total_step
            response.result = _result()
        return response

    def get_state(self, request, response):
        """Tell the state; a node that is not active is paused."""
        response.state.state = self._state()
        response.result = _result(text='' if self._control.pacing() else _INACTIVE)
        return response

    def get_features(self, request, response):
        """Tell what there is."""
        response.features.features = [getattr(SimulatorFeatures, name) for name in _FEATURES]
        response.features.custom_info = (
            f'bristle_ros {bristle_ros.__version__}: a step is a chunk of {self._run.chunk:g} s '
            f'(run.chunk); entities are {self._mount} and {self._brush}, of which accelerations '
            'are not told (NaN); a reset of the state leaves simulation time as it is')
        return response

    def get_entity(self, request, response):
        """Tell where the mount or the brush is at the end of the last chunk, road axes."""
        if request.entity not in (self._mount, self._brush):
            response.result = _result(
                Result.RESULT_NOT_FOUND,
                f'{request.entity!r}: there are {self._mount} and {self._brush}')
            return response
        pacing = self._control.pacing()
        found = pacing.between_chunks(self._look) if pacing else self._look()
        if found is None:
            response.result = _result(Result.RESULT_OPERATION_FAILED, 'no chunk has run yet')
            return response
        self._fill(response.state, *found, turning=request.entity == self._brush)
        response.result = _result()
        return response

    def _look(self):
        last = self._control.look()
        return last and (*last, self._control.driver.simulation.mount_state())

    def _fill(self, state, chunk, stamp, moving, *, turning):
        mount, snapshot = chunk.mount, chunk.last
        state.header.frame_id = self._road
        state.header.stamp.sec, state.header.stamp.nanosec = divmod(stamp, 1_000_000_000)
        pose, twist = state.pose, state.twist
        pose.position.x, pose.position.y, pose.position.z = mount.position.tolist()
        orientation, rate = np.array(mount.orientation), moving.rotation @ moving.rate
        if turning:
            half = 0.5 * snapshot.theta
            orientation = _about_z(orientation, np.cos(half), np.sin(half))
            rate = rate + snapshot.omega * mount.rotation[:, 2]
        (pose.orientation.x, pose.orientation.y, pose.orientation.z,
         pose.orientation.w) = orientation.tolist()
        twist.linear.x, twist.linear.y, twist.linear.z = moving.velocity.tolist()
        twist.angular.x, twist.angular.y, twist.angular.z = rate.tolist()
        unknown = Vector3(x=np.nan, y=np.nan, z=np.nan)
        state.acceleration = Accel(linear=unknown, angular=unknown)


def _about_z(orientation, cosine, sine):
    """Return a quaternion x, y, z, w times a turn about its own z, of half that angle."""
    x, y, z, w = orientation
    return np.array((x * cosine + y * sine, y * cosine - x * sine, w * sine + z * cosine,
                     w * cosine - z * sine))
