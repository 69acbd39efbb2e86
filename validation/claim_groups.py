"""Groups of claims that compile the same kernels: by the worlds they step, or else by file."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping
from functools import cache
from types import CodeType, FunctionType, ModuleType
from typing import Any

from validation.check import Check

# What a claim says where it makes a world, and what the world then has: kernels are compiled anew for each such set.
PARTS = {
    "add_soft_body": "soft bodies",
    "add_box": "boxes",
    "add_joint": "joints",
    "sleep_speed": "sleep",
}
OURS = ("validation", "softbody.scenes")  # where it is looked for; not in the core, which can make all of them
WORLDS = "worlds of "


def group_of(check: Check) -> str:
    """Return the name of a claim's group: a kind of world, or the claim's file.

    The kind is read from what the claim's function says, and those of ours that it calls. It may be wrong, as nothing
    is run: then the claim compiles more than others of its group.
    """
    parts = _parts_of(check.compare)
    return WORLDS + ", ".join(parts) if parts else check.compare.__module__.rpartition(".")[2]


@cache
def _parts_of(function: Any) -> tuple[str, ...]:
    """Return what the worlds of a claim's function have."""
    words = set(_words(function, set()))
    return tuple(part for word, part in PARTS.items() if word in words)


def _words(function: Any, seen: set[Any]) -> Iterator[str]:
    """Yield the names and texts in a function, and in those of ours that it calls."""
    if not isinstance(function, FunctionType) or function in seen or not function.__module__.startswith(OURS):
        return
    seen.add(function)
    words = set(_words_of_code(function.__code__))
    yield from words
    known = {name: function.__globals__[name] for name in words & function.__globals__.keys()}
    modules = [each for each in known.values() if isinstance(each, ModuleType) and each.__name__.startswith(OURS)]
    inner = [vars(module)[name] for module in modules for name in words & vars(module).keys()]
    for called in [*known.values(), *inner]:
        for each in _inside(called):
            yield from _words(each, seen)


def _inside(called: Any) -> Iterable[Any]:
    """Return the functions that may be called where a function, a class, a table of them or a scene is named."""
    if isinstance(called, ModuleType):
        return [vars(called).get("build")]
    if isinstance(called, type):
        return vars(called).values()
    return called.values() if isinstance(called, Mapping) else [called]


def _words_of_code(code: CodeType) -> Iterator[str]:
    """Yield the names and texts in compiled code, and in functions that it defines."""
    yield from code.co_names
    for constant in code.co_consts:
        if isinstance(constant, CodeType):
            yield from _words_of_code(constant)
        for each in constant if isinstance(constant, tuple) else [constant]:
            if isinstance(each, str):
                yield each
