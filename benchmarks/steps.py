"""Change points in a series of measurements: levels nearest to it, where every step has its price.

That is the L1 Potts functional (Storath, Weinmann and Unser 2017), minimised exactly by dynamic programming: the sum of
distances from the medians of the levels, and PRICE times the noise for each step. Distances, not squares: a single
measurement that is far off is no level. A step is at least as large as the noise of both sides.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

PRICE = 8.0  # of a step, in standard deviations of the noise: one series of a hundred without a step gets one
FEWEST = 3  # measurements between two steps


def steps_in(values: Sequence[float]) -> list[int]:
    """Return where new levels begin, in order: the numbers of the first measurements after each step."""
    series = np.asarray(values, float)
    if len(series) < 2 * FEWEST:
        return []
    found = cheapest_steps(series, PRICE * noise_of_neighbours(series))
    ends = [0, *found, len(series)]
    return [at for start, at, end in zip(ends, ends[1:], ends[2:]) if _is_large(series[start:at], series[at:end])]


def cheapest_steps(series: np.ndarray, price: float) -> list[int]:
    """Return the steps that make the sum of distances and prices least."""
    n = len(series)
    least, last = np.full(n + 1, np.inf), np.zeros(n + 1, int)
    least[0] = -price
    for end in range(FEWEST, n + 1):
        for start in range(end - FEWEST + 1):
            if least[start] + price >= least[end]:
                continue
            cost = least[start] + price + distances(series[start:end])
            if cost < least[end]:
                least[end], last[end] = cost, start
    steps, at = [], int(last[n])
    while at > 0:
        steps.append(at)
        at = int(last[at])
    return steps[::-1]


def distances(values: np.ndarray) -> float:
    """Return the sum of distances from the median."""
    return float(np.abs(values - np.median(values)).sum())


def noise_of_neighbours(series: np.ndarray) -> float:
    """Return the standard deviation of the noise, from differences of neighbours: few of them see a step."""
    return 1.4826 * float(np.median(np.abs(np.diff(series)))) / np.sqrt(2.0)


def _is_large(before: np.ndarray, after: np.ndarray) -> bool:
    step = abs(float(np.median(after) - np.median(before)))
    return step > 1.4826 * max(float(np.median(np.abs(side - np.median(side)))) for side in (before, after))
