"""A trend is a ratio to a peer of the same run, so that a slower day is no step; a slower core is one."""

from __future__ import annotations

import re

import numpy as np
import pytest

from benchmarks.history import run_record
from benchmarks.tables import significant, timing_tables
from benchmarks.trends import draw, lines_of, sparkline, trends_of

RUNS = 16


def records(make_document, slow_day=1.0, slow_core=1.0, peer=True):
    rng = np.random.default_rng(5)

    def rounds(mean):
        return (mean * rng.normal(1.0, 0.01, 7)).tolist()

    made = []
    for run in range(RUNS):
        late = run >= RUNS // 2
        day, core = (slow_day, slow_core) if late else (1.0, 1.0)
        theirs = rounds(2e-3 * day) if peer else None
        made.append(run_record(make_document(f"2030-01-{run + 1:02}T10:00:00", rounds(1e-3 * day * core), theirs)))
    return made


def test_a_slower_core_is_a_step_and_said(make_document):
    (trend,) = trends_of(records(make_document, slow_core=1.1))
    assert [step.at for step in trend.steps] == [RUNS // 2]
    first, step = lines_of(trend)
    assert first.startswith("bench_x.py::bench_x[42]: 0.5")
    assert "× a peer" in first
    assert re.search(r"1\.09\d* × slower", step)
    assert "2030-01-09" in step


def test_a_slower_day_is_no_step(make_document):
    (trend,) = trends_of(records(make_document, slow_day=2.0))
    assert trend.steps == []


def test_a_benchmark_whose_file_has_moved_goes_on(make_document):
    runs = records(make_document)
    runs[-1].document["benchmarks"][0]["fullname"] = "benchmarks/suite/bench_x.py::bench_x[42]"
    assert [len(trend.values) for trend in trends_of(runs)] == [RUNS]


def test_without_a_peer_there_are_nanoseconds(make_document):
    (trend,) = trends_of(records(make_document, slow_core=1.1, peer=False))
    assert trend.peer is None
    assert trend.values[0] == pytest.approx(1e5, rel=0.02)
    assert [step.at for step in trend.steps] == [RUNS // 2]


def test_what_is_the_core_itself_is_no_yardstick(make_document):
    (trend,) = trends_of([run_record(make_document(own=["a peer"]))])
    assert trend.peer is None


def test_trends_are_drawn_whole(make_document, tmp_path):
    for ending in ("png", "svg"):
        draw(trends_of(records(make_document, slow_core=1.1)), tmp_path / f"trends.{ending}")
    assert {path.name for path in tmp_path.iterdir()} == {"trends.png", "trends.svg"}


def test_a_sparkline_goes_from_the_least_to_the_greatest():
    assert sparkline([1.0, 2.0, 1.5]) == "▁█▅"
    assert sparkline([1.0, 1.0]) == "▁▁"


def test_a_table_has_a_row_a_size_and_a_column_a_competitor(make_document):
    (table,) = timing_tables(make_document())
    assert [column.header for column in table.columns] == ["particles", "softbody", "a peer"]
    assert [list(column.cells) for column in table.columns] == [["42"], ["150 000"], ["300 000"]]


@pytest.mark.parametrize(
    ("value", "text"), [(0.01234, "0.0123"), (1.234, "1.23"), (123.4, "123"), (1234567.0, "1 234 567")]
)
def test_numbers_have_three_digits_or_more(value, text):
    assert significant(value) == text
