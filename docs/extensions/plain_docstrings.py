"""Docstrings of the core as pages: plain sentences, with `code`.

The fields of a tuple have no docstrings: theirs are the comments beside them.
"""

from __future__ import annotations

import importlib
import inspect
import re
from typing import Any

from sphinx.application import Sphinx

MARKS = re.compile(r"([*|_\\])")  # what reStructuredText would take for marks
ALIAS = re.compile(r"TypeAliasForwardRef\('(\w+)'\)")
NONE_OF_ITS_OWN = "Alias for field number"  # what Python says of a field


def setup(app: Sphinx) -> dict[str, bool]:
    """Let autodoc read docstrings so."""
    app.connect("autodoc-process-docstring", read, priority=400)
    app.connect("autodoc-process-signature", shorten)
    return {"parallel_read_safe": True}


def read(app: Sphinx, what: str, name: str, thing: Any, options: Any, lines: list[str]) -> None:
    """Make reStructuredText of a docstring, in place."""
    if lines and lines[0].startswith(NONE_OF_ITS_OWN):
        lines[:] = [_comment(name)]
    parts = "\n".join(lines).split("`")  # code may go on from line to line
    parts[::2] = [MARKS.sub(r"\\\1", part) for part in parts[::2]]
    parts[1::2] = [part.replace("\\", "\\\\") for part in parts[1::2]]
    lines[:] = "`".join(parts).split("\n")


def shorten(
    app: Sphinx, what: str, name: str, thing: Any, options: Any, signature: str | None, returns: str | None
) -> tuple[str | None, str | None]:
    """Return a signature in which aliases go by their names, also where one may be None."""
    return signature and ALIAS.sub(r"\1", signature), returns


def _comment(name: str) -> str:
    """Return the comment beside a field of a tuple, such as softbody.State.box_position."""
    owner, _, field = name.rpartition(".")
    module, _, tuple_name = owner.rpartition(".")
    source = inspect.getsource(getattr(importlib.import_module(module), tuple_name))
    found = re.search(rf"^    {field}: .*?#\s*(.*)$", source, re.MULTILINE)
    return found.group(1) if found else ""
