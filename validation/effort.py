"""How hard an engine tries, by shorter steps and more iterations than it is asked for, and what that costs it.

A claim asks for steps, and an engine has its usual iterations; both are 1 of an `Effort`. An adapter asks here for how
many iterations it is to make, `iterations(usual)`, and one that chooses its own steps, for how much shorter they are.
What an engine's steps take is told by `spending`, in seconds of the processor: other processes do not change them much.
"""

from __future__ import annotations

import time
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass


@dataclass(frozen=True)
class Effort:
    """Factors on what is usual."""

    steps: float = 1.0
    iterations: float = 1.0


USUAL = Effort()
_now = [USUAL]
_spent: list[float] = []  # seconds of the processor, of each time that steps were taken


@contextmanager
def trying(effort: Effort) -> Iterator[None]:
    """Let engines try so hard meanwhile."""
    before, _now[0] = _now[0], effort
    try:
        yield
    finally:
        _now[0] = before


def finer() -> float:
    """Return by what factor a step is to be shorter than an adapter would choose it."""
    return _now[0].steps


def iterations(usual: int) -> int:
    """Return how many iterations a solver is to make that usually makes so many."""
    return max(1, round(_now[0].iterations * usual))


@contextmanager
def spending() -> Iterator[None]:
    """Count what is done meanwhile as the engine's work, if no part of it has been counted by then."""
    begun, counted = time.process_time(), len(_spent)
    try:
        yield
    finally:
        if len(_spent) == counted:
            spent(time.process_time() - begun)


def spent(seconds: float) -> None:
    """Count so many seconds of the processor as the engine's work."""
    _spent.append(seconds)


def taken() -> float:
    """Return the seconds that were counted since this was asked last."""
    seconds = sum(_spent)
    _spent.clear()
    return seconds
