"""Numba's internals: every kernel is compiled once, with its caller, and kept on disk under the digest of the core.

All that leans on private parts of Numba stands here, in `core_cache` and in `cache_file`. It is known to work from
FIRST to LAST; with any other Numba, or with SOFTBODY_PLAIN_NUMBA=1, `softbody.compiler.jit` takes Numba's public
decorator instead: the same bits, after a longer wait.
"""

from __future__ import annotations

import gc
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from functools import cached_property
from typing import Any, cast

import numba
from llvmlite.binding import Linkage
from numba.core import types
from numba.core.codegen import JITCodeLibrary
from numba.core.compiler import Compiler, Flags
from numba.core.compiler_lock import global_compiler_lock
from numba.core.dispatcher import _FunctionCompiler  # type: ignore[attr-defined]
from numba.core.errors import NumbaTypeError
from numba.core.registry import CPUDispatcher
from numba.core.targetconfig import ConfigStack

from softbody.compiler.core_cache import cache_of
from softbody.compiler.interrupts import later
from softbody.compiler.notice import told_if_long

FIRST, LAST = (0, 60), (0, 68)  # Numba's versions that `make matrix` has seen this work with


class _PartLibrary(JITCodeLibrary):
    """What a kernel is to its callers: LLVM's code, which they link, optimise and make machine code of with their own.

    Numba would do all three for every kernel, and once more in every caller up the chain: two thirds of the time that
    the step of a world takes to compile.
    """

    def _optimize_final_module(self) -> None:
        _hear()

    def _finalize_final_module(self) -> None:
        self._finalize_dynamic_globals()
        self._finalized = True

    def get_pointer_to_function(self, name: str) -> int:
        return 0  # there is no machine code to point to

    @property
    def codegen(self) -> Any:
        return self

    def set_env(self, name: str, environment: Any) -> None:
        """Do nothing: only code in object mode looks at its environment."""


class _KernelLibrary(JITCodeLibrary):
    """A kernel that Python calls, with all the parts that it calls, which nobody else will.

    As Numba links them, somebody might: then LLVM keeps their signatures, and each call pushes all fields of all arrays
    of its arguments, a hundred words and more. What is internal it gives the arguments that are read.
    """

    def _optimize_final_module(self) -> None:
        for function in self._final_module.functions:
            if function.linkage == Linkage.linkonce_odr and not function.name.startswith("NRT_"):
                function.linkage = "internal"
                function.name += ".own"  # what is loaded later and called the same would be taken to be this one
        _hear()
        super()._optimize_final_module()
        _hear()


class _KernelCompiler(Compiler):
    """Numba's compiler, except that it ends in a _KernelLibrary."""

    def __init__(self, typing_context: Any, target_context: Any, library: Any, *rest: Any) -> None:
        library = _KernelLibrary(target_context.codegen(), "kernel")
        library.enable_object_caching()  # so that it can be kept on disk
        super().__init__(typing_context, target_context, library, *rest)


class _PartCompiler(Compiler):
    """Numba's compiler, except that it ends in a _PartLibrary."""

    def __init__(self, typing_context: Any, target_context: Any, library: Any, *rest: Any) -> None:
        library = _PartLibrary(target_context.codegen(), "part of a kernel")
        super().__init__(typing_context, target_context, library, *rest)


class _Flags(Flags):
    """Numba's flags, compared by what was set: Numba lists all options, 200 000 times while a world is compiled."""

    def __eq__(self, other: object) -> bool:
        if not isinstance(other, Flags):
            return NotImplemented
        mine, others, options = self._values, other._values, self.options  # type: ignore[attr-defined]
        return mine == others or all(
            mine.get(name, options[name].default) == others.get(name, options[name].default)
            for name in mine.keys() | others.keys()
        )

    def __hash__(self) -> int:
        return _HASH_OF_FLAGS


_HASH_OF_FLAGS = hash(Flags())  # of any: Numba hashes the names of the options


class _QuickCompiler(_FunctionCompiler):
    """Numba's compiler of one function, with the quick flags; what it makes besides are parts of a kernel, too.

    Those are Numba's own functions, and for each `prange` one that threads run, and two around it.
    """

    def _customize_flags(self, flags: Flags) -> Flags:
        return _Flags(flags)

    def _compile_core(self, args: Any, return_type: Any) -> Any:
        _hear()
        codegen = self.targetdescr.target_context.codegen()
        before, codegen._library_class = codegen._library_class, _PartLibrary
        try:
            return super()._compile_core(args, return_type)
        finally:
            codegen._library_class = before


class _Dispatcher(CPUDispatcher):
    """A dispatcher that compiles undisturbed, and sees that lean kernels keep their promise."""

    _compiler: Any

    def __init__(self, function: Any, options: dict[str, Any], **more: Any) -> None:
        super().__init__(function, targetoptions=options, **more)
        self._is_lean = not options.get("_nrt", True)
        self._compiler.__class__ = _QuickCompiler  # a new one would take the function's signature apart once more

    def compile(self, sig: Any) -> Any:
        """Compile for one signature, or load the machine code from the disk."""
        with _undisturbed():
            return super().compile(sig)

    def add_overload(self, cres: Any) -> None:
        """Take in what was compiled; raises NumbaTypeError for a lean kernel that returns an array."""
        if self._is_lean and _holds_array(cres.signature.return_type):
            raise NumbaTypeError(
                f"{_name(self)} is lean and returns an array, or a view of one, which nobody would count: heap "
                "corruption; compile it with jit"
            )
        super().add_overload(cres)


class _Part(_Dispatcher):
    """A kernel as other kernels call it: linked into them, and one for all values of an argument."""

    def get_call_template(self, args: Any, kws: Any) -> Any:
        """Forget constants: Numba would compile the kernel anew for every 0, 1 and 2 that it is called with."""
        _, args = self._compiler.fold_argument_types(args, kws)
        args = tuple(_without_value(one) for one in args)
        template = super().get_call_template(args, {})
        caller, compiled = ConfigStack.top_or_none(), cast(Any, self.overloads[args])
        if caller is not None and not caller.nrt and _holds_array(compiled.signature.return_type):
            raise NumbaTypeError(f"{_name(self)} returns an array, and a lean kernel calls it: nobody would free it")
        return template


class _Kernel(_Dispatcher):
    """A function that is compiled as a whole where Python calls it, and as a part where other kernels call it.

    Most kernels are neither in a process that finds its machine code on the disk: cache and part are made when they
    are first asked for, or the import of the core would take twice as long.
    """

    def __init__(self, function: Any, options: dict[str, Any]) -> None:
        super().__init__(function, options, pipeline_class=_KernelCompiler)
        del self._cache  # Numba's, which keeps nothing

    @cached_property
    def _cache(self) -> Any:
        return cache_of(self.py_func)

    @cached_property
    def _part(self) -> Any:
        bare = self.targetoptions | {"no_cpython_wrapper": True, "no_cfunc_wrapper": True}
        return _Part(self.py_func, bare, pipeline_class=_PartCompiler)

    def __call__(self, *arguments: Any, **named: Any) -> Any:
        """Run, from Python; what a handler of signals raises leaves as itself.

        Numba makes Python's arrays of what a kernel returns by functions of Python, in which a signal that came
        meanwhile is handled, and goes on without what they would have returned: to a SystemError, of that cause.
        """
        try:
            return CPUDispatcher.__call__(self, *arguments, **named)
        except SystemError as error:
            raise _first_cause(error) from None

    def __reduce__(self) -> Any:
        """Pickle as a name, as functions are: Numba would pickle what its own constructor takes."""
        return self.py_func.__qualname__

    @property
    def _numba_type_(self) -> Any:
        """What Numba takes this for, where it compiles a call of it."""
        return self._part._numba_type_


def compiled_once(function: Any, options: dict[str, Any]) -> Any:
    """Return the kernel of a function, with Numba's `options` besides those of every kernel."""
    return _Kernel(function, options | {"nopython": True, "nogil": True, "error_model": "numpy"})


_waiting: list[Callable[[], None]] = []  # what handles the signals that have come since a kernel began to compile


def _hear() -> None:
    """Handle the signals that have come, where Numba and LLVM bear what a handler raises."""
    for hear in _waiting:
        hear()


@contextmanager
def _undisturbed() -> Iterator[None]:
    """Let signals wait for `_hear`, and Python's garbage collector rest, while a kernel and its parts are compiled.

    What is raised where Numba looks for new functions ends a generator: nothing compiles in that process any more.
    Where LLVM makes or frees an object, it is swallowed, or the process crashes.
    The collector would walk the millions of objects that compiling makes, a sixth of the time.
    """
    with global_compiler_lock._lock:  # a signal is handled at once while another thread compiles
        if _waiting:  # this is a part
            yield
            return
        with later() as hear, told_if_long():
            was_on = gc.isenabled()
            gc.disable()
            _waiting.append(hear)
            try:
                yield
            finally:
                _waiting.clear()
                if was_on:
                    gc.enable()


def _first_cause(error: BaseException) -> BaseException:
    """Return what has led to an error, and to those that it has led to."""
    while isinstance(error, SystemError) and error.__cause__ is not None:
        error = error.__cause__
    return error


def _without_value(one: types.Type) -> types.Type:
    """Return the type of an argument that is a constant, or is left at its default."""
    if isinstance(one, types.Omitted):
        return numba.typeof(one.value)
    return types.unliteral(one)


def _name(kernel: CPUDispatcher) -> str:
    return f"{kernel.py_func.__module__}.{kernel.py_func.__qualname__}"


def _holds_array(one: Any) -> bool:
    """Tell whether a value of a type is, or holds, an array."""
    if isinstance(one, types.Optional):
        return _holds_array(one.type)
    if isinstance(one, types.BaseTuple):
        return any(_holds_array(each) for each in cast(Any, one))
    return isinstance(one, types.Buffer)
