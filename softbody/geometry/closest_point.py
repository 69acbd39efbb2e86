"""Triangle of a mesh closest to a point, by exhaustive search: every triangle is tried."""

from __future__ import annotations

from math import sqrt
from typing import NamedTuple

import numpy as np

from softbody.compiler.jit import jit, jit_lean
from softbody.geometry.triangle import closest_weights_on_triangle, squared_distance_to_triangle, weighted_point
from softbody.linalg.vec import Vec, load, store


class Closest(NamedTuple):
    """The closest triangle to each of m points, and its closest point. For a point that is not finite: −1 and NaN."""

    triangle: np.ndarray  # (m,) int64; of equally close ones, the lowest
    weights: np.ndarray  # (m, 3) barycentric, of the triangle's three vertices
    point: np.ndarray  # (m, 3) [m]
    distance: np.ndarray  # (m,) [m]


@jit_lean
def closest_triangle(p: Vec, vertices: np.ndarray, triangles: np.ndarray) -> tuple[int, Vec, float]:
    """Return (triangle, weights, distance [m]): the triangle of a mesh closest to `p` [m]; paper §4.3.

    `vertices` (n, 3) [m], `triangles` (t, 3), of any kind, also without area: see `closest_point_on_triangle`. Of
    triangles that are equally close, to the last bit, the one with the lowest number. Exhaustive:
    `softbody.geometry.bvh` gives the same answer faster. Without triangles, or for a `p` that is not finite,
    −1 and NaN.
    """
    best = np.inf
    closest = -1
    for t in range(triangles.shape[0]):
        a = load(vertices, triangles[t, 0])
        b = load(vertices, triangles[t, 1])
        c = load(vertices, triangles[t, 2])
        square = squared_distance_to_triangle(p, a, b, c)
        if square < best:
            best = square
            closest = t
    return with_weights(p, vertices, triangles, closest)


@jit_lean
def with_weights(p: Vec, vertices: np.ndarray, triangles: np.ndarray, t: int) -> tuple[int, Vec, float]:
    """Return (triangle, weights, distance [m]) of triangle `t`, seen from `p`; −1 and NaN if there is none."""
    if t < 0:
        return -1, (np.nan, np.nan, np.nan), np.nan
    a = load(vertices, triangles[t, 0])
    b = load(vertices, triangles[t, 1])
    c = load(vertices, triangles[t, 2])
    weights, square = closest_weights_on_triangle(p, a, b, c)
    return t, weights, sqrt(square)


@jit
def point_on_mesh(vertices: np.ndarray, triangles: np.ndarray, t: int, weights: Vec) -> Vec:
    """Return the point [m] with barycentric `weights` in triangle `t`; NaN for triangle −1."""
    if t < 0:
        return np.nan, np.nan, np.nan
    a = load(vertices, triangles[t, 0])
    b = load(vertices, triangles[t, 1])
    c = load(vertices, triangles[t, 2])
    return weighted_point(weights, a, b, c)


@jit
def closest_triangles(points: np.ndarray, vertices: np.ndarray, triangles: np.ndarray) -> Closest:
    """Return the closest triangle to each of `points` (m, 3) [m], exhaustively; see `closest_triangle`."""
    answers = no_answers(points.shape[0])
    for q in range(points.shape[0]):
        p = load(points, q)
        write_answer(answers, q, vertices, triangles, closest_triangle(p, vertices, triangles))
    return answers


@jit
def no_answers(count: int) -> Closest:
    """Return arrays for `count` answers, not yet filled."""
    return Closest(np.empty(count, np.int64), np.empty((count, 3)), np.empty((count, 3)), np.empty(count))


@jit
def write_answer(
    answers: Closest, q: int, vertices: np.ndarray, triangles: np.ndarray, found: tuple[int, Vec, float]
) -> None:
    """Write what was found for point `q`: triangle, weights and distance [m]."""
    t, weights, distance = found
    answers.triangle[q] = t
    store(answers.weights, q, weights)
    store(answers.point, q, point_on_mesh(vertices, triangles, t, weights))
    answers.distance[q] = distance
