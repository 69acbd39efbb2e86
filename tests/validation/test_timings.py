"""Timings come from pytest-benchmark's file: per unit of work, and as ratios of the same round."""

from __future__ import annotations

from validation.timings import rows_of


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
