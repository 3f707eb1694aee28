"""What is timed and weighed to tell a feature's cost; each function runs in a worker."""
import os
from pathlib import Path
import resource
import tempfile
import time

from bristle_ros.report.precision.subjects import scene_of
from bristle_ros.report.runs import prepare_run, timed
from bristle_ros.scene import load, steps

from .features import changed, STEP

COUNT = 200         # messages of one timing
CONFIG = Path(__file__).resolve().parents[3] / 'config'     # of a checkout
BROOM = 'full_brush.yaml'


def scene(keys):
    """Return the default scene with keys changed."""
    return changed(scene_of('cutting_brush', STEP), keys)


def prepare(keys, around, duration):
    """Return what runs the scene with keys, and with what is around it; tells wall time [s]."""
    from bristle_ros.simulation import Simulation
    if around in ('commands', 'log', 'driver'):
        return _prepare_driver(keys, around, duration)
    if around != 'energies':
        return prepare_run(scene(keys), duration)
    return timed(Simulation(scene(keys), energies=True), duration)


def _prepare_driver(keys, around, duration):
    from bristle_ros.simulation import Simulation
    simulation = Simulation(scene(keys))

    def again():
        simulation.reset()
        with tempfile.TemporaryDirectory() as folder:
            began = time.perf_counter()
            _drive(simulation, around, duration, Path(folder) / 'log.mcap')
            return time.perf_counter() - began
    return again


def _drive(simulation, around, duration, path):
    """Run as the node does, chunk by chunk, with commands or a log."""
    from bristle_ros.log import Log
    from bristle_ros.realtime import Driver
    from bristle_ros.simulation import MountPath
    made = simulation.scene
    driver = Driver(simulation, paced=False, sample=steps(made, 1e-3, 'sample'))
    log = None
    if around == 'log':
        log = Log(path, made)
        if made.log.tf:
            driver.mount = MountPath(made)
    end = round(duration / simulation.its)
    while driver.total_step < end:
        if around == 'commands':
            driver.command('cmd_brush_speed', (made.drive.mean_speed,))
        chunk = driver.run_chunk(min(driver.chunk, end - driver.total_step))
        if log is not None:
            log.write(chunk)
    if log is not None:
        log.close()


def log_bytes(keys, duration):
    """Return the bytes of a log per simulated second."""
    from bristle_ros.simulation import Simulation
    with tempfile.TemporaryDirectory() as folder:
        sizes = []
        for part in (0.5, 1.0):     # the head and the scene are in both
            path = Path(folder) / f'{part}.mcap'
            _drive(Simulation(scene(keys)), 'log', part * duration, path)
            sizes.append(os.path.getsize(path))
    return (sizes[1] - sizes[0]) / (0.5 * duration)


def _messages():
    """Return {topic: function that makes its message}, of a state with contact."""
    from bristle_ros.messages import encode as messages, encode_transforms, view
    from bristle_ros.simulation import MountPath, Simulation
    made = scene({})
    simulation = Simulation(made)
    simulation.advance(1500)
    snapshot, mount = simulation.snapshot(), MountPath(made).follow(simulation, 0)
    markers = view.Markers(made)
    found = {topic.name: (lambda topic=topic: topic.encode(snapshot, 0))
             for topic in messages.topics()}
    found['/tf'] = lambda: encode_transforms(0, '', snapshot, mount, 'all')
    found['bristle_markers'] = lambda: markers.encode(0, snapshot, simulation.centreline(), mount)
    return found


def prepare_message(topic):
    """Return what makes a topic's message COUNT times; tells the wall time of one [s]."""
    make = _messages()[topic]

    def again():
        began = time.perf_counter()
        for _ in range(COUNT):
            make()
        return (time.perf_counter() - began) / COUNT
    return again


def message_bytes():
    """Return {topic: bytes of its message}."""
    return {topic: len(make()) for topic, make in _messages().items()}


def prepare_broom(threads, duration):
    """Return what runs the whole broom of config/, or raise RuntimeError where that is not."""
    from bristle_ros.simulation import Simulation
    if not (CONFIG / BROOM).is_file():
        raise RuntimeError(f'no {BROOM} beside the package: run it from a checkout')
    return timed(Simulation(load(CONFIG / BROOM), threads=threads), duration)


def start_up(keys, around):
    """Be ready for the first step; return the largest memory that it took [MB]."""
    from bristle_ros.simulation import Simulation
    if around in ('log', 'commands'):
        with tempfile.TemporaryDirectory() as folder:
            simulation = Simulation(scene(keys))
            _drive(simulation, around, 5e-3, Path(folder) / 'log.mcap')
    else:
        Simulation(scene(keys), energies=around == 'energies').advance(1)
    return resource.getrusage(resource.RUSAGE_SELF).ru_maxrss / 1024.0
