"""What the bits of a run depend on besides its scene: the target and the versions."""
from importlib import metadata
from pathlib import Path
import platform

from bristle_ros import __version__
from bristle_ros.target import target

_PACKAGES = ('numba', 'llvmlite', 'numpy')


def _package_version(name):
    try:
        return metadata.version(name)
    except metadata.PackageNotFoundError:
        return 'not installed'


def _processor():
    """
    Return the processor's model and its vector instructions.

    The marketing name alone is not enough: virtual machines give one name to several generations.
    """
    fields = {}
    try:
        for line in Path('/proc/cpuinfo').read_text().splitlines():
            key, _, value = line.partition(':')
            fields.setdefault(key.strip(), value.strip())
    except OSError:
        pass
    name = fields.get('model name') or platform.processor() or platform.machine()
    for key in ('cpu family', 'model', 'stepping'):
        if key in fields:
            name += f', {key} {fields[key]}'
    flags = sorted(flag for flag in fields.get('flags', '').split()
                   if flag.startswith(('avx', 'fma')))
    return f'{name}, {" ".join(flags)}' if flags else name


def provenance():
    """
    Return what could change the bits of a run as text -> text: `target`, and versions by name.

    What kernels are compiled for, not the processor: others of that target give the same bits.
    """
    return {'target': target(), 'bristle_ros': __version__,
            **{name: _package_version(name) for name in _PACKAGES},
            'libc': ' '.join(platform.libc_ver()).strip() or 'unknown',  # its sine and cosine
            'python': platform.python_version()}


def measured_on():
    """Return what a time depends on, as text -> text: `cpu`, and what `provenance` says."""
    return {'cpu': _processor(), **provenance()}


def differences(logged, here):
    """Return one text for each entry in which `logged` differs, but for the Python version."""
    return [f'{name}: log {logged[name]}, here {here[name]}' for name in here
            if name != 'python' and name in logged and logged[name] != here[name]]
