#!/usr/bin/env python3
"""
Draws what the tests of the controllers of examples/ have logged: draw_controllers.py FOLDER FILE.

    pytest test/node/test_controllers.py test/node/test_follow_kerb.py --basetemp FOLDER

The force that each holds, what it commands for that, and when it was killed.
"""
from pathlib import Path
import sys

ROOT = Path(__file__).resolve().parent.parent
sys.path[:0] = [str(ROOT), str(ROOT / 'test')]

from bristle_ros.log.recording import Recording  # noqa: E402
from bristle_ros.messages.encode import decode_command, TWIST_STAMPED  # noqa: E402
from matplotlib import pyplot as plt  # noqa: E402
from node import test_controllers, test_follow_kerb  # noqa: E402
import numpy as np  # noqa: E402


def log_of(folder, test):
    """Return the log that a test has left in pytest's folder."""
    [found] = Path(folder).glob(f'{test}*/run')
    return found


def sideways(log):
    """Return times [s] and speeds to the left [m/s] that were commanded."""
    its = Recording(log).integration_time_step
    return np.array([(entry.step * its, decode_command(TWIST_STAMPED, entry.message.data)[1])
                     for entry in Recording(log).entries() if entry.name == 'cmd_vel']).T


def draw(axes, title, force, wanted, width, commands, label):
    """Draw a force and its mean over `width` [s] over time, and commands on axes of their own."""
    times, forces = force
    count = round(width / (times[1] - times[0]))
    axes.plot(times, forces, color='0.8', linewidth=0.5, label='each chunk')
    axes.plot(times[count - 1:], np.convolve(forces, np.full(count, 1.0 / count), 'valid'),
              label=f'mean over {width:g} s')
    axes.axhline(wanted, color='black', linestyle='--', linewidth=0.8, label='asked for')
    axes.axvline(commands[0][-1], color='tab:red', linewidth=0.8, label='controller killed')
    axes.set(title=title, xlabel='t [s]', ylabel='force [N]',
             ylim=(min(0.0, 1.1 * np.quantile(forces, 0.01)), 1.2 * np.quantile(forces, 0.995)))
    axes.legend(loc='upper left', ncols=4, fontsize='small')
    other = axes.twinx()
    other.plot(*commands, color='tab:green', linewidth=1.0)
    other.set_ylabel(label, color='tab:green')


def main(folder, file):
    """Draw both."""
    figure, (upper, lower) = plt.subplots(2, figsize=(8.0, 7.0), layout='constrained')
    *force, commands = test_controllers.force_of(log_of(folder, 'test_the_force_is_found'))
    times, depths = commands.T
    draw(upper, 'hold_force.py: a lifted brush finds the road', force,
         test_controllers.WANTED, 0.2, (times, 1e3 * depths), 'commanded depth [mm]')
    log = log_of(folder, 'test_the_kerb_is_found')
    times, speeds = sideways(log)
    draw(lower, 'follow_kerb.py: side force along a kerb', test_follow_kerb.side_force(log)[:2],
         test_follow_kerb.WANTED, 0.5, (times, 1e3 * speeds), 'commanded speed to the left [mm/s]')
    figure.savefig(file, dpi=90)


if __name__ == '__main__':
    if len(sys.argv) != 3:
        sys.exit(__doc__.strip())
    main(*sys.argv[1:])
