"""Numba's internals: every kernel is compiled once, with its caller, and kept on disk under the digest of the core.

All that leans on private parts of Numba stands here and in what this module imports of this folder. It is known to work
from FIRST to LAST; with any other Numba, or with SOFTBODY_PLAIN_NUMBA=1, `softbody.compiler.jit` takes Numba's public
decorator instead: the same bits, after a longer wait.
"""

from __future__ import annotations

from dataclasses import dataclass, field
from functools import cached_property
from typing import Any, cast

import numba
from numba.core import types
from numba.core.compiler import Compiler, Flags
from numba.core.dispatcher import _FunctionCompiler  # type: ignore[attr-defined]
from numba.core.errors import NumbaTypeError
from numba.core.registry import CPUDispatcher
from numba.core.targetconfig import ConfigStack

from softbody.compiler.core_cache import cache_of
from softbody.compiler.fingerprint import name_of
from softbody.compiler.libraries import KernelLibrary, PartLibrary
from softbody.compiler.part_cache import Callee, PartCache, register, unique_id
from softbody.compiler.undisturbed import first_cause, hear, undisturbed

FIRST, LAST = (0, 60), (0, 68)  # Numba's versions that `make matrix` has seen this work with


class _NamedCompiler(Compiler):
    """Numba's compiler, except that a function has the same name in every process, where Numba would number it."""

    def _compile_bytecode(self) -> Any:
        function, chosen = self.state.func_id, _open[-1].unique_id
        if chosen:
            function.unique_id, function.unique_name = chosen, f"{function.func_qualname}${chosen}"
        return super()._compile_bytecode()


class _KernelCompiler(_NamedCompiler):
    """Numba's compiler, except that it ends in a KernelLibrary."""

    def __init__(self, typing_context: Any, target_context: Any, library: Any, *rest: Any) -> None:
        library = KernelLibrary(target_context.codegen(), "kernel")
        library.enable_object_caching()  # so that it can be kept on disk
        super().__init__(typing_context, target_context, library, *rest)


class _PartCompiler(_NamedCompiler):
    """Numba's compiler, except that it ends in a PartLibrary."""

    def __init__(self, typing_context: Any, target_context: Any, library: Any, *rest: Any) -> None:
        library = PartLibrary(target_context.codegen(), "part of a kernel")
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


@dataclass
class _Compiling:
    """A kernel or part that is being compiled."""

    unique_id: str | None  # the same in every process; None where Numba is to number it
    called: dict[PartLibrary, None] = field(default_factory=dict)  # so far


_open: list[_Compiling] = []  # callers first


class _QuickCompiler(_FunctionCompiler):
    """Numba's compiler of one function, with the quick flags; what it makes besides are parts of a kernel, too.

    Those are Numba's own functions, and for each `prange` one that threads run, and two around it.
    """

    unique_id: str | None = None
    called: tuple[PartLibrary, ...] = ()  # by what was compiled last

    def _customize_flags(self, flags: Flags) -> Flags:
        return _Flags(flags)

    def _compile_core(self, args: Any, return_type: Any) -> Any:
        hear()
        codegen = self.targetdescr.target_context.codegen()
        before, codegen._library_class = codegen._library_class, PartLibrary
        _open.append(_Compiling(self.unique_id))
        try:
            return super()._compile_core(args, return_type)
        finally:
            self.called = tuple(_open.pop().called)
            codegen._library_class = before


class _Dispatcher(CPUDispatcher):
    """A dispatcher that compiles undisturbed, and sees that lean kernels keep their promise."""

    _compiler: Any

    def __init__(self, name: str, function: Any, options: dict[str, Any], compiler: type[_NamedCompiler]) -> None:
        super().__init__(function, targetoptions=options, pipeline_class=compiler)
        self._name = name
        self._is_lean = not options.get("_nrt", True)
        self._compiler.__class__ = _QuickCompiler  # a new one would take the function's signature apart once more

    def compile(self, sig: Any) -> Any:
        """Compile for one signature, or load the machine code from the disk."""
        self._compiler.unique_id = unique_id(self._name, self.py_func, sig)
        with undisturbed():
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

    def __init__(self, name: str, function: Any, options: dict[str, Any]) -> None:
        bare = options | {"no_cpython_wrapper": True, "no_cfunc_wrapper": True}
        super().__init__(name, function, bare, _PartCompiler)
        self._cache = PartCache(name, function)

    def add_overload(self, cres: Any) -> None:
        """Take in what was compiled, or kept, as a whole."""
        super().add_overload(cres)
        if not cres.library.is_whole:
            cres.library.make_whole(cres.fndesc.mangled_name, self._compiler.called)
        if self._compiler.unique_id:
            signature, symbol = cres.signature, cres.fndesc.mangled_name
            cres.library.seen_as = Callee(self._name, signature.args, signature.return_type, symbol)

    def get_call_template(self, args: Any, kws: Any) -> Any:
        """Forget constants: Numba would compile the kernel anew for every 0, 1 and 2 that it is called with."""
        _, args = self._compiler.fold_argument_types(args, kws)
        args = tuple(_without_value(one) for one in args)
        template = super().get_call_template(args, {})
        caller, compiled = ConfigStack.top_or_none(), cast(Any, self.overloads[args])
        if _open:
            _open[-1].called[compiled.library] = None
        if caller is not None and not caller.nrt and _holds_array(compiled.signature.return_type):
            raise NumbaTypeError(f"{_name(self)} returns an array, and a lean kernel calls it: nobody would free it")
        return template


class _Kernel(_Dispatcher):
    """A function that is compiled as a whole where Python calls it, and as a part where other kernels call it.

    Most kernels are neither in a process that finds its machine code on the disk: cache and part are made when they
    are first asked for, or the import of the core would take twice as long.
    """

    def __init__(self, function: Any, options: dict[str, Any]) -> None:
        super().__init__(name_of(function, options), function, options, _KernelCompiler)
        del self._cache  # Numba's, which keeps nothing
        register(self._name, self)

    @cached_property
    def _cache(self) -> Any:
        return cache_of(self.py_func)

    @cached_property
    def part(self) -> Any:
        """What this kernel is to others."""
        return _Part(self._name, self.py_func, self.targetoptions)

    def __call__(self, *arguments: Any, **named: Any) -> Any:
        """Run, from Python; what a handler of signals raises leaves as itself.

        Numba makes Python's arrays of what a kernel returns by functions of Python, in which a signal that came
        meanwhile is handled, and goes on without what they would have returned: to a SystemError, of that cause.
        """
        try:
            return CPUDispatcher.__call__(self, *arguments, **named)
        except SystemError as error:
            raise first_cause(error) from None

    def __reduce__(self) -> Any:
        """Pickle as a name, as functions are: Numba would pickle what its own constructor takes."""
        return self.py_func.__qualname__

    @property
    def _numba_type_(self) -> Any:
        """What Numba takes this for, where it compiles a call of it."""
        return self.part._numba_type_


def compiled_once(function: Any, options: dict[str, Any]) -> Any:
    """Return the kernel of a function, with Numba's `options` besides those of every kernel."""
    return _Kernel(function, options | {"nopython": True, "nogil": True, "error_model": "numpy"})


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
