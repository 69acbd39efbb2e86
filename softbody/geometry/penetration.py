"""Which points of one body are inside another, how deep, and under which triangle? The narrow phase of soft bodies."""

from __future__ import annotations

from math import isfinite
from typing import NamedTuple

import numpy as np

from softbody.geometry.closest import closest_triangle, closest_triangle_of_boxes
from softbody.geometry.parity_grid import (
    COLUMNS_PER_TRIANGLE,
    ParityGrid,
    bounding_box,
    may_matter,
    points_in_parity_grid,
    rebuild_parity_grid_within,
)
from softbody.geometry.polyhedron import point_in_polyhedron, ray_hits_triangle
from softbody.geometry.triangle_tree import Search, TriangleTree, closest_in_tree, refit_triangle_tree, search_space
from softbody.jit import jit, jit_lean
from softbody.vec import Vec, add, dot, load, norm, scale, store, sub

# Some ten roundings of 1e-16, of a product of two lengths, and more.
ROUNDING = 1e-14

# So many points are tried against every triangle that may lie above them: a grid costs as much, at any size.
FEW = 16

# For so many, the triangles whose boxes are near are tried: to refit a tree costs as much as two, and more memory.
FEW_INSIDE = 2


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


@jit_lean
def _write(found: Penetrations, row: int, point: int, triangle: int, weights: Vec, depth: float) -> None:
    found.point[row] = point
    found.triangle[row] = triangle
    store(found.weights, row, weights)
    found.depth[row] = depth


@jit_lean
def _reach(vertices: np.ndarray, middle: Vec, way: Vec) -> float:
    """Return how far `vertices` (n, 3) [m] reach along `way`, from `middle` [m], times its length."""
    reach = -np.inf
    for i in range(vertices.shape[0]):
        reach = max(reach, dot(sub(load(vertices, i), middle), way))
    return reach


@jit_lean
def _gather(
    points: np.ndarray,
    low: Vec,
    high: Vec,
    middle: Vec,
    way: Vec,
    reach: float,
    number: np.ndarray,
    candidates: np.ndarray,
) -> int:
    """Copy those of `points` that are between two corners and not beyond `reach`, with their numbers; return how many.

    `reach` along `way`, from `middle`, as above: a plane across the line between the middles of two bodies often parts
    them where their bounding boxes overlap.
    """
    count = 0
    for i in range(points.shape[0]):
        p = load(points, i)
        number[count] = i
        store(candidates, count, p)
        across = (p[0] >= low[0]) & (p[0] <= high[0]) & (p[1] >= low[1]) & (p[1] <= high[1])
        count += across & (p[2] >= low[2]) & (p[2] <= high[2]) & (dot(sub(p, middle), way) <= reach)
    return count


@jit
def _find_inside(points: np.ndarray, vertices: np.ndarray, triangles: np.ndarray, inside: np.ndarray) -> None:
    """Write into `inside` (m,) whether each of a few `points` (m, 3) [m] is inside a mesh: as `point_in_polyhedron`.

    Of the triangles only those count that the +z ray of a point between all of these can meet.
    """
    low, high = bounding_box(points)
    above = np.empty(triangles.shape[0], np.int64)
    count = 0
    for t in range(triangles.shape[0]):
        a, b, c = load(vertices, triangles[t, 0]), load(vertices, triangles[t, 1]), load(vertices, triangles[t, 2])
        above[count] = t
        count += may_matter(a, b, c, low, high)
    for i in range(points.shape[0]):
        p = load(points, i)
        odd = False
        for k in range(count):
            i0, i1, i2 = triangles[above[k], 0], triangles[above[k], 1], triangles[above[k], 2]
            odd ^= ray_hits_triangle(p, load(vertices, i0), load(vertices, i1), load(vertices, i2))
        inside[i] = odd


@jit_lean
def _find_closest(
    points: np.ndarray,
    number: np.ndarray,
    count: int,
    tree: TriangleTree,
    vertices: np.ndarray,
    search: Search,
    found: Penetrations,
) -> None:
    """Write which triangle is closest to each of the first `count` points of `number`."""
    for row in range(count):
        triangle, weights, depth = closest_in_tree(load(points, number[row]), tree, vertices, search)
        _write(found, row, number[row], triangle, weights, depth)


@jit_lean
def _find_closest_few(
    points: np.ndarray, number: np.ndarray, count: int, vertices: np.ndarray, triangles: np.ndarray, found: Penetrations
) -> None:
    """Do the same without a tree."""
    for row in range(count):
        _write(found, row, number[row], *closest_triangle_of_boxes(load(points, number[row]), vertices, triangles))


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
    middle = scale(0.5, add(low_b, high_b))
    way = sub(scale(0.5, add(low_a, high_a)), middle)
    reach = _reach(vertices, middle, way) + ROUNDING * norm(way) * norm(sub(high_b, low_b))
    count = _gather(points, low, high, middle, way, reach, number, candidates)
    if count == 0:
        return 0
    inside = np.empty(count, np.bool_)
    if count <= FEW:
        _find_inside(candidates[:count], vertices, grid.triangles, inside)
    else:
        # No more columns than the points are worth.
        rebuild_parity_grid_within(grid, vertices, low, high, COLUMNS_PER_TRIANGLE * (4 * count + 64))
        points_in_parity_grid(candidates, grid, vertices, inside, 0, count)
    total = 0
    for i in range(count):
        if inside[i]:
            number[total] = number[i]
            total += 1
    if total == 0:
        return 0
    rows = min(total, found.point.shape[0])
    if total <= FEW_INSIDE:
        _find_closest_few(points, number, rows, vertices, grid.triangles, found)
    else:
        refit_triangle_tree(tree, vertices)
        _find_closest(points, number, rows, tree, vertices, search_space(tree), found)
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
