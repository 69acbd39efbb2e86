"""Draws of a claim's cases are one record: the worst, with the seed that replays it, and the sum."""

from __future__ import annotations

import json
from dataclasses import replace

import numpy as np
import pytest

from tests.validation.test_run import place, results, run  # noqa: F401
from validation.check import all_checks
from validation.draws import LARGEST_SEED, seeds_of, together
from validation.judge import blank_record, distribution, groups
from validation.record import BROKEN, FAILS, HOLDS, NOT_RUN, ClaimRecord


def record(seed: int, errors: np.ndarray, verdict: str = HOLDS) -> ClaimRecord:
    """Return what became of some errors."""
    blank = blank_record(next(iter(all_checks().values())), seed)
    labels = np.where(np.arange(len(errors)) % 2, "odd", "even")
    return replace(
        blank,
        value=float(errors.max()),
        n=len(errors),
        verdict=verdict,
        why=f"of seed {seed}",
        seconds=1.0,
        errors=distribution(errors),
        groups=groups(errors, labels, False),
    )


def test_the_worst_is_kept_and_the_rest_is_summed() -> None:
    rng = np.random.default_rng(1)
    errors = [10.0 ** rng.normal(-9.0, 1.0, 1000) for _ in range(5)]
    errors[2][:300] = 0.0
    whole = together([record(seed, part) for seed, part in enumerate(errors)])
    every = np.concatenate(errors)
    worst = int(np.argmax([part.max() for part in errors]))
    assert (whole.seed, whole.why, whole.value) == (worst, f"of seed {worst}", every.max())
    assert (whole.n, whole.seconds, whole.draws) == (5000, 5.0, 5)
    assert whole.errors is not None
    assert whole.errors.zeros == 300
    assert sum(whole.errors.counts) == 4700
    assert (whole.errors.quantiles["0"], whole.errors.quantiles["1"]) == (0.0, every.max())
    bin_width = np.diff(whole.errors.log10_edges).max()
    for name in ("0.5", "0.9", "0.99"):
        assert abs(np.log10(whole.errors.quantiles[name]) - np.log10(np.quantile(every, float(name)))) < 1.5 * bin_width
    assert {group.label: group.n for group in whole.groups} == {"even": 2500, "odd": 2500}
    assert max(group.max or 0.0 for group in whole.groups) == every.max()


@pytest.mark.parametrize("order", [(0, 1, 2, 3), (3, 2, 1, 0)])
def test_the_gravest_verdict_counts(order: tuple[int, ...]) -> None:
    some = np.array([1e-9, 2e-9])
    four = [record(k, some, verdict) for k, verdict in enumerate((HOLDS, NOT_RUN, BROKEN, FAILS))]
    four[2].value = four[1].value = None
    whole = together([four[k] for k in order])
    assert (whole.verdict, whole.seed) == (FAILS, 3)
    four[3].verdict = HOLDS
    assert together([four[k] for k in order]).verdict == BROKEN


def test_what_gave_no_number_is_worse_than_a_number() -> None:
    some = np.array([1e-9, 2e-9])
    first, second = record(1, some, FAILS), record(2, some, FAILS)
    second.value = second.errors = None
    assert together([first, second]).seed == 2
    assert together([first, second]).value is None


def test_errors_that_are_all_zero_stay_zero() -> None:
    whole = together([record(k, np.zeros(4)) for k in range(3)])
    assert whole.errors is not None
    assert (whole.errors.zeros, whole.errors.counts, set(whole.errors.quantiles.values())) == (12, [], {0.0})


def test_one_draw_is_itself_and_seeds_do_not_run_over() -> None:
    one = record(7, np.array([1e-9]))
    assert together([one]) is one
    assert seeds_of(LARGEST_SEED, 3) == [LARGEST_SEED, 0, 1]


def test_draws_of_a_run_are_runs_of_their_seeds_for_any_number_of_workers(place) -> None:  # noqa: F811
    folder = place(count=3)
    for out, workers in (("one", "1"), ("three", "3")):
        assert run(folder, "--draws", "2", "--seed", "5", "--workers", workers, "--out", out).returncode == 0
    assert results(folder / "one") == results(folder / "three")
    values = []
    for seed in range(5, 7):
        assert run(folder, "--seed", str(seed), "--out", f"seed{seed}").returncode == 0
        values.append([claim["value"] for claim in results(folder / f"seed{seed}")])
    for k, claim in enumerate(results(folder / "one")):
        assert claim["value"] == max(row[k] for row in values)
        assert claim["seed"] == 5 + int(np.argmax([row[k] for row in values]))
        assert (claim["n"], claim["draws"]) == (2000, 2)
    assert json.loads((folder / "one" / "report.json").read_text())["draws"] == 2
    page = (folder / "one" / "index.html").read_text(encoding="utf-8")
    assert "the worst of 2 draws" in page
    assert "--draws 2" in page
