#!/usr/bin/env python3
"""
Draw one-token mutants of the kernels and see which ones the tests catch.

    tools/mutate.py --count 100 --seed 7 [--files 'contact/*.py'] [--compiled]

A mutant is a copy of package and tests, in a folder of its own that is removed afterwards, with
one token of one kernel changed: an operator, a constant by one (a small one by ten), a name for a
sibling such as x1 for x2, or axis y for z. First come the tests that run without the compiler, in
seconds; `--compiled` gives survivors to those of the compiled kernels as well, which takes minutes
each. What takes longer than --limit is caught: it does not end. The same seed draws the same
mutants of the same source. Exit code 1 where one survives.
"""
import argparse
import ast
from fnmatch import fnmatch
import os
from pathlib import Path
import random
import re
import resource
import shutil
import signal
import subprocess
import sys
import tempfile
import time
import traceback
from typing import NamedTuple

ROOT = Path(__file__).resolve().parent.parent
KERNELS = ROOT / 'bristle_ros' / 'physics'
# tests that run without the compiler; the most telling ones for a room come first
BEAM, FORCE, MOTION, CONTACT = (
    'test/physics/wire/test_beam.py', 'test/physics/wire/test_section_force.py',
    'test/physics/motion', 'test/physics/contact/test_bracket.py')
STEPS, COSTS, HALVES, STATIC, CURVED = (f'test/physics/interpreted/test_{name}.py' for name in (
    'motion', 'costs', 'substeps', 'equilibrium', 'curved'))
INTERPRETED = {
    'contact': (COSTS, STEPS, CONTACT, CURVED, HALVES, STATIC, BEAM, FORCE, MOTION),
    'motion': (MOTION, STEPS, HALVES, STATIC, COSTS, BEAM, FORCE, CONTACT),
    'step': (STEPS, COSTS, HALVES, STATIC, FORCE, BEAM, MOTION, CONTACT),
    'wire': (BEAM, FORCE, STEPS, COSTS, HALVES, STATIC, MOTION, CONTACT)}
PATIENCE = 20   # wall time per limit of processor time, before a child is ended: it may sleep
COMPILED = ('test/physics/step', 'test/physics/contact/test_runs.py', 'test/physics/wire')
SIGNS = {'Add': ('+', '-'), 'Sub': ('-', '+'), 'Mult': ('*', '/'), 'Div': ('/', '*'),
         'Pow': ('**', '*'), 'Mod': ('%', '*'), 'FloorDiv': ('//', '*'), 'LShift': ('<<', '>>'),
         'RShift': ('>>', '<<'), 'Lt': ('<', '<='), 'LtE': ('<=', '<'), 'Gt': ('>', '>='),
         'GtE': ('>=', '>'), 'Eq': ('==', '!='), 'NotEq': ('!=', '=='), 'And': ('and', 'or'),
         'Or': ('or', 'and')}
PAIRS = {'near': 'far', 'far': 'near', 'left': 'right', 'right': 'left', 'start': 'end',
         'end': 'start', 'cos': 'sin', 'sin': 'cos', 'min': 'max', 'max': 'min', 'c': 's'}


class Mutant(NamedTuple):
    """One changed token: file under the kernels, offset in its text, old and new token."""

    path: str
    line: int
    at: int
    old: str
    new: str


class Sites(ast.NodeVisitor):
    """Collects the tokens of a module that can be changed, and what into."""

    def __init__(self, text):
        """Read the module."""
        self.text = text
        lines = text.splitlines(keepends=True)
        self.starts = [0]
        for line in lines:
            self.starts.append(self.starts[-1] + len(line))
        self.names = set()
        self.found = []     # (offset, old, [new ...])
        for node in ast.parse(text).body:
            if isinstance(node, (ast.FunctionDef, ast.Assign)):
                self.names = {name.id for name in ast.walk(node) if isinstance(name, ast.Name)}
                self.names |= {name.arg for name in ast.walk(node) if isinstance(name, ast.arg)}
                self.visit(node)

    def offset(self, node, end=False):
        """Return where a node starts or ends; source is ASCII."""
        line, column = ((node.end_lineno, node.end_col_offset) if end
                        else (node.lineno, node.col_offset))
        return self.starts[line - 1] + column

    def sign(self, left, right, operator):
        """Add the operator between two nodes."""
        old, new = SIGNS.get(type(operator).__name__, (None, None))
        if old is None:
            return
        first = self.offset(left, end=True)
        between = re.sub(r'#[^\n]*', lambda note: ' ' * len(note[0]),
                         self.text[first:self.offset(right)])
        self.found.append((first + between.index(old), old, [new]))

    def visit_FunctionDef(self, node):
        """Leave decorators and the docstring alone."""
        body = node.body[1:] if ast.get_docstring(node) else node.body
        for child in body:
            self.visit(child)

    def visit_BinOp(self, node):
        """Take + - * / and their like."""
        self.sign(node.left, node.right, node.op)
        self.generic_visit(node)

    def visit_AugAssign(self, node):
        """Take += and its like."""
        self.sign(node.target, node.value, node.op)
        self.generic_visit(node)

    def visit_Compare(self, node):
        """Take comparisons, chained ones too."""
        for left, operator, right in zip([node.left, *node.comparators], node.ops,
                                         node.comparators):
            self.sign(left, right, operator)
        self.generic_visit(node)

    def visit_BoolOp(self, node):
        """Take and, or."""
        for left, right in zip(node.values, node.values[1:]):
            self.sign(left, right, node.op)
        self.generic_visit(node)

    def visit_UnaryOp(self, node):
        """Take a leading minus, and drop `not`."""
        if isinstance(node.op, ast.USub):
            self.found.append((self.offset(node), '-', ['+']))
        elif isinstance(node.op, ast.Not):
            self.found.append((self.offset(node), 'not ', ['']))
        self.generic_visit(node)

    def visit_Constant(self, node):
        """Take numbers and truth values."""
        old = self.text[self.offset(node):self.offset(node, end=True)]
        if isinstance(node.value, bool):
            new = [str(not node.value)]
        elif isinstance(node.value, int):
            new = [str(node.value + 1)] + [str(node.value - 1)] * (node.value > 0)
        elif isinstance(node.value, float):
            small = 0.0 < node.value < 0.01
            new = [repr(value) for value in (
                (node.value * 10.0, node.value / 10.0) if small
                else (node.value + 1.0, node.value - 1.0))]
        else:
            return
        self.found.append((self.offset(node), old, new))

    def visit_Name(self, node):
        """Take a name for a sibling that the function has."""
        new = self.siblings(node.id)
        if isinstance(node.ctx, ast.Load) and new:
            self.found.append((self.offset(node), node.id, new))

    def siblings(self, name):
        """Return names of this function that differ in a digit, and the partners of PAIRS."""
        found = [other for other in self.names if other != name
                 and re.sub(r'\d', '', other) == re.sub(r'\d', '', name)
                 and sum(a != b for a, b in zip(other, name)) == 1 and len(other) == len(name)]
        if PAIRS.get(name) in self.names:
            found.append(PAIRS[name])
        return sorted(found)

    def visit_Attribute(self, node):
        """Take .bending_y for .bending_z, .mount_x for .mount_y."""
        self.generic_visit(node)
        swap = {'_y': '_z', '_z': '_y'} if not node.attr.startswith('mount') else {
            '_x': '_y', '_y': '_x'}
        if node.attr[-2:] in swap:
            at = self.offset(node, end=True) - 2
            self.found.append((at, node.attr[-2:], [swap[node.attr[-2:]]]))


def draw(count, seed, pattern):
    """Return `count` mutants of the kernels in the files that match."""
    sites = []
    for path in sorted(KERNELS.rglob('*.py')):
        name = path.relative_to(KERNELS).as_posix()
        if fnmatch(name, pattern) and not name.startswith('compiler/') and (
                path.name != '__init__.py'):
            text = path.read_text()
            sites += [(name, text.count('\n', 0, at) + 1, at, old, new)
                      for at, old, new in sorted(Sites(text).found)]
    generator = random.Random(seed)
    drawn = generator.sample(sites, min(count, len(sites)))
    return [Mutant(*site, generator.choice(new)) for *site, new in drawn], len(sites)


def keep(folder):
    """Copy package and tests as they are now into a folder: an edit must not meet a long run."""
    for name in ('bristle_ros', 'test', 'config'):
        shutil.copytree(ROOT / name, folder / name, ignore=shutil.ignore_patterns('__pycache__'))
    shutil.copy(ROOT / 'pyproject.toml', folder)


def make(source, folder, mutant):
    """Link to what `keep` kept and change the token."""
    shutil.copytree(source, folder, dirs_exist_ok=True, copy_function=os.link)
    path = folder / KERNELS.relative_to(ROOT) / mutant.path
    text = path.read_text()
    assert text[mutant.at:].startswith(mutant.old)
    path.unlink()
    path.write_text(text[:mutant.at] + mutant.new + text[mutant.at + len(mutant.old):])


class First:
    """A plugin of pytest that writes down the first test that fails."""

    def __init__(self, path):
        """Keep the path."""
        self.path = path

    def pytest_runtest_logreport(self, report):
        """Write the name."""
        if report.failed and not self.path.exists():
            self.path.write_text(report.nodeid)

    def pytest_collectreport(self, report):
        """Write the name where a module can't even be imported."""
        self.pytest_runtest_logreport(report)


ARGUMENTS = ['-x', '-q', '-p', 'no:cacheprovider', '--hypothesis-seed=0', '--no-header']


def interpreted(folder, tests, limit):
    """Run tests in a child that has numpy and numba loaded; None, or what caught the mutant."""
    found = folder / 'first'
    child = os.fork()
    if child == 0:
        code = 1
        try:
            os.setsid()
            resource.setrlimit(resource.RLIMIT_CPU, (limit, limit + 1))
            output = os.open(folder / 'output', os.O_WRONLY | os.O_CREAT)
            os.dup2(output, 1)
            os.dup2(output, 2)
            os.chdir(folder)
            os.environ['XDG_CACHE_HOME'] = str(folder / 'cache')
            os.environ['PYTHONPATH'] = str(folder)
            sys.path.insert(0, str(folder))
            import pytest
            code = pytest.main([*ARGUMENTS, *tests], plugins=[First(found)])
        except Exception:
            traceback.print_exc()
        finally:
            sys.stdout.flush()
            sys.stderr.flush()
            os._exit(int(code))
    end = time.monotonic() + PATIENCE * limit
    while True:
        done, status = os.waitpid(child, os.WNOHANG)
        if done:
            break
        if time.monotonic() > end:
            os.killpg(child, signal.SIGKILL)
            os.waitpid(child, 0)
            return 'time limit'
        time.sleep(0.05)
    code = os.waitstatus_to_exitcode(status)
    if code == 0:
        return None
    if code < 0:
        return 'time limit'
    return found.read_text() if found.exists() else 'no test could start'


def compiled(folder, limit):
    """Run the tests of the compiled kernels; None, or what caught the mutant."""
    environment = {key: value for key, value in os.environ.items() if key != 'NUMBA_DISABLE_JIT'}
    environment |= {'XDG_CACHE_HOME': str(folder / 'cache'), 'PYTHONPATH': str(folder)}
    try:
        run = subprocess.run(
            [sys.executable, '-m', 'pytest', *ARGUMENTS, *COMPILED], cwd=folder, env=environment,
            stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True, timeout=limit)
    except subprocess.TimeoutExpired:
        return 'time limit'
    if run.returncode == 0:
        return None
    return next((line.split()[1] for line in run.stdout.splitlines()
                 if line.startswith(('FAILED', 'ERROR'))), 'no test could start')


def main():
    """Draw, run, say."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[1])
    parser.add_argument('--count', type=int, default=20)
    parser.add_argument('--seed', type=int, default=1)
    parser.add_argument('--files', default='*', help='pattern of files below bristle_ros/physics')
    parser.add_argument('--skip', type=int, default=0, help='mutants that an earlier run has done')
    parser.add_argument('--until', type=int, help='of the drawn ones, counted from 0')
    parser.add_argument('--limit', type=int, default=60,
                        help='[s] of processor time for interpreted tests; 25 without a mutant')
    parser.add_argument('--compiled', action='store_true',
                        help='give survivors to the tests of compiled kernels too')
    parser.add_argument('--list', action='store_true', help='say what is drawn, run nothing')
    options = parser.parse_args()
    mutants, sites = draw(options.count, options.seed, options.files)
    lines = {mutant: describe(mutant) for mutant in mutants}
    print(f'{len(mutants)} of {sites} tokens, seed {options.seed}', flush=True)
    if options.list:
        print('\n'.join(lines.values()))
        return 0
    os.environ['NUMBA_DISABLE_JIT'] = '1'
    import numba    # noqa: F401  children are forked: these are loaded once
    import numpy    # noqa: F401
    import pytest   # noqa: F401
    survivors = []
    with tempfile.TemporaryDirectory(prefix='mutants_') as source:
        keep(Path(source))
        if run_one(source, None, 'no mutant', options) is not None:
            return 2
        mutants = mutants[options.skip:options.until]
        for mutant in mutants:
            if run_one(source, mutant, lines[mutant], options) is None:
                survivors.append(lines[mutant])
    print(f'{len(mutants) - len(survivors)} of {len(mutants)} caught')
    for line in survivors:
        print(f'survived: {line}')
    return 1 if survivors else 0


def run_one(source, mutant, line, options):
    """Try one mutant, or None for the package as it is; say and return what caught it."""
    began = time.monotonic()
    with tempfile.TemporaryDirectory(prefix='mutant_') as name:
        # what Python compiles of the package as it is, the mutants' folders have links to
        folder = Path(name if mutant else source)
        if mutant:
            make(source, folder, mutant)
        room = mutant.path.split('/')[0] if mutant else 'step'
        by = interpreted(folder, INTERPRETED[room], options.limit)
        if by is None and mutant and options.compiled:
            by = compiled(folder, PATIENCE * options.limit)
        if by and not mutant:
            print((folder / 'output').read_text())
        (folder / 'output').unlink()
    outcome = by or ('SURVIVED' if mutant else 'passes')
    print(f'{time.monotonic() - began:5.1f} s  {line}  {outcome}', flush=True)
    return by


def describe(mutant):
    """Return a mutant on one line."""
    line = (KERNELS / mutant.path).read_text().splitlines()[mutant.line - 1].strip()
    return f'{mutant.path}:{mutant.line}  {mutant.old!r} -> {mutant.new!r}  in  {line}'


if __name__ == '__main__':
    sys.exit(main())
