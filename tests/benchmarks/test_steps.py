"""Steps are found where they were made, where `ruptures` finds them, and seldom where there is none."""

from __future__ import annotations

import numpy as np
import pytest
import ruptures

from benchmarks.steps import steps_in

LEVELS = {
    "one": ([0.0, 0.1], [20, 15]),
    "up and down": ([0.0, 0.08, 0.0], [15, 12, 18]),
    "small after large": ([0.0, 1.0, 1.06], [12, 14, 14]),
}


def series_of(levels, lengths, noise=0.01, seed=0):
    rng = np.random.default_rng(seed)
    return np.repeat(levels, lengths) + noise * rng.normal(size=sum(lengths))


@pytest.mark.parametrize("name", LEVELS)
def test_known_steps_are_found_where_they_are(name):
    levels, lengths = LEVELS[name]
    assert steps_in(series_of(levels, lengths)) == list(np.cumsum(lengths)[:-1])


@pytest.mark.parametrize("name", LEVELS)
@pytest.mark.parametrize("seed", range(3))
def test_ruptures_finds_the_same_steps(name, seed):
    series = series_of(*LEVELS[name], seed=seed)
    found = ruptures.Pelt(model="l2", min_size=3, jump=1).fit(series).predict(pen=6.0 * np.log(len(series)) * 0.01**2)
    assert steps_in(series) == found[:-1]


def test_noise_alone_has_no_steps():
    found = [steps_in(series_of([0.0], [30], seed=seed)) for seed in range(60)]
    assert sum(map(bool, found)) <= 3  # one in a hundred is promised


def test_a_step_smaller_than_the_noise_is_none():
    assert steps_in(series_of([0.0, 0.005], [40, 40])) == []


def test_an_outlier_is_no_step():
    series = series_of([0.0], [20])
    series[10] = 1.0
    assert steps_in(series) == []


@pytest.mark.parametrize("values", [[], [1.0], [1.0] * 5, [1.0] * 20])
def test_short_and_constant_series_have_no_steps(values):
    assert steps_in(values) == []
