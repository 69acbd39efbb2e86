"""Line numbers of keys in a TOML file. The parser does not say, so each statement is given to it alone."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from typing import Any

Path = tuple[Any, ...]  # names of keys, and numbers of what is in lists

CLOSING = set("]}\"'")  # what a line must have for a statement of several lines to end there
MOST_PARSED = 2**24  # characters in all, a second: a file can be made for which it would take for ever


def line_of(path: Path, lines: dict[Path, int]) -> int:
    """Return the line of what is at a path, or of the nearest thing around it."""
    around = (path[:k] for k in range(len(path), 0, -1))
    return next((lines[at] for part in around for at in (part, (*part, 0)) if at in lines), 1)


def lines_of(text: str, parse: Callable[[str], dict[str, Any]]) -> dict[Path, int]:
    """Return the line, from 1 on, of the keys and tables of a TOML file that `parse` has read.

    All of them, unless statements go over so many lines that there would be too much to parse.
    """
    found: dict[Path, int] = {}
    counts: dict[Path, int] = {}  # tables so far in each list of tables
    table: Path = ()
    for line, statement in _statements(text, parse):
        paths = list(_paths(statement[1]))
        if statement[0].startswith("["):
            table = _table(paths[-1], counts)
            found.setdefault(table, line)
        else:
            for path in paths:
                found.setdefault(table + path, line)
    return found


def _statements(text: str, parse: Callable[[str], dict[str, Any]]) -> Iterator[tuple[int, tuple[str, dict[str, Any]]]]:
    """Yield the first line, the text and the meaning of each statement: the fewest lines that can be parsed alone."""
    lines = text.replace("\r\n", "\n").split("\n")
    first = parsed = 0
    while first < len(lines) and parsed < MOST_PARSED:
        end, size, meaning = first, 0, None
        while meaning is None and end < len(lines) and parsed < MOST_PARSED:
            size += len(lines[end]) + 1
            end += 1
            if end == first + 1 or CLOSING & set(lines[end - 1]):
                parsed += size
                meaning = _meaning(lines[first:end], parse)
        if meaning:
            yield first + 1, (lines[first].strip(), meaning)
        first = end


def _meaning(lines: list[str], parse: Callable[[str], dict[str, Any]]) -> dict[str, Any] | None:
    try:
        return parse("\n".join(lines) + "\n")
    except ValueError:
        return None


def _paths(value: Any, path: Path = ()) -> Iterator[Path]:
    """Yield the path of everything in a value."""
    items = value.items() if isinstance(value, dict) else enumerate(value) if isinstance(value, list) else ()
    for key, each in items:
        yield (*path, key)
        yield from _paths(each, (*path, key))


def _table(header: Path, counts: dict[Path, int]) -> Path:
    """Return the path of the table that a header begins; a list's is known by the 0 at its end."""
    is_list = header[-1] == 0
    names = header[:-1] if is_list else header
    table: Path = ()
    for k, name in enumerate(names):
        table = (*table, name)
        if is_list and k == len(names) - 1:
            counts[table] = counts.get(table, 0) + 1
        if table in counts:
            table = (*table, counts[table] - 1)
    return table
