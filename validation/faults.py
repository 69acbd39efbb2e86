"""Every claim can fail: damage the core under it, and it turns red. `python -m validation.faults` shows all of it.

Each fault that a claim names is planted in a copy of the core, and the claims that name it are judged on that copy by
the real command, in a process of their own. They must fail; on the sound core they hold.
"""

from __future__ import annotations

import json
import os
import shutil
import subprocess
import sys
import tempfile
from collections.abc import Iterator
from concurrent.futures import ThreadPoolExecutor, as_completed
from dataclasses import dataclass
from pathlib import Path

import click

from validation.check import all_checks
from validation.engines import missing
from validation.fault import Fault, plant

ROOT = Path(__file__).parents[1]

CAUGHT, ESCAPED, NOT_RUN = "caught", "escaped", "not run"


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


def try_fault(fault: Fault, claims: tuple[str, ...]) -> Outcome:
    """Plant one fault in a copy of the core, and judge the claims there."""
    absent = missing(tuple(engine for claim in claims for engine in all_checks()[claim].engines))
    if absent:
        return Outcome(fault, claims, why=f"{', '.join(absent)} is not installed")
    with tempfile.TemporaryDirectory() as folder:
        place = Path(folder)
        shutil.copytree(ROOT / "softbody", place / "softbody", ignore=shutil.ignore_patterns("__pycache__"))
        plant(fault, place)
        verdicts = verdicts_in(place, claims)
    return Outcome(fault, claims, tuple(claim for claim in claims if verdicts.get(claim) != "fails"))


def verdicts_in(folder: Path, claims: tuple[str, ...]) -> dict[str, str]:
    """Judge claims, at level quick, on the core that lies in a folder; return their verdicts."""
    command = [sys.executable, "-m", "validation", "--level", "quick", "--no-timings", "--jobs", "1", "--out", "out"]
    for claim in claims:
        command += ["-k", claim]
    # The working folder comes first on the path: the core is the copy there, everything else the repository's.
    environment = {**os.environ, "PYTHONPATH": str(ROOT)}
    subprocess.run(command, cwd=folder, env=environment, capture_output=True, text=True, timeout=900)
    report = json.loads((folder / "out" / "report.json").read_text(encoding="utf-8"))
    return {claim["id"]: claim["verdict"] for claim in report["claims"]}


def try_all(faults: dict[Fault, tuple[str, ...]], jobs: int) -> Iterator[Outcome]:
    """Try faults, so many at a time, and yield what becomes of each as it ends."""
    with ThreadPoolExecutor(jobs) as pool:
        for future in as_completed([pool.submit(try_fault, *item) for item in faults.items()]):
            yield future.result()


@click.command(context_settings={"help_option_names": ["-h", "--help"]})
@click.option("-k", "pattern", default="", metavar="TEXT", help="Only faults that name TEXT, or claims with it.")
@click.option("--jobs", type=click.IntRange(min=1), default=min(os.cpu_count() or 1, 4), show_default=True)
@click.option("--out", type=click.Path(dir_okay=False, path_type=Path), default=Path("build/faults.json"))
def main(pattern: str, jobs: int, out: Path) -> None:
    """Plant every fault in a copy of the core, and see that the claims that name it turn red.

    Exit code: 0 all are caught, 1 one escapes, 2 wrong usage.
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
    outcomes: list[Outcome] = []
    columns = TextColumn("faults"), BarColumn(), MofNCompleteColumn(), TimeElapsedColumn(), TextColumn("left:")
    with Progress(*columns, TimeRemainingColumn(), console=Console(stderr=True)) as bar:
        task = bar.add_task("faults", total=len(faults))
        for outcome in try_all(faults, jobs):
            outcomes.append(outcome)
            bar.console.print(line_of(outcome), highlight=False, markup=False, soft_wrap=True)
            bar.advance(task)
    caught, escaped = (sum(each.verdict == verdict for each in outcomes) for verdict in (CAUGHT, ESCAPED))
    write(outcomes, caught, out)
    click.echo(f"{len(outcomes)} faults: {caught} caught, {escaped} escaped; {out}")
    sys.exit(1 if escaped else 0)


def line_of(outcome: Outcome) -> str:
    """Return one line that says what became of a fault."""
    mark = {CAUGHT: "✓", ESCAPED: "✗", NOT_RUN: "–"}[outcome.verdict]
    unseen = f": not seen by {', '.join(outcome.blind)}" if outcome.blind else ""
    return f"{mark} {outcome.fault.name} ({'.'.join(outcome.fault.place)}){unseen}{outcome.why or ''}"


def write(outcomes: list[Outcome], caught: int, out: Path) -> None:
    """Write what became of all faults as JSON."""
    rows = [
        {"name": each.fault.name, "place": ".".join(each.fault.place), "claims": each.claims, "verdict": each.verdict}
        for each in outcomes
    ]
    out.parent.mkdir(parents=True, exist_ok=True)
    text = json.dumps({"planted": len(outcomes), "caught": caught, "faults": rows}, indent=1, ensure_ascii=False)
    out.write_text(text + "\n", encoding="utf-8")


if __name__ == "__main__":
    main()
