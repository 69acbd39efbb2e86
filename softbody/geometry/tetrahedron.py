"""Tetrahedra: volume, barycentric weights, and whether a point is inside; for geometry users."""

from __future__ import annotations

import numpy as np

from softbody.compiler.jit import jit
from softbody.linalg.vec import Vec, cross, dot, load, sub


@jit
def tetrahedron_volume(a: Vec, b: Vec, c: Vec, d: Vec) -> float:
    """Return the signed volume [m³]: positive when (b, c, d) turns counter-clockwise seen from outside."""
    return dot(sub(b, a), cross(sub(c, a), sub(d, a))) / 6.0


@jit
def barycentric_in_tetrahedron(p: Vec, a: Vec, b: Vec, c: Vec, d: Vec) -> tuple[float, float, float, float]:
    """Return the weights (they sum to 1) that make `p` of a, b, c, d; NaN for a flat tetrahedron; paper §10.10."""
    whole = tetrahedron_volume(a, b, c, d)
    return (
        tetrahedron_volume(p, b, c, d) / whole,
        tetrahedron_volume(a, p, c, d) / whole,
        tetrahedron_volume(a, b, p, d) / whole,
        tetrahedron_volume(a, b, c, p) / whole,
    )


@jit
def point_in_tetrahedron(p: Vec, a: Vec, b: Vec, c: Vec, d: Vec) -> bool:
    """Tell whether `p` lies in the tetrahedron or on its border, whatever its orientation; paper §10.10.

    The five determinants must be of one *sign* (the paper prints "size"). A flat one contains nothing.
    """
    whole = tetrahedron_volume(a, b, c, d)
    sign = 1.0 if whole > 0.0 else -1.0
    return (
        whole != 0.0
        and sign * tetrahedron_volume(p, b, c, d) >= 0.0
        and sign * tetrahedron_volume(a, p, c, d) >= 0.0
        and sign * tetrahedron_volume(a, b, p, d) >= 0.0
        and sign * tetrahedron_volume(a, b, c, p) >= 0.0
    )


@jit
def points_in_tetrahedra(points: np.ndarray, corners: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Return (inside (m,) of bool, weights (m, 4)) of each of `points` (m, 3) [m] in its own tetrahedron; paper §10.10.

    `corners` (m, 4, 3) [m]. The weights, of the four corners, are NaN for a flat one.
    """
    inside = np.empty(points.shape[0], np.bool_)
    weights = np.empty((points.shape[0], 4))
    for q in range(points.shape[0]):
        p = load(points, q)
        a, b, c, d = load(corners[q], 0), load(corners[q], 1), load(corners[q], 2), load(corners[q], 3)
        inside[q] = point_in_tetrahedron(p, a, b, c, d)
        weights[q, 0], weights[q, 1], weights[q, 2], weights[q, 3] = barycentric_in_tetrahedron(p, a, b, c, d)
    return inside, weights
