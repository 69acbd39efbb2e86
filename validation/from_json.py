"""Dataclasses made from JSON, with checks that name the entry that is damaged."""

from __future__ import annotations

import dataclasses
import types
from collections.abc import Callable
from functools import cache
from math import isfinite
from typing import Any, TypeVar, Union, get_args, get_origin, get_type_hints

LONGEST_TEXT = 100_000  # characters of one entry
LONGEST_LIST = 200_000  # entries of one list or table
DEEPEST = 20  # lists and tables within each other, where anything may stand
LARGEST_WHOLE = 2**63 - 1
LARGEST = 1e300  # of numbers: what is larger is no measurement, and overflows when it is multiplied

Record = TypeVar("Record")


def from_json(kind: Callable[..., Record], data: Any, where: str = "") -> Record:
    """Return a dataclass made of what JSON holds; unknown entries are left out, missing ones have their defaults.

    Raises ValueError, naming the entry, for what is missing, of another type, too large or not finite.
    """
    if not isinstance(data, dict):
        raise ValueError(f"{where or 'the document'} is {_shown(data)}, and should be a table of names")
    given = {}
    for name, hint, is_needed in _fields(kind):
        place = f"{where}.{name}" if where else name
        if name in data:
            given[name] = _value(hint, data[name], place)
        elif is_needed:
            raise ValueError(f"{place} is missing")
    try:
        return kind(**given)
    except ValueError as error:
        raise ValueError(f"{where}: {error}" if where else str(error)) from None


@cache
def _fields(kind: Any) -> list[tuple[str, Any, bool]]:
    """Return name, type and whether it must be given, of each field."""
    hints, missing = get_type_hints(kind), dataclasses.MISSING
    return [
        (one.name, hints[one.name], one.default is missing and one.default_factory is missing)
        for one in dataclasses.fields(kind)
    ]


def _value(hint: Any, value: Any, where: str) -> Any:
    if hint is Any:
        return _anything(value, where)
    if get_origin(hint) in (Union, types.UnionType):
        if value is None and type(None) in get_args(hint):
            return None
        (hint,) = (one for one in get_args(hint) if one is not type(None))
    if isinstance(hint, type) and dataclasses.is_dataclass(hint):
        return from_json(hint, value, where)
    if get_origin(hint) is list:
        return [_value(get_args(hint)[0], one, f"{where}[{k}]") for k, one in enumerate(_sized(list, value, where))]
    if get_origin(hint) is dict:
        table = _sized(dict, value, where)
        return {_text(name, where): _value(get_args(hint)[1], one, f"{where}.{name}") for name, one in table.items()}
    return _PLAIN[hint](value, where)


def _anything(value: Any, where: str, depth: int = DEEPEST) -> Any:
    """Return a value of any type, whose parts are of sizes that can be shown, and no deeper than `depth`."""
    if isinstance(value, (list, dict)) and depth == 0:
        raise ValueError(f"{where} is nested deeper than {DEEPEST}")
    if isinstance(value, list):
        return [_anything(one, f"{where}[{k}]", depth - 1) for k, one in enumerate(_sized(list, value, where))]
    if isinstance(value, dict):
        table = _sized(dict, value, where)
        return {_text(name, where): _anything(one, f"{where}.{name}", depth - 1) for name, one in table.items()}
    return value if value is None or isinstance(value, bool) else _PLAIN[type(value)](value, where)


def _sized(kind: type[list[Any]] | type[dict[str, Any]], value: Any, where: str) -> Any:
    if not isinstance(value, kind):
        raise ValueError(f"{where} is {_shown(value)}, and should be a {'list' if kind is list else 'table of names'}")
    if len(value) > LONGEST_LIST:
        raise ValueError(f"{where} has {len(value)} entries: more than {LONGEST_LIST} are not read")
    return value


def _text(value: Any, where: str) -> str:
    if not isinstance(value, str):
        raise ValueError(f"{where} is {_shown(value)}, and should be a text")
    if len(value) > LONGEST_TEXT:
        raise ValueError(f"{where} has {len(value)} characters: more than {LONGEST_TEXT} are not read")
    try:
        value.encode()
    except UnicodeEncodeError as error:
        raise ValueError(f"{where} holds half a character ({error.reason})") from None
    return value


def _whole(value: Any, where: str) -> int:
    if isinstance(value, bool) or not isinstance(value, int):
        raise ValueError(f"{where} is {_shown(value)}, and should be a whole number")
    if abs(value) > LARGEST_WHOLE:
        raise ValueError(f"{where} is a number of {len(str(value))} digits: too large to be one")
    return value


def _real(value: Any, where: str) -> float:
    if isinstance(value, bool) or not isinstance(value, (int, float)):
        raise ValueError(f"{where} is {_shown(value)}, and should be a number")
    if not (abs(value) <= LARGEST and isfinite(value)):
        raise ValueError(f"{where} is {_shown(value)}: no measurement is as large as that")
    return value


def _yes_or_no(value: Any, where: str) -> bool:
    if not isinstance(value, bool):
        raise ValueError(f"{where} is {_shown(value)}, and should be true or false")
    return value


_PLAIN: dict[type, Callable[[Any, str], Any]] = {str: _text, int: _whole, float: _real, bool: _yes_or_no}


def _shown(value: Any) -> str:
    """Return a value in a few words."""
    if isinstance(value, (list, dict)):
        return "a list" if isinstance(value, list) else "a table"
    text = "null" if value is None else repr(value)
    return text if len(text) <= 40 else f"{text[:40]}…"
