"""Axial stress in a wire at its clamp, and how long it lasts under that."""
import math

from bristle_ros.scene import brush_rows
import numpy as np
import rainflow

CORNERS = ((1.0, 1.0), (1.0, -1.0), (-1.0, -1.0), (-1.0, 1.0))     # of y and z


def clamp_stress(history, scene):
    """
    Return the axial stress at the four corners of the section at the clamp [Pa]: (n, B, 4).

    The force F and moment M of the wire on the board are the section's resultants there, damping
    included; shear and torsion are left out. In section axes (x along the wire, y along t1, z
    along t2; undeformed as `tip_orientation` has them, at the clamp turned by gamma about x)

        sigma = F_x / A + M_y z / I_y - M_z y / I_z,  I_y = t1 t2^3 / 12,  I_z = t2 t1^3 / 12.

    Source: Euler-Bernoulli bending, Timoshenko, Strength of Materials I (1955), art. 23, 47.
    """
    t1, t2 = scene.bristle.breadth, scene.bristle.width
    azimuth, lean, turn = np.array([
        (azimuth, row.angle, row.orientation)
        for row in brush_rows(scene) for azimuth in row.azimuths]).T[..., None]
    c, s = np.cos(azimuth), np.sin(azimuth)
    radial, tangential, axial = (np.hstack(parts) for parts in (
        (c, s, 0 * c), (-s, c, 0 * c), (0 * c, 0 * c, 1 + 0 * c)))
    sine, cosine = np.sin(lean), np.cos(lean)
    x = sine * radial - cosine * axial
    z0 = cosine * radial + sine * axial
    turn_c, turn_s = np.cos(turn), np.sin(turn)
    y = turn_c * tangential + turn_s * z0
    z = turn_c * z0 - turn_s * tangential
    along = np.einsum('nbi,bi->nb', history.mount_force, x) / (t1 * t2)
    about_y = np.einsum('nbi,bi->nb', history.mount_moment, y) * 6.0 / (t1 * t2 * t2)
    about_z = np.einsum('nbi,bi->nb', history.mount_moment, z) * 6.0 / (t2 * t1 * t1)
    return np.stack([along + up * about_y - side * about_z for side, up in CORNERS], axis=-1)


def life(stress, duration, fatigue):
    """
    Return the hours until the first wire breaks at its clamp; infinite where nothing alternates.

    stress [Pa] : (n, B, 4) over `duration` [s];  fatigue : (m, amplitude [Pa] at 1e6 cycles)
    Cycles are counted by rainflow (ASTM E1049-85), amplitudes a of range/2 cost 1e-6 (a / S)^m of
    a life each (Basquin's S-N line without a limit; Miner's sum). Mean stress is left out.
    """
    exponent, strength = fatigue
    worst = 0.0
    for series in stress.reshape(len(stress), -1).T:
        damage = sum(count * 1e-6 * (0.5 * extent / strength) ** exponent
                     for extent, count in rainflow.count_cycles(series))
        worst = max(worst, damage)
    return duration / 3600.0 / worst if worst > 0.0 else math.inf
