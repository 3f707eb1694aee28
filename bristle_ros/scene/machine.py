"""What a drive that feels its load, and a mount that is carried, ask of the rest of a scene."""
from typing import TYPE_CHECKING

from .error import SceneError

if TYPE_CHECKING:
    from .scene import Scene


def check_drive(scene: 'Scene') -> None:
    """Refuse what has to know the brush's angle beforehand, where the drive feels its load."""
    mode, solver = scene.drive.mode, scene.solver
    if mode == 'speed':
        return
    if solver.load_case == 'displacement':
        raise SceneError('prescribes the angle of the brush, which is a result here: take '
                         'load_case: inertia, or drive.mode: speed', key='drive.mode', value=mode)
    if solver.time_step > 0.0:
        raise SceneError(f"the angle at a load step's end is not known beforehand with "
                         f'drive.mode: {mode}: take 0.0', key='solver.time_step',
                         value=solver.time_step)


def follows_mount(scene: 'Scene') -> bool:
    """Return whether all is ready for a mount that is carried, before a first cmd_mount."""
    return scene.mount.enabled or scene.run.carried


def carrying_refusal(scene: 'Scene') -> str:
    """Return why the mount of a scene cannot be carried, or ''."""
    if scene.solver.load_case == 'displacement':
        return 'a mount that is carried needs the forces of its frame: take load_case: inertia'
    if scene.solver.time_step > 0.0:
        return ('a mount that is carried moves as it is told, without load steps: take '
                'solver.time_step: 0.0')
    return ''


def check_mount(scene: 'Scene') -> None:
    """Refuse what a mount that is carried contradicts."""
    if not follows_mount(scene):
        return
    key = 'mount.enabled' if scene.mount.enabled else 'run.carried'
    refusal = carrying_refusal(scene)
    if refusal:
        raise SceneError(refusal, key=key, value=True)
    if scene.run.carried and scene.run.real_time_factor not in (0.0, 1.0):
        raise SceneError('with run.carried, cmd_mount sets the pace: leave it at 1.0',
                         key='run.real_time_factor', value=scene.run.real_time_factor)
    if scene.run.carried and scene.run.max_load > 0.0:
        raise SceneError('with run.carried there is no real time to keep to: leave it at 0.0',
                         key='run.max_load', value=scene.run.max_load)
