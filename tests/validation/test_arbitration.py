"""Who was right is counted for everybody alike, with the worst case of who was wrong."""

from __future__ import annotations

from dataclasses import asdict

import numpy as np
import pytest

from validation.arbitration import US, arbitrate
from validation.check import Comparison, all_checks
from validation.judge import blank_record, weigh
from validation.record import ClaimRecord, finite, from_json


def test_yes_or_no_is_counted_and_disputes_are_where_somebody_alone_is_right() -> None:
    truth = np.array([True, False, True, True])
    answers = {US: truth.copy(), "one": np.array([True, True, True, False]), "all wrong": ~truth}
    found = arbitrate("exact arithmetic", truth, answers, inputs={"x": np.arange(4.0)})
    assert [(who.who, who.n, who.wrong) for who in found.standings] == [(US, 4, 0), ("one", 4, 2), ("all wrong", 4, 4)]
    assert found.disputed == 4
    assert found.standings[0].case is None
    case = found.standings[1].case
    assert case is not None
    assert (case.inputs, case.measured, case.expected) == ({"x": 1.0}, [True], [False])


def test_numbers_are_wrong_beyond_the_tolerance_and_what_is_no_number_is_wrong() -> None:
    truth = np.ones((3, 2))
    theirs = truth + [[0.0, 1e-3], [0.0, 3e-3], [np.nan, 0.0]]
    found = arbitrate("closed form", truth, {US: truth + 1e-9, "Bullet": theirs}, tolerance=2e-3, scale=np.ones(3))
    assert [who.wrong for who in found.standings] == [0, 2]
    assert found.disputed == 2


def test_what_is_compared_with_itself_is_refused() -> None:
    truth = np.ones(3)
    with pytest.raises(ValueError, match="share memory"):
        arbitrate("closed form", truth, {US: truth})


def test_it_is_in_the_record_and_turns_no_claim_red() -> None:
    check = all_checks()["sat.random_pairs"]
    record = blank_record(check, 1)
    a, b = np.zeros(9, bool), np.zeros(9, bool)
    found = arbitrate("exact arithmetic", b, {US: a, "fcl": ~a})
    weigh(check, Comparison(a, b, arbitrations=[found], printed=~b), record)
    assert record.verdict == "holds"
    again = from_json(ClaimRecord, finite(asdict(record)))
    assert again.arbitrations == [found]
