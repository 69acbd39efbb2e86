"""Terminal output of a run: progress on standard error, the sum on standard output."""

from __future__ import annotations

import os
import sys
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import TYPE_CHECKING

import click

from validation.record import BROKEN, FAILS, HOLDS, NOT_RUN, ClaimRecord, Report

if TYPE_CHECKING:
    from rich.console import Console
    from rich.progress import Progress, TaskID

STYLES = {HOLDS: "green", FAILS: "bold red", BROKEN: "bold yellow", NOT_RUN: "yellow"}
SYMBOLS = {HOLDS: "✓", FAILS: "✗", BROKEN: "!", NOT_RUN: "–"}
NARROW = 140  # columns of a file or a pipe


class Terminal:
    """Where a run is followed."""

    def __init__(self, quiet: bool) -> None:
        self._quiet = quiet
        self._bar: Progress | None = None
        self._task: TaskID | None = None

    def say(self, text: str) -> None:
        """Say something in a line of its own, also when quiet."""
        if self._bar is None:
            click.echo(text, err=True)
        else:
            self._bar.console.print(text, highlight=False, markup=False, soft_wrap=True)

    @contextmanager
    def following(self, label: str, total: int) -> Iterator[None]:
        """Show a bar: what is running, how much of `total` is done, and the time left."""
        from rich.console import Console
        from rich.progress import (
            BarColumn,
            MofNCompleteColumn,
            Progress,
            TextColumn,
            TimeElapsedColumn,
            TimeRemainingColumn,
        )

        columns = TextColumn("{task.description}", markup=False), BarColumn(), MofNCompleteColumn()
        times = TimeElapsedColumn(), TextColumn("left:"), TimeRemainingColumn()
        bar = Progress(*columns, *times, console=Console(stderr=True), disable=self._quiet)
        with bar:
            self._bar, self._task = bar, bar.add_task(label, total=total)
            try:
                yield
            finally:
                self._bar = None

    def started(self, name: str) -> None:
        """Show what is running."""
        if self._bar is not None and self._task is not None:
            self._bar.update(self._task, description=name)

    def ended(self, record: ClaimRecord | None = None) -> None:
        """Show that one more is done, and what became of it if it is a claim."""
        if self._bar is None or self._task is None:
            return
        if record is not None and not self._quiet:
            self._bar.console.print(
                line_of(record), style=STYLES[record.verdict], highlight=False, markup=False, soft_wrap=True
            )
        self._bar.advance(self._task)

    def summarize(self, report: Report, out: Path) -> None:
        """Print the verdicts, the failures with the command that repeats each, and where the page is."""
        counts = {verdict: sum(c.verdict == verdict for c in report.claims) for verdict in STYLES}
        if not self._quiet:
            click.echo()
        for record in report.claims:
            if record.verdict != HOLDS:
                click.echo(line_of(record))
            if record.verdict in (FAILS, BROKEN):
                click.echo(f"  {again(record, report.level)}")
        said = [f"{n} {verdict}" for verdict, n in counts.items() if n or verdict != BROKEN]
        click.echo(", ".join(said) + f", in {report.seconds:.0f} s")
        for name in ("index.html", "report.json", "junit.xml"):
            if (out / name).exists():
                click.echo(f"  {out / name}")


def line_of(record: ClaimRecord) -> str:
    """Return one line that says what became of a claim."""
    mark = SYMBOLS[record.verdict]
    if record.value is None:
        return f"{mark} {record.id}: {record.verdict}, {record.why}"
    line = f"{mark} {record.id}: {record.value:.3g} ≤ {record.tolerance:.3g} {record.unit}, n = {record.n}"
    if record.verdict != HOLDS:
        line = line.replace("≤", "against a tolerance of") + f" — {record.why}"
    return f"{line} ({record.seconds:.1f} s)"


def again(record: ClaimRecord, level: str) -> str:
    """Return the command that repeats a claim and shows its worst case."""
    return f"python -m validation replay {record.id} --level {level} --seed {record.seed}"


def wide_enough() -> Console:
    """Return where tables are printed: standard output, wide where it is no terminal."""
    from rich.console import Console

    return Console(width=None if sys.stdout.isatty() or "COLUMNS" in os.environ else NARROW)
