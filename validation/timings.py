"""Timings of the pieces, and since when: benchmarks run in a process of their own, then read."""

from __future__ import annotations

import json
import subprocess
import sys
import tempfile
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import numpy as np

from validation.record import Goal, Timing, Trend, from_json

BENCHMARKS = Path("benchmarks")


def measure_timings(level: str) -> tuple[list[Timing], list[Goal], str | None]:
    """Return the rows of the timing tables and how far goals are met, or none and the reason."""
    if not BENCHMARKS.is_dir():
        return [], [], f"{BENCHMARKS}/ is not in this folder: run from the root of the repository"
    with tempfile.TemporaryDirectory() as folder:
        written = Path(folder) / "benchmarks.json"
        command = [sys.executable, "-m", "benchmarks", "run", "--page"]
        command += ["--level", level, "--json", str(written), "--no-history"]
        done = subprocess.run(command, stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True)
        if done.returncode or not written.exists():
            return [], [], " ".join(done.stdout.strip().splitlines()[-3:])
        document = json.loads(written.read_text(encoding="utf-8"))
    rows = [row for race in document["benchmarks"] for row in rows_of(race)]
    return rows, [from_json(Goal, goal) for goal in document["goals"]], None


def add_trends(rows: list[Timing]) -> str | None:
    """Give our rows their trends, from the history of benchmarks; return why, if none gets one."""
    with tempfile.TemporaryDirectory() as folder:
        written = Path(folder) / "trends.json"
        command = [sys.executable, "-m", "benchmarks", "history", "--json", str(written)]
        done = subprocess.run(command, capture_output=True, text=True)
        if done.returncode or not written.exists():
            return " ".join(done.stderr.strip().splitlines()[-1:]).removeprefix("Error: ")
        trends = [from_json(Trend, trend) for trend in json.loads(written.read_text(encoding="utf-8"))["trends"]]
    by_row = {(trend.row["table"], trend.row["name"], trend.row["size"]): trend for trend in trends}
    for row in rows:
        row.trend = by_row.get((row.table, row.name, row.size)) if row.ratio is None else None
    return None if any(row.trend for row in rows) else "no run that is stored has these benchmarks"


def rows_of(race: dict[str, Any]) -> Iterator[Timing]:
    """Yield the rows of one race, ours first, from what pytest-benchmark wrote of it."""
    info = race["extra_info"]
    ours = np.array(race["stats"]["data"]) / info["units"]
    yield _row(info, info["name"], ours, None)
    for name, peer in info["peers"].items():
        theirs = np.array(peer["seconds"]) / peer["units"]
        yield _row(info, name, theirs, theirs / ours)


def _row(info: dict[str, Any], name: str, seconds: np.ndarray, ratios: np.ndarray | None) -> Timing:
    low, median, high = (float(1e9 * q) for q in np.quantile(seconds, (0.25, 0.5, 0.75)))
    low_ratio, ratio, high_ratio = (None,) * 3 if ratios is None else np.quantile(ratios, (0.25, 0.5, 0.75)).tolist()
    return Timing(
        table=info["table"],
        name=name,
        size=info["size"],
        of=info["of"],
        per=info["per"],
        nanoseconds=median,
        low=low,
        high=high,
        rounds=len(seconds),
        error=info.get("errors", {}).get(name),
        ratio=ratio,
        low_ratio=low_ratio,
        high_ratio=high_ratio,
        own=name in info.get("own", ()),
    )
