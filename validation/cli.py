"""The command line of the validation: what to run, how to show it, which exit code it ends with."""

from __future__ import annotations

import fnmatch
import os
import subprocess
import sys
import time
from collections.abc import Callable
from concurrent.futures import ProcessPoolExecutor
from datetime import datetime, timezone
from functools import partial
from multiprocessing import get_context
from pathlib import Path
from typing import TYPE_CHECKING, TypeVar

import click

if TYPE_CHECKING:
    from rich.console import Console

    from validation.check import Check
    from validation.record import Behaviour, ClaimRecord, Figure, Picture, Report, Timing

Scene = TypeVar("Scene")
Seen = TypeVar("Seen")

ALL_HOLD, A_CLAIM_FAILS, WRONG_USAGE, ENGINE_MISSING, INTERRUPTED = 0, 1, 2, 3, 130

# The level of a plain run, and the seed of all random cases.
LEVEL, SEED = "standard", 20080101


@click.command(context_settings={"help_option_names": ["-h", "--help"]})
@click.option("--level", type=click.Choice(["quick", "standard", "full"]), default=LEVEL, show_default=True)
@click.option("--seed", type=click.IntRange(min=0), default=SEED, show_default=True, help="Of all random cases.")
@click.option(
    "-k",
    "patterns",
    multiple=True,
    metavar="PATTERN",
    help="Only claims whose id or family contains or matches PATTERN.",
)
@click.option("--list", "list_only", is_flag=True, help="List the claims and stop.")
@click.option(
    "--out",
    type=click.Path(file_okay=False, path_type=Path),
    default=Path("build/report"),
    show_default=True,
    help="Folder for index.html, report.json and junit.xml.",
)
@click.option(
    "--require", "required", multiple=True, metavar="ENGINE", help="Exit with 3 if ENGINE is missing or broken."
)
@click.option("--require-all", is_flag=True, help="Exit with 3 if any engine that a claim needs is missing or broken.")
@click.option("--timings/--no-timings", default=None, help="Measure step costs too. Default: yes, but not with -k.")
@click.option("--pictures/--no-pictures", default=None, help="Run, film and compare scenes too. Default: as --timings.")
@click.option("--jobs", type=click.IntRange(min=1), default=min(os.cpu_count() or 1, 4), show_default=True)
def main(
    level: str,
    seed: int,
    patterns: tuple[str, ...],
    list_only: bool,
    out: Path,
    required: tuple[str, ...],
    require_all: bool,
    timings: bool | None,
    pictures: bool | None,
    jobs: int,
) -> None:
    """Check every claim about the core against its judge, and write a report.

    Exit code: 0 all claims hold, or were not run, 1 a claim fails, 2 wrong usage, 3 a required engine is missing or
    broken.
    """
    checks = chosen(patterns)
    if list_only:
        for check in checks:
            click.echo(f"{check.id:44} {check.claim}")
        return
    refuse_missing_engines(checks, required, require_all)
    try:
        out.mkdir(parents=True, exist_ok=True)
    except OSError as error:
        raise click.UsageError(f"cannot write to {out}: {error.strerror}; choose another folder with --out") from error
    if timings is None:
        timings = not patterns
    if pictures is None:
        pictures = timings
    report, interrupted = run_report(checks, level, seed, jobs, timings)
    if pictures and not interrupted:
        report.pictures = film_scenes(out, jobs)
        report.behaviours = compare_rules(jobs)
    write_outputs(report, out)
    summarize(report, out)
    if interrupted:
        sys.exit(INTERRUPTED)
    sys.exit(exit_code(report, required, require_all))


def chosen(patterns: tuple[str, ...]) -> list[Check]:
    """Return the checks that match any of the patterns, or all if there are none; wrong usage if one finds nothing."""
    from validation.check import all_checks

    checks = list(all_checks().values())
    for pattern in patterns:
        if not any(matches(check, pattern) for check in checks):
            raise click.UsageError(f"no claim matches {pattern!r}; --list shows them all")
    return [check for check in checks if not patterns or any(matches(check, pattern) for pattern in patterns)]


def matches(check: Check, pattern: str) -> bool:
    """Tell whether a pattern is part of, or matches, the check's id or family."""
    wanted = pattern.lower()
    return any(wanted in name or fnmatch.fnmatch(name, wanted) for name in (check.id.lower(), check.family.lower()))


def refuse_missing_engines(checks: list[Check], required: tuple[str, ...], require_all: bool) -> None:
    """End with ENGINE_MISSING, before anything runs, if a demanded engine is not there."""
    from validation.engines import PACKAGES, missing

    unknown = [engine for engine in required if engine not in PACKAGES]
    if unknown:
        raise click.UsageError(f"unknown engine {unknown[0]!r}; choose from {', '.join(PACKAGES)}")
    demanded = set(required)
    if require_all:
        demanded |= {engine for check in checks for engine in check.engines}
    absent = missing(tuple(sorted(demanded)))
    if absent:
        names = ", ".join(f"{engine} (install {PACKAGES[engine]})" for engine in absent)
        click.echo(f"Required but missing: {names}.", err=True)
        sys.exit(ENGINE_MISSING)


def run_report(checks: list[Check], level: str, seed: int, jobs: int, timings: bool) -> tuple[Report, bool]:
    """Judge all checks with progress; return the report, and whether Ctrl-C cut it short."""
    from validation.engines import environment, revision, versions
    from validation.judge import blank_record
    from validation.record import Report
    from validation.startup import measure_startup
    from validation.timings import add_trends, measure_timings

    start = time.perf_counter()
    records: dict[str, ClaimRecord] = {}
    interrupted = False
    try:
        judge_with_progress(checks, level, seed, jobs, records)
    except KeyboardInterrupt:
        interrupted = True
        click.echo("Interrupted: writing what is done.", err=True)
    for check in checks:
        if check.id not in records:
            records[check.id] = blank_record(check, seed)
            records[check.id].why = "interrupted"
    rows: list[Timing] = []
    figures: list[Figure] = []
    why: str | None = "not asked for (--timings)"
    trends_why: str | None = None
    if timings and not interrupted:
        try:
            rows, why = measure_timings(level)
            trends_why = add_trends(rows) if rows else None
            figures = measure_startup(level)
        except KeyboardInterrupt:
            interrupted, why = True, "interrupted"
    report = Report(
        level=level,
        seed=seed,
        created=datetime.now(timezone.utc).isoformat(timespec="seconds"),
        seconds=time.perf_counter() - start,
        softbody_version=core_version(),
        revision=revision(),
        environment=environment(),
        engines=versions(),
        claims=[records[check.id] for check in checks],
        timings=rows,
        timings_why=None if rows else why,
        trends_why=trends_why,
        figures=figures,
    )
    return report, interrupted


def film_scenes(out: Path, jobs: int) -> list[Picture]:
    """Run and film the scenes, `jobs` at a time; a scene that fails is left out, and said."""
    from validation.pictures import SCENES, make_picture

    return each_scene(partial(make_picture, folder=out / "pictures"), SCENES, "films", jobs)


def compare_rules(jobs: int) -> list[Behaviour]:
    """Run the paper's scenes by its own rules and by the defaults; one that fails is left out, and said."""
    from validation.behaviour import SCENES, SHOTS, behaviours_of

    return [one for scene in each_scene(behaviours_of, [*SCENES, SHOTS], "rules", jobs) for one in scene]


def each_scene(task: Callable[[Scene], Seen], scenes: list[Scene], label: str, jobs: int) -> list[Seen]:
    """Return what a task makes of each scene, `jobs` at a time, in processes of their own."""
    from rich.progress import track

    seen = []
    with ProcessPoolExecutor(jobs, get_context("spawn")) as pool:
        futures = [pool.submit(task, scene) for scene in scenes]
        for scene, future in track(list(zip(scenes, futures)), label, console=progress_console()):
            try:
                seen.append(future.result())
            except Exception as error:
                click.echo(f"{label}: {scene} is left out: {error}", err=True)
    return seen


def core_version() -> str:
    """Return the version of the core under test."""
    import softbody

    return softbody.__version__


def judge_with_progress(checks: list[Check], level: str, seed: int, jobs: int, records: dict[str, ClaimRecord]) -> None:
    """Fill `records` while a bar shows what is running, what is done and the time left."""
    from rich.progress import (
        BarColumn,
        MofNCompleteColumn,
        Progress,
        TextColumn,
        TimeElapsedColumn,
        TimeRemainingColumn,
    )

    from validation.runner import run_checks

    bar = Progress(
        TextColumn("{task.description}"),
        BarColumn(),
        MofNCompleteColumn(),
        TimeElapsedColumn(),
        TextColumn("left:"),
        TimeRemainingColumn(),
        console=progress_console(),
    )
    with bar:
        task = bar.add_task("claims", total=len(checks))
        started = lambda check: bar.update(task, description=check.id)  # noqa: E731
        for record in run_checks(checks, level, seed, jobs, started):
            records[record.id] = record
            bar.console.print(
                line_of(record), style=STYLES[record.verdict], highlight=False, markup=False, soft_wrap=True
            )
            bar.advance(task)


def progress_console() -> Console:
    """Return where progress is shown: standard error, so that standard output holds the summary alone."""
    from rich.console import Console

    return Console(stderr=True)


STYLES = {"holds": "green", "fails": "bold red", "engine broken": "bold yellow", "not run": "yellow"}
SYMBOLS = {"holds": "✓", "fails": "✗", "engine broken": "!", "not run": "–"}


def line_of(record: ClaimRecord) -> str:
    """Return one line that says what became of a claim."""
    mark = SYMBOLS[record.verdict]
    if record.value is None:
        return f"{mark} {record.id}: {record.verdict}, {record.why}"
    line = f"{mark} {record.id}: {record.value:.3g} ≤ {record.tolerance:.3g} {record.unit}, n = {record.n}"
    if record.verdict == "fails":
        line = line.replace("≤", "against a tolerance of") + f" — {record.why}"
    return f"{line} ({record.seconds:.1f} s)"


def write_outputs(report: Report, out: Path) -> None:
    """Write report.json and junit.xml, then have the page made from the record."""
    from validation.junit import write_junit
    from validation.record import write_report

    write_report(report, out / "report.json")
    write_junit(report, out / "junit.xml")
    made = subprocess.run([sys.executable, "-m", "reports", str(out)], capture_output=True, text=True)
    if made.returncode:
        click.echo(f"The page could not be made:\n{made.stderr.strip()}", err=True)


def summarize(report: Report, out: Path) -> None:
    """Print the verdicts, the failures and where the page is."""
    counts = {verdict: sum(c.verdict == verdict for c in report.claims) for verdict in STYLES}
    click.echo()
    for record in report.claims:
        if record.verdict != "holds":
            click.echo(line_of(record))
    said = [f"{n} {verdict}" for verdict, n in counts.items() if n or verdict != "engine broken"]
    click.echo(", ".join(said) + f", in {report.seconds:.0f} s")
    for name in ("index.html", "report.json", "junit.xml"):
        if (out / name).exists():
            click.echo(f"  {out / name}")


def exit_code(report: Report, required: tuple[str, ...] = (), require_all: bool = False) -> int:
    """Return ALL_HOLD, A_CLAIM_FAILS, or ENGINE_MISSING if a demanded engine is broken. "Not run" is no failure."""
    if any(record.verdict == "fails" for record in report.claims):
        return A_CLAIM_FAILS
    broken = {engine for record in report.claims if record.verdict == "engine broken" for engine in record.engines}
    return ENGINE_MISSING if broken and (require_all or broken & set(required)) else ALL_HOLD
