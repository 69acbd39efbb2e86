"""What is said, once a process each, where machine code cannot be kept, or what came with the package not be read."""

from __future__ import annotations

from softbody.errors import CacheWarning, warn_user

_said: set[str] = set()


def warn_not_kept(why: object) -> None:
    """Warn that machine code cannot be kept, and why."""
    _warn_once(
        "machine code cannot be kept (%s), and is compiled anew in every process: let NUMBA_CACHE_DIR name a folder "
        "that can be written",
        str(why),
    )


def warn_not_read(where: object) -> None:
    """Warn that machine code that came with the package is damaged."""
    _warn_once("machine code in %s is damaged, and is compiled instead: install the package anew", str(where))


def _warn_once(text: str, about: str) -> None:
    if text not in _said:
        _said.add(text)
        warn_user(text % about, CacheWarning)
