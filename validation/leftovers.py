"""What a claim must not leave behind for the next one in its process: a changed core, and processes that go on."""

from __future__ import annotations

import contextlib
import sys
from collections.abc import Iterator
from importlib import import_module
from types import FunctionType, ModuleType
from typing import Any

import psutil

CORE = "softbody"
OURS = "resource_tracker"  # a process of Python's own, which cleans up after others

Things = dict[tuple[str, str], Any]


def core_now() -> Things:
    """Return what constants and callables in the core's modules and classes are, and the code of functions."""
    import_module(CORE)
    found: Things = {}
    for name, module in list(sys.modules.items()):
        if isinstance(module, ModuleType) and (name == CORE or name.startswith(f"{CORE}.")):
            for where, owner in [(name, module), *_classes_of(name, module)]:
                for key, value in list(vars(owner).items()):
                    if callable(value) or key.isupper():  # what else there is may be what has been said, or counted
                        found[where, key] = _same(value)
    return found


def changed(before: Things) -> list[str]:
    """Return names in the core that stand for something else than they did before."""
    now = core_now()
    return sorted(f"{where}.{key}" for (where, key), value in before.items() if now.get((where, key)) != value)


def end_children(before: set[int]) -> list[str]:
    """End the processes that were begun here and go on, but for those `before`; return their names."""
    ended = []
    for child in psutil.Process().children(recursive=True):
        with contextlib.suppress(psutil.Error):
            if child.pid not in before and child.status() != psutil.STATUS_ZOMBIE and not _is_ours(child):
                ended.append(child.name())
                child.kill()
    return ended


def children_now() -> set[int]:
    """Return the numbers of the processes that were begun here."""
    return {child.pid for child in psutil.Process().children(recursive=True)}


def _classes_of(name: str, module: ModuleType) -> Iterator[tuple[str, type]]:
    for key, value in list(vars(module).items()):
        if isinstance(value, type) and value.__module__ == name:
            yield f"{name}.{key}", value


def _same(value: Any) -> Any:
    """Return what tells whether a value is still the same one, and does the same."""
    if isinstance(value, FunctionType):
        return id(value), id(value.__code__), repr(value.__defaults__)
    return id(value), repr(value) if isinstance(value, (bool, int, float, str, tuple)) else ""


def _is_ours(process: psutil.Process) -> bool:
    return any(OURS in word for word in process.cmdline())
