"""
Ctrl-C while modules are imported or kernels compiled: the process ends where it is.

Nothing can be lost then, and nothing else is certain to work: a KeyboardInterrupt that comes up in
a callback of the compiler is printed and forgotten, one inside LLVM waits until that returns.
"""
import os
import signal
import sys
import threading

_COMPILER = ('numba', 'llvmlite')
_OURS = __package__.partition('.')[0]


def is_loading(frame):
    """Whether a stack, from its innermost frame out, imports a module of ours or compiles."""
    while frame is not None:
        name = frame.f_globals.get('__name__') or ''
        package = name.partition('.')[0]
        if package in _COMPILER or (package == _OURS and frame.f_code.co_name == '<module>'):
            return True
        frame = frame.f_back
    return False


def is_compiling(thread):
    """Whether a thread imports a module of ours or compiles at the moment."""
    return is_loading(sys._current_frames().get(thread.ident))


def leave_while_loading(leave):
    """
    Have SIGINT call leave(), which does not return, while the main thread loads.

    At other times it raises KeyboardInterrupt, as ever. A thread looks as well, since a handler
    has to wait for the main thread to come back from compiled code.
    """
    once = threading.Lock()
    main = threading.main_thread()
    read, write = os.pipe()
    os.set_blocking(write, False)

    def take(number, frame):
        if is_loading(frame):
            with once:
                leave()
        raise KeyboardInterrupt

    def watch():
        while True:
            if signal.SIGINT in os.read(read, 64) and is_compiling(main):
                with once:
                    leave()

    signal.signal(signal.SIGINT, take)
    signal.set_wakeup_fd(write, warn_on_full_buffer=False)
    threading.Thread(target=watch, name='interrupt', daemon=True).start()
