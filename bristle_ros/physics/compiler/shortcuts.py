"""
Shortcuts through numba's compiler: three quarters of the time to wait.

Each stands in for a function of numba's. Those of its front end return what that returns. Machine
code is made of what Python calls alone: kernels take others in before there is any. Of the
optimiser's three rounds one is left: those before it, over single functions and for the sake of
reference counts that kernels do not have, took a tenth of compiling, and steps that keep energy
accounts took a quarter longer by them. A result may differ in its last bit. All are in place only
while kernels are compiled, and with the version of numba that they were tried with; with another
one compiling takes longer, and that is all.
"""
from collections.abc import Iterator
import contextlib
import functools
import gc
from types import NoneType
from typing import Any

import llvmlite.binding as llvm
import numba
from numba.core.codegen import CPUCodeLibrary
from numba.core.compiler_lock import global_compiler_lock
from numba.core.ir import Inst, Loc, Scope, Var
from numba.core.targetconfig import TargetConfig
from numba.core.types.functions import BaseFunction

TRIED = '0.68.1'
# The garbage collector looks thousands of times through what the compiler still needs: a sixth of
# the time. What lies about meanwhile is less than 20 MB.
RARELY = (50_000, 10, 10)
OPERATORS = ('_operator', 'math')   # modules of what is called with the same types over and over

_WITHOUT = frozenset((Loc, str, int, float, bool, NoneType))   # types with no variable inside

_plain_finalise = CPUCodeLibrary._finalize_final_module
_plain_variables = Inst._rec_list_vars
_call_types: dict[Any, Any] = {}
_plain_call_type = BaseFunction.get_call_type


def copy_scope(self: Any, memo: dict[int, Any]) -> Any:
    """
    Do for a Scope what deepcopy does, but for new variables in it: names and places are the same.

    Inlining copies a scope for each block, of which most use few of its variables; those are
    copied with the block.
    """
    scope = Scope(self.parent, self.loc)
    memo[id(self)] = scope
    scope.localvars._con.update(self.localvars._con)
    scope.redefined.update(self.redefined)
    for name, versions in self.var_redefinitions.items():
        scope.var_redefinitions[name] = set(versions)
    return scope


def variables_in(self: Any, value: Any) -> list[Var]:
    """Return what Inst._rec_list_vars does: the variables in what a statement is made of."""
    if isinstance(value, dict):
        value = value.values()
    elif not isinstance(value, (list, tuple)):
        return _plain_variables(self, value)
    found = []
    for part in value:
        kind = type(part)
        if kind is Var:
            found.append(part)
        elif kind not in _WITHOUT:
            found += variables_in(self, part)
    return found


@functools.cache
def _defaults(cls: Any) -> tuple[dict[str, Any], int]:
    """Return the defaults of a class of options, and the hash that all of them have."""
    return ({name: option.default for name, option in cls.options.items()},
            hash(tuple(sorted(cls.options))))


def option_values(self: Any) -> dict[str, Any]:
    """Do what TargetConfig.values does, without a call for each option."""
    return {**_defaults(type(self))[0], **self._values}


def hash_options(self: Any) -> int:
    """Return what TargetConfig.__hash__ does: the hash of the names."""
    return _defaults(type(self))[1]


def same_options(self: Any, other: Any) -> bool:
    """Do what TargetConfig.__eq__ does; most that are compared have the same options set."""
    if isinstance(other, TargetConfig):
        return (type(self) is type(other) and self._values == other._values
                or option_values(self) == option_values(other))
    return NotImplemented


def call_type(self: Any, context: Any, args: Any, kws: Any) -> Any:
    """Return what an operator makes of these types; look it up the first time alone."""
    if kws or getattr(self.typing_key, '__module__', None) not in OPERATORS:
        return _plain_call_type(self, context, args, kws)
    known = _call_types.get((self, args))
    if known is None:
        signature = _plain_call_type(self, context, args, kws)
        known = _call_types[self, args] = signature, self.get_impl_key(signature)
    signature, self._impl_keys[known[0].args] = known
    return signature


def take_functions_as_they_are(self: Any, module: Any) -> None:
    """Leave functions to the passes over the whole; do what else `_optimize_functions` does."""
    module.data_layout = self._codegen._data_layout


def optimise_once(self: Any) -> None:
    """Do the last of the rounds of `_optimize_final_module`, the full one."""
    passes, builder = self._codegen._module_pass_manager()
    passes.run(self._final_module, builder)


def finalise(self: Any) -> None:
    """
    Do what `_finalize_final_module` does; make no machine code of what Python does not call.

    Kernels take others in as LLVM has them, never as machine code.
    """
    module, stub = self._final_module, None
    if not self._object_caching_enabled:
        self.enable_object_caching()
    if self._compiled_object is None and not any(map(_is_wrapper, module.functions)):
        stub = self._codegen._tm.emit_object(_with_environments_of(module))
        self._set_compiled_object(stub)
    _plain_finalise(self)
    if stub is not None:
        self._compiled_object = stub    # handing it out empties the place; the cache keeps it


def _is_wrapper(function: Any) -> bool:
    """Whether it is what Python calls of a kernel; see prepend_namespace in itanium_mangler."""
    return function.name.startswith('_ZN7cpython') and not function.is_declaration


def _with_environments_of(module: Any) -> Any:
    """Return a module that has nothing but its environments, which numba writes to."""
    stub = llvm.parse_assembly('\n'.join(
        f'@"{variable.name}" = common global ptr null' for variable in module.global_variables
        if variable.name.startswith('_ZN08NumbaEnv')))
    stub.triple, stub.data_layout = module.triple, module.data_layout
    return stub


SHORTCUTS = ((CPUCodeLibrary, '_optimize_functions', take_functions_as_they_are),
             (CPUCodeLibrary, '_optimize_final_module', optimise_once),
             (CPUCodeLibrary, '_finalize_final_module', finalise),
             (Scope, '__deepcopy__', copy_scope),
             (Inst, '_rec_list_vars', variables_in), (TargetConfig, 'values', option_values),
             (TargetConfig, '__hash__', hash_options), (TargetConfig, '__eq__', same_options),
             (BaseFunction, 'get_call_type', call_type))


@contextlib.contextmanager
def shortcuts() -> Iterator[None]:
    """Put them in place; to be entered again by who is in already."""
    with global_compiler_lock:
        if numba.__version__ != TRIED or BaseFunction.get_call_type is call_type:
            yield
            return
        with contextlib.ExitStack() as stack:
            stack.callback(_call_types.clear)
            stack.callback(gc.set_threshold, *gc.get_threshold())
            gc.set_threshold(*RARELY)
            for owner, name, shorter in SHORTCUTS:
                stack.callback(_put_back, owner, name, vars(owner).get(name))
                setattr(owner, name, shorter)
            yield


def _put_back(owner: Any, name: str, before: Any) -> None:
    if before is None:
        delattr(owner, name)
    else:
        setattr(owner, name, before)
