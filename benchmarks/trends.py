"""Trend of each benchmark from run to run, as ratios to a peer of the same run if any.

A machine that is slower on some day is so for both: what steps in the ratio is the core, or the peer.
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterator
from dataclasses import dataclass
from itertools import pairwise
from pathlib import Path
from typing import Any

import numpy as np

from benchmarks.history import Record
from benchmarks.race import short_name
from benchmarks.running import competitors
from benchmarks.steps import steps_in
from benchmarks.tables import significant

BARS = "▁▂▃▄▅▆▇█"


@dataclass(frozen=True)
class Step:
    """A change of level between two runs."""

    at: int  # the number of the first run after it
    ratio: float  # of the new level to the old one
    started: str  # of that run
    before: str  # revision of the run before it
    revision: str  # of that run

    @property
    def kind(self) -> str:
        """Slower or faster."""
        return "slower" if self.ratio > 1.0 else "faster"


@dataclass(frozen=True)
class Trend:
    """One benchmark, run by run."""

    name: str
    row: dict[str, Any]  # of the table that it fills: table, name, size, of, per
    peer: str | None  # whose time is 1; None: there is none, and values are ns
    started: list[str]
    revisions: list[str]
    values: list[float]

    @property
    def unit(self) -> str:
        """Of the values."""
        return f"× {self.peer}" if self.peer else f"ns per {self.row['per']}"

    @property
    def levels(self) -> list[tuple[int, int, float]]:
        """First run, end and median of each level."""
        ends = [0, *steps_in([float(np.log(value)) for value in self.values]), len(self.values)]
        return [(start, end, float(np.median(self.values[start:end]))) for start, end in pairwise(ends)]

    @property
    def steps(self) -> list[Step]:
        """Where its level changes."""
        return [
            Step(at, after / before, self.started[at], self.revisions[at - 1], self.revisions[at])
            for (_, at, before), (_, _, after) in pairwise(self.levels)
        ]


@dataclass(frozen=True)
class _Run:
    started: str
    revision: str
    info: dict[str, Any]
    times: dict[str, np.ndarray]  # seconds per unit of every competitor that is a yardstick, ours first


def trends_of(records: list[Record]) -> list[Trend]:
    """Return the trend of every benchmark in some runs, which are in the order of time."""
    by_name: dict[str, list[_Run]] = {}
    for record in records:
        for race in record.document["benchmarks"]:
            info = race["extra_info"]
            if "table" in info:
                own = info.get("own", ())
                times = {name: times for name, times in competitors(race).items() if name not in own}
                run = _Run(record.started, revision_of(record), info, times)
                by_name.setdefault(short_name(race["fullname"]), []).append(run)
    return [_trend(name, runs) for name, runs in by_name.items()]


def _trend(name: str, runs: list[_Run]) -> Trend:
    counts = Counter(peer for run in runs for peer in list(run.times)[1:])
    common = [peer for peer, count in counts.items() if count == len(runs)]
    # Of the peers that were always there, the one that varies least from round to round.
    peer = min(common, key=lambda one: np.median([_spread(run.times[one]) for run in runs]), default=None)
    values = []
    for run in runs:
        ours = next(iter(run.times.values()))
        values.append(1e9 * float(np.median(ours)) if peer is None else float(np.median(ours / run.times[peer])))
    row = {key: runs[-1].info[key] for key in ("table", "name", "size", "of", "per")}
    return Trend(name, row, peer, [run.started for run in runs], [run.revision for run in runs], values)


def _spread(times: np.ndarray) -> float:
    low, middle, high = np.quantile(times, (0.25, 0.5, 0.75))
    return float((high - low) / middle)


def revision_of(record: Record) -> str:
    """Return the commit that was measured, with "+" if the working tree differed."""
    commit = record.document.get("commit_info") or {}
    return str(commit.get("id") or "unknown")[:12] + ("+" if commit.get("dirty") else "")


def lines_of(trend: Trend) -> Iterator[str]:
    """Yield what to print: a line with the last value and all of them as bars, and one for each step."""
    yield f"{trend.name}: {significant(trend.values[-1])} {trend.unit}  {sparkline(trend.values)}"
    for step in trend.steps:
        yield (
            f"    {max(step.ratio, 1.0 / step.ratio):.3f} × {step.kind}, from {step.started[:16]} on: "
            f"after {step.before}, with {step.revision}"
        )


def sparkline(values: list[float]) -> str:
    """Return a bar for each value, from the least to the greatest."""
    low, span = min(values), max(values) - min(values)
    return "".join(BARS[round((len(BARS) - 1) * (value - low) / span) if span else 0] for value in values)


def draw(trends: list[Trend], path: Path) -> None:
    """Draw each trend with its levels into a PNG or SVG file, whole or not at all."""
    import matplotlib

    matplotlib.use("Agg")
    from matplotlib import pyplot

    figure, axes = pyplot.subplots(
        len(trends), 1, figsize=(8.0, 2.2 * len(trends)), squeeze=False, layout="constrained"
    )
    for axis, trend in zip(axes[:, 0], trends):
        axis.plot(trend.values, "o", markersize=3, color="#3465a4")
        for start, end, level in trend.levels:
            axis.hlines(level, start - 0.5, end - 0.5, color="#cc0000")
        axis.set_title(trend.name, fontsize=9, loc="left")
        axis.set_ylabel(trend.unit, fontsize=7)
        axis.set_xlabel("run", fontsize=7)
        axis.set_ylim(bottom=0.0)
    temporary = path.with_name(f".{path.stem}.part{path.suffix}")
    figure.savefig(temporary)
    pyplot.close(figure)
    temporary.replace(path)
