"""How kernels are compiled: four decorators, and what each is for.

Every kernel: nopython mode, strict IEEE arithmetic (no fused multiply-add, no reordering: the same bits compiled or
interpreted), x/0 = inf, no GIL, kept on disk. How Numba is brought to do it in half its time is `compile_once`'s
business; where Numba's internals are not as expected, `plain_numba` does the same by its public decorator.
With NUMBA_DISABLE_JIT=1 kernels are plain Python.

A kernel believes what it is given: an index out of range, or an array of another length, reads or writes the memory of
something else. With NUMBA_BOUNDSCHECK=1 it is an IndexError.
"""

from __future__ import annotations

import os
import re
from collections.abc import Callable
from typing import Any, TypeVar

import numba

Kernel = TypeVar("Kernel", bound=Callable[..., Any])


def jit(function: Kernel) -> Kernel:
    """Compile a kernel: the default."""
    return _compiled(function, _nrt=True)


def jit_lean(function: Kernel) -> Kernel:
    """Compile like `jit` a kernel that makes no array, and returns none: views of its arguments it may pass on.

    Numba then does not count the references to its arguments, which costs a small kernel of many arrays more than its
    work does (224 against 339 ns for the contacts of two boxes). It may call kernels that make arrays for themselves,
    and none that returns one. A kernel that breaks the rule is refused when it is compiled.
    """
    return _compiled(function, _nrt=False)


def jit_threaded(function: Kernel) -> Kernel:
    """Compile like `jit`, the turns of its `prange` loops side by side on threads; elsewhere they run as `range`."""
    return _compiled(function, parallel=True, _nrt=True)


def jit_inlined(function: Kernel) -> Kernel:
    """Compile like `jit`, and paste the body into every kernel that calls it.

    For a large function in the innermost loop: LLVM leaves a call there, and then does not vectorise the loop.
    """
    return _compiled(function, inline="always")


def _knows_numba() -> bool:
    """Tell whether `compile_once` has been seen to work with this Numba, and may be used."""
    if os.environ.get("SOFTBODY_PLAIN_NUMBA") == "1":
        return False
    try:
        from softbody.compiler.compile_once import FIRST, LAST
    except (ImportError, AttributeError):  # what it takes from Numba is not there
        return False
    version = tuple(int(part) for part in re.findall(r"\d+", numba.__version__)[:2])
    return FIRST <= version <= LAST


if numba.config.DISABLE_JIT:  # type: ignore[attr-defined]

    def _compiled(function: Any, **options: Any) -> Any:
        return function

elif _knows_numba():
    from softbody.compiler.compile_once import compiled_once

    def _compiled(function: Any, **options: Any) -> Any:
        return compiled_once(function, options)

else:
    from softbody.compiler.plain_numba import compiled_plainly

    def _compiled(function: Any, **options: Any) -> Any:
        return compiled_plainly(function, options)
