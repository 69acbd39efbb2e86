"""Public functions that no claim names as its piece."""

from __future__ import annotations

import inspect
from collections.abc import Iterator
from types import FunctionType

import softbody
from validation.check import all_checks


def unnamed_functions() -> list[str]:
    """Return the dotted names, in order, of public functions that no claim is about.

    Of `softbody.__all__`, with methods and scenes. Claims may use them all the same.
    """
    named = {piece for check in all_checks().values() for piece in check.piece.split(", ")}
    return [name for name in public_functions() if name not in named]


def public_functions() -> Iterator[str]:
    """Yield the dotted names of public functions, methods and scenes; errors and warnings have none."""
    for name in softbody.__all__:
        thing, dotted = getattr(softbody, name), f"softbody.{name}"
        if inspect.ismodule(thing):
            yield from (f"{dotted}.{scene}" for scene in thing.__all__)
        elif inspect.isfunction(thing):
            yield dotted
        elif not issubclass(thing, BaseException):
            for method, what in vars(thing).items():
                if not method.startswith("_") and isinstance(what, (FunctionType, classmethod, staticmethod)):
                    yield f"{dotted}.{method}"
