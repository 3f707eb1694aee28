"""
Kelvin-Voigt damping of the strains: stress = C (strain + beta_D * rate).

The rate follows the strain by the integrator's own recursion,

    rate = cv (strain - strain0) + keep * rate0 + drift * rateacc0,

not through nodal velocities: for small strain that is beta_D K v, a rigid rotation gives exactly
none at any step size, and contact stays passive (test_passivity.py).
"""
from bristle_ros.physics.compiler import jit, load8, store8

from .beam import gather_left_nodes, interpolate, point, stiffness
from .layout import LANES, RATE0, RATEACC0, STRAIN, STRAIN0, STRAIN_BEFORE, STRESS0


@jit
def strains(s, blocks, clamp, element_length):
    """
    Fill the strains at the present positions, and no forces; see beam.py.

    s : (blocks, BLOCK), clamp : (7,) position and quaternion of the clamped node
    """
    gather_left_nodes(s, blocks, clamp)
    for j in range(blocks):
        interpolate(s, j, element_length)
        for i in range(LANES):
            _, _, (_, k1, k2, k3), _, (c1, c2, c3) = point(s, j, i)
            s[j, STRAIN * LANES + i] = c1 - 1.0
            s[j, (STRAIN + 1) * LANES + i] = c2
            s[j, (STRAIN + 2) * LANES + i] = c3
            s[j, (STRAIN + 3) * LANES + i] = 2.0 * k1
            s[j, (STRAIN + 4) * LANES + i] = 2.0 * k2
            s[j, (STRAIN + 5) * LANES + i] = 2.0 * k3


@jit
def predict_damping(s, blocks, section, viscosity, cv, keep, drift):
    """
    Put what the strain rate's history gives into STRESS0.

    viscosity [s] : float     beta_D
    cv [1/s], keep, drift [s] : float
    """
    c = stiffness(section)
    for j in range(blocks):
        r = s[j]
        for row in range(6):
            scale = viscosity * c[row]
            store8(r, (STRESS0 + row) * LANES,
                   (scale * keep) * load8(r, (RATE0 + row) * LANES)
                   + (scale * drift) * load8(r, (RATEACC0 + row) * LANES)
                   - (scale * cv) * load8(r, (STRAIN0 + row) * LANES))


@jit
def accept_damping(s, blocks, cv, keep, drift, ca, keep_acc, drift_acc):
    """Carry strain, its rate and the rate's own acceleration over; STRAIN is that of the end."""
    for j in range(blocks):
        r = s[j]
        for row in range(6):
            strain = load8(r, (STRAIN + row) * LANES)
            change = strain - load8(r, (STRAIN0 + row) * LANES)
            rate, acceleration = load8(r, (RATE0 + row) * LANES), load8(
                r, (RATEACC0 + row) * LANES)
            store8(r, (RATE0 + row) * LANES, cv * change + keep * rate + drift * acceleration)
            store8(r, (RATEACC0 + row) * LANES,
                   ca * change - keep_acc * rate - drift_acc * acceleration)
            store8(r, (STRAIN0 + row) * LANES, strain)


@jit
def keep_strains(s):
    """Keep the strains that an integration step begins with: its mean rate follows from them."""
    for j in range(s.shape[0]):
        for row in range(6):
            store8(s[j], (STRAIN_BEFORE + row) * LANES, load8(s[j], (STRAIN0 + row) * LANES))
