"""The kernels without the compiler: same source, same numbers."""
from dataclasses import replace
import os
import re
import subprocess
import sys

from bristle_ros.physics.contact.bracket import solve_contact
from bristle_ros.physics.contact.law import ContactLaw
from bristle_ros.physics.motion.drive import profile_at, SINE, VAP
from bristle_ros.simulation.simulation import Simulation
import numpy as np
from physics.scenes import bouncing_sweep, cantilever_drop, tilted_sweep


def scenes():
    """Return short runs that between them reach contact, damping and rigid roads."""
    tight = {'its': 2e-4, 'tolerance': 1e-9}    # what Newton leaves is as large as last bits
    quick = bouncing_sweep(elements=3, **tight)
    return [cantilever_drop(elements=2, **tight), quick,
            replace(quick, contact=replace(quick.contact, normal_stiffness=np.inf, damping=0.0)),
            replace(tilted_sweep(elements=2, **tight),
                    road=replace(tilted_sweep().road, penetration=0.0, approach_time=0.0))]


def results():
    """Return a dictionary of arrays from steps and from single kernels."""
    found = {}
    for i, scene in enumerate(scenes()):
        simulation = Simulation(scene, energies=True)
        simulation.advance(12)
        now = simulation.snapshot()
        for name in ('tip_position', 'tip_orientation', 'contact_impulse', 'mount_moment',
                     'energy_kinetic', 'newton_iterations'):
            found[f'{i} {name}'] = np.asarray(getattr(now, name), float)
    rng = np.random.default_rng(3)
    forces = []
    for law in (ContactLaw(0.0, 0.0, 0.7, 0.27, 0.4), ContactLaw(1e4, 1.0, 0.5, 0.5, 0.0)):
        for _ in range(20):
            m = rng.normal(size=(3, 3))
            force = np.zeros(3)
            state = solve_contact(law, 1e-4, 1e-5 * (m @ m.T + 0.1 * np.eye(3)), 1e-6,
                                  1e-5 * rng.normal(size=3), 1.0, force)
            forces.append([*force, state])
    found['contact'] = np.array(forces)
    found['profiles'] = np.array([profile_at(t, kind, 0.5, 9.0, 0.08)
                                  for kind in (SINE, VAP) for t in np.linspace(0.0, 0.3, 31)])
    return found


def test_interpreted_kernels_give_the_same(tmp_path):
    path = tmp_path / 'interpreted.npz'
    code = ('import sys; sys.path[:0] = sys.argv[2:]\n'
            'import numpy as np\n'
            'from physics.compiler import test_interpreted\n'
            'np.savez(sys.argv[1], **test_interpreted.results())\n')
    folders = [folder for folder in sys.path if folder]
    subprocess.run([sys.executable, '-c', code, str(path), *folders], check=True,
                   env={**os.environ, 'NUMBA_DISABLE_JIT': '1'})
    with np.load(path) as file:
        interpreted = {name: file[name] for name in file}
    compiled = results()
    assert interpreted.keys() == compiled.keys()
    for name, ours in compiled.items():
        # fused multiply-add rounds differently; stiffness and impacts amplify that over a run
        scale = max(abs(ours).max(), 1e-12)
        bound = 1e-12 if name in ('contact', 'profiles') else 1e-7 if 'moment' in name else 1e-9
        np.testing.assert_allclose(interpreted[name], ours, rtol=0.0, atol=bound * scale,
                                   err_msg=name)
    # there was contact to compare
    assert compiled['1 contact_impulse'][0, 2] > 0.0
    assert compiled['2 contact_impulse'][0, 2] > 0.0


def test_what_the_kernels_promise_step_by_step(root):
    # the tests of interpreted/ want plain Python: seconds instead of a new variant compiled
    run = subprocess.run(
        [sys.executable, '-m', 'pytest', '-q', '-p', 'no:cacheprovider',
         'test/physics/interpreted'], cwd=root, text=True, capture_output=True,
        env={**os.environ, 'NUMBA_DISABLE_JIT': '1'})
    assert run.returncode == 0, run.stdout + run.stderr
    assert int(re.search(r'(\d+) passed', run.stdout)[1]) > 90, 'none was left out'
