"""Every claim can fail: damage the core under it, and it turns red. `python -m validation.faults` shows all of it.

First the claims are judged on the core as it is, where they must hold. Then each fault that a claim names is planted in
a copy of the core, and the claims that name it are judged on that copy by the real command, in a process of their own.
They must fail.
"""

from __future__ import annotations

import importlib
import inspect
import json
import os
import shutil
import subprocess
import sys
import tempfile
from collections.abc import Iterable, Iterator
from concurrent.futures import ThreadPoolExecutor, as_completed
from dataclasses import dataclass
from pathlib import Path

import click

from validation.check import all_checks
from validation.engines import missing
from validation.fault import Fault, damaged, plant
from validation.record import FAILS, HOLDS, write_whole

ROOT = Path(__file__).parents[1]

CAUGHT, ESCAPED, NOT_RUN = "caught", "escaped", "not run"
PATIENCE = 900.0  # seconds that the claims of one fault may take; some take 60, and a fault may be one that never ends


@dataclass(frozen=True)
class Outcome:
    """What became of one fault: the claims that should see it, those that did not, and why it was not run."""

    fault: Fault
    claims: tuple[str, ...]
    blind: tuple[str, ...] = ()
    why: str | None = None

    @property
    def verdict(self) -> str:
        """CAUGHT, ESCAPED or NOT_RUN."""
        return NOT_RUN if self.why else ESCAPED if self.blind else CAUGHT


def planted_faults() -> dict[Fault, tuple[str, ...]]:
    """Return every fault, in the order of the claims, and the claims that name it."""
    claims: dict[Fault, tuple[str, ...]] = {}
    for check in all_checks().values():
        for fault in check.faults:
            claims[fault] = (*claims.get(fault, ()), check.id)
    return claims


def try_fault(fault: Fault, claims: tuple[str, ...], sound: dict[str, str]) -> Outcome:
    """Plant one fault in a copy of the core, and judge the claims there; `sound` are their verdicts without it."""
    absent = missing(tuple(engine for claim in claims for engine in all_checks()[claim].engines))
    if absent:
        return Outcome(fault, claims, why=f"{', '.join(absent)} is not installed")
    verdicts = verdicts_with(fault, claims)
    seen = {claim for claim in claims if verdicts.get(claim) == FAILS and sound.get(claim) == HOLDS}
    return Outcome(fault, claims, tuple(claim for claim in claims if claim not in seen))


def verdicts_with(fault: Fault | None, claims: Iterable[str], jobs: int = 1) -> dict[str, str]:
    """Judge claims, at level quick, on a copy of the core with a fault in it, if any; return the verdicts there are."""
    command = [sys.executable, "-m", "validation", "--level", "quick", "--no-timings", "--jobs", str(jobs)]
    for claim in claims:
        command += ["-k", claim]
    with tempfile.TemporaryDirectory() as folder:
        place = Path(folder)
        shutil.copytree(ROOT / "softbody", place / "softbody", ignore=shutil.ignore_patterns("__pycache__"))
        if fault is not None:
            plant(fault, place)
        # The working folder comes first on the path: the core is the copy there, everything else the repository's.
        environment = {**os.environ, "PYTHONPATH": str(ROOT)}
        patience = PATIENCE if fault is not None else None
        try:
            subprocess.run(
                [*command, "--out", "out"], cwd=place, env=environment, capture_output=True, timeout=patience
            )
            report = json.loads((place / "out" / "report.json").read_text(encoding="utf-8"))
        except (subprocess.TimeoutExpired, FileNotFoundError):
            return {}
    return {claim["id"]: claim["verdict"] for claim in report["claims"]}


def try_all(faults: dict[Fault, tuple[str, ...]], sound: dict[str, str], jobs: int) -> Iterator[Outcome]:
    """Try faults, so many at a time, and yield what becomes of each as it ends."""
    pool = ThreadPoolExecutor(jobs)
    try:
        for future in as_completed([pool.submit(try_fault, *item, sound) for item in faults.items()]):
            yield future.result()
    finally:
        pool.shutdown(cancel_futures=True)


@click.command(context_settings={"help_option_names": ["-h", "--help"]})
@click.option("-k", "pattern", default="", metavar="TEXT", help="Only faults that name TEXT, or claims with it.")
@click.option("--jobs", type=click.IntRange(min=1), default=min(os.cpu_count() or 1, 4), show_default=True)
@click.option("--out", type=click.Path(dir_okay=False, path_type=Path), default=Path("build/faults.json"))
def main(pattern: str, jobs: int, out: Path) -> None:
    """Plant every fault in a copy of the core, and see that the claims that name it turn red.

    Exit code: 0 all are caught, 1 one escapes, 2 wrong usage, 130 interrupted; what was done by then is written.
    """
    from rich.console import Console
    from rich.progress import (
        BarColumn,
        MofNCompleteColumn,
        Progress,
        TextColumn,
        TimeElapsedColumn,
        TimeRemainingColumn,
    )

    faults = {
        fault: claims
        for fault, claims in planted_faults().items()
        if any(pattern in text for text in (fault.name, *claims))
    }
    if not faults:
        raise click.UsageError(f"no fault and no claim has {pattern!r} in its name")
    try:
        for fault in faults:
            damaged(fault, inspect.getsource(importlib.import_module(fault.place[0])))
    except ValueError as error:
        raise click.ClickException(str(error)) from error
    outcomes: list[Outcome] = []
    console = Console(stderr=True)
    columns = TextColumn("{task.description}"), BarColumn(), MofNCompleteColumn(), TimeElapsedColumn()
    interrupted = False
    with Progress(*columns, TextColumn("left:"), TimeRemainingColumn(), console=console) as bar:
        task = bar.add_task("the claims without faults", total=len(faults))
        try:
            sound = verdicts_with(None, sorted({claim for claims in faults.values() for claim in claims}), jobs)
            bar.reset(task, description="faults")
            for outcome in try_all(faults, sound, jobs):
                outcomes.append(outcome)
                bar.console.print(line_of(outcome, sound), highlight=False, markup=False, soft_wrap=True)
                bar.advance(task)
        except KeyboardInterrupt:
            interrupted = True
    caught, escaped = (sum(each.verdict == verdict for each in outcomes) for verdict in (CAUGHT, ESCAPED))
    write(outcomes, caught, out)
    click.echo(f"{len(outcomes)} of {len(faults)} faults: {caught} caught, {escaped} escaped; {out}")
    sys.exit(130 if interrupted else 1 if escaped else 0)


def line_of(outcome: Outcome, sound: dict[str, str]) -> str:
    """Return one line that says what became of a fault."""
    mark = {CAUGHT: "✓", ESCAPED: "✗", NOT_RUN: "–"}[outcome.verdict]
    unseen = [
        f"not seen by {claim}" if sound.get(claim) == HOLDS else f"{claim} does not hold without it"
        for claim in outcome.blind
    ]
    return f"{mark} {outcome.fault.name} ({'.'.join(outcome.fault.place)}) {outcome.why or ', '.join(unseen)}".rstrip()


def write(outcomes: list[Outcome], caught: int, out: Path) -> None:
    """Write what became of all faults as JSON."""
    rows = [
        {"name": each.fault.name, "place": ".".join(each.fault.place), "claims": each.claims, "verdict": each.verdict}
        for each in outcomes
    ]
    planted = {"planted": len(outcomes), "caught": caught, "faults": rows}
    write_whole(out, json.dumps(planted, indent=1, ensure_ascii=False) + "\n")


if __name__ == "__main__":
    main()
