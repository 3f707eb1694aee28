"""The fault campaign in short, and that its checks see what they are there to see."""
from pathlib import Path
import random
import subprocess
import sys
import time

from bristle_ros.log.writer import Log
import pytest

HERE = Path(__file__).resolve().parent
sys.path.insert(0, str(HERE))

from examples import chunk_of, SCENE  # noqa: E402, I100
from mangle import damaged  # noqa: E402
from promises import BrokenPromiseError, following, killed, whole  # noqa: E402


def test_short_campaign_breaks_no_promise():
    done = subprocess.run([sys.executable, HERE / 'campaign.py'], capture_output=True, text=True)
    assert done.returncode == 0, done.stdout + done.stderr
    *held, summary, lost = done.stdout.splitlines()[1:]
    assert len(held) == 9
    assert all(': held {' in line for line in held)
    assert summary.startswith('9 faults, 9 survived')
    assert lost.startswith('kill -9 cost')


def test_a_seed_gives_the_same_faults_again():
    first, again = ([damaged(bytes(1000), random.Random(f'{seed} mangled 0')) for seed in range(9)]
                    for _ in range(2))
    assert first == again
    assert len(set(first)) > 1


@pytest.fixture
def log(tmp_path):
    """Return a whole log, every second step of which has a sample."""
    with Log(tmp_path / 'run', SCENE) as log:
        for step in range(2, 402, 2):
            log.write(chunk_of([step]))
    return tmp_path / 'run'


def cut(log):
    file = log / 'run_0.mcap'
    file.write_bytes(file.read_bytes()[:-5000])


def test_checks_see_a_log_that_was_cut(log):
    assert len(whole(log, simulate=False)) > 1000
    with pytest.raises(BrokenPromiseError, match='cut off'):
        following(log, cut=True)
    cut(log)
    with pytest.raises(BrokenPromiseError, match='cut off'):
        whole(log, simulate=False)


def test_checks_see_a_sample_that_is_missing(tmp_path):
    with Log(tmp_path / 'run', SCENE) as log:
        for step in (2, 4, 8):
            log.write(chunk_of([step]))
    with pytest.raises(BrokenPromiseError, match='missing'):
        whole(tmp_path / 'run', simulate=False)


def test_checks_see_other_values(log):
    with pytest.raises(BrokenPromiseError, match='replay --verify'):
        whole(log)


def test_checks_see_what_a_kill_cost(log):
    cut(log)
    with pytest.raises(BrokenPromiseError, match='cost'):
        killed(log, time.time_ns() + 1_000_000_000)
