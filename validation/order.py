"""Order in which claims find most soonest: first those that see many planted faults in little time."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING

from validation.record import read_report

if TYPE_CHECKING:
    from validation.check import Check

LEAST_SECONDS = 0.01  # of a claim: what is quicker is as quick


def soonest_first(checks: Sequence[Check], folder: Path) -> list[Check]:
    """Return checks by the faults that each names a second; of its seconds the last report in `folder` knows.

    Those that it does not know take a second, and without one all do. Equal ones stay in their order.
    """
    seconds = seconds_before(folder / "report.json")

    return sorted(checks, key=lambda check: -faults_a_second(len(check.faults), seconds.get(check.id, 1.0)))


def faults_a_second(faults: int, seconds: float) -> float:
    """Return what a claim finds in a second, which names so many faults and takes so long."""
    return max(faults, 1) / max(seconds, LEAST_SECONDS)


def seconds_before(path: Path) -> dict[str, float]:
    """Return how long claims took when a report was made; nothing if there is none that can be read."""
    try:
        return {claim.id: claim.seconds for claim in read_report(path).claims}
    except (OSError, ValueError):
        return {}
