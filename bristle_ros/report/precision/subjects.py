"""The scenes whose error against run time is drawn, and the settings that are tried on each."""
from typing import NamedTuple

from bristle_ros.report.peers.scenes import our_scene, RPM
from bristle_ros.scene import Contact, Damping, Drive, Road, Run, Scene, Solver

TOLERANCES = (1e-3, 1e-4, 1e-5, 1e-6, 1e-7)     # of adaptive steps, per length of the bristle
HALVED = 5e-7       # local error above which the steps of a family of fixed ones are halved
# The second discretisation: another integrator, its damping as in the usual practice of HHT.
OTHER = {'integrator': 'hht', 'amplitude_decay': 0.05}
FREE_STEPS = (4e-3, 2e-3, 1e-3, 5e-4, 2e-4, 1e-4)
CONTACT_STEPS = (5e-4, 2e-4, 1e-4, 5e-5, 2e-5, 1e-5)


class Subject(NamedTuple):
    """A scene whose error against run time is drawn."""

    name: str
    what: str
    duration: float     # [s]
    contact: bool
    steps: tuple        # ITS [s], coarse to fine
    usual: float        # [s] the ITS at which the other things are varied
    reference: tuple    # elements and ITS [s] of the converged run
    check: tuple        # the same of the second discretisation, which has another integrator too


SUBJECTS = (
    Subject('S1', 'cantilever dropped from the horizontal', 0.5, False, FREE_STEPS, 5e-4,
            (32, 2e-5), (24, 2e-5)),
    Subject('S2', 'free rotation at 150 rpm with a sine of 4 rpm', 0.5, False, FREE_STEPS, 5e-4,
            (32, 2e-5), (24, 2e-5)),
    Subject('S5', 'S2 with a stiffness damping of 21 ms', 0.5, False, FREE_STEPS, 5e-4,
            (32, 2e-5), (24, 2e-5)),
    Subject('cutting_brush', 'the default scene, the road up after 0.1 s', 0.3, True,
            (1e-3, 5e-4, 2e-4, 1e-4, 5e-5, 2e-5), 1e-4, (12, 2e-6), (12, 2e-6)),
    Subject('S3', 'bouncing sweep at 100 rpm', 0.3, True, CONTACT_STEPS, 5e-5, (12, 1e-6),
            (12, 1e-6)),
    Subject('S4', 'the tilted, deep, undamped sweep of the paper', 0.24, True, CONTACT_STEPS, 5e-5,
            (12, 1e-6), (12, 1e-6)),
)


def subject_of(name):
    """Return the Subject of a name."""
    return next(subject for subject in SUBJECTS if subject.name == name)


def scene_of(name, its, **solver):
    """Return the Scene of a subject with this step; solver: keys of its solver section."""
    if name != 'cutting_brush':
        return our_scene(name, its, **solver)
    # as config/cutting_brush.yaml, but with the road up after 0.1 s
    return Scene(road=Road(penetration=0.02, approach_time=0.1), contact=Contact(),
                 damping=Damping(stiffness=1e-3), drive=Drive(mean_speed=100 * RPM),
                 solver=Solver(integration_time_step=its, **solver),
                 run=Run(chunk=max(1, round(5e-3 / its)) * its,
                         sample=max(1, round(1e-3 / its)) * its))


def settings(subject, quick):
    """Return (family, label, ITS [s], solver keys) of the runs to make."""
    usual = subject.usual
    every = subject.steps[:-1] if quick else subject.steps
    found = [('step', f'{its * 1e6:g} us', its, {}) for its in every]
    for elements in (4, 8) if quick else (2, 4, 6, 8, 16, 24):
        found.append(('elements', f'{elements} el', usual, {'elements': elements}))
    makes = [('rho 0', {'spectral_radius': 0.0}), ('rho 0.95', {'spectral_radius': 0.95}),
             ('HHT', {'integrator': 'hht', 'amplitude_decay': 0.1}),
             ('Newmark', {'integrator': 'newmark'})]
    for label, keys in makes[-2:] if quick else makes:
        found.append(('integrator', label, usual, keys))
    for label, step in (('TS 0', 0.0),) if quick else (('TS 0', 0.0), ('TS 1 ms', 1e-3)):
        found.append(('load case', f'displacement, {label}', usual,
                      {'load_case': 'displacement', 'time_step': step}))
    for tolerance in TOLERANCES[1:4] if quick else TOLERANCES:
        found.append(('adaptive', f'tol {tolerance:g}', subject.steps[0],
                      {'step': 'adaptive', 'error_tolerance': tolerance}))
    if subject.contact:
        found += [('halved', f'{its * 1e6:g} us, halved', its, {'largest_error': HALVED})
                  for its in subject.steps[1:3 if quick else 5]]
    return found
