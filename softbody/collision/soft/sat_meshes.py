"""Separating-axis test of two meshes along the normals of their faces, before particles are looked for; §4.3, §4.5.

Meshes that a normal parts do not touch, convex or not, so that this saves work and changes nothing. Meshes that none
parts may be apart all the same: concave ones, and those that only a direction across two edges parts.
"""

from __future__ import annotations

import numpy as np

from softbody.compiler.jit import jit_lean
from softbody.geometry.triangle import area_vector
from softbody.linalg.vec import Vec, dot, load, sub


@jit_lean
def faces_part(
    points: np.ndarray, triangles: np.ndarray, other_points: np.ndarray, other_triangles: np.ndarray
) -> bool:
    """Tell whether the normal of a triangle of one mesh or of the other parts them: (n, 3) [m] and (t, 3) of each."""
    return _own_faces_part(points, triangles, other_points) or _own_faces_part(other_points, other_triangles, points)


@jit_lean
def _own_faces_part(points: np.ndarray, triangles: np.ndarray, other_points: np.ndarray) -> bool:
    for t in range(triangles.shape[0]):
        i, j, k = triangles[t, 0], triangles[t, 1], triangles[t, 2]
        normal = area_vector(load(points, i), load(points, j), load(points, k))
        # Both ends, for the normal of a dent points at what is across it. Mostly a few points tell that neither parts.
        if _is_beyond(normal, other_points, points, i) or _is_beyond(normal, points, other_points, 0):
            return True
    return False


@jit_lean
def _is_beyond(direction: Vec, points: np.ndarray, others: np.ndarray, guess: int) -> bool:
    """Tell whether all `points` are farther along `direction` than all `others`, of which `guess` may be farthest."""
    origin = load(others, guess)
    nearest = np.inf
    for p in range(points.shape[0]):
        nearest = min(nearest, dot(direction, sub(load(points, p), origin)))
        if nearest <= 0.0:
            return False
    farthest = 0.0
    for p in range(others.shape[0]):
        farthest = max(farthest, dot(direction, sub(load(others, p), origin)))
    return farthest < nearest
