"""Several draws of a claim's cases as one record; each has a seed of its own."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from typing import Any

import numpy as np

from validation.record import BROKEN, FAILS, HOLDS, NOT_RUN, ClaimRecord, Distribution, Group

LARGEST_SEED = 2**63 - 1
GRAVITY = {FAILS: 0, BROKEN: 1, NOT_RUN: 2, HOLDS: 3}  # of verdicts, the gravest first


def seeds_of(seed: int, draws: int) -> list[int]:
    """Return the seed of each draw: the run's, and those after it."""
    return [(seed + draw) % (LARGEST_SEED + 1) for draw in range(draws)]


def together(records: list[ClaimRecord]) -> ClaimRecord:
    """Return the record of a claim over all its draws, given in their order.

    Verdict, value, worst case and seed, notes, erratum and arbitrations are those of the worst draw, so that its seed
    replays them; cases and seconds are summed, errors put together.
    """
    if len(records) == 1:
        return records[0]
    worst = min(records, key=lambda one: (GRAVITY[one.verdict], -np.inf if one.value is None else -one.value))
    return replace(
        worst,
        n=sum(one.n for one in records),
        seconds=sum(one.seconds for one in records),
        draws=len(records),
        errors=_errors([one.errors for one in records if one.errors is not None and one.errors.quantiles]),
        groups=_groups([one.groups for one in records]),
    )


def _errors(parts: list[Distribution]) -> Distribution | None:
    """Return the distribution of all errors; quantiles between the least and the largest are to a bin's width."""
    if not parts:
        return None
    zeros, drawn = sum(part.zeros for part in parts), [part for part in parts if part.counts]
    ends = {"0": min(part.quantiles["0"] for part in parts), "1": max(part.quantiles["1"] for part in parts)}
    if not drawn:
        return Distribution(dict.fromkeys(parts[0].quantiles, 0.0), zeros, [], [])
    middles = np.concatenate([0.5 * (np.array(part.log10_edges)[1:] + part.log10_edges[:-1]) for part in drawn])
    counts = np.concatenate([part.counts for part in drawn])
    low, high = min(part.log10_edges[0] for part in drawn), max(part.log10_edges[-1] for part in drawn)
    edges = np.linspace(low, high, len(drawn[0].log10_edges))
    order = np.argsort(middles, kind="stable")
    below = zeros + np.cumsum(counts[order])  # how many errors are in a bin or below it

    def quantile(share: float) -> float:
        place = share * (below[-1] - 1)
        if place < zeros:
            return 0.0
        found = 10.0 ** middles[order[np.searchsorted(below, place, side="right")]]
        return float(np.clip(found, ends["0"], ends["1"]))

    quantiles = {name: ends[name] if name in ends else quantile(float(name)) for name in parts[0].quantiles}
    binned, _ = np.histogram(middles, edges, weights=counts)
    return Distribution(quantiles, zeros, edges.tolist(), binned.astype(int).tolist())


def _groups(parts: list[list[Group]]) -> list[Group]:
    """Return all kinds of cases: median of the draws' medians, largest 99th percentile, largest error."""
    by_label: dict[str, list[Group]] = {}
    for group in (group for part in parts for group in part):
        by_label.setdefault(group.label, []).append(group)
    return [
        Group(
            label,
            sum(group.n for group in same),
            _over(np.median, [group.median for group in same]),
            _over(np.max, [group.p99 for group in same]),
            _over(np.max, [group.max for group in same]),
        )
        for label, same in by_label.items()
    ]


def _over(measure: Callable[[list[float]], Any], values: list[float | None]) -> float | None:
    """Return a measure of values, or None if one of them is no number."""
    known = [value for value in values if value is not None]
    return float(measure(known)) if len(known) == len(values) else None
