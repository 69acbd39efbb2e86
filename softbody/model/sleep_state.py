"""Who is at rest: what kernels know of bodies that sleep."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from softbody.compiler.jit import jit_lean
from softbody.model.arrays import Model


class SleepState(NamedTuple):
    """Who is at rest, and for how long; boxes are numbered after soft bodies, joints after them."""

    time: np.ndarray  # (b + m,) [s] for which each body has been slow
    asleep: np.ndarray  # (b + m,) of bool: in this step, or in the last one
    settled: np.ndarray  # (b + m,) of bool: which slept in the step before, too, since when nothing of them has changed
    mark: np.ndarray  # (b + m + j + 1,) what tells that a user has changed each, and, at last, what acts on all
    box_inverse_mass: np.ndarray  # (m,) [1/kg]; in the Model that steps read, that of a box that sleeps is 0
    centre: np.ndarray  # (b + m, 3) [m] of the bounding spheres of those who sleep, of this
    radius: np.ndarray  # (b + m,) [m]
    low: np.ndarray  # (b + m, 3) [m] corner of their bounding boxes
    high: np.ndarray  # (b + m, 3) [m]


class Rested(NamedTuple):
    """For how long bodies have been at rest, boxes after soft bodies: what a snapshot says of it."""

    time: np.ndarray  # (b + m,) [s]
    asleep: np.ndarray  # (b + m,) 1 for those that slept in the last step, 0 for others


def not_rested(model: Model) -> Rested:
    """Return what is said of bodies that are new."""
    count = model.soft_count + model.box_count
    return Rested(np.zeros(count), np.zeros(count, np.int64))


@jit_lean
def sleeps(rest: SleepState | None, body: int) -> bool:
    """Tell whether a body sleeps in this step; `rest` is None where nobody may."""
    if rest is None:
        return False
    return bool(rest.asleep[body])


@jit_lean
def is_settled(rest: SleepState | None, body: int) -> bool:
    """Tell whether all that is known of a body is as in the last step."""
    if rest is None:
        return False
    return bool(rest.settled[body])
