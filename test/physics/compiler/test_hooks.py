"""
What the compiler room takes of numba that numba does not promise: each hook by its name.

Where one is gone the failure says which, and who needs it; without it kernels would be slower, or
stale, or not compile at all.
"""
import copy
import inspect
import math
import operator
from pathlib import Path

from bristle_ros.physics.compiler import shortcuts
from bristle_ros.physics.compiler.jit import _OPTIONS, Called
from bristle_ros.physics.compiler.kernel_cache import _Cache, FOLDER
from bristle_ros.physics.motion.drive import profile_at
from llvmlite import ir
import numba
from numba.core import caching, codegen, compiler, options, targetconfig, types
from numba.core.registry import cpu_target, CPUDispatcher
from numba.core.types import functions
from numba.core.typing import templates
import numba.extending
import pytest

TESTED = '0.68.1'   # of numba: what requirements.txt pins, and what these hooks were tried with

# owner, attribute, what for
HOOKS = [
    (caching, 'FunctionCache', 'kernel_cache.py: a cache that trusts no file'),
    (caching.FunctionCache, 'load_overload', 'kernel_cache.py: a damaged file is compiled anew'),
    (caching.FunctionCache, '_load_overload', 'kernel_cache.py: loads, and prepares nothing'),
    (caching.FunctionCache, '_guard_against_spurious_io_errors', 'kernel_cache.py: as it does'),
    (caching, 'NullCache', 'kernel_cache.py: no cache at all'),
    (caching.FunctionCache, 'save_overload', 'kernel_cache.py: one process at a time saves'),
    (caching.IndexDataCacheFile, '_dump', 'kernel_cache.py: a checksum goes behind the content'),
    (caching.IndexDataCacheFile, '_load_data', 'kernel_cache.py: and is compared'),
    (caching.IndexDataCacheFile, '_data_path', 'kernel_cache.py: where the content is'),
    (caching.CompileResultCacheImpl, '_locator_classes', 'kernel_cache.py: where code is kept'),
    (caching.InTreeCacheLocator, 'get_cache_path', 'kernel_cache.py: a folder for each content'),
    (options.DefaultOptions, 'no_cpython_wrapper', 'jit.py: kernels that Python does not call'),
    (options.DefaultOptions, 'no_cfunc_wrapper', 'jit.py: and C neither'),
    (numba.config, 'CPU_NAME', 'jit.py: code for a level of x86-64'),
    (numba.config, 'CPU_FEATURES', 'jit.py: and for nothing beyond'),
    (numba.config, 'DISABLE_JIT', 'jit.py, lanes.py, work_queue.py: kernels as plain Python'),
    (codegen.CPUCodeLibrary, '_optimize_functions', 'shortcuts.py: no passes over functions'),
    (codegen.CPUCodeLibrary, '_optimize_final_module', 'shortcuts.py: one round of passes'),
    (numba.core.ir.Inst, '_rec_list_vars', 'shortcuts.py: variables in a statement'),
    (codegen.CPUCodeLibrary, '_finalize_final_module', 'shortcuts.py: machine code of few'),
    (codegen.CPUCodeLibrary, '_set_compiled_object', 'shortcuts.py: in place of machine code'),
    (codegen.CPUCodeLibrary, '_object_getbuffer_hook', 'shortcuts.py: takes it from there'),
    (codegen.CPUCodegen, '_module_pass_manager', 'shortcuts.py: that round'),
    (targetconfig.TargetConfig, 'options', 'shortcuts.py: all options and their defaults'),
    (functions.BaseFunction, 'get_call_type', 'shortcuts.py: types of operators'),
    (numba.types, 'unliteral', 'jit.py: one version for all constants'),
    (templates, 'AbstractTemplate', 'lanes.py: operators of vectors'),
    (templates, 'infer_global', 'lanes.py: operators of vectors'),
    (templates, 'signature', 'lanes.py: operators of vectors'),
    (numba.extending, 'lower_builtin', 'lanes.py: operators of vectors'),
    (numba.extending, 'register_model', 'lanes.py: the type of a vector'),
    (numba.extending.models, 'PrimitiveModel', 'lanes.py: the type of a vector'),
    (types, 'Type', 'lanes.py: the type of a vector'),
    (ir.IRBuilder, 'atomic_rmw', 'work_queue.py: a queue that threads share'),
    (ir, 'VectorType', 'lanes.py: vectors'),
]


@pytest.mark.parametrize(('owner', 'name', 'purpose'), HOOKS)
def test_a_hook_is_there(owner, name, purpose):
    assert hasattr(owner, name), (
        f'numba {numba.__version__} has no {owner.__name__}.{name} (tested with {TESTED}): '
        f'{purpose}')


def test_what_a_kernel_has_of_numba():
    for name, purpose in (('_cache', 'another cache'), ('get_call_template', 'no literal types')):
        assert hasattr(profile_at, name), (
            f'a dispatcher of numba {numba.__version__} has no {name} (tested with {TESTED}): '
            f'{purpose}')
    cache = caching.FunctionCache(profile_at.py_func)
    for name in ('_cache_file', 'load_overload', 'save_overload'):
        assert hasattr(cache, name), f'FunctionCache of numba {numba.__version__} has no {name}'
    for name in ('_dump', '_load_data', '_data_path', '_index_path'):
        assert hasattr(cache._cache_file, name), (
            f'the cache file of numba {numba.__version__} has no {name} (tested with {TESTED})')
    assert isinstance(profile_at._cache, _Cache), 'kernels have the cache of kernel_cache.py'
    assert isinstance(profile_at.called._cache, _Cache), 'and so has what Python calls'
    assert type(profile_at.called) is Called, 'which takes shortcuts'
    assert Called.__mro__[1] is CPUDispatcher, 'and is a dispatcher as numba makes it'
    assert Path(profile_at._cache.cache_path).is_relative_to(FOLDER), (
        '_cache_path of a locator still decides where code is kept')


def test_the_content_of_a_cache_file_goes_through_dump_and_load_data():
    # kernel_cache.py puts its own in their place on the instance: numba has to call them there
    source = inspect.getsource(caching.IndexDataCacheFile)
    for call in ('self._dump(', 'self._load_data('):
        assert call in source, f'numba {numba.__version__} no longer calls {call}...)'


def test_kernels_have_no_reference_counts():
    # _nrt: an allocation does not even compile
    assert _OPTIONS['_nrt'] is False

    @numba.njit(**_OPTIONS)
    def allocate(n):
        return [n]

    with pytest.raises(numba.core.errors.NumbaError, match='NRT|_nrt|nrt'):
        allocate(3)


def test_the_pinned_version_is_the_tested_one(root):
    assert f'numba=={TESTED}\n' in (root / 'requirements.txt').read_text(), (
        'another numba is pinned: try the hooks above with it, then write it down as TESTED')


@pytest.fixture
def scope():
    """Return the scope of a kernel, renamed variables and all."""
    blocks = compiler.run_frontend(profile_at.py_func).blocks
    made = next(iter(blocks.values())).scope
    made.redefine(next(iter(made.localvars._con)), made.loc)
    return made


def test_a_copied_scope_is_that_of_deepcopy(scope):
    memo = {}
    plain, short = copy.deepcopy(scope), shortcuts.copy_scope(scope, memo)
    assert memo[id(scope)] is short
    assert len(short.localvars) == len(plain.localvars) > 10
    assert short.var_redefinitions == plain.var_redefinitions != {}
    for name, variable in plain.localvars._con.items():
        found = short.localvars.get(name)
        assert (found.name, found.loc) == (variable.name, variable.loc)
    short.redefine(next(iter(short.localvars._con)), short.loc)
    assert len(short.localvars) == len(scope.localvars) + 1


def test_blocks_are_copied_with_their_scope():
    block = next(iter(compiler.run_frontend(profile_at.py_func).blocks.values()))
    with shortcuts.shortcuts():
        copied = copy.deepcopy(block)
    assert copied.scope is not block.scope
    names = [variable.name for line in block.body for variable in line.list_vars()]
    variables = [variable for line in copied.body for variable in line.list_vars()]
    assert [variable.name for variable in variables] == names != []
    assert all(variable.scope is copied.scope for variable in variables)


def test_statements_list_the_variables_that_numba_finds():
    blocks = compiler.run_frontend(profile_at.py_func).blocks
    lines = [line for block in blocks.values() for line in block.body]
    plain = [line.list_vars() for line in lines]
    with shortcuts.shortcuts():
        assert [line.list_vars() for line in lines] == plain
    assert sum(map(len, plain)) > 100
    assert max(map(len, plain)) > 2


def test_options_are_compared_as_numba_does():
    one, two = compiler.Flags(), compiler.Flags()
    two.nrt = True
    for options_ in (one, two):
        assert shortcuts.option_values(options_) == options_.values()
        assert shortcuts.hash_options(options_) == hash(options_)
    three = two.copy()
    three.nrt = compiler.Flags.options['nrt'].default      # said, and yet the same
    assert [shortcuts.same_options(one, other) for other in (one, two, three)] == [
        one == other for other in (one, two, three)] == [True, False, True]
    assert shortcuts.same_options(one, 1) is NotImplemented


def test_operators_have_the_signatures_that_numba_finds():
    context = cpu_target.typing_context
    for function, args in ((operator.add, (types.float64, types.int64)),
                           (operator.getitem, (types.float64[:, ::1], types.int64)),
                           (math.sqrt, (types.float64,))):
        kind = context.resolve_value_type(function)
        plain = kind.get_call_type(context, args, {})
        with shortcuts.shortcuts():
            for _ in range(2):
                assert kind.get_call_type(context, args, {}) == plain
                assert kind.get_impl_key(plain)


def test_shortcuts_are_there_while_kernels_compile_and_in_one_version(monkeypatch):
    def in_place():
        return [vars(owner).get(name) is shorter for owner, name, shorter in shortcuts.SHORTCUTS]
    before = [vars(owner).get(name) for owner, name, _ in shortcuts.SHORTCUTS]
    assert shortcuts.TRIED == TESTED
    with shortcuts.shortcuts():
        assert all(in_place())
        with shortcuts.shortcuts():
            assert all(in_place())
        assert all(in_place())
    assert before == [vars(owner).get(name) for owner, name, _ in shortcuts.SHORTCUTS]
    assert not any(in_place())
    assert not shortcuts._call_types
    monkeypatch.setattr(numba, '__version__', '0.99')
    with shortcuts.shortcuts():
        assert not any(in_place())
