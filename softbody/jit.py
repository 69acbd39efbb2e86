"""The one decorator under which every kernel of the core is compiled."""

from __future__ import annotations

import hashlib
import os
from collections.abc import Callable
from pathlib import Path
from typing import Any, TypeVar

import numba
from numba.core.caching import FunctionCache

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
