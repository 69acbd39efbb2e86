"""How does a docstring of the core become a page? As what it is: plain sentences, with `code`."""

from __future__ import annotations

import re
from typing import Any

from sphinx.application import Sphinx

MARKS = re.compile(r"([*|_\\])")  # what reStructuredText would take for marks


def setup(app: Sphinx) -> dict[str, bool]:
    """Let autodoc escape whatever stands outside of backticks."""
    app.connect("autodoc-process-docstring", escape, priority=400)
    return {"parallel_read_safe": True}


def escape(app: Sphinx, what: str, name: str, thing: Any, options: Any, lines: list[str]) -> None:
    """Escape a docstring, in place; code may go on from line to line."""
    parts = "\n".join(lines).split("`")
    parts[::2] = [MARKS.sub(r"\\\1", part) for part in parts[::2]]
    parts[1::2] = [part.replace("\\", "\\\\") for part in parts[1::2]]
    lines[:] = "`".join(parts).split("\n")
