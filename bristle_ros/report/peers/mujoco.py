"""
The scenes S1 to S5 in MuJoCo 4: its discrete elastic rod (a flex with a box section).

The rod is inextensible, integrated by the `discrete` integrator. It is solved in the rotating
frame, clamped to the world, which is MuJoCo's fastest case; frame forces, gravity and the contact
law are applied at each step. Vertices stand at half, one and a half ... elements, so that each
bends over one element; the first edge, half of it before the clamp, is held.
"""
import time

import numpy as np

from .scenes import BREADTH, E, LENGTH, NU, RHO, WIDTH


def version():
    """Return MuJoCo's version, or None where it is not installed or has no elastic rod."""
    try:
        import mujoco
    except ImportError:
        return None
    return mujoco.__version__ if int(mujoco.__version__.split('.')[0]) >= 4 else None


def _model(scene, elements, step):
    """Return the MjModel, and the free vertices' masses."""
    import mujoco
    h = LENGTH / elements
    # rod along x, breadth along y: its material frame has no better name
    places = [-0.5 * h, *(h * (0.5 + np.arange(elements))), LENGTH]
    points = ' '.join(f'{x:.17g} 0 0' for x in places)
    # the weak axis gets the geometric mean of both stiffnesses: a quarter of beta there is beta
    damping = scene.damping * WIDTH / BREADTH
    spec = mujoco.MjModel.from_xml_string(f"""
<mujoco>
  <option timestep="{step!r}" gravity="0 0 0" integrator="discrete" solver="Newton"
          tolerance="1e-12" iterations="50">
    <flag contact="disable"/>
  </option>
  <worldbody>
    <flexcomp name="rod" type="direct" dim="1" dof="full" mass="1" point="{points}"
              element="{' '.join(f'{i} {i + 1}' for i in range(len(places) - 1))}">
      <edge equality="true" solref="{2 * step!r} 1" solimp="0.9999 0.9999 0.001"/>
      <elasticity young="{E!r}" poisson="{NU!r}" damping="{damping!r}" section="box"
                  sectionsize="{0.5 * BREADTH!r} {0.5 * WIDTH!r}"/>
      <pin id="0 1"/>
    </flexcomp>
  </worldbody>
</mujoco>""")
    mass = np.diff([0.0, *(h * (1.0 + np.arange(elements - 1))), LENGTH - 0.25 * h, LENGTH])
    return spec, RHO * BREADTH * WIDTH * mass[1:]


def solve(scene, elements, step, *, sample=1e-3):
    """
    Solve a PeerScene; return (t, tip path in the brush frame, normal impulse [N s], wall [s]).

    elements : int;  step, sample : [s]
    Raises RuntimeError where values stop being finite. Wall time: stepping, forces included.
    """
    import mujoco
    model, mass = _model(scene, elements, step)
    bodies = [i for i in range(model.nbody) if model.body_dofnum[i] == 3]
    for body, share in zip(bodies, mass):
        scale = share / model.body_mass[body]
        model.body_mass[body] *= scale
        model.body_inertia[body] *= scale
    data = mujoco.MjData(model)
    mujoco.mj_setConst(model, data)
    turn = np.column_stack([scene.along, scene.across, np.cross(scene.along, scene.across)])
    dofs = np.array([model.body_dofadr[body] + np.arange(3) for body in bodies])
    places = np.array([model.jnt_qposadr[model.dof_jntid[dof]] for dof in dofs.ravel()])
    start = np.array(scene.clamp) + model.body_pos[bodies] @ turn.T
    every = max(1, round(sample / step))
    steps = round(scene.duration / step)
    times, path, impulse = [0.0], [start[-1].copy()], 0.0
    touch = scene.touching
    limits = mass[touch] / step
    still = scene.mean == 0.0 and not scene.contact
    if still:   # nothing changes with time: one constant load
        data.qfrc_applied[dofs] = mass[:, None] * (scene.field(0.0)[0] @ turn)
    began = time.perf_counter()
    for i in range(1, steps + 1):
        if still:
            mujoco.mj_step(model, data)
            if i % every == 0:
                times.append(i * step)
                path.append(start[-1] + turn @ data.qpos[places[-3:]])
            continue
        t = (i - 1) * step
        position = start + data.qpos[places].reshape(-1, 3) @ turn.T
        velocity = data.qvel[dofs] @ turn.T
        field, by_position, by_velocity = scene.field(t + 0.5 * step)
        force = mass[:, None] * (field + position @ by_position.T + velocity @ by_velocity.T)
        if scene.contact:
            # friction no larger than what stops a node in a step
            push, normal = scene.forces(t, position[touch], velocity[touch], limits)
            force[touch] += push
            impulse += float(normal.sum()) * step
        data.qfrc_applied[dofs] = force @ turn
        mujoco.mj_step(model, data)
        if i % every == 0:
            times.append(i * step)
            path.append(start[-1] + turn @ data.qpos[places[-3:]])
    wall = time.perf_counter() - began
    path = np.array(path)
    if not np.isfinite(path).all() or data.warning.number.any():
        raise RuntimeError('MuJoCo: the solution diverged')
    return np.array(times), path, impulse, wall

