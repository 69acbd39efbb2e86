"""A point of a soft body's skin: how fast is it, how easily does it move, and what does an impulse do to it?

A point of the triangle (i, j, k) with barycentric weights w is the sum w·x of its corners. A particle is the patch of
its own index, three times, with weights (1, 0, 0). An impulse is shared by the corners in proportion to w, so that its
moment is that of the same impulse at the point itself: linear and angular momentum are kept.
"""

from __future__ import annotations

import numpy as np

from softbody.jit import jit_lean
from softbody.vec import Vec, accumulate, add, load, scale

Corners = tuple[int, int, int]

WHOLE = (1.0, 0.0, 0.0)  # the weights of a particle


@jit_lean
def patch_point(rows: np.ndarray, corners: Corners, weights: Vec) -> Vec:
    """Return Σ w x [m] of `rows` (n, 3) of positions; of velocities, the velocity [m/s] of the point."""
    i, j, k = corners
    return add(
        scale(weights[0], load(rows, i)), add(scale(weights[1], load(rows, j)), scale(weights[2], load(rows, k)))
    )


@jit_lean
def patch_mobility(inverse_mass: np.ndarray, corners: Corners, weights: Vec) -> float:
    """Return Σ w²/m [1/kg]: the speed that a unit impulse gives the point that it acts on; paper §4.2, §4.3."""
    i, j, k = corners
    return (
        weights[0] * weights[0] * inverse_mass[i]
        + weights[1] * weights[1] * inverse_mass[j]
        + weights[2] * weights[2] * inverse_mass[k]
    )


@jit_lean
def push_patch(rows: np.ndarray, inverse_mass: np.ndarray, corners: Corners, weights: Vec, push: Vec) -> None:
    """Add w push/m to each corner's row: of velocities for an impulse [N s], of positions for a shift [kg m]."""
    i, j, k = corners
    accumulate(rows, i, scale(weights[0] * inverse_mass[i], push))
    accumulate(rows, j, scale(weights[1] * inverse_mass[j], push))
    accumulate(rows, k, scale(weights[2] * inverse_mass[k], push))
