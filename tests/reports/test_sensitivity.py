"""What planted faults and mutants have shown stands on the page, and what is not known is said."""

from __future__ import annotations

import pytest

from reports.overview import ratios
from reports.page import page
from reports.sensitivity import by_family, rooms, seconds_for, soonest
from validation.record import PlantedFault, Sensitivity


@pytest.fixture
def tried(report):
    first, second = report.claims[0].id, report.claims[-1].id
    measured = next(claim.id for claim in report.claims if ratios(claim) is not None)
    report.sensitivity = Sensitivity(
        [
            PlantedFault(
                "a sign <turned>", "softbody.model.material.sliding_kept", [first, second], "caught", {measured: 40.0}
            ),
            PlantedFault("a factor of two", "softbody.linalg.vec.dot", [second], "escaped", {measured: 9.0}),
            PlantedFault("of a claim that is gone", "softbody.linalg.vec.dot", ["nobody.knows"], "caught"),
        ],
        mutants=110,
        killed=90,
        crashed=6,
        hung=1,
        equivalent=10,
        earlier=7,
        seen_at={"quick": 80, "standard": 17},
        survivors=["softbody/model/material.py:12 f: a < b -> a <= b"],
    )
    return report


def test_faults_are_counted_by_families_and_drawn_by_claims(tried):
    text = page(tried)
    assert "2 of 3 planted faults" in text
    assert "<b>97 %</b> of the others turn a claim red: 90 % by what it measures, 6 % because" in text
    assert "Level quick was the first to see 80, level standard 17. 7 of them were tried on an earlier core" in text
    assert "The mutant that no claim has seen" in text
    assert "a &lt; b -&gt; a &lt;= b" in text
    assert "a sign &lt;turned&gt;" in text
    assert text[text.index('<svg class="matrix"') :].count("</title></circle>") == 3 + 2  # and how wide a tolerance is
    assert [(len(family.faults), family.caught) for family in by_family(tried) if family.faults] != []


def test_a_tolerance_may_widen_as_far_as_its_smallest_fault(tried):
    (room,) = rooms(tried)
    assert (room.fault, room.off) == ("a factor of two", 9.0)
    text = page(tried)
    assert "1 of 1 would miss a fault if they were ten times as wide" in text
    assert "9 × it with “a factor of two”" in text


def test_what_a_minute_buys_is_drawn_from_what_claims_cost(tried):
    first, *_, last = tried.claims
    for claim in tried.claims:
        claim.seconds, claim.faults = 4.0, []
    first.seconds, last.seconds = 1.0, 2.0
    course = soonest(tried)
    assert course[:3] == [(0.0, 0), (1.0, 1), (3.0, 1)]  # the same fault is not seen twice
    assert seconds_for(course, 0.5) == 1.0
    assert "all within 1 of" in page(tried)


def test_what_was_not_tried_says_how_to(report):
    report.sensitivity = Sensitivity(
        faults_why="not tried: make faults", mutants_why="tried on another core: make mutants again"
    )
    text = page(report)
    assert "not tried: make faults" in text
    assert "tried on another core: make mutants again" in text


def test_records_that_do_not_know_say_nothing(report):
    report.sensitivity = None
    assert "have been seen to detect" not in page(report)
