"""The kernels by Numba's public decorator alone: for a Numba whose internals `compile_once` does not know.

The same bits. Compiling takes two to three times as long.
"""

from __future__ import annotations

import os
from pathlib import Path
from typing import Any

import numba

from softbody.compiler.cache_warning import warn_not_kept
from softbody.compiler.core_digest import CORE_DIGEST


def compiled_plainly(function: Any, options: dict[str, Any]) -> Any:
    """Return the kernel of a function, with Numba's `options` besides those of every kernel, but for private ones."""
    public = {name: value for name, value in options.items() if not name.startswith("_")}
    # Numba's cache knows a function by its own file only, and would load stale machine code after an edit to a callee
    # in another. So each state of the core has a folder of its own. Numba asks for it here, once for each function.
    before = numba.config.CACHE_DIR  # type: ignore[attr-defined]
    numba.config.CACHE_DIR = str(_folder(before))  # type: ignore[attr-defined]
    try:
        return numba.njit(nogil=True, error_model="numpy", cache=True, **public)(function)
    except (RuntimeError, OSError) as error:  # there is no folder to keep it in
        warn_not_kept(error)
        return numba.njit(nogil=True, error_model="numpy", **public)(function)
    finally:
        numba.config.CACHE_DIR = before  # type: ignore[attr-defined]


def _folder(chosen: str) -> Path:
    """Return where machine code is kept: in the folder that the user has `chosen` for Numba, or in their own cache."""
    users = Path(os.environ.get("XDG_CACHE_HOME") or Path.home() / ".cache")
    return Path(chosen or users / "numba") / f"softbody-{CORE_DIGEST[:16]}"
