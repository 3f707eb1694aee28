"""Where a step's time goes: each kernel is called as a step calls it."""
from bristle_ros.report.lean import step_profile
import pytest


@pytest.mark.parametrize('name', step_profile.SCENES)
def test_every_kernel_of_a_step_is_timed(name, monkeypatch):
    monkeypatch.setattr(step_profile, 'CALLS', 2)
    monkeypatch.setattr(step_profile, 'TURNS', 2)
    rows = step_profile.profile(name, 0.02, 1)
    assert len(rows) > 10
