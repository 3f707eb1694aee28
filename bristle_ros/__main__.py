"""
The command line: `python3 -m bristle_ros VERB ...`, and the executables that ROS 2 finds.

Each verb parses its own arguments, in the module that does it. That module is imported only then,
so that `--help`, `--version` and `scene --keys` need neither numba nor ROS.
"""
import errno
from importlib import import_module
import os
import signal
import sys

if __name__ == '__main__' and signal.getsignal(signal.SIGINT) is signal.default_int_handler:
    signal.signal(signal.SIGINT, signal.SIG_DFL)    # until `run` can answer with one line

from bristle_ros import __version__
from bristle_ros.command_line import leave_while_loading
from bristle_ros.scene import SceneError

# The one table of commands: verb, module whose main(arguments) does it, what it does. setup.py and
# `run.sh --help` read it as text, so it is a literal.
VERBS = {
    'brush_node': ('node.brush_node',
                   'the ROS 2 node: steps the brush, subscribes, publishes, logs'),
    'simulate': ('verbs.simulate', 'run a scene as fast as it goes and write what happened'),
    'static': ('verbs.static', "a scene's static equilibrium"),
    'replay': ('verbs.replay', 'publish a log again, or verify it by simulating it again'),
    'recover': ('verbs.recover', 'make a complete log out of one that was cut off'),
    'plot': ('plot.main', 'draw a log, or the arrays of simulate, to one page of figures'),
    'report': ('report.main',
               'accuracy against run time, stability, cost of each feature: a page'),
    'view': ('view.main', 'a page with the brush in 3-D, its forces, and controls'),
    'study': ('study.main', 'many runs of a scene: sweeps, sensitivities, optima; a page'),
    'fit': ('study.fit', 'find parameters of a scene from measured rows'),
    'compare': ('study.compare', 'lay a measured time series over a simulated one'),
    'bench': ('verbs.bench', "a scene's run times, as JSON"),
    'compile': ('verbs.compile', 'compile what scenes need, so that they start at once'),
    'scene': ('verbs.scene', 'list every key of a scene, or check a scene file'),
}
DONE, CHECK_FAILED, UNUSABLE_INPUT, COULD_NOT_GO_ON = 0, 1, 2, 3
INTERRUPTED = 130  # what shells give for SIGINT
# Errors known by name, since the module that defines them is heavy to import.
_CODES = {'StepFailure': COULD_NOT_GO_ON, 'CommandRefused': UNUSABLE_INPUT,
          'CompilerRefused': UNUSABLE_INPUT}


def main(arguments=None):
    """Run the verb that the command line names; return the exit code."""
    ours = arguments is None    # the process: else we are called from within another program
    arguments = sys.argv[1:] if ours else list(arguments)
    verb = arguments[0] if arguments else ''
    if ours:
        _begin(verb if verb in VERBS else 'bristle_ros')
    if verb in VERBS:
        return run(verb, arguments[1:])
    return _guarded('bristle_ros', lambda: _general(verb))


def _general(verb):
    if verb in ('-h', '--help'):
        print(_help())
        return DONE
    if verb == '--version':
        print(f'bristle_ros {__version__}')
        return DONE
    import difflib  # here: what it imports would be in the way of Ctrl-C
    near = difflib.get_close_matches(verb, VERBS, 1) or ['--help']
    wrong = f'{verb!r} is no verb, did you mean {near[0]}?' if verb else 'no verb'
    raise SceneError(f'{wrong} (--help lists them)')


def run(verb, arguments):
    """Do one verb; turn what can go wrong into one line on stderr and an exit code."""
    return _guarded(verb, lambda: import_module(f'.{VERBS[verb][0]}', __package__).main(arguments))


def _guarded(verb, do):
    try:
        try:
            code = do()
        except SystemExit:  # argparse, once it has answered
            _flush()
            raise
        _flush()
        return DONE if code is None else code
    except SceneError as error:
        return _fail(verb, error, UNUSABLE_INPUT)
    except KeyboardInterrupt:
        return _fail(verb, 'interrupted', INTERRUPTED)
    except BrokenPipeError:
        _forget_output()    # whoever read us (head, less) has gone
        return DONE
    except ModuleNotFoundError as error:
        if error.name and error.name.partition('.')[0] == __package__:
            raise
        return _fail(verb, f'needs the Python package {error.name!r}, which is not installed: '
                     'see README.md, Installing', UNUSABLE_INPUT)
    except OSError as error:
        place = f'{error.filename}: ' if error.filename else ''
        if not place and (error.errno == errno.EBADF or not _flushed()):
            place = 'stdout: '
        return _fail(verb, f'{place}{error.strerror or error}', UNUSABLE_INPUT)
    except (RuntimeError, ValueError) as error:
        code = _CODES.get(type(error).__name__)
        if code is None and str(error).startswith('Could not determine home'):
            error, code = 'a path begins with ~ and there is no such home', UNUSABLE_INPUT
        if code is None:
            raise
        return _fail(verb, error, code)


def _flush():
    if sys.stdout is not None:
        sys.stdout.flush()


def _flushed():
    """Whether all that was printed could be written; if not, it is forgotten."""
    try:
        _flush()
    except OSError:
        _forget_output()
        return False
    return True


def _forget_output():
    """Keep the interpreter from complaining at exit about output that cannot be written."""
    os.dup2(os.open(os.devnull, os.O_WRONLY), sys.stdout.fileno())


def _begin(verb):
    """Set up a process that is ours alone: its streams, and Ctrl-C."""
    _fill_closed_streams()
    for stream in (sys.stdout, sys.stderr):
        # what the terminal has no letter for, a name of a file say, is written as an escape
        stream.reconfigure(errors='backslashreplace')
    if signal.getsignal(signal.SIGINT) in (signal.SIG_DFL, signal.default_int_handler):
        leave_while_loading(lambda: os._exit(_fail(verb, 'interrupted', INTERRUPTED)))


def _fill_closed_streams():
    """Put something where a stream is closed, or the next file that is opened takes its place."""
    for number, name, mode in ((0, 'stdin', 'r'), (1, 'stdout', 'w'), (2, 'stderr', 'w')):
        if getattr(sys, name) is not None:
            continue
        # What is printed must not get lost without a word: writing to a closed stdout fails.
        flags = os.O_RDWR if number == 2 else os.O_RDONLY
        given = os.open(os.devnull, flags)
        if given != number:
            os.dup2(given, number)
            os.close(given)
        setattr(sys, name, open(number, mode, closefd=False))  # noqa: SIM115


def _fail(verb, message, code):
    line = ' '.join(str(message).split())
    _flushed()
    print(f'{verb}: {line}', file=sys.stderr, flush=True)
    return code


def _help():
    verbs = '\n'.join(f'  {verb:<12}{does}' for verb, (_, does) in VERBS.items())
    return f"""usage: python3 -m bristle_ros VERB ... | --help | --version

A rotating brush of flexible bristles on a road, for ROS 2 and without it.

verbs ('VERB --help' tells the arguments of each):
{verbs}

exit codes: 0 done, 1 a check failed, 2 unusable input, 3 the simulation could not go on"""


def _entry_point(verb):
    """Make the function that the executable of a verb calls."""
    def entry_point():
        _begin(verb)
        return run(verb, sys.argv[1:])
    return entry_point


globals().update({verb: _entry_point(verb) for verb in VERBS})

if __name__ == '__main__':
    sys.exit(main())
