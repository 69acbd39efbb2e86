"""What several files of claims about worlds share."""

from __future__ import annotations

from collections.abc import Iterable
from itertools import cycle, islice

import numpy as np

from softbody import Box
from softbody.collision.soft import soft_solver
from validation.fault import Fault

NEVER_ACT = Fault(
    "contacts that never act", soft_solver._answer, "problem_.mobility[k_] > 0.0 → problem.mobility[k] > 1e300"
)
WEIGHTLESS = (0.0, 0.0, 0.0)


def by_turns(count: int, *kinds: str) -> Iterable[str]:
    """Return the kinds of so many trials: one after the other, and from the first again."""
    return islice(cycle(kinds), count)


def motion_of(box: Box) -> np.ndarray:
    """Return the velocity and the angular velocity of a box: (6,) [m/s, rad/s]."""
    return np.concatenate([box.velocity, box.angular_velocity])


def same_bits(one: np.ndarray, other: np.ndarray) -> np.ndarray:
    """Tell of each row of two arrays (n, k) of doubles whether they have the same bits: (n,)."""
    same: np.ndarray = (one.view(np.uint64) == other.view(np.uint64)).all(axis=1)
    return same
