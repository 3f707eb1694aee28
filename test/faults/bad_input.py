#!/usr/bin/env python3
"""
Unusable input of every kind to every verb that takes it: one line and an exit code, no file lost.

Prints each broken promise, then counts: cases, tracebacks, exit codes, files lost.
"""
import argparse
from collections import Counter
import contextlib
import io
import os
from pathlib import Path
import subprocess
import sys
import tempfile
import traceback
from typing import NamedTuple

ROOT = Path(__file__).resolve().parents[2]
if __name__ == '__main__':
    sys.path[:0] = [str(ROOT)]

from bristle_ros.__main__ import main as command_line  # noqa: E402
from bristle_ros.scene.scene import keys  # noqa: E402

SMALL = (ROOT / 'test/small_brush.yaml').read_text()
SENSELESS = ('nan', 'inf', '-inf', '-1', '0', '1e400', 'two', '', '1e30', '0x10')
VALUES = ('.nan', '"text"', '[[1.0]]', '{a: 1}', '-1.0e+300', '1e999', '!!python/name:os.system x',
          '*a', '"', '[1.0, .nan]', '\x07', '99999999999999999999999')
FILES = {
    'empty': b'', 'blank': b' \n\n', 'bytes': bytes(range(256)), 'zeros': bytes(4096),
    'utf-16': SMALL.encode('utf-16'), 'latin-1': b'/**:\n  ros__parameters: {log: {path: "\xe9"}}',
    'list': b'- 1\n- 2\n', 'number': b'12\n', 'text': b'brush\n', 'null': b'null\n',
    'deep': b'[' * 5000, 'deep map': b'{a: ' * 3000, 'deep block': b'- ' * 3000 + b'1',
    'bomb': b'a: &a [1,1,1,1,1,1,1,1,1]\n' + b''.join(
        b'%c: &%c [%s]\n' % (c, c, b','.join([b'*%c' % (c - 1)] * 9)) for c in range(98, 112)),
    'cycle': b'/**: &a\n  ros__parameters: *a\n', 'unknown anchor': b'/**: *a\n',
    'tag': b'/**: !!python/object/apply:os.system ["true"]\n',
    'tab': b'/**:\n\tros__parameters: 1', 'no parameters': b'/**:\n  gravity: 1.0\n',
    'parameters a list': b'/**:\n  ros__parameters: [1]',
    'two documents': SMALL.encode() + b'---\n' + SMALL.encode(), 'json cut': b'{"/**": {"ros__par',
    'section a number': b'/**:\n  ros__parameters: {road: 3}\n',
    'section a list': b'/**:\n  ros__parameters: {road: [1]}\n',
    'key a list': b'/**:\n  ros__parameters: {[1]: 2}\n',
    'key a number': b'/**:\n  ros__parameters: {3: 2}\n',
    'unknown key': b'/**:\n  ros__parameters: {road: {depht: 1.0}}\n',
    'unknown section': b'/**:\n  ros__parameters: {raod: {penetration: 1.0}}\n',
    'another node': b'/other:\n  ros__parameters: {road: {penetration: 1.0}}\n',
    'merge': b'/**:\n  ros__parameters: {<<: 3}\n', 'long line': b'a' * 10**6,
    'long number': b'/**:\n  ros__parameters: {gravity: ' + b'9' * 10000 + b'}\n',
}
TABLES = {
    'bytes': bytes(range(256)), 'no number': b'a,cmd_vel,1,0,0\n', 'nan': b'nan,cmd_vel,1,0,0\n',
    'late': b'1e308,cmd_vel,1,0,0\n', 'before': b'-1,cmd_vel,1,0,0\n', 'topic': b'0,cmd_stop,1\n',
    'too few': b'0,cmd_vel,1\n', 'too many': b'0,cmd_brush_speed,1,2\n', 'one cell': b'0\n',
    'value nan': b'0,cmd_brush_speed,nan\n', 'value inf': b'0,cmd_vel,inf,0,0\n',
    'value huge': b'0,cmd_penetration,1e300\n', 'value text': b'0,cmd_brush_speed,fast\n',
    'fast': b'0,cmd_brush_speed,1e9\n', 'zeros': bytes(99), 'quote': b'0,"cmd_vel,1,0,0\n',
    'reset with a value': b'0,reset,1\n', 'long cell': b'0,' + b'c' * 200_000 + b',1\n',
    'long number': b'9' * 10000 + b',cmd_brush_speed,1\n', 'semicolons': b'0;cmd_vel;1;0;0\n',
}


class Case(NamedTuple):
    """One command line; `refused`: it must end with 2, else with any of its exit codes."""

    name: str
    arguments: tuple
    refused: bool = True


def scene_cases(place):
    """Scenes: every key with every kind of wrong value, files, and paths that are none."""
    good = place / 'good.yaml'
    for key in keys():
        for value in VALUES:
            if key.kind != 'str' or key.choices:
                fine = key.maximum == float('inf') and value[0] in '19'     # and it may be .inf
                yield Case(f'-p {key.name} {value}',
                           ('scene', good, '-p', f'{key.name}:={value}'), not fine)
    for text in ('', 'gravity', ':=', 'gravity:=', ':=1', 'gravity:=:=', '.:=1', 'a.b.c:=1',
                 'road:=1', '[]:=1', 'gravity.x:=1', ' :=1'):
        yield Case(f'-p {text!r}', ('scene', good, '-p', text))
    for name, content in FILES.items():
        (place / f'{name}.yaml').write_bytes(content)
        yield Case(f'scene {name}', ('scene', place / f'{name}.yaml'), False)
        yield Case(f'simulate {name}', ('simulate', place / f'{name}.yaml', '--duration', '3e-5'))
    for path in ('', '.', place, '/', 'a' * 300, 'a/' * 3000, '/proc/self/mem', '~nobody-here/x',
                 'none\n.yaml', '\udcff.yaml', '/dev/null/x'):
        for verb in ('scene', 'static', 'bench'):
            yield Case(f'{verb} path {str(path)[:20]!r}', (verb, path))
    for node in ('', '/', '//', 'a b', '\n', '/**', '9'):
        yield Case(f'--node {node!r}', ('scene', good, '--node', node), False)


def option_cases(place):
    """Options: numbers that make no sense, and what the parsers know."""
    good, log = place / 'good.yaml', place / 'good.mcap'
    for value in SENSELESS:
        for verb, option in (('simulate', '--duration'), ('simulate', '--sample'),
                             ('bench', '--duration'), ('bench', '--repeats')):
            more = ('--duration', '0.01') if option == '--sample' else ()
            yield Case(f'{verb} {option} {value}', (verb, good, *more, f'{option}={value}'))
        for option in ('--wall-limit', '--repeats', '--drawn', '--seed'):
            if option in ('--drawn', '--seed') and value == '0':
                continue
            yield Case(f'report {option} {value}', (
                'report', '--only', 'stability', '--output', place / 'report',
                f'{option}={value}'))
        yield Case(f'replay --rate {value}', ('replay', log, f'--rate={value}'))
        if value not in ('0', '1e30', 'inf', '1e400'):
            yield Case(f'plot --from {value}', ('plot', log, f'--from={value}'))
        if value not in ('1e30', 'inf', '1e400'):
            yield Case(f'plot --to {value}', ('plot', log, f'--to={value}'))
    yield Case('plot backwards', ('plot', log, '--from', '2', '--to', '1'))
    yield Case('plot after the end', ('plot', log, '--from', '1e30'))
    for verb in ('', 'simulat', '--verbose', '\udcff', 'scene\n'):
        yield Case(f'verb {verb!r}', (verb,))
    for verb in ('simulate', 'static', 'replay', 'recover', 'plot', 'bench', 'scene'):
        yield Case(f'{verb} alone', (verb,))
        yield Case(f'{verb} --nonsense', (verb, good, '--nonsense'))
        yield Case(f'{verb} extra', (verb, good, good, good))
    yield Case('node argument', ('brush_node', 'x'))
    yield Case('report --only', ('report', '--only', 'all'))


def command_cases(place):
    """Commands of an offline run."""
    run = ('simulate', place / 'good.yaml', '--duration', '0.01', '--commands')
    for name, content in TABLES.items():
        (place / f'{name}.csv').write_bytes(content)
        yield Case(f'commands {name}', (*run, place / f'{name}.csv'))
    for path in ('none.csv', 'none', place / 'good.yaml', '/dev/null/x.csv', 'none.mcap', '/',
                 'a' * 300 + '.csv', '~nobody-here/x.csv'):
        yield Case(f'commands {str(path)[:20]!r}', (*run, path))


def log_cases(place):
    """Logs that are cut, garbled, or none."""
    content = (place / 'good.mcap').read_bytes()
    logs = {'empty': b'', 'magic': content[:8], 'header': content[:40], 'text': SMALL.encode(),
            'zeros': bytes(9999), 'half': content[:len(content) // 2], 'tail': content[-9999:],
            'no end': content[:-30], 'gap': content[:999] + content[2999:],
            'zeros inside': content[:1500] + bytes(500) + content[2000:],
            'twice': content + content}
    for name, damaged in logs.items():
        (place / f'log {name}.mcap').write_bytes(damaged)
    (place / 'bag').mkdir(exist_ok=True)
    (place / 'bag' / 'metadata.yaml').write_bytes(b'[' * 99)
    (place / 'bad.npz').write_bytes(b'PK\x03\x04' + bytes(99))
    for name in (*(f'log {name}.mcap' for name in logs), 'bag', 'none.mcap', 'good.yaml',
                 'bad.npz'):
        for verb in (('replay', '--verify'), ('recover',), ('plot',)):
            yield Case(f'{" ".join(verb)} {name}', (verb[0], place / name, *verb[1:]), False)


def output_cases(place, existing):
    """Places where nothing can be written, and files that are there already."""
    good, log = place / 'good.yaml', place / 'good.mcap'
    run = ('simulate', good, '--duration', '0.01', '--output')
    for suffix in ('.npz', '.csv', '.mcap'):
        for path in (place / f'no/where{suffix}', f'/proc/x{suffix}',
                     place / f'good.yaml/x{suffix}', place / f'folder{suffix}', 'a' * 300 + suffix,
                     f'~nobody-here/x{suffix}', f'/dev/full/x{suffix}'):
            yield Case(f'output {str(path)[-20:]}', (*run, path))
    for path in ('', '.', 'x', 'x.txt', place, '.npz/', place / 'x.npz.gz'):
        yield Case(f'output {path}', (*run, path))
    for verb in ('plot', 'recover'):
        for path in (place / 'no/where.png', '/proc/x.mcap', place / 'good.yaml/x.png', log):
            yield Case(f'{verb} output {str(path)[-20:]}', (verb, log, '--output', path), False)
    for path in existing:
        yield Case(f'existing {path.name}, no such scene', (
            'simulate', place / 'none.yaml', '--duration', '1', '--output', path))
        yield Case(f'existing {path.name}, no such duration', (
            'simulate', good, '--duration', '-1', '--output', path))
        yield Case(f'existing {path.name}', (*run, path))
    for path in (place / 'good.yaml', '/proc/x', place / 'good.yaml/x'):
        yield Case(f'report to {path}', ('report', '--only', 'cost', '--output', path))


def prepare(place):
    """Make what the cases need; return the files that must outlive them."""
    (place / 'good.yaml').write_text(SMALL)
    for suffix in ('.npz', '.csv', '.mcap'):
        (place / f'folder{suffix}').mkdir()
    existing = [place / f'existing{suffix}' for suffix in ('.npz', '.csv', '.mcap')]
    for path in existing:
        path.write_bytes(b'years of work\n')
    with contextlib.redirect_stdout(io.StringIO()):
        command_line(['simulate', str(place / 'good.yaml'), '--duration', '0.05', '--output',
                      str(place / 'good.mcap')])
    return existing


def in_process(arguments):
    """Return exit code and stderr of a command line that is run here."""
    out, err = io.StringIO(), io.StringIO()
    with contextlib.redirect_stdout(out), contextlib.redirect_stderr(err):
        try:
            code = command_line(arguments)
        except SystemExit as left:
            code = left.code
        except Exception:   # of any kind: that is what is looked for
            return 1, traceback.format_exc()
    return code, err.getvalue()


def in_a_process(arguments):
    """Return exit code and stderr of a process."""
    done = subprocess.run([sys.executable, '-m', 'bristle_ros', *arguments], cwd=ROOT, text=True,
                          capture_output=True, errors='backslashreplace', timeout=600)
    return done.returncode, done.stderr


def problem_of(case, code, err):
    """Return what is wrong with an answer, or an empty text."""
    if 'Traceback' in err or 'Exception ignored' in err:
        return 'traceback: ' + err.strip().splitlines()[-1]
    if code not in ((2,) if case.refused else (0, 1, 2, 3)):
        return f'exit code {code}'
    if code == 2 and err.count('\n') != 1:
        return f'not one line: {err!r}'
    return ''


def run(place, every=0, step=1, show=print):
    """
    Do the cases in a folder of their own; return their counts.

    every : one of so many goes through a process; 0: none.  step : only each so manieth case
    """
    existing = prepare(place)
    cases = [*option_cases(place), *command_cases(place), *log_cases(place),
             *output_cases(place, existing), *scene_cases(place)][::step]
    kept = {path: path.read_bytes() for path in sorted(place.rglob('*')) if path.is_file()}
    counts, codes = Counter(), Counter()
    for number, case in enumerate(cases):
        arguments = [str(word) for word in case.arguments]
        real = every and number % every == 0 and '\0' not in ''.join(arguments)
        code, err = (in_a_process if real else in_process)(arguments)
        codes[code] += 1
        counts['cases'] += 1
        counts['processes'] += bool(real)
        problem = problem_of(case, code, err)
        if problem:
            counts['tracebacks'] += problem.startswith('traceback')
            counts['broken'] += 1
            show(f'{case.name}: {problem}')
        for path, content in kept.items():
            if not path.exists() or path.read_bytes() != content:
                counts['files lost'] += 1
                show(f'{case.name}: {path.name} is lost')
                path.write_bytes(content)
    return counts, codes


def main(arguments=None):
    """Run all; return the exit code."""
    parser = argparse.ArgumentParser(description=__doc__.strip().splitlines()[0])
    parser.add_argument('--every', type=int, default=12, help='one of so many in a process')
    options = parser.parse_args(arguments)
    with tempfile.TemporaryDirectory() as folder:
        os.chdir(folder)
        counts, codes = run(Path(folder).resolve(), options.every)
    print(f'{counts["cases"]} cases, {counts["processes"]} of them in processes of their own; '
          f'{counts["tracebacks"]} tracebacks, {counts["broken"]} broken promises; '
          f'{counts["files lost"]} files lost; exit codes '
          + ', '.join(f'{code}: {count}' for code, count in sorted(codes.items())))
    return 1 if counts['broken'] or counts['files lost'] else 0


if __name__ == '__main__':
    sys.exit(main())
