"""Point on a soft body's surface: its velocity, its inverse mass, and the effect of an impulse.

A point of the triangle (i, j, k) with barycentric weights w is the sum w·x of its corners. A particle is the point of
its own index, three times, with weights (1, 0, 0). An impulse is shared by the corners in proportion to w, so that its
moment is that of the same impulse at the point itself: linear and angular momentum are kept.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from softbody.compiler.jit import jit_lean
from softbody.linalg.vec import Vec, accumulate, add, load, scale

Corners = tuple[int, int, int]

WHOLE = (1.0, 0.0, 0.0)  # the weights of a particle


class SurfacePoint(NamedTuple):
    """A point on a surface: three particles and their barycentric weights."""

    particles: Corners
    weights: Vec


@jit_lean
def at_particle(i: int) -> SurfacePoint:
    """Return the point that particle `i` is."""
    return SurfacePoint((i, i, i), WHOLE)


@jit_lean
def on_edge(i: int, j: int, place: float) -> SurfacePoint:
    """Return the point of the edge from particle `i`, at `place` 0, to particle `j`, at 1."""
    return SurfacePoint((i, j, j), (1.0 - place, place, 0.0))


@jit_lean
def value_at(rows: np.ndarray, point: SurfacePoint) -> Vec:
    """Return Σ w x of `rows` (n, 3): of positions, where the point is [m]; of velocities, its velocity [m/s]."""
    i, j, k = point.particles
    if i == j == k:  # a particle, as most are
        return load(rows, i)
    weights = point.weights
    return add(
        scale(weights[0], load(rows, i)), add(scale(weights[1], load(rows, j)), scale(weights[2], load(rows, k)))
    )


@jit_lean
def inverse_mass_at(inverse_mass: np.ndarray, point: SurfacePoint) -> float:
    """Return Σ w²/m [1/kg]: how easily a point moves."""
    i, j, k = point.particles
    a, b, c = point.weights
    return a * a * inverse_mass[i] + b * b * inverse_mass[j] + c * c * inverse_mass[k]


@jit_lean
def add_at(rows: np.ndarray, inverse_mass: np.ndarray, point: SurfacePoint, impulse: Vec) -> None:
    """Add w p/m to each corner's row: of velocities for an `impulse` p [N s], of positions for a shift [kg m]."""
    i, j, k = point.particles
    if i == j == k:
        accumulate(rows, i, scale(inverse_mass[i], impulse))
        return
    weights = point.weights
    accumulate(rows, i, scale(weights[0] * inverse_mass[i], impulse))
    accumulate(rows, j, scale(weights[1] * inverse_mass[j], impulse))
    accumulate(rows, k, scale(weights[2] * inverse_mass[k], impulse))
