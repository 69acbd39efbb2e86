"""Verdicts faster, slower, or no difference shown, from ratios, one of each time both were opened.

The same work can be some percent slower for as long as its arrays lie where they lie, so rounds of one opening are not
independent of each other; openings are. If the sides are equal, the logarithm of a ratio is as likely x as −x, whatever
its distribution: Wilcoxon's signed ranks then err exactly as often as they promise. The estimate is that of Hodges and
Lehmann (1963), the interval that of Tukey: of the means of all pairs, some are left out at either end.

It is looked at after some openings, and again after more (LOOKS), and when time is up; each look may err a share of
what all may together.
"""

from __future__ import annotations

import functools
import math
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

LOOKS = (12, 20, 28, 40, 60)  # openings
ERROR = 0.01  # how often the looks at equal sides may err, all together
FLOOR = 0.005  # of the time: less than that is never called a difference, for two processes may differ by it
RESOLUTION = 0.015  # of the time: an interval of that half width is an answer, too

FASTER, SLOWER, NO_DIFFERENCE = "faster", "slower", "no difference shown"


@dataclass(frozen=True)
class Verdict:
    """What was found: the second side's time over the first's."""

    verdict: str
    ratio: float
    low: float  # of the interval
    high: float
    noise: float  # standard deviation of one opening's ratio, robust, as a share
    openings: int
    clear: bool  # more openings are not needed

    def is_slower_than(self, allowed: float) -> bool:
        """Tell whether the second side is shown to be slower, and estimated to be so by more than a share."""
        return self.verdict == SLOWER and self.ratio > 1.0 + allowed


def verdict_of(logs: Sequence[float]) -> Verdict:
    """Return the verdict on the logarithms of the ratios of some openings."""
    values = np.sort(np.asarray(logs, float))
    estimate, low, high = signed_rank_interval(values, ERROR / (len(LOOKS) + 1))
    floor = math.log1p(FLOOR)
    verdict = SLOWER if low > floor else FASTER if high < -floor else NO_DIFFERENCE
    noise = 1.4826 * float(np.median(np.abs(values - np.median(values)))) if len(values) else math.inf
    is_narrow = high - low < 2.0 * RESOLUTION
    clear = verdict != NO_DIFFERENCE or is_narrow or len(values) >= LOOKS[-1]
    return Verdict(verdict, math.exp(estimate), math.exp(low), math.exp(high), noise, len(values), clear)


def sequential_verdict(logs: Sequence[float]) -> Verdict:
    """Return the verdict that a comparison comes to which sees these openings one after the other."""
    for look in LOOKS:
        verdict = verdict_of(logs[:look])
        if verdict.clear or look >= len(logs):
            break
    return verdict


def signed_rank_interval(values: np.ndarray, error: float) -> tuple[float, float, float]:
    """Return the estimate of the centre, and an interval that misses it with a chance of at most `error`."""
    n = len(values)
    if not n:
        return 0.0, -math.inf, math.inf
    i, j = np.triu_indices(n)
    means = np.sort(0.5 * (values[i] + values[j]))
    outside = int(np.searchsorted(np.cumsum(signed_rank_chances(n)), 0.5 * error, side="right"))
    if outside == 0:
        return float(np.median(means)), -math.inf, math.inf
    return float(np.median(means)), float(means[outside - 1]), float(means[-outside])


@functools.cache
def signed_rank_chances(n: int) -> np.ndarray:
    """Return the chance of each sum of ranks 0 … n (n + 1) / 2, every rank counted or not, as coins fall."""
    chances = np.ones(1)
    for rank in range(1, n + 1):
        longer = np.zeros(len(chances) + rank)
        longer[: len(chances)] += 0.5 * chances
        longer[rank:] += 0.5 * chances
        chances = longer
    return chances


def opening_ratio(pairs: Sequence[tuple[float, float]]) -> float:
    """Return the logarithm of the ratio of one opening: the median over its rounds, each a pair of neighbours."""
    seconds = np.asarray(pairs, float)
    return float(np.median(np.log(seconds[:, 1] / seconds[:, 0])))
