"""A scene's machine code holds nothing that the scene does not use: read from the code itself."""
from pathlib import Path

from bristle_ros.physics.step.stepping import advance
from bristle_ros.simulation.simulation import Simulation
from physics.scenes import bouncing_sweep, free_rotation
import pytest

CONTACT = (b'contact_correction', b'solve_contact', b'slip_by_newton')
DAMPING = (b'predict_damping', b'accept_damping')


def code_of(contact, damping):
    """Return the cached code of `advance` for scenes with or without these."""
    found = [path.read_bytes() for path in Path(advance._cache.cache_path).glob(
        'stepping.advance-*.nbc')]
    return [code for code in found if (b'ContactLaw' in code) == contact
            and any(name in code for name in DAMPING) == damping]


@pytest.mark.parametrize(('scene', 'contact', 'damping'), [
    (free_rotation(), False, False), (free_rotation(viscosity=0.021), False, True),
    (bouncing_sweep(), True, True)])
def test_code_has_only_what_the_scene_uses(scene, contact, damping):
    Simulation(scene).advance(2)
    codes = code_of(contact, damping)
    assert codes
    for code in codes:
        assert all((name in code) == contact for name in CONTACT)
        assert b'factorise' in code     # names of functions are there to be found


def test_lean_code_is_smaller():
    for scene in (free_rotation(), free_rotation(viscosity=0.021), bouncing_sweep()):
        Simulation(scene)
    sizes = [min(len(code) for code in code_of(contact, damping))   # others keep accounts
             for contact, damping in ((False, False), (False, True), (True, True))]
    assert sizes[0] < sizes[1] < sizes[2]
