"""
Independent theory: normal modes of the clamped bristle that turns freely, small deflections.

Tangential, strong plane: E I_s v'''' + rho A v_tt = -rho A (r + x sin phi) dw/dt; radial, weak
plane: E I_w u'''' + rho A u_tt = rho A cos phi (r + x sin phi) w^2 (gamma = 0). Solved by the
cantilever's modes; each modal equation is integrated exactly for a forcing that is linear between
close points.
"""
import math

from bristle_ros.report.peers.scenes import RPM
from bristle_ros.report.runs import run
from bristle_ros.scene import Bristle, Brush, Contact, Damping, Drive, Run, Scene, Solver
import numpy as np

MODES = 12
_BRISTLE, _BRUSH = Bristle(), Brush()


def wave_numbers(count):
    """Return the first roots of cos(k) cosh(k) = -1."""
    roots = []
    for n in range(count):
        k = (n + 0.5) * math.pi
        for _ in range(60):    # Newton on cos(k) + 1/cosh(k)
            value = math.cos(k) + 1.0 / math.cosh(k)
            k -= value / (-math.sin(k) - math.sinh(k) / math.cosh(k) ** 2)
        roots.append(k)
    return roots


def natural_frequencies(strong, count=MODES):
    """Return the natural frequencies [Hz] of a plane of the default bristle at rest."""
    b = _BRISTLE
    side = b.breadth if strong else b.width
    speed = math.sqrt(b.youngs_modulus * side ** 2 / (12.0 * b.density))    # sqrt(E I / rho A)
    return [k * k * speed / b.length ** 2 / (2.0 * math.pi) for k in wave_numbers(count)]


def modal_loads(count=MODES):
    """Return the load A_i of each mode [m], for shapes whose tip value is 2."""
    x = np.linspace(0.0, 1.0, 20_001)
    loads = []
    for k in wave_numbers(count):
        # 1 - sigma from its own expression: as a difference it would lose its digits
        small = (math.cos(k) + math.exp(-k) + math.sin(k)) / (math.cosh(k) + math.cos(k))
        shape = (0.5 * small * np.exp(k * x) + 0.5 * (2.0 - small) * np.exp(-k * x)
                 - np.cos(k * x) + (1.0 - small) * np.sin(k * x))
        shape *= np.sign(shape[-1])
        lever = _BRUSH.mount_radius + _BRISTLE.length * math.sin(_BRUSH.mount_angle) * x
        loads.append(float(np.trapezoid(lever * shape, x)))
    return loads


def deflections(times, speed, rate, beta, count=MODES):
    """
    Return the tip's tangential and radial deflection [m] at `times`.

    times : (n,) [s], equally spaced and fine;  speed, rate : (n,) w [rad/s], dw/dt [rad/s^2]
    beta : [s] stiffness-proportional damping
    Both planes have the same mode shapes, so that Coriolis forces couple mode to mode: those of
    the tangential swing on the radial one are kept, 2 w q' cos phi.
    """
    h = times[1] - times[0]
    lean = math.cos(_BRUSH.mount_angle)
    both = np.zeros((2, len(times)))
    for strong, weak, load in zip(natural_frequencies(True, count),
                                  natural_frequencies(False, count), modal_loads(count)):
        q, rate_of_q = _single(strong, beta, h, -load * rate)
        u, _ = _single(weak, beta, h, lean * (load * speed ** 2 + 2.0 * speed * rate_of_q))
        both += 2.0 * np.array([q, u])
    return both


def _single(frequency, beta, h, f):
    """Return q, q' of q'' + beta w^2 q' + w^2 q = f from rest, f linear between points."""
    w = 2.0 * math.pi * frequency
    zeta = 0.5 * beta * w
    if zeta >= 1.0:
        raise ValueError(f'beta_D = {beta:g} s overdamps the mode of {frequency:.4g} Hz')
    d = w * math.sqrt(1.0 - zeta * zeta)
    decay = math.exp(-zeta * w * h)
    c, s = math.cos(d * h), math.sin(d * h)
    a11, a12 = decay * (c + zeta * w / d * s), decay * s / d
    a21, a22 = -w * w * a12, decay * (c - zeta * w / d * s)
    q, v = 0.0, 0.0
    path, rates = np.zeros(len(f)), np.zeros(len(f))
    for i in range(1, len(f)):
        slope = (f[i] - f[i - 1]) / h
        # particular solution p0 + p1 t of a linear load
        p1 = slope / (w * w)
        p0 = f[i - 1] / (w * w) - 2.0 * zeta / w * p1
        e, g = q - p0, v - p1
        q = a11 * e + a12 * g + p0 + p1 * h
        v = a21 * e + a22 * g + p1
        path[i], rates[i] = q, v
    return path, rates


def _scene(profile, mean, alternating, frequency, beta, its=2e-4, elements=8):
    return Scene(contact=Contact(enabled=False), gravity=0.0,
                 damping=Damping(mass=0.0, stiffness=beta),
                 drive=Drive(profile=profile, mean_speed=mean, alternating_speed=alternating,
                             frequency=frequency),
                 solver=Solver(integration_time_step=its, elements=elements,
                               spectral_radius=0.95),
                 run=Run(chunk=0.01, sample=1e-3))


def against_modes(profile, beta=2e-5):
    """Return how far model and theory lie apart for a profile, small amplitudes; in a worker."""
    from bristle_ros.simulation import Simulation
    duration = 0.5
    scene = _scene(profile, 2.0 * RPM, 1.0 * RPM, 9.0, beta)
    path = run(scene, duration)
    # the drive as the model has it, at fine points
    fine = Simulation(scene)
    h = scene.solver.integration_time_step
    speed = [fine.snapshot().omega]
    for _ in range(round(duration / h)):
        fine.advance(1)
        speed.append(fine.snapshot().omega)
    times, speed = h * np.arange(len(speed)), np.array(speed)
    rate = _rate(profile, scene.drive, times, speed)
    exact = deflections(times, speed, rate, beta)[:, ::round(1e-3 / h)]
    rows = []
    for name, theory, mine in (('tangential', exact[0], path.tip[:, 1]),
                               ('radial', exact[1], (path.tip - path.tip[0]) @ _along())):
        scale = float(np.abs(theory).max())
        rows.append({'profile': profile, 'plane': name, 'largest_um': 1e6 * scale,
                     'deviation': 100 * float(np.abs(theory - mine).max()) / scale,
                     'series': (path.t.tolist(), (1e6 * theory).tolist(), (1e6 * mine).tolist())})
    return rows


def _along():
    """Return the direction of radial deflection: the section's thin side, outward."""
    phi = _BRUSH.mount_angle
    return np.array([math.cos(phi), 0.0, math.sin(phi)])


def _rate(profile, drive, times, speed):
    """Return dw/dt [rad/s^2]: exact for the sine, by central differences for VAP."""
    if profile == 'sine':
        w = 2.0 * math.pi * drive.frequency
        return drive.alternating_speed * w * np.cos(w * times)
    return np.gradient(speed, times)


def swing(profile, fraction, beta=1.1e-4):
    """
    Return the swing of the tip under a drive at a fraction of the strong plane's frequency.

    Swing in the tangent once the start has died away, divided by the quasi-static one of the same
    acceleration. beta 0.11 ms: 1 % of critical in mode 1. In a worker.
    """
    frequency = natural_frequencies(True, 1)[0] * fraction
    scene = _scene(profile, 2.0 * RPM, 1.0 * RPM, frequency, beta, 1e-3, 4)
    path = run(scene, 2.4, sample=3e-3)
    late = path.tip[path.t > 1.6, 1]
    b = scene.drive.shape
    peak = 2.0 * math.pi if profile == 'sine' else (
        4.0 * (1.0 - b * math.exp(-(1.0 - b) / b)) / (1.0 - b))
    # statics of the strong plane: 0.183 mm at the tip for 20.49 rad/s^2
    static = 0.183e-3 / 20.49 * peak * frequency * scene.drive.alternating_speed
    return {'profile': profile, 'f_over_f1': fraction, 'frequency_hz': frequency,
            'swing_over_static': 0.5 * float(np.ptp(late)) / static}


def fractions(quick):
    """Return the fractions of the first frequency at which a drive is tried."""
    near = (0.0,) if quick else (-0.006, 0.0, 0.006)
    return sorted({*np.round(np.linspace(0.14, 1.15, 12 if quick else 40), 4).tolist(),
                   *(1.0 / n + d for n in range(1, 9) for d in near)})


def on_and_off(rows, profile, n):
    """Return swing at f1/n over the mean swing half-way to its even neighbours."""
    points = [row for row in rows if row['profile'] == profile]

    def at(fraction):
        return min(points, key=lambda row: abs(row['f_over_f1'] - fraction))['swing_over_static']
    on = max(at(1.0 / n + d) for d in (-0.006, 0.0, 0.006))
    return on / (0.5 * (at(1.0 / (n - 1)) + at(1.0 / (n + 1)))) if n > 1 else on / at(0.5)


def frequencies_at(rpm, duration=4.0):
    """Return the first frequencies of both planes [Hz] at a spin, about the steady shape."""
    from bristle_ros.simulation import Simulation
    scene = Scene(contact=Contact(enabled=False), damping=Damping(mass=0.0),
                  drive=Drive(profile='constant', mean_speed=rpm * RPM, max_acceleration=10.0),
                  solver=Solver(integration_time_step=5e-4, elements=8, start='steady',
                                spectral_radius=0.95),
                  run=Run(chunk=0.01, sample=1e-3))
    simulation = Simulation(scene)
    # a small change of speed sets both planes swinging
    simulation.command('cmd_brush_speed', (rpm * RPM + 0.05,))
    count = round(duration / 2e-3)
    tip = np.empty((count, 3))
    for i in range(count):
        simulation.advance(4)
        tip[i] = simulation.snapshot().tip_position[0]
    return {'spin_rpm': rpm,
            'weak_hz': _peak_frequency((tip - tip.mean(axis=0)) @ _along(), 2e-3),
            'strong_hz': _peak_frequency(tip[:, 1] - tip[:, 1].mean(), 2e-3, 20.0)}


def _peak_frequency(signal, h, above=3.0):
    """Return the frequency of the largest line of a signal [Hz], interpolated between lines."""
    n = len(signal)
    spectrum = np.abs(np.fft.rfft(signal * np.hanning(n), 8 * n))
    frequencies = np.fft.rfftfreq(8 * n, h)
    spectrum[frequencies < above] = 0.0
    i = int(np.argmax(spectrum))
    a, b, c = np.log(spectrum[i - 1:i + 2])
    return float(frequencies[i] + 0.5 * (a - c) / (a - 2.0 * b + c) * frequencies[1])
