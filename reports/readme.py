"""Figures of a run in the README, and its badge: `python -m reports readme` writes them between two marks."""

from __future__ import annotations

from pathlib import Path

import click

from reports.reading import CannotRead, read, write
from reports.traces import pieces_of
from reports.verdicts import kinds, tally
from validation.record import BROKEN, Report, read_report

BADGE = "docs/badge.svg"  # beside the README
BEGIN, END = "<!-- python -m reports readme: begin -->", "<!-- end -->"


@click.command(name="readme")
@click.argument("folder", type=click.Path(file_okay=False, path_type=Path), default=Path("build/report"))
@click.option("--file", type=click.Path(path_type=Path), default=Path("README.md"), show_default=True)
def main(folder: Path, file: Path) -> None:
    """Write figures of FOLDER/report.json [build/report], a run of all claims, into the README, between its marks.

    The badge of that run goes to docs/badge.svg beside it.

    Exit code: 0 they are there, 2 there is no such record or no place for them, 4 the README cannot be written.
    """
    from reports.badge import badge  # which draws, and takes a while to load

    record = folder / "report.json"
    report = read(record, read_report, "run `python -m validation` first")
    if report.patterns or report.subject or not report.claims:
        whose = f"about {report.subject.name}" if report.subject else "of some claims only"
        raise CannotRead(f"{record} is {whose}: the README states a run of all; give the folder of one")
    text = read(file, lambda path: path.read_text(encoding="utf-8"), "give the README by --file")
    before, begin, rest = text.partition(BEGIN)
    _, end, after = rest.partition(END)
    if not begin or not end or BEGIN in rest or END in before + after:
        raise CannotRead(f"{file} has not one {BEGIN!r} with one {END!r} after it; put both where the figures belong")
    write(file.parent / BADGE, badge(report))
    write(file, f"{before}{BEGIN}\n\n![Verdict of the last run]({BADGE})\n\n{figures(report)}\n\n{END}{after}")
    click.echo(file)


def figures(report: Report) -> str:
    """Return what is stated of a run: no date and no duration, so that the same verdicts are the same text."""
    counts = tally(report.claims)
    told = ", ".join(f"{n} {name.removesuffix('s')}" for name, n in counts.items() if n or name != BROKEN)
    pieces, alone = pieces_of(report.claims)
    lines = [
        f"At level {report.level}, seed {report.seed}: {len(report.claims)} claims ({told}) judge",
        f"{len(pieces)} pieces of the core, {len(alone)} of them without a judge from outside.",
        "",
        "| kind of judge | claims | hold |",
        "|---|---|---|",
    ]
    lines += [f"| {kind} | {n} | {good} |" for kind, _, n, good in kinds(report.claims)]
    return "\n".join(lines)
