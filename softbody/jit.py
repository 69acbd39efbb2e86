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


def jit(function: Kernel) -> Kernel:
    """Compile `function` in nopython mode: strict IEEE arithmetic, disk cache, no GIL, x/0 = inf."""
    return _compiled(function)


def jit_inlined(function: Kernel) -> Kernel:
    """Compile like `jit`, and paste the body into every kernel that calls it.

    For a large function in the innermost loop: LLVM leaves a call there, and then does not vectorise the loop.
    """
    return _compiled(function, inline="always")


def _compiled(function: Kernel, **options: Any) -> Kernel:
    kernel: Any = numba.njit(error_model="numpy", nogil=True, **options)(function)
    if kernel is not function:  # as it is under NUMBA_DISABLE_JIT=1
        kernel._cache = _CoreCache(function)
    return kernel


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

    def compile_apart() -> None:
        """Keep the calling kernel out of its callers' machine code."""

else:

    @intrinsic
    def compile_apart(typing_context: Any) -> Any:  # type: ignore[misc]
        """Keep the calling kernel out of its callers' machine code: else each of them takes as long to compile."""

        def generate(context: Any, builder: Any, signature: Any, arguments: Any) -> Any:
            builder.function.attributes.add("noinline")
            return context.get_dummy_value()

        return numba.types.void(), generate

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
            builder.function.attributes.add("noinline")  # as for compile_apart
            for attribute in _vector_attributes():
                set.add(builder.function.attributes, attribute)  # llvmlite's own `add` knows plain names only
            return context.get_dummy_value()

        return numba.types.void(), generate
