"""Pacing, overload, commands and resets, against a clock turned by hand."""
import threading
import time
from types import SimpleNamespace

from bristle_ros.realtime.driver import Driver, Event
from bristle_ros.realtime.pace import BACKLOG_NS, CATCH_UP_NS, WINDOW_NS
from bristle_ros.realtime.pacing_thread import PacingThread
from bristle_ros.simulation import CommandRefused, StepFailure
from bristle_ros.simulation.snapshot import Snapshot
from examples import waits_in
import pytest

MS = 1_000_000


class Clock:
    """Steady time [ns] that stands still until a test turns it."""

    def __init__(self):
        self.now = 7_000_000_000

    def __call__(self):
        return self.now


class Counting:
    """
    Keeps the interface of Simulation and counts steps: 1e9 of them take no time.

    `cost` [ns] is what the clock moves for each step.
    """

    def __init__(self, clock, *, chunk=5e-3, factor=1.0, timeout=0.0, cost=0, fail_at=None):
        self.scene = SimpleNamespace(run=SimpleNamespace(
            chunk=chunk, real_time_factor=factor, command_timeout=timeout, max_load=0.0,
            carried=False))
        self.carried = False
        self.its, self.step = 1e-4, 0
        self.calls, self._clock, self.cost, self.fail_at = [], clock, cost, fail_at

    def advance(self, n):
        if self.fail_at is not None and self.step + n > self.fail_at:
            self.step = self.fail_at
            raise StepFailure(self.step * self.its, self.step, 'made to fail')
        self.step += n
        self._clock.now += n * self.cost

    def snapshot(self):
        return Snapshot(self.step, self.step * self.its, *[0.0] * (len(Snapshot._fields) - 2))

    def begin_sample(self):
        pass

    def check_command(self, topic, values):
        if values == (666.0,):
            raise CommandRefused(f'{topic} = 666.0: not this one')

    def command(self, topic, values):
        self.check_command(topic, values)
        self.calls.append((self.step, topic, values))

    def reset(self):
        self.calls.append((self.step, 'reset', ()))
        self.step = 0


def drive(driver, clock, duration):
    """Do what a pacing thread does, for `duration` [ns] of the clock; return the chunks."""
    chunks, end = [], clock.now + duration
    while True:
        deadline = driver.next_deadline()
        if deadline is None or max(deadline, clock.now) > end:
            clock.now = max(clock.now, end)
            return chunks
        clock.now = max(clock.now, deadline)
        assert driver.due()
        chunks.append(driver.run_chunk())


@pytest.mark.parametrize('factor', [0.2, 1.0, 5.0, 1 / 3])
def test_rate(factor):
    clock = Clock()
    driver = Driver(Counting(clock, factor=factor), clock=clock)
    assert not driver.due()
    chunks = drive(driver, clock, 10_000 * MS)
    assert len(chunks) == pytest.approx(10.0 * factor / 5e-3, abs=1)
    assert driver.total_step == 50 * len(chunks)
    assert driver.reached() == pytest.approx(factor, rel=1e-6)
    assert (driver.late_chunks, driver.shed) == (0, 0)


def test_as_fast_as_it_goes():
    clock = Clock()
    driver = Driver(Counting(clock, factor=0.0, cost=20_000), clock=clock)
    drive(driver, clock, 3_000 * MS)
    assert driver.reached() == pytest.approx(5.0)
    assert (driver.late_chunks, driver.shed) == (0, 0)


def test_no_drift_after_a_billion_steps():
    clock = Clock()
    simulation = Counting(clock, factor=3.0, chunk=5000.0)  # 5e7 steps each
    driver = Driver(simulation, clock=clock)
    start = clock.now
    for _ in range(20):
        clock.now = driver.next_deadline()
        driver.run_chunk()
    assert driver.total_step == 10**9
    assert clock.now - start == round(1e5 / 3.0 * 1e9)
    fine = Driver(Counting(clock, factor=1.0), clock=clock)
    fine.run_chunk(10**9)
    # The next deadline lies exactly one chunk after 1e5 s, to the nanosecond.
    assert fine.next_deadline() - clock.now == 10**14 + 5 * MS


def test_a_short_delay_is_made_up():
    clock = Clock()
    driver = Driver(Counting(clock), clock=clock)
    drive(driver, clock, 100 * MS)
    clock.now += 12 * MS
    drive(driver, clock, 88 * MS)
    assert driver.total_step == 2000
    assert driver.late_chunks == 1  # 12 ms: two chunks due, the first ended after the second was
    assert driver.shed == 0


def test_a_long_delay_slows_simulation_time_and_is_counted():
    clock = Clock()
    driver = Driver(Counting(clock), clock=clock)
    drive(driver, clock, 100 * MS)
    clock.now += 10_000 * MS  # as after SIGSTOP
    behind = drive(driver, clock, 0)
    assert len(behind) <= 11, 'the backlog is bounded'
    assert driver.shed == pytest.approx(9_945 * MS, abs=5 * MS)
    assert driver.late_chunks == 9  # of those caught up, the ones that ended a chunk late
    drive(driver, clock, 900 * MS)
    assert driver.total_step * 100_000 + driver.shed == pytest.approx(11_000 * MS, abs=5 * MS)


def test_overload_goes_as_fast_as_it_can_and_never_jumps():
    clock = Clock()
    driver = Driver(Counting(clock, cost=250_000), clock=clock)  # 2.5 times too slow
    chunks = drive(driver, clock, 10_000 * MS)
    assert driver.reached() == pytest.approx(0.4, rel=0.02)
    assert all(chunk.end - chunk.start == 50 for chunk in chunks)
    assert [chunk.start for chunk in chunks] == [50 * i for i in range(len(chunks))]
    assert driver.late_chunks > 0.95 * len(chunks)
    assert clock.now - driver.next_deadline() <= 70 * MS, 'the backlog does not grow'


def test_a_new_factor_does_not_jump():
    clock = Clock()
    driver = Driver(Counting(clock), clock=clock)
    drive(driver, clock, 1_002 * MS)
    driver.real_time_factor = 0.1
    # 2 ms of the next chunk's 5 had passed at factor 1; from step 10000 on it is 50 ms.
    assert driver.next_deadline() - clock.now == 48 * MS
    drive(driver, clock, 1_000 * MS)
    driver.real_time_factor = 0.0
    assert driver.due()
    driver.run_chunk()
    driver.real_time_factor = 2.0
    assert driver.next_deadline() - clock.now == 2.5 * MS
    assert (driver.late_chunks, driver.shed) == (0, 0)


@pytest.mark.parametrize('factor', [-1.0, float('nan'), float('inf')])
def test_bad_factor(factor):
    driver = Driver(Counting(Clock()))
    with pytest.raises(ValueError, match='real-time factor = .*must be 0'):
        driver.real_time_factor = factor
    assert driver.real_time_factor == 1.0


def test_commands_take_effect_at_the_next_chunk_start():
    clock = Clock()
    driver = Driver(Counting(clock), clock=clock)
    driver.run_chunk()
    driver.command('cmd_brush_speed', [1])
    driver.command('cmd_vel', (1.0, 0.0, 0.0))
    driver.command('cmd_brush_speed', [2])
    chunk = driver.run_chunk()
    assert chunk.events == (Event(50, 'command', 'cmd_vel', (1.0, 0.0, 0.0)),
                            Event(50, 'command', 'cmd_brush_speed', (2.0,)))
    assert [call[0] for call in driver.simulation.calls] == [50, 50]
    assert driver.run_chunk().events == ()


def test_refused_commands_are_counted_and_have_no_effect():
    driver = Driver(Counting(Clock()))
    with pytest.raises(CommandRefused, match='666'):
        driver.command('cmd_penetration', (666.0,))
    assert driver.refused == 1
    assert driver.run_chunk().events == ()


def test_scheduled_events_take_effect_at_exactly_their_step():
    driver = Driver(Counting(Clock()), sample=20, paced=False)
    events = [Event(77, 'command', 'cmd_brush_speed', (2.0,)), Event(0, 'reset'),
              Event(33, 'command', 'cmd_vel', (1.0, 0.0, 0.0))]
    driver.schedule(events)
    first, second = driver.run_chunk(), driver.run_chunk()
    assert first.events == (events[1], events[2])
    assert second.events == (events[0],)
    assert [call[0] for call in driver.simulation.calls] == [0, 33, 77]
    assert [s.step for s in first.samples + second.samples] == [20, 40, 60, 80, 100]
    assert driver.scheduled == 0
    with pytest.raises(ValueError, match='cmd_vel at step 33: the run is already at step 100'):
        driver.schedule(events[2:])


def test_samples_and_the_chunk_end():
    driver = Driver(Counting(Clock()), sample=30)
    chunk = driver.run_chunk()
    assert [snapshot.step for snapshot in chunk.samples] == [30]
    assert chunk.last.step == chunk.end == 50
    assert [snapshot.step for snapshot in driver.run_chunk().samples] == [60, 90]


def test_time_goes_on_through_a_reset():
    clock = Clock()
    driver = Driver(Counting(clock), clock=clock, sample=10)
    drive(driver, clock, 10 * MS)
    driver.command('cmd_brush_speed', (1.0,))
    driver.reset()
    driver.command('cmd_brush_speed', (3.0,))
    (chunk,) = drive(driver, clock, 5 * MS)
    assert chunk.events == (Event(100, 'reset'),
                            Event(100, 'command', 'cmd_brush_speed', (3.0,)))
    assert [snapshot.step for snapshot in chunk.samples] == [110, 120, 130, 140, 150]
    assert chunk.last.t == pytest.approx(0.015)
    assert driver.simulation.step == 50
    assert driver.resets == 1
    assert driver.late_chunks == 0


def test_pause_step_and_resume():
    clock = Clock()
    driver = Driver(Counting(clock), clock=clock)
    drive(driver, clock, 20 * MS)
    assert not driver.step_once(), 'only while paused'
    driver.pause()
    assert driver.next_deadline() is None
    assert not driver.due()
    assert drive(driver, clock, 60_000 * MS) == []
    assert driver.reached() == 0.0
    assert driver.step_once()
    assert len(drive(driver, clock, 1_000 * MS)) == 1
    driver.resume()
    assert driver.next_deadline() - clock.now == 5 * MS
    assert (driver.late_chunks, driver.shed) == (0, 0)


def test_velocity_times_out_once_and_comes_back():
    clock = Clock()
    driver = Driver(Counting(clock, timeout=0.1), clock=clock)
    driver.command('cmd_vel', (1.0, 0.0, 0.0))
    events = [event for chunk in drive(driver, clock, 1_000 * MS) for event in chunk.events]
    assert events == [Event(0, 'command', 'cmd_vel', (1.0, 0.0, 0.0)),
                      Event(1000, 'timeout', 'cmd_vel', (0.0, 0.0, 0.0))]
    driver.command('cmd_vel', (0.5, 0.0, 0.0))
    events = [event for chunk in drive(driver, clock, 1_000 * MS) for event in chunk.events]
    assert [event.kind for event in events] == ['command', 'timeout']
    driver.reset()  # the scene's own velocity is back, and so is its time limit
    events = [event for chunk in drive(driver, clock, 1_000 * MS) for event in chunk.events]
    assert [event.kind for event in events] == ['reset', 'timeout']


def test_an_offline_run_depends_on_no_clock():
    clock = Clock()
    driver = Driver(Counting(clock, timeout=0.1, cost=10**9), clock=clock, paced=False)
    chunks = [driver.run_chunk() for _ in range(100)]
    assert not any(chunk.events for chunk in chunks)
    assert (driver.late_chunks, driver.shed, driver.real_time_factor) == (0, 0, 0.0)
    assert driver.stepping == 5000 * 10**9


def test_failure_keeps_what_was_reached():
    driver = Driver(Counting(Clock(), fail_at=75), sample=10)
    assert driver.run_chunk().failure is None
    chunk = driver.run_chunk()
    assert [snapshot.step for snapshot in chunk.samples] == [60, 70]
    assert (chunk.end, chunk.last.step) == (75, 75)
    assert 'made to fail' in str(chunk.failure)


def test_memory_stays_bounded():
    clock = Clock()
    driver = Driver(Counting(clock, factor=0.0, cost=10), clock=clock)
    for _ in range(20_000):
        driver.command('cmd_brush_speed', (1.0,))
        driver.command('cmd_brush_speed', (2.0,))
        clock.now += WINDOW_NS // 1000
        assert len(driver.run_chunk().events) == 1
    assert len(driver._marks) < 30
    assert len(driver._pending) == 0


def following(clock, **given):
    """Return a driver that follows, 10 s into a clock, and ready to go."""
    driver = Driver(Counting(clock, **given), clock=clock, follow=True)
    assert driver.next_deadline() is None, 'nothing before the clock is heard'
    assert not driver.step_once()
    assert driver.follow(10_000 * MS) == 0
    return driver


def run_due(driver):
    """Run what is due and check that none of it is ahead; return how many chunks."""
    count = 0
    while driver.due():
        driver.run_chunk()
        count += 1
        assert driver.pace.behind(driver.total_step) >= 0
        assert driver.pace.origin + driver.total_step * 100_000 <= driver.pace.time
    assert driver.next_deadline() is None, 'no busy waiting'
    return count


@pytest.mark.parametrize('factor', [0.2, 1, 5])
@pytest.mark.parametrize('period', [1, 10, 100])
def test_lockstep_with_a_followed_clock(factor, period):
    clock = Clock()
    driver = following(clock)
    for tick in range(1, 2_000 // period):
        clock.now += round(period * MS / factor)
        driver.follow((10_000 + tick * period) * MS)
        run_due(driver)
        assert driver.total_step == tick * period // 5 * 50
    assert driver.real_time_factor == pytest.approx(factor, rel=0.01)
    # Chunks come in bursts, a tick's at once, so this one is coarse.
    assert driver.reached() == pytest.approx(factor, rel=0.02 if period == 1 else 0.5)
    assert driver.pace.origin == 10_000 * MS
    assert (driver.late_chunks, driver.shed) == (0, 0)


def test_a_followed_clock_that_stands_still():
    clock = Clock()
    driver = following(clock)
    driver.follow(10_100 * MS)
    assert run_due(driver) == 20
    for _ in range(100):
        clock.now += 100 * MS
        driver.follow(10_100 * MS)
        assert run_due(driver) == 0
    assert (driver.reached(), driver.real_time_factor) == (0.0, 0.0)
    driver.follow(10_110 * MS)
    assert run_due(driver) == 2


def test_a_followed_clock_that_jumps_ahead():
    clock = Clock()
    driver = following(clock)
    driver.follow(10_010 * MS)
    run_due(driver)
    driver.follow(10_810 * MS)
    assert run_due(driver) == 160, 'a short jump is made up for'
    assert driver.shed == 0
    driver.follow(70_810 * MS)
    assert run_due(driver) == pytest.approx(CATCH_UP_NS / (5 * MS), abs=1)
    assert driver.shed == pytest.approx(60_000 * MS - CATCH_UP_NS, abs=5 * MS)
    assert driver.pace.behind(driver.total_step) < 5 * MS, 'stamps follow the clock'


def test_too_slow_for_a_followed_clock():
    """A chunk of 5 ms takes 12 ms: time is given up, after a while so that little is missing."""
    clock = Clock()
    driver = following(clock)
    for _ in range(600):
        driver.follow(driver.pace.time + 12 * MS)
        clock.now += 12 * MS
        assert driver.due()
        driver.run_chunk()
        assert driver.pace.behind(driver.total_step) <= CATCH_UP_NS + 12 * MS
    assert driver.total_step == 600 * 50, 'no step is left out'
    assert driver.late_chunks > 590
    assert driver.pace.behind(driver.total_step) <= BACKLOG_NS + 12 * MS
    assert driver.shed == pytest.approx(600 * 7 * MS, abs=BACKLOG_NS + 12 * MS)


def test_a_stall_beside_a_followed_clock_is_made_up_for():
    """As when the machine is busy: half a second without a chunk, while the clock goes on."""
    clock = Clock()
    driver = following(clock)
    for tick in range(1, 1000):
        clock.now += 10 * MS
        driver.follow((10_000 + 10 * tick) * MS)
        if not 300 < tick < 350:
            for _ in range(3):  # it can do 1.5 times what the clock asks
                if driver.due():
                    driver.run_chunk()
    assert driver.shed == 0
    assert driver.pace.behind(driver.total_step) < 5 * MS


def test_a_followed_clock_that_goes_back():
    clock = Clock()
    driver = following(clock)
    driver.follow(12_000 * MS)
    run_due(driver)
    step = driver.total_step
    assert driver.follow(500 * MS) == 11_500 * MS
    assert driver.pace.jumps_back == 1
    assert run_due(driver) == 0
    assert driver.pace.behind(step) == 0, 'what is reached is now'
    driver.follow(520 * MS)
    assert run_due(driver) == 4
    assert driver.total_step == step + 200, 'simulation time goes on'
    assert driver.shed == 995 * MS, 'of the first jump, 2 s ahead, not of this one'


def test_a_chunk_that_runs_while_the_followed_clock_goes_back():
    clock = Clock()
    driver = following(clock)
    driver.follow(10_005 * MS)
    advance = driver.simulation.advance
    driver.simulation.advance = lambda n: (advance(n), driver.follow(3_000 * MS))
    driver.run_chunk()
    assert driver.pace.origin + driver.total_step * 100_000 == 3_000 * MS, 'not ahead of the clock'


def test_pause_and_step_beside_a_followed_clock():
    clock = Clock()
    driver = following(clock)
    driver.follow(10_020 * MS)
    run_due(driver)
    driver.pause()
    driver.follow(15_000 * MS)
    assert driver.next_deadline() is None
    assert driver.step_once()
    driver.run_chunk()
    assert driver.pace.behind(driver.total_step) == 0
    driver.resume()
    assert driver.next_deadline() is None
    driver.follow(15_010 * MS)
    assert driver.next_deadline() is None, 'from here on, as if no time had passed'
    driver.follow(15_020 * MS)
    assert run_due(driver) == 2
    assert driver.shed == 0


def test_nothing_runs_once_it_has_settled_after_a_pause():
    """Who pauses tells the time then; a chunk that had become due just before must not follow."""
    clock, failures = Clock(), []
    driver = Driver(Counting(clock), clock=clock)
    pacing = PacingThread(driver, lambda chunk: None, failures.append)
    with pacing._busy:  # the thread finds its chunk due and has to wait here
        pacing.start()
        clock.now += 100 * MS
        while not waits_in(pacing._thread, '_run_chunk'):
            time.sleep(1e-3)
        driver.pause()
    pacing.settle()
    told = driver.total_step
    pacing.stop()
    assert driver.total_step == told == 0
    assert not failures


def test_going_on_while_a_chunk_runs_leaves_no_stamp_ahead_of_the_followed_clock():
    clock = Clock()
    driver = following(clock)
    driver.follow(10_005 * MS)
    plain = driver.simulation.advance

    def advance(steps):     # what other threads do meanwhile
        driver.pause()
        driver.resume()
        driver.follow(10_006 * MS)
        plain(steps)

    driver.simulation.advance = advance
    chunk = driver.run_chunk()
    assert driver.pace.origin + round(chunk.end * driver.its * 1e9) <= driver.pace.time


def test_refusals_of_many_threads_are_all_counted():
    driver = Driver(Counting(Clock()), clock=Clock())

    class Slow(int):    # lets another thread in between reading a number and storing it
        def __add__(self, other):
            time.sleep(1e-4)
            return Slow(int(self) + other)

    driver.refused = Slow(0)

    def refuse():
        for _ in range(20):
            with pytest.raises(CommandRefused):
                driver.command('cmd_penetration', (666.0,))

    threads = [threading.Thread(target=refuse) for _ in range(4)]
    for thread in threads:
        thread.start()
    for thread in threads:
        thread.join()
    assert driver.refused == 80


def test_in_lockstep_a_chunk_waits_for_its_way():
    clock = Clock()
    simulation = Counting(clock)
    simulation.scene.run.carried = True
    driver, way = Driver(simulation, clock=clock), (0.0,) * 12
    told = []
    driver.on_refusal = told.append
    assert driver.next_deadline() is None
    for end, words in ((0, 'the next chunk is'), (49, 'the next chunk is'),
                       (100, 'the next chunk is')):
        with pytest.raises(CommandRefused, match=words):
            driver.carry(end, (*way, 1.0))
    assert not driver.due()
    driver.carry(50, (*way, 1.0))
    driver.carry(50, (*way, 1.0))   # the same once more: no harm
    with pytest.raises(CommandRefused, match='there is one for the chunk that ends at 0.005 s'):
        driver.carry(50, (*way, 2.0))
    assert driver.due()
    assert driver.run_chunk().events == ((0, 'command', 'cmd_mount', (*way, 1.0)),)
    assert driver.next_deadline() is None
    with pytest.raises(CommandRefused, match='not this one'):
        driver.carry(100, (666.0,))
    assert driver.due()     # the other simulator is not left waiting
    assert driver.run_chunk().events == ()
    assert (driver.refused, driver.late_chunks, simulation.step) == (5, 0, 100)
    assert told == []       # whoever sent them was told at once
    offline = Driver(simulation, clock=clock, paced=False)
    assert offline.due()
