"""Every claim can fail: damage the core under it, and it turns red. `python -m validation.faults` shows all of it.

All faults that claims name are planted in one copy of the core, each asleep behind a switch, so that it is compiled
once. First the claims are judged while all are asleep, and must hold. Then one fault after the other is woken, and the
claims that name it are judged by the real command, in a process of their own, and must fail. A fault in a constant,
which no switch can change while kernels run, has a copy of its own.
"""

from __future__ import annotations

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
from typing import Any

import click

from softbody.core_digest import core_digest
from validation.check import all_checks
from validation.engines import missing
from validation.fault import Fault, plant, plant_switched
from validation.record import FAILS, HOLDS, write_whole

ROOT = Path(__file__).parents[1]

CAUGHT, ESCAPED, NOT_RUN, CRASHED = "caught", "escaped", "not run", "crashed"
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


class Bench:
    """Copies of the core in a folder, damaged, to judge claims on."""

    def __init__(self, faults: Iterable[Fault], folder: Path) -> None:
        """Plant the faults; raises ValueError for one that has no place."""
        self._folder = folder
        self._number = {fault: number for number, fault in enumerate(faults)}
        plant_switched({k: fault for fault, k in self._number.items() if fault.has_switch}, self._copy("switched"))
        for fault, number in self._number.items():
            if not fault.has_switch:
                plant(fault, self._copy(str(number)))

    def _copy(self, name: str) -> Path:
        """Return a copy of the core."""
        core = self._folder / name / "softbody"
        shutil.copytree(ROOT / "softbody", core, ignore=shutil.ignore_patterns("__pycache__"))
        return core

    def verdicts(self, claims: Iterable[str], fault: Fault | None = None, jobs: int = 1) -> dict[str, str]:
        """Judge claims, at level quick, with a fault, if any; return the verdicts there are."""
        number = -1 if fault is None else self._number[fault]
        place = self._folder / ("switched" if fault is None or fault.has_switch else str(number))
        command = [sys.executable, "-m", "validation", "--level", "quick", "--no-timings", "--jobs", str(jobs)]
        command += [argument for claim in claims for argument in ("-k", claim)]
        # The working folder comes first on the path: the core is the copy there, everything else the repository's.
        environment = {**os.environ, "PYTHONPATH": str(ROOT), "SOFTBODY_FAULT": str(number)}
        with tempfile.TemporaryDirectory(dir=self._folder) as out:
            try:
                subprocess.run(
                    [*command, "--out", out],
                    cwd=place,
                    env=environment,
                    capture_output=True,
                    timeout=None if fault is None else PATIENCE,
                )
                report = json.loads(Path(out, "report.json").read_text(encoding="utf-8"))
            except (subprocess.TimeoutExpired, FileNotFoundError):
                return {}
        return {claim["id"]: claim["verdict"] if _has_seen(claim) else CRASHED for claim in report["claims"]}


def _has_seen(claim: dict[str, Any]) -> bool:
    """Tell whether a claim has measured something, or was told by the core itself that the simulation went wrong.

    A core that crashes, hangs or raises whatever else shows nothing.
    """
    return claim["n"] > 0 or (claim["why"] or "").startswith("raised SimulationError")


def planted_faults() -> dict[Fault, tuple[str, ...]]:
    """Return every fault, in the order of the claims, and the claims that name it."""
    claims: dict[Fault, tuple[str, ...]] = {}
    for check in all_checks().values():
        for fault in check.faults:
            claims[fault] = (*claims.get(fault, ()), check.id)
    return claims


def try_fault(fault: Fault, claims: tuple[str, ...], bench: Bench, sound: dict[str, str]) -> Outcome:
    """Judge claims with one fault in the core; `sound` are their verdicts without it."""
    absent = missing(tuple(engine for claim in claims for engine in all_checks()[claim].engines))
    if absent:
        return Outcome(fault, claims, why=f"{', '.join(absent)} is not installed")
    verdicts = bench.verdicts(claims, fault)
    seen = {claim for claim in claims if verdicts.get(claim) == FAILS and sound.get(claim) == HOLDS}
    return Outcome(fault, claims, tuple(claim for claim in claims if claim not in seen))


def try_all(faults: dict[Fault, tuple[str, ...]], bench: Bench, sound: dict[str, str], jobs: int) -> Iterator[Outcome]:
    """Try faults, so many at a time, and yield what becomes of each as it ends."""
    pool = ThreadPoolExecutor(jobs)
    try:
        for future in as_completed([pool.submit(try_fault, *item, bench, sound) for item in faults.items()]):
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
    outcomes: list[Outcome] = []
    console = Console(stderr=True)
    columns = TextColumn("{task.description}"), BarColumn(), MofNCompleteColumn(), TimeElapsedColumn()
    bar = Progress(*columns, TextColumn("left:"), TimeRemainingColumn(), console=console)
    interrupted = False
    with tempfile.TemporaryDirectory() as folder, bar:
        try:
            bench = Bench(faults, Path(folder))
        except ValueError as error:
            raise click.ClickException(str(error)) from error
        task = bar.add_task("the claims without faults", total=len(faults))
        try:
            sound = bench.verdicts(sorted({claim for claims in faults.values() for claim in claims}), jobs=jobs)
            bar.reset(task, description="faults")
            for outcome in try_all(faults, bench, sound, jobs):
                outcomes.append(outcome)
                console.print(line_of(outcome, sound), highlight=False, markup=False, soft_wrap=True)
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
    planted = {"core": core_digest(), "planted": len(outcomes), "caught": caught, "faults": rows}
    write_whole(out, json.dumps(planted, indent=1, ensure_ascii=False) + "\n")


if __name__ == "__main__":
    main()
