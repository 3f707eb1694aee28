"""
The node and ROS time: its own pace, or /clock as a follower (use_sim_time), never a mixture.

What follows a clock is in pace.py; here the clock is heard, told apart, and told about. Pacing,
the command timeout and diagnostics live on the steady clock in either case.
"""
from bristle_ros.scene import SceneError
from rclpy.clock import JumpThreshold
from rclpy.duration import Duration

SIM_TIME = 'use_sim_time'
_TIMES_OF_DAY = 10**18   # [ns] a stamp before 2001 is simulation time, not the time of day
_TICK = Duration(nanoseconds=1)
_QUIET = 5.0             # [s] between lines about the same thing


def follows(node, run):
    """
    Return whether the node is to follow /clock.

    run : the scene's section. Raises SceneError when its keys contradict use_sim_time.
    """
    if not node.get_parameter(SIM_TIME).value:
        return False
    if run.carried:
        raise SceneError('a node follows /clock or cmd_mount, not both: set this or use_sim_time '
                         'to false', key='run.carried', value=True)
    if run.publish_clock:
        raise SceneError('a node cannot follow the /clock that it publishes: set this or '
                         'use_sim_time to false', key='run.publish_clock', value=True)
    if run.real_time_factor not in (0.0, 1.0):
        raise SceneError('with use_sim_time, /clock sets the pace: leave it at 1.0',
                         key='run.real_time_factor', value=run.real_time_factor)
    if run.time_origin != 'zero':
        raise SceneError('with use_sim_time, stamps are of /clock: leave it at zero',
                         key='run.time_origin', value=run.time_origin)
    return True


class Follower:
    """Tells a driver the time of /clock; `wake()` is called when a chunk is due by it."""

    def __init__(self, node, driver, wake):
        self._driver, self._wake = driver, wake
        self._logger, self._clock = node.get_logger(), node.get_clock()
        self._shed = 0
        self.went_back = 0      # [ns] at the last jump, until it is asked for by `news`
        if self._clock.now().nanoseconds:   # 0: not heard yet
            driver.follow(self._clock.now().nanoseconds)
        self._handle = self._clock.create_jump_callback(
            JumpThreshold(min_forward=_TICK, min_backward=Duration(nanoseconds=-1),
                          on_clock_change=False), post_callback=self._tick)

    def _tick(self, jump):
        back = self._driver.follow(self._clock.now().nanoseconds)
        if back:
            self.went_back = back
            driver = self._driver
            self._logger.warning(
                f'/clock went back by {back * 1e-9:.6g} s: simulation time goes on from '
                f'{driver.total_step * driver.its:.6f} s, stamps follow /clock',
                throttle_duration_sec=_QUIET)
        if self._driver.due():
            self._wake()

    def news(self):
        """Return what to warn of since this was last asked, or ''; log it where it matters."""
        back, self.went_back = self.went_back, 0
        shed, self._shed = self._driver.shed - self._shed, self._driver.shed
        if self._driver.pace.time is None:
            return 'waiting for /clock'
        if shed:
            text = (f'/clock ran ahead: {shed * 1e-9:.3f} s of it are not simulated, stamps '
                    'follow /clock')
            self._logger.warning(text, throttle_duration_sec=_QUIET)
            return text
        return f'/clock went back by {back * 1e-9:.6g} s' if back else ''

    def values(self):
        """Return what diagnostics say of the clock."""
        pace = self._driver.pace
        return {'behind /clock [s]': f'{self._driver.behind() * 1e-9:.4f}',
                'jumps back of /clock': pace.jumps_back}

    def destroy(self):
        """Hear no more."""
        self._handle.unregister()


def age(node, stamp, own):
    """
    Return how old [ns] a header stamp is, or None where that cannot be told.

    own : the node's simulation time as a stamp [ns], when others take their time from it
    (run.publish_clock), else None. Without either clock, stamps are the time of day.
    """
    time = stamp.sec * 1_000_000_000 + stamp.nanosec
    if not time:
        return None
    if own is not None:
        return own - time
    now = node.get_clock().now().nanoseconds
    comparable = node.get_parameter(SIM_TIME).value or time > _TIMES_OF_DAY
    return now - time if now and comparable else None
