"""The one decorator under which every kernel of the core is compiled."""

from __future__ import annotations

import hashlib
import os
from collections.abc import Callable
from pathlib import Path
from typing import Any, TypeVar

import llvmlite.binding
import numba
from llvmlite import ir
from numba.core.caching import FunctionCache
from numba.core.codegen import JITCodeLibrary
from numba.core.compiler import Compiler
from numba.core.registry import CPUDispatcher
from numba.extending import intrinsic

Kernel = TypeVar("Kernel", bound=Callable[..., Any])


def _core_digest() -> str:
    """Hash what decides the machine code of every kernel: the core's sources and Numba's flags."""
    digest = hashlib.sha256()
    root = Path(__file__).parent
    for path in sorted(root.rglob("*.py")):
        digest.update(path.relative_to(root).as_posix().encode())
        digest.update(path.read_bytes())
    for flag in ("NUMBA_BOUNDSCHECK", "NUMBA_OPT", "NUMBA_CPU_NAME", "NUMBA_CPU_FEATURES"):
        digest.update(f"{flag}={os.environ.get(flag)}".encode())
    return digest.hexdigest()


CORE_DIGEST = _core_digest()


class _CoreCache(FunctionCache):
    """Numba's disk cache, keyed by the whole core.

    Numba's own key is the file of the function itself: after an edit to a callee in another file it would
    load stale machine code, silently. It also ignores the bounds-check flag.
    """

    def _index_key(self, sig: Any, codegen: Any) -> tuple[Any, ...]:
        return (*super()._index_key(sig, codegen), CORE_DIGEST)


class _PartLibrary(JITCodeLibrary):
    """What a kernel is to its callers: LLVM's code, which they link, optimise and make machine code of with their own.

    Numba would do all three for every kernel, and once more in every caller up the chain: two thirds of the time that
    the step of a world takes to compile.
    """

    def _optimize_final_module(self) -> None:
        pass

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


class _PartCompiler(Compiler):
    """Numba's compiler, except that it ends in a _PartLibrary."""

    def __init__(self, typing_context: Any, target_context: Any, library: Any, *rest: Any) -> None:
        library = _PartLibrary(target_context.codegen(), "part of a kernel")
        super().__init__(typing_context, target_context, library, *rest)


class _Kernel(CPUDispatcher):
    """A function that is compiled as a whole where Python calls it, and as a part where other kernels call it."""

    def __init__(self, function: Any, **options: Any) -> None:
        options |= {"nopython": True, "nogil": True, "error_model": "numpy"}
        super().__init__(function, targetoptions=options)
        self._cache = _CoreCache(function)
        bare = options | {"no_cpython_wrapper": True, "no_cfunc_wrapper": True}
        self._part = CPUDispatcher(function, targetoptions=bare, pipeline_class=_PartCompiler)

    def __reduce__(self) -> Any:
        """Pickle as a name, as functions are: Numba would pickle what its own constructor takes."""
        return self.py_func.__qualname__

    @property
    def _numba_type_(self) -> Any:
        """What Numba takes this for, where it compiles a call of it."""
        return self._part._numba_type_


def _compiled(function: Kernel, **options: Any) -> Kernel:
    kernel: Any = function if numba.config.DISABLE_JIT else _Kernel(function, **options)  # type: ignore[attr-defined]
    return kernel  # type: ignore[no-any-return]


def jit(function: Kernel) -> Kernel:
    """Compile `function` in nopython mode: strict IEEE arithmetic, disk cache, no GIL, x/0 = inf."""
    return _compiled(function)


def jit_lean(function: Kernel) -> Kernel:
    """Compile like `jit` a kernel that makes no array, and calls no kernel that does (Numba refuses it).

    Numba then does not count the references to its arguments, which costs a small kernel of many arrays more than its
    work does (224 against 339 ns for the contacts of two boxes).
    """
    return _compiled(function, _nrt=False)


def jit_threaded(function: Kernel) -> Kernel:
    """Compile like `jit`, the turns of its `prange` loops side by side on threads; elsewhere they run as `range`."""
    return _compiled(function, parallel=True)


def jit_inlined(function: Kernel) -> Kernel:
    """Compile like `jit`, and paste the body into every kernel that calls it.

    For a large function in the innermost loop: LLVM leaves a call there, and then does not vectorise the loop.
    """
    return _compiled(function, inline="always")


# How the vector loops are compiled: whole registers, and single loads where the processor's own gather instruction
# is slower than they are (Zen 4 and 5: 12 against 16 ns a particle). Intel's gathers are fast.
def _vector_attributes() -> list[str]:
    """Return the attributes of the functions in which `arrays_do_not_overlap` is called."""
    attributes = ['"prefer-vector-width"="512"']
    if llvmlite.binding.get_host_cpu_name().startswith("znver"):
        features = llvmlite.binding.get_host_cpu_features().flatten()
        attributes.append(f'"target-features"="{features},+prefer-no-gather"')
    return attributes


if numba.config.DISABLE_JIT:  # type: ignore[attr-defined]

    def arrays_do_not_overlap() -> None:
        """Promise that no array that the calling kernel writes to overlaps another of its arguments."""

else:

    @intrinsic
    def arrays_do_not_overlap(typing_context: Any) -> Any:  # type: ignore[misc]
        """Promise that no array that the calling kernel writes to overlaps another of its arguments.

        Without the promise LLVM does not turn a loop that gathers and stores into vector code, which is what makes
        the step fast; a broken promise gives wrong numbers. Numba has no public flag for it, but an intrinsic may
        mark the arguments of the function that it is called in.
        """

        def generate(context: Any, builder: Any, signature: Any, arguments: Any) -> Any:
            for argument in builder.function.args:
                if isinstance(argument.type, ir.PointerType):
                    argument.add_attribute("noalias")
            builder.function.attributes.add("noinline")  # these attributes are of a whole function
            for attribute in _vector_attributes():
                set.add(builder.function.attributes, attribute)  # llvmlite's own `add` knows plain names only
            return context.get_dummy_value()

        return numba.types.void(), generate
