"""Which points of one body are inside another, how deep, and under which triangle? The narrow phase of soft bodies."""

from __future__ import annotations

from math import isfinite
from typing import NamedTuple

import numpy as np

from softbody.geometry.closest import closest_triangle
from softbody.geometry.parity_grid import (
    COLUMNS_PER_TRIANGLE,
    ParityGrid,
    bounding_box,
    points_in_parity_grid,
    rebuild_parity_grid_within,
)
from softbody.geometry.polyhedron import point_in_polyhedron
from softbody.geometry.triangle_tree import TriangleTree, closest_in_tree, refit_triangle_tree, search_space
from softbody.jit import jit
from softbody.vec import Vec, load, store


class Penetrations(NamedTuple):
    """The points of one body that are inside another, in order; only the first `count` rows, as returned, are set."""

    point: np.ndarray  # (capacity,) int64 its number
    triangle: np.ndarray  # (capacity,) int64 the closest triangle of the other body
    weights: np.ndarray  # (capacity, 3) barycentric, of the closest point of that triangle
    depth: np.ndarray  # (capacity,) [m] the distance to it


@jit
def room_for_penetrations(capacity: int) -> Penetrations:
    """Return arrays for as many points; a body needs at most as many as it has."""
    return Penetrations(
        np.empty(capacity, np.int64), np.empty(capacity, np.int64), np.empty((capacity, 3)), np.empty(capacity)
    )


@jit
def _write(found: Penetrations, row: int, point: int, triangle: int, weights: Vec, depth: float) -> None:
    found.point[row] = point
    found.triangle[row] = triangle
    store(found.weights, row, weights)
    found.depth[row] = depth


@jit
def find_penetrations(
    points: np.ndarray, vertices: np.ndarray, grid: ParityGrid, tree: TriangleTree, found: Penetrations
) -> int:
    """Find those of `points` (m, 3) [m] that are inside a closed mesh, and its triangle closest to each; paper §4.3.

    `vertices` (n, 3) [m] are where the mesh of `grid` and `tree` is now: both are rebuilt here, as far as the two
    bodies overlap. Returns how many are inside; the first rows of `found` hold them. If there are more than it
    has room for, the rest are counted only. If any number is not finite, nothing is inside.
    """
    low_a, high_a = bounding_box(points)
    low_b, high_b = bounding_box(vertices)
    if not isfinite(low_a[0] + high_a[0] + low_b[0] + high_b[0]):
        return 0
    low = max(low_a[0], low_b[0]), max(low_a[1], low_b[1]), max(low_a[2], low_b[2])
    high = min(high_a[0], high_b[0]), min(high_a[1], high_b[1]), min(high_a[2], high_b[2])
    if not (low[0] <= high[0] and low[1] <= high[1] and low[2] <= high[2]):
        return 0
    number = np.empty(points.shape[0], np.int64)
    candidates = np.empty((points.shape[0], 3))
    count = 0
    for i in range(points.shape[0]):
        x, y, z = load(points, i)
        number[count] = i
        store(candidates, count, (x, y, z))
        across = (x >= low[0]) & (x <= high[0]) & (y >= low[1]) & (y <= high[1])
        count += across & (z >= low[2]) & (z <= high[2])
    if count == 0:
        return 0
    # No more columns than the points are worth.
    rebuild_parity_grid_within(grid, vertices, low, high, COLUMNS_PER_TRIANGLE * (4 * count + 64))
    inside = np.empty(count, np.bool_)
    points_in_parity_grid(candidates, grid, vertices, inside, 0, count)
    total = 0
    for i in range(count):
        if inside[i]:
            number[total] = number[i]
            total += 1
    if total == 0:
        return 0
    refit_triangle_tree(tree, vertices)
    search = search_space(tree)
    for row in range(min(total, found.point.shape[0])):
        triangle, weights, depth = closest_in_tree(load(points, number[row]), tree, vertices, search)
        _write(found, row, number[row], triangle, weights, depth)
    return total


@jit
def find_penetrations_exhaustively(
    points: np.ndarray, vertices: np.ndarray, triangles: np.ndarray, found: Penetrations
) -> int:
    """Do the same by trying every point against every triangle, as the paper does: the baseline."""
    total = 0
    for i in range(points.shape[0]):
        p = load(points, i)
        if point_in_polyhedron(p, vertices, triangles):
            if total < found.point.shape[0]:
                triangle, weights, depth = closest_triangle(p, vertices, triangles)
                _write(found, total, i, triangle, weights, depth)
            total += 1
    return total
