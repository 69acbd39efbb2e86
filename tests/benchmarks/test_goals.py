"""A goal is a ratio of the same rounds, at the worst of its sizes; what was not measured is no success."""

from __future__ import annotations

import re
from pathlib import Path

import pytest

from benchmarks import suite
from benchmarks.goals import CLOCK, CLOSE, MET, MISSED, NOT_MEASURED, Goal, Growth, outcomes
from benchmarks.tables import goals_table

THREE = (1.0, 1.1, 0.9)


def race(size=42, ours=THREE, theirs=THREE, name="ours", peer="a peer", table="Steps of things", clock=None):
    info = {"table": table, "name": name, "size": size, "of": "things", "per": "step", "units": 10, "clock": clock}
    return {"extra_info": info | {"peers": {peer: {"units": 5, "seconds": theirs}}}, "stats": {"data": ours}}


def outcome(goal, *races):
    (found,) = outcomes({"benchmarks": [*races, {"extra_info": {}, "stats": {"data": [1.0]}}]}, [goal])
    return found


@pytest.mark.parametrize(
    ("theirs", "verdict", "measured"),
    [
        ((2.0, 2.2, 1.8), MET, 4.0),  # units: 5 of theirs, 10 of ours
        ((1.0, 1.1, 0.9), MISSED, 2.0),
        ((1.0, 2.2, 1.3), CLOSE, 2 * 1.3 / 0.9),  # ratios 2, 4, 2.9
    ],
)
def test_a_goal_is_met_or_missed_by_the_ratios_of_rounds(theirs, verdict, measured):
    found = outcome(Goal("a peer", 3.0, name="ours", table="Steps*"), race(theirs=theirs))
    assert found.verdict == verdict
    assert found.measured == pytest.approx(measured)
    assert found.low <= found.measured <= found.high


def test_the_worst_size_counts_of_those_that_the_goal_is_for():
    races = [race(10, theirs=(9.0,) * 3), race(1_000, theirs=(4.0,) * 3), race(50_000, theirs=(1.0,) * 3)]
    within = outcome(Goal("a peer", 3.0, (0, 1_000), "ours", "Steps*"), *races)
    assert (within.verdict, within.where) == (MET, "1 000 things")
    assert within.what == "ours against a peer, to 1 000 things"
    assert outcome(Goal("a peer", 3.0, name="ours", table="Steps*"), *races).where == "50 000 things"
    beyond = outcome(Goal("a peer", 3.0, (100_000, 200_000), "ours", "Steps*"), *races)
    assert (beyond.verdict, beyond.measured) == (NOT_MEASURED, None)


def test_a_peer_may_be_the_core_on_more_threads_and_is_asked_the_other_way_round():
    goal = Goal("ours", 1.8, name="ours, 2 threads", table="Steps*")
    found = outcome(goal, race(peer="ours, 2 threads", theirs=(0.25,) * 3))
    assert (found.verdict, found.measured) == (MET, pytest.approx(2.0))


def test_the_clock_is_a_peer_where_there_is_motion():
    goal = Goal(CLOCK, 8.0, name="ours", table="Steps*")
    found = outcome(goal, race(ours=(1.0,) * 3, clock=0.9))  # 0.1 s of work for 0.9 s of motion
    assert (found.verdict, found.measured) == (MET, pytest.approx(9.0))
    assert outcome(goal, race()).verdict == NOT_MEASURED


def test_growth_is_the_exponent_of_the_whole_cost():
    goal = Growth(1.1, (10, 10_000), "ours", "Steps*")
    races = [race(size, ours=(size**0.25,) * 3) for size in (10, 100, 1_000)]
    found = outcome(goal, *races, race(1, ours=(1.0,) * 3))
    assert (found.verdict, found.measured) == (MISSED, pytest.approx(1.25))
    assert found.where == "10 things to 1 000 things"
    assert not found.is_least
    assert outcome(goal, *races[:2]).verdict == NOT_MEASURED


def test_a_table_of_goals_says_all_of_them():
    goals = [
        Goal("a peer", 3.0, name="ours", table="Steps*"),
        Goal("a [peer] *", 3.0, name="ours", table="Other*"),
        Growth(1.1, name="x", table="Other"),
    ]
    table = goals_table(outcomes({"benchmarks": [race()]}, goals))
    assert list(table.columns[-1].cells) == [MISSED, NOT_MEASURED, NOT_MEASURED]
    assert list(table.columns[2].cells) == ["≥ 3", "≥ 3", "≤ 1.1"]


def test_every_goal_names_rows_that_the_benchmarks_have():
    sources = "".join(path.read_text() for path in Path("benchmarks/suite").glob("bench_*.py"))
    rows = re.sub(r"\b(Goal|Growth)\(.*", "", sources).replace("{THREADS}", "2")
    for goal in suite.goals():
        names = goal.table, goal.name, *([goal.peer] if isinstance(goal, Goal) else [])
        for name in set(names) - {CLOCK}:
            for part in filter(None, name.split("*")):
                assert part.strip() in rows, f"no benchmark has {part!r}"
