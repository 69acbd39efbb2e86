"""What is said, once a process, where machine code cannot be kept."""

from __future__ import annotations

import warnings

from softbody.errors import CacheWarning

_has_warned = False


def warn_not_kept(why: object) -> None:
    """Warn that machine code cannot be kept, and why."""
    global _has_warned
    if not _has_warned:
        _has_warned = True
        warnings.warn(
            f"machine code cannot be kept ({why}), and is compiled anew in every process: let NUMBA_CACHE_DIR name a "
            "folder that can be written",
            CacheWarning,
            stacklevel=2,
        )
