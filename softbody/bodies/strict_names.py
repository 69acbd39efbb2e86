"""Objects that refuse to set an attribute their class does not list, and say which one was meant."""

from __future__ import annotations

from collections.abc import Callable, Iterable
from difflib import get_close_matches
from functools import wraps
from typing import TYPE_CHECKING, Any, NoReturn, ParamSpec, TypeVar

from softbody.errors import ParameterError

P = ParamSpec("P")
R = TypeVar("R")


class StrictNames:
    """What has only the attributes that its class lists: a name that was mistyped is an error, not a new attribute."""

    __slots__ = ()

    def __setattr__(self, name: str, value: Any) -> None:
        """Set an attribute; raises AttributeError for one that there is none of, or that is only to be read."""
        kind, known = type(self).__name__, getattr(type(self), name, None)
        if hasattr(known, "__set__"):  # a slot, or a property
            if not (isinstance(known, property) and known.fset is None):
                object.__setattr__(self, name, value)
                return
            raise AttributeError(f"{name!r} of a {kind} is only to be read; {_settable(type(self))}")
        raise AttributeError(f"a {kind} has no {name!r} to set; {hint(name, dir(type(self)))}{_settable(type(self))}")

    if not TYPE_CHECKING:  # which is to see names that there are none of

        def __getattr__(self, name: str) -> NoReturn:
            """Raise AttributeError, which says which name may be meant."""
            meant = hint(name, [each for each in dir(type(self)) if not each.startswith("_")])
            raise AttributeError(f"a {type(self).__name__} has no {name!r}{'; ' if meant else ''}{meant.strip()}")


def hint(name: str, known: Iterable[str]) -> str:
    """Return a question, and a space, which of the `known` names is meant; nothing where none is like it."""
    meant = get_close_matches(name, list(known), 1)
    return f"did you mean {meant[0]!r}? " if meant else ""


def check_options(what: str, function: Callable[..., Any], given: Iterable[str]) -> None:
    """Raise ParameterError for the name of an argument that a method has none of, with those that there are."""
    code = function.__code__
    known = code.co_varnames[1 : code.co_argcount + code.co_kwonlyargcount]
    for name in given:
        if name not in known:
            raise ParameterError(f"{what} has no {name!r}; {hint(name, known)}choose from {', '.join(known)}")


def strict_options(method: Callable[P, R]) -> Callable[P, R]:
    """Let a method refuse the name of an argument that it has none of by `check_options`."""

    @wraps(method)
    def checked(*values: P.args, **options: P.kwargs) -> R:
        check_options(method.__name__, method, options)
        return method(*values, **options)

    return checked


def _settable(kind: type) -> str:
    """Say what may be set on objects of a class."""
    names = [
        name
        for name in dir(kind)
        if not name.startswith("_")
        and hasattr(member := getattr(kind, name), "__set__")
        and not (isinstance(member, property) and member.fset is None)
    ]
    return f"settable are {', '.join(names)}"
