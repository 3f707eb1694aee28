"""Builds a package of ROS interfaces for Python, with the generators that ROS's wheels bring."""
import os
from pathlib import Path
import shutil
import subprocess
import sys
import sysconfig

import numpy as np

PREFIX = Path(sys.prefix)
HEADERS = Path(sysconfig.get_paths()['include'])
GENERATED = (('types', 'c'), ('types', 'py'), ('typesupports', 'c'),
             ('typesupports', 'fastrtps_c'))
DEPENDENCIES = ('std_msgs', 'geometry_msgs', 'builtin_interfaces', 'service_msgs')
LINKED = ('generator_c', 'generator_py', 'typesupport_c', 'typesupport_fastrtps_c')


def can_build():
    """Whether there is a compiler, and what it includes."""
    return bool(shutil.which('g++') and (HEADERS / 'Python.h').exists()
                and (PREFIX / 'share/rosidl_generator_py').exists())


def build(source, folder):
    """
    Build the package whose .msg and .srv files lie in `source`; `folder` is then to be imported.

    All goes into one library, of the name by which ROS looks for the part that knows Fast DDS:
    loaded with the module, it is found without LD_LIBRARY_PATH.
    """
    name, package = source.name, folder / source.name
    package.mkdir(parents=True)
    _generate(source, package)
    (package / '__init__.py').touch()
    includes = [f'-I{path}' for path in (
        folder, HEADERS, np.get_include(), PREFIX / 'include', *(PREFIX / 'include').iterdir())]
    objects = []
    for compiler, pattern in (('gcc', '*.c'), ('g++', '*.cpp')):
        for path in sorted(package.rglob(pattern)):
            if '.ep.' not in path.name:
                objects.append(folder / f'{len(objects)}.o')
                _run(compiler, '-w', '-O0', '-fPIC', '-c', *includes, path, '-o', objects[-1])
    library = package / f'lib{name}__rosidl_typesupport_fastrtps_c.so'
    link = '-shared', f'-L{PREFIX / "lib"}', '-Wl,--allow-shlib-undefined'
    parts = ['rosidl_runtime_c', 'rosidl_typesupport_c', 'rosidl_typesupport_fastrtps_c',
             'rosidl_typesupport_fastrtps_cpp', 'fastcdr', 'rmw', 'rcutils']
    parts += [path.stem.removeprefix('lib') for other in DEPENDENCIES for path in sorted(
        (PREFIX / 'lib').glob(f'lib{other}__rosidl_*_*.so')) if path.stem.endswith(LINKED)]
    _run('g++', *link, *objects, *(f'-l{part}' for part in parts), f'-Wl,-soname,{library.name}',
         '-o', library)
    _run('gcc', '-w', '-fPIC', *includes, *link, package / f'_{name}_s.ep.rosidl_typesupport_c.c',
         '-Wl,--no-as-needed', library, '-Wl,-rpath,$ORIGIN',
         '-o', package / f'{name}_s__rosidl_typesupport_c.so')
    return folder


def _generate(source, package):
    """Write the code in C, C++ and Python, each in a process of its own: they share no state."""
    names = [str(path.relative_to(source)) for path in sorted(source.rglob('*'))
             if path.suffix in ('.msg', '.srv')]
    _run(sys.executable, '-c', f"""
from pathlib import Path
from rosidl_adapter.msg import convert_msg_to_idl
from rosidl_adapter.srv import convert_srv_to_idl
for name in map(Path, {names!r}):
    convert = convert_msg_to_idl if name.suffix == '.msg' else convert_srv_to_idl
    (Path({str(package)!r}) / name.parent).mkdir(exist_ok=True)
    convert(Path({str(source)!r}), {source.name!r}, name, Path({str(package)!r}) / name.parent)
""")
    files = [f'{package}:{Path(name).with_suffix(".idl")}' for name in names]
    for kind, target in GENERATED:
        _run(sys.executable, '-c', f"""
from importlib import metadata
from pathlib import Path
# the wheels tell of each generator twice, which rosidl refuses
found = metadata.EntryPoints(dict.fromkeys(
    point for one in metadata.distributions() for point in one.entry_points))
metadata.entry_points = lambda: found
from rosidl_cli.command.generate.api import generate
generate(package_name={source.name!r}, interface_files={files!r},
         include_paths=[{str(PREFIX / 'share')!r}], output_path=Path({str(package)!r}),
         {kind}=[{target!r}])
""")


def _run(*command):
    done = subprocess.run([str(part) for part in command], capture_output=True, text=True,
                          env={**os.environ, 'AMENT_PREFIX_PATH': str(PREFIX)})
    assert done.returncode == 0, f'{" ".join(map(str, command))}\n{done.stdout}{done.stderr}'
