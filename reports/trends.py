"""How have timings changed? `python -m reports.trends FOLDER` reads trends.json there and writes trends.html.

`Trends` is the document, and with `validation.record.Trend` its schema; `python -m benchmarks publish` writes it.
"""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

import click

from reports.reading import read, write
from validation.record import Trend, read_document

SCHEMA = "softbody-trends/1"
CURE = "write it by `python -m benchmarks publish FOLDER`"


@dataclass
class Run:
    """One run of the benchmarks."""

    started: str  # ISO 8601
    revision: str  # with "+" if the working tree differed
    level: str | None
    load: float | None  # of the machine, when it began
    versions: dict[str, str]


@dataclass
class Rate:
    """How many of some comparisons of two revisions ended in a verdict."""

    percent: int  # slow-down that was planted; 0: none, and `found` are false alarms
    comparisons: int
    found: int
    openings: int  # from which they are drawn


@dataclass
class Calibration:
    """How often verdicts err, as the machine was found on some day."""

    started: str
    revision: str
    load: float | None
    rates: list[Rate]


@dataclass
class Trends:
    """All benchmarks of one machine."""

    machine: dict[str, str]
    runs: list[Run]  # oldest first
    fewest: int  # runs in which a step can be found
    calibration: Calibration | None
    trends: list[Trend]
    schema: str = SCHEMA


def read_trends(path: Path) -> Trends:
    """Read the document; raises ValueError, naming the file, if it is not of this schema."""
    return read_document(path, Trends, (SCHEMA,), CURE)


@click.command(context_settings={"help_option_names": ["-h", "--help"]})
@click.argument("folder", type=click.Path(exists=True, file_okay=False, path_type=Path))
def main(folder: Path) -> None:
    """Make FOLDER/trends.html, one self-contained page, from FOLDER/trends.json.

    Exit code: 0 the page is written, 2 there is no record that could be read, 4 the page cannot be written.
    """
    trends = read(folder / "trends.json", read_trends, CURE)

    from reports.trends_page import page

    target = folder / "trends.html"
    write(target, page(trends))
    click.echo(target)


if __name__ == "__main__":
    main(prog_name="python -m reports.trends")
