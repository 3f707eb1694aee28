"""
Beside exudyn and MuJoCo: the same scenes, in the same run, on the same core, in turns.

Each program is judged against its own converged run, so that the differences left between the
programs count for none; how far the converged runs lie apart is stated. MuJoCo is of first order
in time and exudyn's elements are of second order in length: their converged runs are extrapolated
from two or three fine ones. Their own errors are those of a second, coarser extrapolation.
"""
from dataclasses import replace
import math
import time
from typing import NamedTuple

from bristle_ros.report.runs import prepare_run, run
from bristle_ros.report.timing import Timed
from bristle_ros.report.workers import Failed, Job
import numpy as np

from . import exudyn as peers_exudyn, mujoco as peers_mujoco
from .scenes import our_scene, peer_scene

LEVELS = (1.0, 0.3, 0.1)    # [%] at which costs are compared
START_ANGLES = 1e-6 * np.linspace(-1.0, 1.0, 6)    # [rad] S4 is run from each and averaged
LONGEST = 6.5       # [s] of wall time: what takes longer is run once, for its error, not timed
PEERS = {'exudyn': peers_exudyn, 'mujoco': peers_mujoco}

# Settings to try: (elements, step [s]), from coarse to fine.
OURS = ((3, 4e-3), (4, 4e-3), (4, 2e-3), (6, 2e-3), (6, 1e-3), (8, 1e-3), (8, 5e-4), (12, 5e-4),
        (12, 2e-4))
EXUDYN = ((6, 4e-3), (8, 2e-3), (12, 2e-3), (12, 1e-3), (16, 5e-4), (24, 5e-4), (32, 5e-4),
          (48, 5e-4), (48, 2.5e-4))
MUJOCO = ((8, 1e-3), (8, 2e-4), (8, 1e-4), (12, 5e-5), (16, 2e-5), (24, 1e-5), (32, 5e-6))
MUJOCO_DAMPED = ((6, 1e-3), (8, 1e-3), (8, 5e-4), (12, 2e-4), (16, 1e-4), (24, 2e-5), (32, 1e-5))
# With contact what is compared is the impulse, and steps have to be shorter.
OURS_CONTACT = ((6, 5e-4), (8, 2e-4), (12, 2e-4), (12, 1e-4), (12, 5e-5), (12, 2e-5))
EXUDYN_CONTACT = ((12, 2e-4), (12, 1e-4), (12, 5e-5), (24, 1e-4))
MUJOCO_CONTACT = ((12, 5e-5), (12, 2e-5), (24, 1e-5))

# On the road every node touches and what is compared is the path; converged runs, and the second.
ROAD = {
    'bristle_ros': ((6, 1e-3), (6, 5e-4), (8, 5e-4), (8, 2e-4), (12, 2e-4), (12, 1e-4),
                    (12, 5e-5), (16, 2e-5)),
    'exudyn': ((8, 5e-4), (12, 2e-4), (16, 1e-4)),
    'mujoco': ((8, 5e-5), (12, 2e-5), (16, 1e-5))}
ROAD_CONVERGED = {
    'bristle_ros': ((1.0, 24, 4e-6), (1.0, 20, 8e-6)),
    'exudyn': ((1.0, 24, 4e-5), (1.0, 20, 6e-5)),
    'mujoco': ((1.0, 24, 4e-6), (1.0, 20, 6e-6))}


class Solution(NamedTuple):
    """A path sampled every millisecond."""

    t: np.ndarray
    tip: np.ndarray
    impulse: float      # [N s] normal, whole run
    wall: float         # [s]
    spread: float = 0.0     # [N s] standard deviation of the impulse over the start angles


def solve(program, name, elements, step, change=0.0):
    """Solve a scene with a program; return its Solution; in a worker."""
    if program == 'bristle_ros':
        began = time.perf_counter()
        path = run(_our_scene(name, elements, step, change), peer_scene(name).duration)
        return Solution(path.t, path.tip, float(path.impulse[-1, 2]),
                        time.perf_counter() - began)
    scene = peer_scene(name)
    scene = scene._replace(start_angle=scene.start_angle + change)
    return Solution(*PEERS[program].solve(scene, elements, step))


def _our_scene(name, elements, step, change=0.0):
    scene = our_scene(name, step, elements=elements)
    return replace(scene, brush=replace(scene.brush,
                                        start_angle=scene.brush.start_angle + change))


def prepare(program, name, elements, step):
    """Return what solves a scene and tells its wall time; in a worker."""
    if program == 'bristle_ros':
        return prepare_run(_our_scene(name, elements, step), peer_scene(name).duration)
    return lambda: PEERS[program].solve(peer_scene(name), elements, step)[3]


def programs():
    """Return {name: version} of the peers that are here."""
    return {name: module.version() for name, module in PEERS.items() if module.version()}


def _averaged(crew, name, wanted):
    """
    Return the Solutions of [(program, elements, step, start angles)], or Failed, all cores on it.

    S4, undamped, does not repeat in detail: its impulse is the mean over start angles.
    """
    jobs, counts = [], []
    for program, elements, step, angles in wanted:
        changes = angles if name == 'S4' else (0.0,)
        jobs += [Job(solve, (program, name, elements, step, float(change))) for change in changes]
        counts.append(len(changes))
    found = iter(crew.run(jobs))
    return [_mean([next(found) for _ in range(count)]) for count in counts]


def _mean(parts):
    """Return the Solution of the first part with the mean impulse of all, or Failed."""
    failed = [part for part in parts if isinstance(part, Failed)]
    if failed:
        return failed[0]
    impulses = [part.impulse for part in parts]
    return parts[0]._replace(impulse=float(np.mean(impulses)), spread=float(np.std(impulses)),
                             wall=float(np.mean([part.wall for part in parts])))


def _blend(parts):
    """Return the linear combination [(weight, Solution), ...] on the first one's times."""
    t = parts[0][1].t
    tip = sum(weight * _on(t, solution) for weight, solution in parts)
    return Solution(t, tip, sum(weight * solution.impulse for weight, solution in parts), math.nan)


def _on(t, solution):
    return np.column_stack([np.interp(t, solution.t, column) for column in solution.tip.T])


def _recipe(program, scene, quick, second):
    """Return [(weight, elements, step)] of a converged run, or of the second one."""
    contact = scene.contact
    if scene.whole:
        return [ROAD_CONVERGED[program][second]]
    if program == 'bristle_ros':
        if contact:
            return [(1.0, 12, 4e-6 if second else 2e-6)]
        return [(1.0, 24, 4e-5) if second else (1.0, 32, 2e-5)]
    if program == 'exudyn':
        if contact:
            return [(1.0, 24, 8e-5 if second else 4e-5)]
        coarse, fine = ((16, 5e-4), (32, 2.5e-4)) if quick else ((24, 2.5e-4), (48, 1.25e-4))
        if second:
            coarse, fine = ((12, 5e-4), (24, 2.5e-4)) if quick else ((16, 2.5e-4), (32, 1.25e-4))
        return [(4 / 3, *fine), (-1 / 3, *coarse)]
    if contact:
        return [(1.0, 24, 8e-6 if second else 4e-6)]
    few, many, step = (12, 24, 2e-5) if quick else (16, 32, 1e-5)
    if second:
        few, many, step = (8, 16, 4e-5) if quick else (12, 24, 2e-5)
    # first order in time, second in length
    return [(4 / 3, many, step), (-1 / 3 + 1.0, few, step), (-1.0, few, 2 * step)]


def converged(crew, programs_, name, *, quick):
    """
    Return {program: (converged Solution or Failed, how it was made, the second one or Failed)}.

    All of them at once: they are the longest runs there are.
    """
    scene = peer_scene(name)
    recipes = {(program, second): _recipe(program, scene, quick, second)
               for program in programs_ for second in (False, True)}
    solutions = iter(_averaged(crew, name, [
        (program, elements, step, START_ANGLES[:4] if second else START_ANGLES)
        for (program, second), recipe in recipes.items() for _, elements, step in recipe]))
    blends = {}
    for key, recipe in recipes.items():
        parts = [(weight, next(solutions)) for weight, _, _ in recipe]
        failed = [part for _, part in parts if isinstance(part, Failed)]
        blends[key] = failed[0] if failed else _blend(parts)
    return {program: (blends[program, False], _how(recipes[program, False]),
                      blends[program, True]) for program in programs_}


def _how(recipe):
    """Say how a converged run is made."""
    words = ' and '.join(f'{elements} elements, {step * 1e6:g} us' for _, elements, step in recipe)
    return words + (' extrapolated' if len(recipe) > 1 else '')


def path_error(solution, reference):
    """Return the relative error of the tip path [%], on the coarser of both samplings."""
    at = solution.t[solution.t <= reference.t[-1] + 1e-9]
    exact = _on(at, reference)
    straight = reference.tip[0]
    return 100.0 * float(np.sqrt(((_on(at, solution) - exact) ** 2).sum()
                                 / ((exact - straight) ** 2).sum()))


def error_of(solution, exact, contact):
    """Return the error that is compared [%]: of the impulse with contact, else of the path."""
    if contact:
        return 100.0 * abs(solution.impulse / exact.impulse - 1.0)
    return path_error(solution, exact)


def settings(program, name):
    """Return the (elements, step) to try."""
    if peer_scene(name).whole:
        return ROAD[program]
    if peer_scene(name).contact:
        return {'bristle_ros': OURS_CONTACT, 'exudyn': EXUDYN_CONTACT,
                'mujoco': MUJOCO_CONTACT}[program]
    mujoco = MUJOCO_DAMPED if name == 'S5' else MUJOCO
    return {'bristle_ros': OURS, 'exudyn': EXUDYN, 'mujoco': mujoco}[program]


def measure(context, names=None):
    """Return the part's data; without a peer nothing is measured."""
    found = programs()
    data = {'versions': found, 'absent': [name for name in PEERS if name not in found],
            'scenes': []}
    if not found:
        return data
    names = names or (('S2',) if context.quick else ('S1', 'S2', 'S5', 'S3', 'S4'))
    for number, name in enumerate(names):
        context.progress.count(number, len(names), f'{name}: errors')
        entries = _errors(context, ('bristle_ros', *found), name)
        timed = [Timed(f'{program} {row["label"]}', prepare,
                       (program, name, row['elements'], row['step']), program,
                       peer_scene(name).duration)
                 for program, entry in entries.items() for row in entry['rows']
                 if 'error' in row and row['wall_once'] < LONGEST]
        timings = context.timer.group(timed)
        for program, entry in entries.items():
            exact = entry.pop('exact')
            entry['apart'] = _apart(entries['bristle_ros'].get('solution'), exact, name)
            entry['solution'] = exact if program == 'bristle_ros' else None
            for row in entry['rows']:
                row['timing'] = timings.get(f'{program} {row["label"]}')
        for entry in entries.values():
            entry.pop('solution', None)
        data['scenes'].append({'name': name, 'contact': peer_scene(name).by_impulse,
                               'programs': entries})
    return data


def _apart(ours, exact, name):
    if ours is None or exact is None:
        return {}
    return {'path': path_error(exact, ours), 'impulse': 100 * (exact.impulse / ours.impulse - 1.0)
            if peer_scene(name).by_impulse else None}


def _errors(context, programs_, name):
    """Return of each program its converged run, own error, and rows of its settings' errors."""
    contact, entries, todo = peer_scene(name).by_impulse, {}, {}
    runs = converged(context.crew, programs_, name, quick=context.quick)
    for program, (exact, how, second) in runs.items():
        if isinstance(exact, Failed):
            entries[program] = {'rows': [{'label': 'converged run', 'note': exact.reason}],
                                'own': None, 'exact': None, 'how': ''}
            continue
        own = None if isinstance(second, Failed) else error_of(second, exact, contact)
        entries[program] = {'rows': [], 'own': own, 'exact': exact, 'how': how}
        # in the quick form not what takes minutes
        todo[program] = [(elements, step) for elements, step in settings(program, name)
                         if not context.quick or (
                             elements <= 24 and peer_scene(name).duration / step <= 60_000)]
    while any(todo.values()):   # from coarse to fine, one setting of each program at a time
        turn = [(program, *todo[program].pop(0)) for program in todo if todo[program]]
        solutions = _averaged(context.crew, name, [(*each, START_ANGLES) for each in turn])
        for (program, elements, step), solution in zip(turn, solutions):
            row = _row(elements, step, solution, entries[program]['exact'], contact)
            entries[program]['rows'].append(row)
            if row.get('error', math.inf) <= LEVELS[-1]:
                todo[program] = []      # what follows is finer and slower
    return entries


def _row(elements, step, solution, exact, contact):
    row = {'label': f'{elements} elements, {step * 1e6:g} us', 'elements': elements, 'step': step,
           'note': ''}
    if isinstance(solution, Failed):
        return {**row, 'note': solution.reason}
    return {**row, 'error': error_of(solution, exact, contact), 'wall_once': solution.wall,
            'scatter': 100 * solution.spread / exact.impulse if contact else None}
