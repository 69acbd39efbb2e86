"""Bounding spheres of sets of points."""

from __future__ import annotations

from math import sqrt

import numpy as np

from softbody.compiler.jit import jit, jit_lean
from softbody.linalg.vec import Vec, add, dot, load, scale, store, sub

# A computed distance may be too short by this part (five roundings, halved by the root): the radius is lengthened by
# it.
ROUNDING = 1.0 + 2.0**-50


@jit_lean
def _farthest(points: np.ndarray, first: int, last: int, origin: Vec) -> tuple[int, float]:
    """Return which of points[first:last] is farthest from `origin` [m], and its squared distance [m²]."""
    farthest = first
    most = -1.0
    for i in range(first, last):
        d = sub(load(points, i), origin)
        square = dot(d, d)
        if square > most:
            most = square
            farthest = i
    return farthest, most


@jit_lean
def _sphere_of_rows(points: np.ndarray, first: int, last: int) -> tuple[Vec, float]:
    if last <= first:
        return (np.nan, np.nan, np.nan), np.nan
    one, _ = _farthest(points, first, last, load(points, first))
    other, square = _farthest(points, first, last, load(points, one))
    centre = scale(0.5, add(load(points, one), load(points, other)))
    radius = 0.5 * sqrt(square)
    for i in range(first, last):
        d = sub(load(points, i), centre)
        distance = sqrt(dot(d, d))
        if distance > radius:
            # The smallest sphere around the sphere so far and this point.
            radius = 0.5 * (radius + distance)
            centre = add(centre, scale((distance - radius) / distance, d))
    # The centre has moved and been rounded: so measure once more.
    return centre, sqrt(_farthest(points, first, last, centre)[1]) * ROUNDING


@jit_lean
def radius_about(centre: Vec, points: np.ndarray) -> float:
    """Return the radius [m] of the sphere about `centre` [m] that holds all `points` (n, 3) [m], of which there are."""
    return sqrt(_farthest(points, 0, points.shape[0], centre)[1]) * ROUNDING


@jit
def bounding_sphere(points: np.ndarray) -> tuple[Vec, float]:
    """Return (centre [m], radius [m]) of a sphere that holds all `points` (n, 3) [m], if not the smallest; paper §4.

    Ritter 1990: within a fifth of the smallest radius, as a rule. NaN if there are no points.
    """
    return _sphere_of_rows(points, 0, points.shape[0])


@jit_lean
def bounding_spheres(points: np.ndarray, start: np.ndarray, centres: np.ndarray, radii: np.ndarray) -> None:
    """Write the sphere of each body i, points[start[i]:start[i + 1]], into `centres` (k, 3) and `radii` (k,) [m]."""
    for k in range(radii.shape[0]):
        centre, radius = _sphere_of_rows(points, start[k], start[k + 1])
        store(centres, k, centre)
        radii[k] = radius
