"""Progress as one line on standard error, so that standard output holds the results alone."""

from __future__ import annotations

import os
import sys
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from typing import Any

from rich.console import Console

NARROW = 140  # columns of a file or a pipe


def show(*things: Any) -> None:
    """Print tables on standard output."""
    is_terminal = sys.stdout.isatty()
    console = Console(width=None if is_terminal or "COLUMNS" in os.environ else NARROW)
    for thing in things:
        console.print(thing)
        console.print()


@contextmanager
def show_progress() -> Iterator[Callable[[str], None]]:
    """Yield what to tell of each thing as it begins."""
    with Console(stderr=True).status("starting …") as status:
        yield lambda what: status.update(what)
