"""How has each benchmark changed from run to run? As ratios to a peer of the same run, where there is one.

A machine that is slower on some day is so for both: what steps in the ratio is the core, or the peer.
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterator
from dataclasses import dataclass
from itertools import pairwise
from pathlib import Path

import numpy as np

from benchmarks.history import Record
from benchmarks.race import short_name
from benchmarks.steps import steps_in
from benchmarks.tables import competitors, significant

BARS = "▁▂▃▄▅▆▇█"


@dataclass(frozen=True)
class Trend:
    """One benchmark, run by run."""

    name: str
    peer: str | None  # whose time is 1; None: there is none, and values are ns
    per: str
    started: list[str]
    revisions: list[str]
    values: list[float]

    @property
    def steps(self) -> list[int]:
        """Where its level changes."""
        return steps_in([float(np.log(value)) for value in self.values])


def trends_of(records: list[Record]) -> list[Trend]:
    """Return the trend of every benchmark in some runs, which are in the order of time."""
    rows: dict[str, list[tuple[str, str, str, dict[str, np.ndarray]]]] = {}
    for record in records:
        revision = _revision(record)
        for race in record.document["benchmarks"]:
            if "table" in race["extra_info"]:
                own = race["extra_info"].get("own", ())
                times = {name: times for name, times in competitors(race).items() if name not in own}
                row = record.started, revision, race["extra_info"]["per"], times
                rows.setdefault(short_name(race["fullname"]), []).append(row)
    return [_trend(name, row) for name, row in rows.items()]


def _trend(name: str, rows: list[tuple[str, str, str, dict[str, np.ndarray]]]) -> Trend:
    counts = Counter(peer for *_, times in rows for peer in list(times)[1:])
    common = [peer for peer, count in counts.items() if count == len(rows)]
    # Of the peers that were always there, the one that varies least from round to round.
    peer = min(common, key=lambda one: np.median([_spread(times[one]) for *_, times in rows]), default=None)
    values = []
    for *_, times in rows:
        ours = next(iter(times.values()))
        values.append(1e9 * float(np.median(ours)) if peer is None else float(np.median(ours / times[peer])))
    return Trend(name, peer, rows[-1][2], [row[0] for row in rows], [row[1] for row in rows], values)


def _spread(times: np.ndarray) -> float:
    low, middle, high = np.quantile(times, (0.25, 0.5, 0.75))
    return float((high - low) / middle)


def _revision(record: Record) -> str:
    commit = record.document.get("commit_info") or {}
    return str(commit.get("id") or "unknown")[:12] + ("+" if commit.get("dirty") else "")


def lines_of(trend: Trend) -> Iterator[str]:
    """Yield what to print: a line with the last value and all of them as bars, and one for each step."""
    unit = f"× {trend.peer}" if trend.peer else f"ns per {trend.per}"
    yield f"{trend.name}: {significant(trend.values[-1])} {unit}  {sparkline(trend.values)}"
    ends = [0, *trend.steps, len(trend.values)]
    for before, at, after in zip(ends, ends[1:], ends[2:]):
        ratio = np.median(trend.values[at:after]) / np.median(trend.values[before:at])
        kind = "slower" if ratio > 1.0 else "faster"
        yield (
            f"    {kind}, × {ratio:.3f}, from {trend.started[at][:16]} on: "
            f"after {trend.revisions[at - 1]}, with {trend.revisions[at]}"
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
        ends = [0, *trend.steps, len(trend.values)]
        for start, end in pairwise(ends):
            axis.hlines(np.median(trend.values[start:end]), start - 0.5, end - 0.5, color="#cc0000")
        axis.set_title(trend.name, fontsize=9, loc="left")
        axis.set_ylabel(f"× {trend.peer}" if trend.peer else f"ns per {trend.per}", fontsize=7)
        axis.set_xlabel("run", fontsize=7)
        axis.set_ylim(bottom=0.0)
    temporary = path.with_name(f".{path.stem}.part{path.suffix}")
    figure.savefig(temporary)
    pyplot.close(figure)
    temporary.replace(path)
