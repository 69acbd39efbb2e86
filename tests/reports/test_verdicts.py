"""Is "not run" never a pass, and does the sentence say what happened?"""

import numpy as np
import pytest

from reports import verdicts
from validation.record import FAILS, HOLDS, NOT_RUN


@pytest.fixture
def claims_of(claim_of):
    """Make claims that hold, fail and were not run, so many of each."""
    held, failed = np.array([1e-15]), np.array([1.0])

    def make(holds, fails, not_run):
        skipped = {"verdict": NOT_RUN, "value": None, "n": 0, "errors": None}
        return [claim_of(0, held)] * holds + [claim_of(0, failed)] * fails + [claim_of(0, held, **skipped)] * not_run

    return make


@pytest.mark.parametrize(
    ("mix", "sentence", "overall"),
    [
        ((31, 0, 0), "All 31 claims hold", HOLDS),
        ((1, 0, 0), "The only claim holds", HOLDS),
        ((29, 2, 0), "2 of 31 claims FAIL", FAILS),
        ((30, 1, 0), "1 of 31 claims FAILS", FAILS),
        ((26, 2, 3), "2 of 31 claims FAIL, 3 not run", FAILS),
        ((29, 0, 2), "29 hold, 2 not run", NOT_RUN),
        ((1, 0, 2), "1 holds, 2 not run", NOT_RUN),
        ((0, 0, 4), "None of 4 claims was run", NOT_RUN),
        ((0, 0, 1), "None of 1 claim was run", NOT_RUN),
        ((0, 0, 0), "Nothing was claimed, so nothing is shown", NOT_RUN),
    ],
)
def test_the_sentence_tells_every_mix_apart(claims_of, mix, sentence, overall):
    assert verdicts.sentence(claims_of(*mix)) == sentence
    assert verdicts.overall(claims_of(*mix)) == overall


@pytest.mark.parametrize(
    ("changes", "reason"),
    [
        ({"n": 0}, "nothing was compared"),
        ({"value": None}, "not a number"),
        ({"value": 1.0}, "exceeds its tolerance"),
    ],
)
def test_a_record_that_contradicts_itself_fails(claim_of, changes, reason):
    claim = claim_of(0, np.array([1e-15]), verdict=HOLDS, **changes)
    assert verdicts.verdict(claim) == FAILS
    assert reason in verdicts.why(claim)


def test_an_unknown_verdict_is_no_pass(claim_of):
    assert verdicts.verdict(claim_of(0, np.array([1e-15]), verdict="probably")) == FAILS


def test_cases_that_differ_are_counted(claim_of):
    assert verdicts.wrong_cases(claim_of(0, np.array([0.0, 1.0, 1.0]), 0.0, "disagreements")) == 2
    assert verdicts.wrong_cases(claim_of(0, np.array([0.0, 1e-16, 0.0]), 0.0, "m")) == 1
    assert not verdicts.is_count(claim_of(0, np.array([1.0])))
