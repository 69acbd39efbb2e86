"""Error rates of verdicts on this machine: a core against itself, and with a slow-down planted.

Openings are recorded as a comparison makes them, and comparisons drawn from the record. So there are hundreds of them
in the time of some dozen; but they are not independent of each other, as those would be.
"""

from __future__ import annotations

import os
import random
import time
from collections.abc import Iterator
from dataclasses import asdict, dataclass, fields, replace
from datetime import datetime, timezone
from typing import Any

import click
import numpy as np

from benchmarks.compare import SESSION, Plan, Said, dueling
from benchmarks.duel import UnableError
from benchmarks.planted import SLOWED, slower
from benchmarks.verdicts import NO_DIFFERENCE, SLOWER, Verdict, sequential_verdict
from benchmarks.worker import WorkerError

PERCENT = (0, 3, 10)  # slow-downs; 0 for false alarms
SHARE = (0.65, 0.25, 0.1)  # of the budget for each
DRAWN = 60  # comparisons of each benchmark: 600 of equal sides
# What is run against itself: short rounds, ready at once, and one of each kind of kernel.
SAME = (
    *SLOWED,
    "bench_point_in_mesh",
    "bench_closest_triangle",
    "bench_soft_against_soft",
    "::bench_boxes",
    "bench_near_pairs[100]",
    "bench_near_pairs[1000]",
)


@dataclass
class Rate:
    """How many of some comparisons ended in a verdict."""

    percent: int  # slow-down that was planted; 0: none
    comparisons: int = 0
    found: int = 0  # slower; at 0 %, faster or slower: false alarms
    openings: int = 0  # from which they are drawn

    def __str__(self) -> str:
        share = f"{100.0 * self.found / max(1, self.comparisons):.1f} % of {self.comparisons}"
        return f"false alarms in {share}" if self.percent == 0 else f"slow-downs by {self.percent} % found in {share}"


@dataclass
class Calibration:
    """What was found on one machine."""

    started: str
    revision: str
    load: float | None
    seconds: float
    series: dict[str, dict[str, list[list[float]]]]  # percent → benchmark → sessions → logarithms of ratios

    @property
    def rates(self) -> list[Rate]:
        """How verdicts, as they are come to now, do on what was recorded."""
        return [rate_of(percent, self.series[str(percent)]) for percent in sorted(map(int, self.series))]

    def gate(self, allowed: float) -> str:
        """Say how often a gate that allows slow-downs by a share would have stopped what was recorded."""
        stopped = []
        for percent in sorted(map(int, self.series)):
            ends = [one.is_slower_than(allowed) for one in drawn(percent, self.series[str(percent)])]
            which = f"slowed by {percent} %" if percent else "as fast as before"
            stopped.append(f"{100.0 * sum(ends) / max(1, len(ends)):.1f} % of benchmarks {which}")
        return f"--fail-slower {100.0 * allowed:g}% stops, by that calibration, {', '.join(stopped)}"

    def document(self) -> dict[str, Any]:
        """Return it as JSON has it."""
        return asdict(self)

    def __str__(self) -> str:
        load = "" if self.load is None else f", load {self.load:.1f}"
        rates = "; ".join(str(rate) for rate in self.rates)
        openings = sum(rate.openings for rate in self.rates)
        return f"calibrated here on {self.started[:10]}{load}: {rates} (drawn from {openings} openings)"


def from_document(document: dict[str, Any]) -> Calibration:
    """Return what `Calibration.document` gave."""
    return Calibration(**{field.name: document[field.name] for field in fields(Calibration)})


def calibrate(plan: Plan, said: Said) -> Calibration:
    """Record until the budget is spent, or interrupted; most of it goes to false alarms, of which there are few."""
    start = time.monotonic()
    started = datetime.now(timezone.utc).isoformat(timespec="seconds")
    load = os.getloadavg()[0] if hasattr(os, "getloadavg") else None
    series: dict[str, dict[str, list[list[float]]]] = {}
    side = plan.sides[0]
    try:
        for percent, share in zip(PERCENT, SHARE):
            other = slower(side, percent) if percent else side
            part = replace(plan, sides=(side, other), budget=share * plan.budget, seed=plan.seed + percent)
            _record(part, SLOWED if percent else SAME, series.setdefault(str(percent), {}), said)
    except (KeyboardInterrupt, WorkerError) as error:  # what was recorded is counted
        click.echo(f"cut short: {error or 'interrupted'}", err=True)
    return Calibration(started, side.revision, load, time.monotonic() - start, series)


def _record(plan: Plan, patterns: tuple[str, ...], series: dict[str, list[list[float]]], said: Said) -> None:
    """Open the benchmarks in turns until time is up, with new processes now and then; compiling is not counted."""
    rng, end = random.Random(plan.seed), None
    while end is None or time.monotonic() < end:
        with dueling(plan, rng) as duel:
            names = [name for name in duel.benchmarks() if any(pattern in name for pattern in patterns)]
            for name in names if end is None else []:  # compile
                duel.open(name)
            end = end or time.monotonic() + plan.budget
            for name in names:
                series.setdefault(name, []).append([])
            for k in range(SESSION):
                said(f"{plan.sides[1].name}: opening {k + 1}")
                for name in list(names):
                    if time.monotonic() >= end:
                        return
                    try:
                        series[name][-1].append(duel.open(name)[0].ratio)
                    except UnableError:
                        names.remove(name)


def rate_of(percent: int, by_name: dict[str, list[list[float]]]) -> Rate:
    """Return how comparisons end that are drawn from recorded sessions."""
    verdicts = [verdict.verdict for verdict in drawn(percent, by_name)]
    found = sum(verdict == SLOWER if percent else verdict != NO_DIFFERENCE for verdict in verdicts)
    return Rate(percent, len(verdicts), found, sum(len(one) for sessions in by_name.values() for one in sessions))


def drawn(percent: int, by_name: dict[str, list[list[float]]]) -> Iterator[Verdict]:
    """Yield verdicts of comparisons that are drawn from recorded sessions.

    Sessions come whole, for what two processes have by chance stays with them, in random order, none twice in a
    comparison. Without a slow-down the sides are equal, so that each is turned round as a coin falls.
    """
    rng = np.random.default_rng(percent)
    for sessions in by_name.values():
        for _ in range(DRAWN if sessions else 0):
            order = rng.permutation(len(sessions))
            signs = rng.choice([-1.0, 1.0], len(sessions)) if percent == 0 else np.ones(len(sessions))
            yield sequential_verdict([signs[k] * one for k in order for one in sessions[k]])
