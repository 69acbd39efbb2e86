"""Does a claim's row show how far it is from failing?"""

import numpy as np
import pytest

from reports.overview import Axis, axis_of, ratios, strip


def test_the_axis_is_logarithmic():
    axis = Axis(-4, 1)
    assert [axis.at(r) for r in (1e-4, 1e-2, 1.0, 10.0)] == [0.0, 40.0, 80.0, 100.0]


def test_the_axis_holds_all_errors_and_the_tolerance():
    axis = axis_of([3e-7, 0.2])
    assert axis.low == -7
    assert axis.high >= 1
    assert any(label == "1" for _, label in axis.ticks)


def test_an_axis_without_errors_still_has_a_tolerance():
    assert 0.0 < axis_of([]).at(1.0) < 100.0


@pytest.mark.parametrize("decades", range(2, 31))
def test_ticks_fit_a_phone(decades):
    assert 2 <= len(Axis(-decades // 2, decades - decades // 2).ticks) <= 7


def test_what_lies_beyond_the_axis_sits_at_its_edge_and_is_marked():
    row = strip(Axis(-4, 2), 0.0, 1e-3, 1e9)
    assert (row.median, row.max, row.below, row.above) == (0.0, 100.0, True, True)


def test_ratios_are_multiples_of_the_tolerance(claim_of):
    assert ratios(claim_of(0, np.full(9, 2e-13), 1e-12)) == pytest.approx((0.2, 0.2, 0.2))


def test_claims_that_count_or_were_not_run_have_no_ratio(claim_of):
    assert ratios(claim_of(0, np.zeros(9), 0.0)) is None
    assert ratios(claim_of(0, np.ones(9), 3.0, "disagreements")) is None
    assert ratios(claim_of(0, np.ones(9), errors=None)) is None
