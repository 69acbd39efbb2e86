"""Edges of triangles: how long they are, and which of them each side of a triangle is."""

from __future__ import annotations

import numpy as np

from softbody.compiler.jit import jit
from softbody.linalg.vec import load, norm, sub


@jit
def lengths_of(points: np.ndarray, edges: np.ndarray) -> np.ndarray:
    """Return the length (e,) [m] of `edges` (e, 2) between `points` (n, 3) [m]."""
    lengths = np.empty(edges.shape[0])
    for e in range(edges.shape[0]):
        lengths[e] = norm(sub(load(points, edges[e, 1]), load(points, edges[e, 0])))
    return lengths


@jit
def rows_of_edges(edges: np.ndarray, count: int, a: np.ndarray, b: np.ndarray) -> np.ndarray:
    """Return the row (k,) of the edge between each of `a` (k,) and `b` (k,), of `count` vertices.

    `edges` (e, 2), smaller number first, sorted, have all of them: a few of each first vertex.
    """
    start = np.zeros(count + 1, np.int64)
    for e in range(edges.shape[0]):
        start[edges[e, 0] + 1] += 1
    for i in range(count):
        start[i + 1] += start[i]
    rows = np.empty(a.shape[0], np.int64)
    for k in range(a.shape[0]):
        low, high = min(a[k], b[k]), max(a[k], b[k])
        first, last = start[low], start[low + 1] - 1
        while first < last:
            middle = (first + last) // 2
            if edges[middle, 1] < high:
                first = middle + 1
            else:
                last = middle
        rows[k] = first
    return rows


def edges_of_sides(triangles: np.ndarray, edges: np.ndarray, count: int) -> np.ndarray:
    """Return the edge (t, 3) of `edges` (e, 2), sorted, from each corner of `triangles` (t, 3) to the next."""
    after = np.roll(triangles, -1, axis=1)
    return rows_of_edges(edges, count, triangles.flatten(), after.ravel()).reshape(-1, 3)


def triangles_at(triangles: np.ndarray, edges: np.ndarray, count: int) -> np.ndarray:
    """Return how many of `triangles` (t, 3) have each of `edges` (e, 2), sorted: 2, or 1 on a border."""
    return np.bincount(edges_of_sides(triangles, edges, count).ravel(), minlength=len(edges))
