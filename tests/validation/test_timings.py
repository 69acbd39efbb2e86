"""Timings come from pytest-benchmark's file: per unit of work, and as ratios of the same round."""

from __future__ import annotations

import json
import subprocess
from pathlib import Path

import pytest

from validation import timings
from validation.record import Timing
from validation.timings import add_trends, rows_of


def test_a_race_becomes_a_row_of_ours_and_one_of_each_peer() -> None:
    info = {"table": "t", "name": "ours", "size": 10, "of": "things", "per": "thing", "units": 10}
    info["peers"] = {"theirs": {"units": 5, "seconds": [1e-6, 3e-6, 2e-6]}}
    ours, theirs = rows_of({"extra_info": info, "stats": {"data": [1e-6, 1e-6, 4e-6]}})
    assert (ours.name, ours.nanoseconds, ours.ratio, ours.rounds) == ("ours", 100.0, None, 3)
    assert (theirs.name, round(theirs.nanoseconds, 9)) == ("theirs", 400.0)
    # 200/100, 600/100, 400/400 ns: the median of the ratios, not the ratio of the medians.
    assert round(theirs.ratio, 9) == 2.0
    assert round(theirs.low_ratio, 9) == 1.5
    assert round(theirs.high_ratio, 9) == 4.0
    assert not theirs.own


def test_a_peer_that_is_the_core_is_marked() -> None:
    info = {"table": "t", "name": "ours", "size": 10, "of": "things", "per": "thing", "units": 10, "own": ["all pairs"]}
    info["peers"] = {name: {"units": 5, "seconds": [1e-6]} for name in ("all pairs", "theirs")}
    rows = rows_of({"extra_info": info, "stats": {"data": [1e-6]}})
    assert {row.name: row.own for row in rows} == {"ours": False, "all pairs": True, "theirs": False}


def row_of(name: str, size: int, ratio: float | None = None) -> Timing:
    return Timing("t", name, size, "things", "thing", 1.0, 1.0, 1.0, 5, ratio)


@pytest.fixture
def history(monkeypatch: pytest.MonkeyPatch):
    """Return a function that says what the benchmarks are to answer."""

    def answer(document: dict | None, error: str = "") -> None:
        def run(command: list[str], **_: object) -> subprocess.CompletedProcess[str]:
            if document is None:
                return subprocess.CompletedProcess(command, 1, "", error)
            Path(command[command.index("--json") + 1]).write_text(json.dumps(document))
            return subprocess.CompletedProcess(command, 0, "", "")

        monkeypatch.setattr(timings.subprocess, "run", run)

    return answer


STEP = {"at": 1, "ratio": 2.0, "started": "b", "before": "old", "revision": "new"}
TREND = {
    "file": "bench_x.py",
    "name": "bench_x[10]",
    "row": {"table": "t", "name": "ours", "size": 10, "of": "things", "per": "thing"},
    "peer": "theirs",
    "started": ["a", "b"],
    "values": [1.0, 2.0],
    "steps": [STEP],
}


def test_rows_of_ours_get_the_trend_of_their_benchmark(history) -> None:
    history({"trends": [TREND]})
    rows = [row_of("ours", 10), row_of("theirs", 10, 2.0), row_of("ours", 20)]
    assert add_trends(rows) is None
    assert [bool(row.trend) for row in rows] == [True, False, False]
    assert rows[0].trend.steps[0].before == "old"


def test_without_a_history_the_reason_is_what_the_benchmarks_say(history) -> None:
    rows = [row_of("ours", 10)]
    history(None, "something else\nError: nothing is stored; `python -m benchmarks run` measures something\n")
    assert add_trends(rows) == "nothing is stored; `python -m benchmarks run` measures something"
    history({"trends": [TREND | {"row": TREND["row"] | {"size": 11}}]})
    assert add_trends(rows) == "no run that is stored has these benchmarks"
    assert rows[0].trend is None
