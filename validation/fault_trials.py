"""Damage the core under claims, and see whether they turn red by what they measure.

All faults that claims name are planted in one copy of the core, each asleep behind a switch, so that it is compiled
once. First the claims are judged while all are asleep, and must hold. Then one fault after the other is woken, and the
claims that name it are judged as `python -m validation` judges them, each in a process of its own, and must fail by
what they measure. A fault in a constant, which no switch can change while kernels run, has a copy of its own.
"""

from __future__ import annotations

import json
import queue
import time
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from concurrent.futures import ThreadPoolExecutor, as_completed
from dataclasses import dataclass, field
from math import isfinite
from pathlib import Path
from threading import Event
from typing import Any

from softbody.compiler.core_digest import core_digest
from validation.bench import ASLEEP, GREEN, MEASURED, Bench, Seen
from validation.check import all_checks
from validation.claim_groups import group_of
from validation.damaged_core import copy_core
from validation.engines import missing
from validation.fault import Fault, plant, plant_switched
from validation.record import write_whole

LEVEL, SEED = "quick", 20080101
# Seconds of the processor that a claim may take: asleep the compilation of its kernels is among them, awake at times
# that of some more, and a fault may be one that never ends.
PATIENCE_ASLEEP, PATIENCE = 900.0, 300.0

CAUGHT, ESCAPED, NOT_RUN = "caught", "escaped", "not run"
TOO_LATE = "the minutes were over"


@dataclass(frozen=True)
class Outcome:
    """What became of one fault: the claims that should see it, why some did not, and why it was not run.

    `off` is by how many of its tolerances a claim was off, where it has one and the error was finite.
    """

    fault: Fault
    claims: tuple[str, ...]
    blind: Mapping[str, str] = field(default_factory=dict)
    off: Mapping[str, float] = field(default_factory=dict)
    why: str | None = None

    @property
    def verdict(self) -> str:
        """CAUGHT, ESCAPED or NOT_RUN."""
        return NOT_RUN if self.why else ESCAPED if self.blind else CAUGHT


class Judges:
    """Copies of the core in a folder, damaged, and the servers that judge claims on them, so many at a time."""

    def __init__(self, faults: Iterable[Fault], folder: Path, jobs: int) -> None:
        """Plant the faults; raises ValueError for one that has no place."""
        self._folder = folder.resolve()
        self._number = {fault: number for number, fault in enumerate(faults)}
        switched = self._folder / "switched"
        plant_switched({k: fault for fault, k in self._number.items() if fault.has_switch}, copy_core(switched))
        for fault, number in self._number.items():
            if not fault.has_switch:
                plant(fault, copy_core(self._folder / str(number)))
        self._bench = Bench(switched, jobs=jobs)
        self._bench.split()
        self._idle: queue.SimpleQueue[int] = queue.SimpleQueue()
        for job in range(jobs):
            self._idle.put(job)

    def asleep(self, claim: str) -> Seen:
        """Return what a claim shows while all faults are asleep."""
        return self._judged(ASLEEP, claim, PATIENCE_ASLEEP)

    def awake(self, fault: Fault, claim: str) -> Seen:
        """Return what a claim shows of a fault."""
        number = self._number[fault]
        if fault.has_switch:
            return self._judged(number, claim, PATIENCE)
        with Bench(self._folder / str(number)) as bench:
            return bench.judge(number, claim, LEVEL, SEED, PATIENCE_ASLEEP)

    def _judged(self, number: int, claim: str, limit: float) -> Seen:
        job = self._idle.get()
        try:
            return self._bench.judge(number, claim, LEVEL, SEED, limit, job)
        finally:
            self._idle.put(job)

    def close(self) -> None:
        """End the servers."""
        self._bench.close()


def planted_faults() -> dict[Fault, tuple[str, ...]]:
    """Return every fault, in the order of the claims, and the claims that name it."""
    claims: dict[Fault, tuple[str, ...]] = {}
    for check in all_checks().values():
        for fault in check.faults:
            claims[fault] = (*claims.get(fault, ()), check.id)
    return claims


def claims_by_group(faults: Mapping[Fault, tuple[str, ...]]) -> list[list[str]]:
    """Return the claims that can be judged, those that compile the same kernels together; most of them first.

    Two that are judged side by side would both compile what the second may load from the disk.
    """
    groups: dict[str, list[str]] = {}
    for claim in dict.fromkeys(claim for claims in faults.values() for claim in claims):
        check = all_checks()[claim]
        if not missing(check.engines):
            groups.setdefault(group_of(check), []).append(claim)
    return sorted(groups.values(), key=len, reverse=True)


def try_in_time(
    fault: Fault, claims: tuple[str, ...], judges: Judges, sound: Mapping[str, Seen], end: float
) -> Outcome:
    """Try a fault as `try_fault` does, unless time.monotonic() [s] is past an end."""
    return Outcome(fault, claims, why=TOO_LATE) if time.monotonic() >= end else try_fault(fault, claims, judges, sound)


def try_fault(fault: Fault, claims: tuple[str, ...], judges: Judges, sound: Mapping[str, Seen]) -> Outcome:
    """Judge claims with one fault in the core; `sound` is what they show without it."""
    absent = missing(tuple(engine for claim in claims for engine in all_checks()[claim].engines))
    if absent:
        return Outcome(fault, claims, why=f"{', '.join(absent)} is not installed")
    blind, off = {}, {}
    for claim in claims:
        if sound[claim].what != GREEN:
            blind[claim] = f"{claim} does not hold without it: {sound[claim].why}"
            continue
        seen = judges.awake(fault, claim)
        if seen.what != MEASURED:
            blind[claim] = why_not_seen(claim, seen)
        elif isfinite(seen.off):
            off[claim] = seen.off
    return Outcome(fault, claims, blind, off)


def why_not_seen(claim: str, seen: Seen) -> str:
    """Return why a claim cannot be said to have seen a fault: it did not turn red by what it measured."""
    return f"not seen by {claim}" if seen.what == GREEN else f"{claim} {seen.what}, and has seen nothing: {seen.why}"


def side_by_side(work: Callable[..., Any], rows: Iterable[Sequence[tuple[Any, ...]]], jobs: int) -> Iterator[Any]:
    """Call `work` for rows of tasks, each row in turn, so many rows at a time, and yield what it returned as rows end.

    Once nobody asks for more, no more tasks are begun.
    """
    pool, is_over = ThreadPoolExecutor(jobs), Event()

    def work_on(row: Sequence[tuple[Any, ...]]) -> list[Any]:
        return [work(*task) for task in row if not is_over.is_set()]

    try:
        for future in as_completed([pool.submit(work_on, row) for row in rows]):
            yield from future.result()
    finally:
        is_over.set()
        pool.shutdown(cancel_futures=True)


def line_of(outcome: Outcome) -> str:
    """Return one line that says what became of a fault."""
    mark = {CAUGHT: "✓", ESCAPED: "✗", NOT_RUN: "–"}[outcome.verdict]
    why = outcome.why or ", ".join(outcome.blind.values())
    return f"{mark} {outcome.fault.name} ({'.'.join(outcome.fault.place)}) {why}".rstrip()


def write(outcomes: list[Outcome], caught: int, out: Path) -> None:
    """Write what became of all faults as JSON."""
    rows = [
        {
            "name": each.fault.name,
            "place": ".".join(each.fault.place),
            "claims": each.claims,
            "verdict": each.verdict,
            "off": dict(each.off),
        }
        for each in outcomes
    ]
    planted = {"core": core_digest(), "planted": len(outcomes), "caught": caught, "faults": rows}
    write_whole(out, json.dumps(planted, indent=1, ensure_ascii=False) + "\n")
