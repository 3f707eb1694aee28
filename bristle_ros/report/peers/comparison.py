"""
Beside exudyn and MuJoCo: the same scenes, in the same run, on the same core, best of several.

Each program is judged against its own converged run, so that the differences left between the
programs count for none; how far the converged runs lie apart is stated. At equal error the
fastest of the tried settings counts. MuJoCo is of first order in time and exudyn's elements are of
second order in length: their converged runs are extrapolated from two or three fine ones.
"""
from dataclasses import replace
import math
from typing import NamedTuple

from bristle_ros.report.page import new_figure, whole_decades
from bristle_ros.report.runs import run
import numpy as np

from . import exudyn as peers_exudyn, mujoco as peers_mujoco
from .scenes import our_scene, peer_scene

TARGETS = (1.0, 0.1)    # [%]
MARKERS = {'bristle_ros': ('#1f77b4', 'o'), 'exudyn': ('#d62728', 's'), 'mujoco': ('#2ca02c', '^')}


class Solution(NamedTuple):
    """A path sampled every millisecond."""

    t: np.ndarray
    tip: np.ndarray
    impulse: float      # [N s] normal, whole run
    wall: float         # [s]
    spread: float = 0.0     # [N s] standard deviation of the impulse over the start angles


START_ANGLES = 1e-6 * np.linspace(-1.0, 1.0, 10)    # [rad] S4 is run from each and averaged


# Settings to try: (elements, step [s]), from coarse to fine.
OURS = ((3, 4e-3), (4, 4e-3), (4, 2e-3), (6, 2e-3), (6, 1e-3), (8, 1e-3), (8, 5e-4), (12, 5e-4),
        (12, 2e-4))
EXUDYN = ((6, 4e-3), (8, 2e-3), (12, 2e-3), (12, 1e-3), (16, 5e-4), (24, 5e-4), (32, 5e-4),
          (48, 5e-4), (48, 2.5e-4))
MUJOCO = ((8, 1e-3), (8, 2e-4), (8, 1e-4), (12, 5e-5), (16, 2e-5), (24, 1e-5), (32, 2e-6),
          (48, 2e-6))
MUJOCO_DAMPED = ((6, 1e-3), (8, 1e-3), (8, 5e-4), (12, 2e-4), (16, 1e-4), (24, 2e-5), (32, 1e-5))
# With contact what is compared is the impulse, and steps have to be shorter.
OURS_CONTACT = ((6, 5e-4), (8, 2e-4), (12, 2e-4), (12, 1e-4), (12, 5e-5), (12, 2e-5))
EXUDYN_CONTACT = ((12, 2e-4), (12, 5e-5), (24, 1e-4), (24, 5e-5))
MUJOCO_CONTACT = ((12, 5e-5), (12, 2e-5), (24, 1e-5), (24, 5e-6), (24, 2e-6))


def _averaged(solve, name, elements, step):
    """
    Return the Solution of solve(scene name, start angle's change, elements, step).

    S4, undamped, does not repeat in detail: its impulse and wall time are means over start angles.
    """
    if name != 'S4':
        return solve(name, 0.0, elements, step)
    parts = [solve(name, change, elements, step) for change in START_ANGLES]
    impulses = [part.impulse for part in parts]
    return parts[0]._replace(impulse=float(np.mean(impulses)), spread=float(np.std(impulses)),
                             wall=float(np.mean([part.wall for part in parts])))


def ours(name, elements, step):
    """Solve one of the five scenes with this package; return its Solution."""
    def solve(name, change, elements, step):
        scene = our_scene(name, step, elements=elements)
        scene = replace(scene, brush=replace(scene.brush,
                                             start_angle=scene.brush.start_angle + change))
        path = run(scene, peer_scene(name).duration)
        return Solution(path.t, path.tip, float(path.impulse[-1, 2]), path.wall)
    return _averaged(solve, name, elements, step)


def _peer(module):
    def solve(name, change, elements, step):
        scene = peer_scene(name)
        scene = scene._replace(start_angle=scene.start_angle + change)
        return Solution(*module.solve(scene, elements, step))
    return lambda name, elements, step: _averaged(solve, name, elements, step)


def programs():
    """Return name to (solve, version) of the programs that are here, and the absent names."""
    found = {'bristle_ros': (ours, '')}
    absent = []
    for name, module in (('exudyn', peers_exudyn), ('mujoco', peers_mujoco)):
        version = module.version()
        if version:
            found[name] = _peer(module), version
        else:
            absent.append(name)
    return found, absent


def _blend(parts):
    """Return the linear combination [(weight, Solution), ...] on the first one's times."""
    t = parts[0][1].t
    tip = sum(weight * _on(t, solution) for weight, solution in parts)
    return Solution(t, tip, sum(weight * solution.impulse for weight, solution in parts), math.nan)


def _on(t, solution):
    return np.column_stack([np.interp(t, solution.t, column) for column in solution.tip.T])


def converged(program, solve, name, *, quick):
    """Return a program's converged Solution of a scene, and how it was made."""
    contact = peer_scene(name).contact
    if program == 'bristle_ros':
        elements, step = (12, 2e-6) if contact else (32, 2e-5)
        return solve(name, elements, step), f'{elements} el, {step * 1e6:g} us'
    if program == 'exudyn':
        if contact:
            return solve(name, 24, 2e-5), '24 el, 20 us'
        coarse, fine = ((16, 5e-4), (32, 2.5e-4)) if quick else ((24, 2.5e-4), (48, 1.25e-4))
        return (_blend([(4 / 3, solve(name, *fine)), (-1 / 3, solve(name, *coarse))]),
                f'{coarse[0]} and {fine[0]} el extrapolated')
    if contact:
        return solve(name, 24, 1e-6), '24 el, 1 us'
    few, many, step = (12, 24, 2e-5) if quick else (16, 32, 1e-5)
    # first order in time, second in length
    return (_blend([(4 / 3, solve(name, many, step)), (-1 / 3 + 1.0, solve(name, few, step)),
                    (-1.0, solve(name, few, 2 * step))]),
            f'{few} and {many} el, {step * 1e6:g} and {2e6 * step:g} us extrapolated')


def path_error(solution, reference):
    """Return the relative error of the tip path [%], on the coarser of both samplings."""
    at = solution.t[solution.t <= reference.t[-1] + 1e-9]
    exact = _on(at, reference)
    straight = reference.tip[0]
    return 100.0 * float(np.sqrt(((_on(at, solution) - exact) ** 2).sum()
                                 / ((exact - straight) ** 2).sum()))


def settings(program, name):
    """Return the (elements, step) to try."""
    if peer_scene(name).contact:
        return {'bristle_ros': OURS_CONTACT, 'exudyn': EXUDYN_CONTACT,
                'mujoco': MUJOCO_CONTACT}[program]
    mujoco = MUJOCO_DAMPED if name == 'S5' else MUJOCO
    return {'bristle_ros': OURS, 'exudyn': EXUDYN, 'mujoco': mujoco}[program]


def compare(progress, names, *, quick=False, repeats=5):
    """
    Return rows of all runs, rows of equal error with the ratios, and rows of disagreements.

    Runs that meet a target are timed `repeats` times, taking turns with the other programs.
    """
    found, absent = programs()
    rows, equal, apart = [], [], []
    for name in names:
        best, exact = {}, {}
        contact = peer_scene(name).contact
        for program, (solve, _) in found.items():
            progress(f'{name}: {program}, converged run')
            try:
                exact[program], how = converged(program, solve, name, quick=quick)
            except RuntimeError as failure:
                rows.append({'scene': name, 'program': program, 'note': str(failure)})
                continue
            for elements, step in settings(program, name):
                if quick and (elements > 24 or peer_scene(name).duration / step > 60_000):
                    continue    # minutes
                progress(f'{name}: {program}, {elements} el, {step * 1e6:g} us')
                row = {'scene': name, 'program': program, 'elements': elements,
                       'step_us': step * 1e6}
                try:
                    solution = solve(name, elements, step)
                except RuntimeError as failure:
                    rows.append({**row, 'note': str(failure)})
                    continue
                if contact:
                    error = 100 * abs(solution.impulse / exact[program].impulse - 1.0)
                else:
                    error = path_error(solution, exact[program])
                row.update(error_percent=error, note='', spread_percent=(
                    100 * solution.spread / exact[program].impulse if contact else math.nan),
                           wall_per_simulated_s=solution.wall / peer_scene(name).duration)
                rows.append(row)
                for target in TARGETS:
                    least = best.get((program, target))
                    if error <= target and (least is None or row['wall_per_simulated_s']
                                            < least['wall_per_simulated_s']):
                        best[program, target] = row
                if error <= TARGETS[-1]:
                    break       # what follows is finer and slower
            apart.append({
                'scene': name, 'program': program, 'converged_run': how,
                'path_from_ours_percent': path_error(exact[program], exact['bristle_ros'])
                if 'bristle_ros' in exact else math.nan,
                'impulse_mNs': 1e3 * exact[program].impulse if contact else math.nan,
                'impulse_from_ours_percent': 100 * (
                    exact[program].impulse / exact['bristle_ros'].impulse - 1.0)
                if contact else math.nan})
        _time_again(progress, name, found, best, repeats)
        for target in TARGETS:
            equal.append(_equal_row(name, target, best, found))
    return rows, equal, apart, absent


def _time_again(progress, name, found, best, repeats):
    """Time the winners again, in turns; keep the least."""
    for turn in range(1, repeats):
        done = set()
        for (program, _), row in best.items():
            # a run that takes minutes is not disturbed by what disturbs one of milliseconds
            if id(row) in done or row['wall_per_simulated_s'] > 60.0:
                continue
            done.add(id(row))
            progress(f'{name}: timing {program}, {turn + 1} of {repeats}')
            again = found[program][0](name, row['elements'], row['step_us'] * 1e-6)
            row['wall_per_simulated_s'] = min(row['wall_per_simulated_s'],
                                              again.wall / peer_scene(name).duration)


def _equal_row(name, target, best, found):
    row = {'scene': name, 'error_at_most_percent': target}
    mine = best.get(('bristle_ros', target))
    for program in found:
        theirs = best.get((program, target))
        row[f'{program}_s_per_s'] = theirs['wall_per_simulated_s'] if theirs else math.nan
        row[f'{program}_setting'] = (
            f'{theirs["elements"]} el, {theirs["step_us"]:g} us, {theirs["error_percent"]:.2g} %'
            if theirs else 'none of those tried')
        if program != 'bristle_ros':
            row[f'{program}_over_ours'] = (
                theirs['wall_per_simulated_s'] / mine['wall_per_simulated_s']
                if theirs and mine else math.nan)
    return row


def draw(rows, names):
    """Return the figure of error against run time of all programs."""
    figure, axes = new_figure(min(3, len(names)), -(-len(names) // 3), 10.5, 3.6)
    for panel in axes.flat[len(names):]:
        panel.set_visible(False)
    for name, panel in zip(names, axes.flat):
        for program, (colour, marker) in MARKERS.items():
            points = [row for row in rows if row['scene'] == name and row['program'] == program
                      and row.get('error_percent', 0.0) > 0.0]
            if points:
                panel.loglog([p['wall_per_simulated_s'] for p in points],
                             [p['error_percent'] for p in points], marker=marker, color=colour,
                             ms=5, lw=1, label=program)
        for target in TARGETS:
            panel.axhline(target, color='#888', ls=':', lw=1)
        panel.axvline(1.0, color='k', lw=0.8)
        panel.set_title(name)
        panel.set_xlabel('wall seconds per simulated second')
        panel.set_ylabel('error of the impulse [%]' if peer_scene(name).contact
                         else 'error of the tip path [%]')
        whole_decades(panel)
        panel.legend()
    return figure
