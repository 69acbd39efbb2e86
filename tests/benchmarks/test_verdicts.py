"""Verdicts err as seldom as they promise, whatever the noise, and find what they should."""

from __future__ import annotations

import itertools
import math

import numpy as np
import pytest
from scipy import stats

from benchmarks.verdicts import (
    ERROR,
    FASTER,
    LOOKS,
    NO_DIFFERENCE,
    SLOWER,
    opening_ratio,
    sequential_verdict,
    signed_rank_chances,
    signed_rank_interval,
    verdict_of,
)

NOISES = {
    "normal": lambda rng, n: rng.normal(size=n),
    "heavy tails": lambda rng, n: rng.standard_t(2, n),
    "two moods of the machine": lambda rng, n: rng.normal(size=n) * np.where(rng.random(n) < 0.2, 8.0, 1.0),
    "skewed to both sides": lambda rng, n: rng.choice([-1.0, 1.0], n) * rng.exponential(size=n),
}


def verdicts(noise, size, slower, count=400):
    rng = np.random.default_rng(13)
    series = (size * NOISES[noise](rng, LOOKS[-1]) + math.log1p(slower) for _ in range(count))
    return [sequential_verdict(list(one)) for one in series]


@pytest.mark.parametrize("noise", NOISES)
@pytest.mark.parametrize("size", [0.003, 0.015, 0.04])
def test_equal_sides_are_called_different_at_most_as_often_as_promised(noise, size):
    alarms = sum(one.verdict != NO_DIFFERENCE for one in verdicts(noise, size, 0.0))
    assert alarms <= stats.binom.ppf(0.999, 400, ERROR)


def test_three_percent_are_found_in_the_noise_of_a_busy_machine():
    assert np.mean([one.verdict == SLOWER for one in verdicts("normal", 0.02, 0.03)]) >= 0.95


def test_ten_percent_are_always_found():
    assert all(one.verdict == SLOWER for one in verdicts("two moods of the machine", 0.02, 0.1))


def test_what_is_clear_takes_few_openings():
    assert verdicts("normal", 0.01, 0.1, 1)[0].openings == LOOKS[0]
    assert verdicts("normal", 0.001, 0.0, 1)[0].openings == LOOKS[0]


def test_faster_is_slower_the_other_way_round():
    logs = np.random.default_rng(1).normal(0.05, 0.01, 20)
    slower, faster = verdict_of(logs), verdict_of(-logs)
    assert (slower.verdict, faster.verdict) == (SLOWER, FASTER)
    assert faster.ratio == pytest.approx(1.0 / slower.ratio)
    assert faster.low == pytest.approx(1.0 / slower.high)


def test_the_chances_of_signed_ranks_are_those_of_all_signs():
    n = 7
    sums = [sum(r for r, sign in zip(range(1, n + 1), signs) if sign) for signs in itertools.product([0, 1], repeat=n)]
    assert signed_rank_chances(n) == pytest.approx(np.bincount(sums) / 2**n)


def test_the_interval_is_what_wilcoxon_does_not_reject():
    values = np.sort(np.random.default_rng(2).normal(0.01, 0.02, 15))
    _, low, high = signed_rank_interval(values, 0.05)
    for centre, is_inside in [(low, True), (low - 1e-9, False), (high, True), (high + 1e-9, False)]:
        # A hair inside or outside of the interval, so that no difference is 0.
        p = stats.wilcoxon(values - (centre + math.copysign(1e-12, values.mean() - centre)), method="exact").pvalue
        assert (p > 0.05) == is_inside


def test_few_openings_show_nothing():
    assert verdict_of([0.5] * 3).verdict == NO_DIFFERENCE
    assert math.isinf(verdict_of([0.5] * 3).high)
    assert not verdict_of([]).clear


def test_a_round_in_which_the_machine_did_something_else_does_not_count():
    assert opening_ratio([(1.0, 1.02), (1.0, 5.0), (1.0, 1.02), (3.0, 1.0), (2.0, 2.04)]) == pytest.approx(
        math.log(1.02)
    )
