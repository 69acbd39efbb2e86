"""Progress of long work in the terminal: what is done and time left, as rich's bar or as plain lines."""

from __future__ import annotations

import sys
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from time import monotonic

PAUSE = 5.0  # [s] between plain lines


@contextmanager
def reporter(total: int, done: int, what: str = "frame") -> Iterator[Callable[[int], None]]:
    """Yield what is to be told, on stderr, how many of `total` frames, or `what` else, are done; `done` were before."""
    try:
        from rich.console import Console
        from rich.progress import BarColumn, MofNCompleteColumn, Progress, TextColumn, TimeRemainingColumn
    except ImportError:
        yield _Lines(total, done, what)
        return
    console = Console(stderr=True)
    if not console.is_terminal:
        yield _Lines(total, done, what)
        return
    columns = TextColumn(what), MofNCompleteColumn(), BarColumn(), TextColumn("left"), TimeRemainingColumn()
    with Progress(*columns, console=console) as shown:
        bar = shown.add_task("", total=total, completed=done)
        yield lambda number: shown.update(bar, completed=number)


class _Lines:
    """Lines on stderr, none of them sooner than a PAUSE after the one before."""

    def __init__(self, total: int, done: int, what: str) -> None:
        self._total, self._done, self._what, self._begun = total, done, what, monotonic()
        self._next = self._begun + PAUSE

    def __call__(self, frames: int) -> None:
        now = monotonic()
        if now >= self._next and frames > self._done:
            self._next = now + PAUSE
            left = round((now - self._begun) / (frames - self._done) * (self._total - frames))
            clock = f"{left // 3600}:{left // 60 % 60:02d}:{left % 60:02d}"
            print(f"{self._what} {frames} of {self._total}, {clock} left", file=sys.stderr, flush=True)
