"""Where a step's time goes: each kernel timed by itself, times how often a step calls it."""
from bristle_ros.physics.motion import CLAMP
from bristle_ros.physics.step import FACTORISATIONS, NEWTON, own_frame
from bristle_ros.physics.wire import (accept_damping, accept_step, add_excess, begin_step,
                                      CORNER, eliminate, factorise, internal_forces, LANES,
                                      local_error, move_nodes, predict_damping, R, residual,
                                      ROWS, StepCoefficients, strains, substitute,
                                      update_section_forces)
from bristle_ros.report.precision.subjects import scene_of
from bristle_ros.simulation import new_scratch, viscosity_of
from bristle_ros.verbs import best_of, measure

CALLS = 300
TURNS = 40      # of so many the best
SCENES = ('S2', 'cutting_brush')
WHOLE = 'a whole step'
STEP = 2e-4     # [s]


def _kernels(simulation):
    """Return {kernel: (what calls it, its call with nodes, blocks and elements)}."""
    model, state, scratch = simulation.model, simulation.state, new_scratch(simulation.model)
    section, scheme = model.section, model.scheme
    mids, chain = state.mids[0].copy(), state.chain[0].copy()
    chain[:, CORNER:] = 0.0
    ca, cv = 1.0 / (scheme.beta * STEP ** 2), scheme.gamma / (scheme.beta * STEP)
    frame = scratch.frames[2]
    own_frame(model, state.motion, model.azimuth[0], 0.1, scratch, frame)
    clamp, step = frame[CLAMP:], StepCoefficients(
        h=STEP, ca=ca, cv=cv, keep=0.0, drift=STEP, factor=1.0, mass_factor=ca, gain=0.5)
    kernels = {
        'eliminate': ('iteration', lambda s, blocks, elements: eliminate(
            s, elements, mids, chain)),
        'substitute': ('iteration', lambda s, blocks, elements: substitute(
            s, elements, mids, chain)),
        'move nodes': ('iteration', lambda s, blocks, elements: move_nodes(
            s, blocks, section.element_length)),
        'internal forces': ('iteration', lambda s, blocks, elements: internal_forces(
            s, blocks, clamp, section, 1.0, 1.0)),
        'excess of section forces': ('iteration', lambda s, blocks, elements: add_excess(
            s, mids)),
        'update section forces': ('iteration', lambda s, blocks, elements: update_section_forces(
            s, mids, section, 1.0)),
        'residual': ('iteration', lambda s, blocks, elements: residual(
            s, blocks, ca, cv, 0.1, frame)),
        'factorise': ('matrix', lambda s, blocks, elements: factorise(
            s, elements, section, step, frame, mids, chain, scratch.work)),
        'begin step': ('step', lambda s, blocks, elements: begin_step(
            s, blocks, STEP, scheme, 0.0, 0.0)),
        'accept step': ('step', lambda s, blocks, elements: accept_step(
            s, blocks, STEP, scheme)),
        'local error': ('step', lambda s, blocks, elements: local_error(
            s, max(elements, 1), STEP, scheme, (0.0, 0.0, 0.0))),
    }
    viscosity = viscosity_of(simulation.scene)
    if viscosity:
        kernels |= {
            'predict damping': ('step', lambda s, blocks, elements: predict_damping(
                s, blocks, section, viscosity, cv, 0.0, STEP)),
            'strains': ('step', lambda s, blocks, elements: strains(
                s, blocks, clamp, section.element_length)),
            'accept damping': ('step', lambda s, blocks, elements: accept_damping(
                s, blocks, cv, 0.0, STEP, ca, 0.0, 0.0))}
    return kernels


def _times(simulation):
    """Return [(kernel, what calls it, time of a call [us], less that with no nodes)]."""
    return [(kernel, place, _time_of(simulation, call))
            for kernel, (place, call) in _kernels(simulation).items()]


def _time_of(simulation, call):
    """Return the time of a call, less that with no nodes [us]."""
    elements, blocks = simulation.model.elements, simulation.model.blocks
    # its own copy: what other kernels leave behind may be no numbers, and factorising those stops
    nodes = simulation.state.nodes[0].copy()
    # no residual, no increment: repeated calls lead nowhere
    nodes.reshape(blocks, ROWS, LANES)[:, R:R + 6] = 0.0

    def often(*arguments):
        for _ in range(CALLS):
            call(*arguments)
    full, _ = best_of(lambda: often(nodes, blocks, elements), TURNS)
    empty, _ = best_of(lambda: often(nodes[:0], 0, 0), TURNS)
    return 1e6 * (full - empty) / CALLS


def profile(name, duration, repeats):
    """Return rows: time of a call, calls and time in a step of each kernel; in a worker."""
    from bristle_ros.simulation import Simulation
    simulation = Simulation(scene_of(name, STEP))
    found = measure(simulation, duration, repeats)
    counts = simulation.state.counts[0] / found['steps']
    often = {'step': 1.0, 'iteration': counts[NEWTON], 'matrix': counts[FACTORISATIONS]}
    left, rows = found['step_us'], []
    for kernel, place, each in _times(simulation):
        calls = float(often[place])
        left -= each * calls
        rows.append({'scene': name, 'kernel': kernel, 'call_us': each,
                     'calls_per_step': calls, 'step_us': each * calls})
    rows.append({'scene': name, 'kernel': 'contact, frames and the loops', 'step_us': left})
    rows.append({'scene': name, 'kernel': WHOLE, 'step_us': found['step_us']})
    return [{**row, 'share': 100.0 * row['step_us'] / found['step_us']} for row in rows]
