"""Command `python -m reports diff BEFORE NOW`: what became worse; `reports.compare` is its old name."""

from __future__ import annotations

import os
import sys
from pathlib import Path
from typing import TYPE_CHECKING

import click

from reports.reading import CannotRead, read
from validation.record import Report, read_report

if TYPE_CHECKING:
    from rich.console import Console
    from rich.table import Table

    from reports.differences import Change, SlowDown

NARROW = 140  # columns of a file or a pipe
MACHINE = ("processor", "cores", "system")  # of a report's environment: what timings depend on
FILE = click.Path(path_type=Path)


@click.command(context_settings={"help_option_names": ["-h", "--help"]})
@click.argument("before", type=FILE)
@click.argument("now", type=FILE)
def main(before: Path, now: Path) -> None:
    """Say which claims fail, are closer to their tolerance, or are gone in NOW, and what became slower than in BEFORE.

    Both are report.json of a run of the same level and seed, or its folder. Exit code: 0 nothing fails now that did
    not fail before, 1 something does, 2 the two cannot be compared.
    """
    from rich.console import Console

    from reports.differences import FAILS_NOW, changes
    from reports.verdicts import headline

    before, now = (path / "report.json" if path.is_dir() else path for path in (before, now))
    reports = [read(path, read_report, "run `python -m validation --out FOLDER`") for path in (before, now)]
    refuse_other_cases(before, now, *reports)
    for path, report in zip((before, now), reports):
        click.echo(f"{path}: {headline(report)} (revision {report.revision or 'unknown'}, {report.created})")
    console = Console(width=None if sys.stdout.isatty() or "COLUMNS" in os.environ else NARROW)
    found = changes(*reports)
    if found:
        console.print(claims_table(found))
    else:
        click.echo("no claim has changed its verdict or come closer to its tolerance")
    for line in other_versions(*reports):
        click.echo(line)
    tell_timings(console, *reports)
    sys.exit(any(change.kind == FAILS_NOW for change in found))


def refuse_other_cases(before: Path, now: Path, a: Report, b: Report) -> None:
    """Raise CannotRead if the two reports are of other cases."""
    judged = [report.subject.name if report.subject else "softbody" for report in (a, b)]
    if judged[0] != judged[1]:
        raise CannotRead(f"{before} judges {judged[0]}, {now} {judged[1]}; give two runs about the same engine")
    if (a.level, a.seed, a.draws) != (b.level, b.seed, b.draws):
        raise CannotRead(
            f"{before} is {_cases_of(a)}, {now} {_cases_of(b)}: their cases differ; run both by `python -m validation` "
            "with the same --level, --seed and --draws"
        )


def _cases_of(report: Report) -> str:
    draws = f", {report.draws} draws" if report.draws > 1 else ""
    return f"of level {report.level} and seed {report.seed}{draws}"


def claims_table(found: list[Change]) -> Table:
    """Return a row for each claim that has changed."""
    from rich.markup import escape
    from rich.table import Table

    from reports.differences import CLOSER_NOW, FAILS_NOW, HOLDS_NOW, NOT_RUN_NOW, WIDENED

    styles = {FAILS_NOW: "bold red", HOLDS_NOW: "green"} | dict.fromkeys((NOT_RUN_NOW, WIDENED, CLOSER_NOW), "yellow")
    table = Table(title="Claims", title_justify="left", title_style="bold")
    for heading in ("", "claim", ""):
        table.add_column(heading, overflow="fold")
    for change in found:
        table.add_row(change.kind, escape(change.id), escape(change.what), style=styles.get(change.kind))
    return table


def other_versions(before: Report, now: Report) -> list[str]:
    """Return the judges whose version has changed: a line each, for another answer may be theirs."""

    def of(report: Report, name: str) -> str:
        return report.engines.get(name) or "missing"

    names = sorted({*before.engines, *now.engines})
    return [f"{name}: {of(before, name)} → {of(now, name)}" for name in names if of(before, name) != of(now, name)]


def tell_timings(console: Console, before: Report, now: Report) -> None:
    """Print what became slower, or why that cannot be said."""
    from reports.differences import slow_downs

    machines = [", ".join(report.environment.get(name) or "unknown" for name in MACHINE) for report in (before, now)]
    if machines[0] != machines[1]:
        click.echo(f"timings are not compared, for they are of other machines: {machines[0]}; {machines[1]}")
        return
    found, count = slow_downs(before, now)
    if not count:
        click.echo("timings are not compared: the two reports have none with a peer in common")
        return
    click.echo(f"{len(found)} of {count} timings are slower relative to every peer, beyond the spread of both reports")
    if found:
        console.print(timings_table(found))
        click.echo("two runs apart in time are no proof: `python -m benchmarks compare` runs both revisions in turns")


def timings_table(found: list[SlowDown]) -> Table:
    """Return a row for each timing that is slower."""
    from rich.markup import escape
    from rich.table import Table

    table = Table(title="Timings", title_justify="left", title_style="bold")
    for heading in ("table", "who", "size", "time", "relative to"):
        table.add_column(heading, overflow="fold", justify="right" if heading in ("size", "time") else "left")
    for one in found:
        title, name, size = one.row
        peers = ", ".join(one.peers)
        table.add_row(escape(title), escape(name), str(size), f"× {one.ratio:.2f}", escape(peers), style="yellow")
    return table


if __name__ == "__main__":
    main(prog_name="python -m reports diff")
