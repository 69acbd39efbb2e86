"""Overview of how close each claim is to failing, on a logarithmic axis of error / tolerance."""

from __future__ import annotations

import math
from collections.abc import Iterable
from dataclasses import dataclass

from reports.notation import power_of_ten
from reports.verdicts import is_count
from validation.record import ClaimRecord

# Decades shown at most, below and above the tolerance: what lies beyond sits at the edge, with an arrow.
LOWEST, HIGHEST = -10, 20


@dataclass(frozen=True)
class Axis:
    """A logarithmic axis of error / tolerance, whose ends are powers of ten."""

    low: int
    high: int

    def at(self, ratio: float) -> float:
        """Return the place of a ratio, in percent of the axis; 0 sits at the lower end."""
        log = math.log10(ratio) if ratio > 0.0 else -math.inf
        return round(100.0 * (min(max(log, self.low), self.high) - self.low) / (self.high - self.low), 2)

    @property
    def ticks(self) -> list[tuple[float, str]]:
        """Places and labels of powers of ten, few enough for a phone; the tolerance is always one of them."""
        step = math.ceil((self.high - self.low) / 6)
        powers = [p for p in range(self.low, self.high + 1) if p % step == 0]
        return [(self.at(10.0**p), power_of_ten(p)) for p in powers]


@dataclass(frozen=True)
class Strip:
    """A row of the overview: where the median, the 99th percentile and the largest error lie, in percent."""

    median: float
    p99: float
    max: float
    below: bool  # the median is below the axis, or 0
    above: bool  # the largest error is above the axis


def ratios(claim: ClaimRecord) -> tuple[float, float, float] | None:
    """Return median, 99th percentile and maximum of the errors / tolerance, or None where there is no such thing."""
    if claim.errors is None or is_count(claim) or not claim.tolerance:
        return None
    found = [claim.errors.quantiles.get(q) for q in ("0.5", "0.99", "1")]
    if any(q is None for q in found):
        return None
    median, p99, largest = (q / claim.tolerance for q in found if q is not None)
    return median, p99, largest


def axis_of(values: Iterable[float]) -> Axis:
    """Return an axis that holds the tolerance, a decade above it, and the given ratios as far as is sensible."""
    logs = [math.log10(v) for v in values if v > 0.0 and math.isfinite(v)]
    low = math.floor(min([*logs, -2.0]))
    high = math.ceil(max([*logs, 0.0]) + 0.3)
    return Axis(max(low, LOWEST), min(high, HIGHEST))


def strip(axis: Axis, median: float, p99: float, largest: float) -> Strip:
    """Return the places of a row's three ratios on an axis."""
    below = median <= 0.0 or math.log10(median) < axis.low
    above = largest > 0.0 and math.log10(largest) > axis.high
    return Strip(axis.at(median), axis.at(p99), axis.at(largest), below, above)
