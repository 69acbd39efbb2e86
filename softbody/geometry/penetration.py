"""Which points of one body are inside another, how deep, and under which triangle? The narrow phase of soft bodies."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from softbody.geometry.closest import closest_triangle
from softbody.geometry.parity_grid import bounding_box
from softbody.geometry.polyhedron import UNSURE, point_in_polyhedron
from softbody.geometry.tree_hits import point_in_tree, quick_point_in_tree
from softbody.geometry.triangle_tree import Search, TriangleTree, closest_in_tree, refit_triangle_tree, search_space
from softbody.jit import jit, jit_lean
from softbody.vec import Vec, add, dot, load, norm, scale, store, sub

# Some ten roundings of 1e-16, of a product of two lengths, and more.
ROUNDING = 1e-14

INSIDE = 1 << 7  # the mark of a point that is inside; one with another mark is not
IN_DOUBT = 1 << 7 | 1
BoundingBox = tuple[Vec, Vec]  # low and high corner [m]


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
def boxes_meet(a: BoundingBox, b: BoundingBox) -> bool:
    """Tell whether two boxes along the axes, each by its low and high corner [m], have a point in common.

    None has, if any number is not finite.
    """
    for axis in range(3):  # noqa: SIM110 (Numba has no all() of a generator)
        if not (a[0][axis] <= b[1][axis] and b[0][axis] <= a[1][axis]):
            return False
    return True


@jit_lean
def mark_points(
    points: np.ndarray, box: BoundingBox, vertices: np.ndarray, other: BoundingBox, mark: np.ndarray
) -> int:
    """Mark each of `points` (n, 3) [m] with the sides on which it is outside a mesh; return how many have no mark.

    `box` and `other` are the bounding boxes of the points and of the mesh's `vertices` (n, 3) [m]. A bit for each side
    of `other`, and one for a plane across the line between the middles of both: it often parts what the boxes do not.
    Where all ends of an edge share a bit, all of it is outside (Cohen and Sutherland).
    """
    low, high = other
    middle = scale(0.5, add(low, high))
    way = sub(scale(0.5, add(box[0], box[1])), middle)
    reach = -np.inf
    for i in range(vertices.shape[0]):
        reach = max(reach, dot(sub(load(vertices, i), middle), way))
    reach += ROUNDING * norm(way) * norm(sub(high, low))
    free = 0
    for i in range(points.shape[0]):
        p = load(points, i)
        bits = (p[0] < low[0]) | (p[0] > high[0]) << 1 | (p[1] < low[1]) << 2 | (p[1] > high[1]) << 3
        bits |= (p[2] < low[2]) << 4 | (p[2] > high[2]) << 5 | (dot(sub(p, middle), way) > reach) << 6
        mark[i] = bits
        free += bits == 0
    return free


@jit_lean
def mark_inside(
    points: np.ndarray, mark: np.ndarray, tree: TriangleTree, vertices: np.ndarray, search: Search
) -> tuple[int, int]:
    """Mark those of the unmarked `points` (n, 3) [m] that are INSIDE a mesh, or IN_DOUBT; return how many of each.

    In doubt are those of which only `settle_doubts` can tell. `tree` must have been fitted to `vertices` (n, 3) [m].
    """
    inside = doubts = 0
    for i in range(points.shape[0]):
        if mark[i] == 0:
            answer = quick_point_in_tree(load(points, i), tree, vertices, search)
            mark[i] = IN_DOUBT if answer == UNSURE else INSIDE * answer
            inside += answer == 1
            doubts += answer == UNSURE
    return inside, doubts


@jit
def settle_doubts(
    points: np.ndarray, mark: np.ndarray, tree: TriangleTree, vertices: np.ndarray, search: Search
) -> int:
    """Decide by exact arithmetic which of `points` (n, 3) [m] in doubt are inside; return how many are."""
    inside = 0
    for i in range(points.shape[0]):
        if mark[i] == IN_DOUBT:
            is_inside = point_in_tree(load(points, i), tree, vertices, search)
            mark[i] = INSIDE if is_inside else 0
            inside += is_inside
    return inside


@jit_lean
def find_closest(
    points: np.ndarray,
    mark: np.ndarray,
    hint: np.ndarray,
    tree: TriangleTree,
    vertices: np.ndarray,
    search: Search,
    found: Penetrations,
) -> None:
    """Write which triangle is closest to each of `points` (n, 3) [m] that is marked INSIDE, for as many as have room.

    `hint` (n,): the triangles where to look first, or −1; those of the last step, as a rule. They are replaced.
    """
    row, rows = 0, found.point.shape[0]
    for i in range(points.shape[0]):
        if mark[i] == INSIDE and row < rows:
            triangle, weights, depth = closest_in_tree(load(points, i), tree, vertices, search, hint[i])
            hint[i] = triangle
            _write(found, row, i, triangle, weights, depth)
            row += 1


@jit
def find_penetrations(points: np.ndarray, vertices: np.ndarray, tree: TriangleTree, found: Penetrations) -> int:
    """Find those of `points` (m, 3) [m] that are inside a closed mesh, and its triangle closest to each; paper §4.3.

    `vertices` (n, 3) [m] are where the mesh of `tree` is now: it is fitted to them here, if the two bodies may overlap.
    Returns how many are inside; the first rows of `found` hold them. If there are more than it has room for, the rest
    are counted only. If any number is not finite, nothing is inside.
    """
    box, other = bounding_box(points), bounding_box(vertices)
    if not boxes_meet(box, other):
        return 0
    mark = np.empty(points.shape[0], np.uint8)
    if mark_points(points, box, vertices, other, mark) == 0:
        return 0
    refit_triangle_tree(tree, vertices)
    search = search_space(tree)
    inside, doubts = mark_inside(points, mark, tree, vertices, search)
    if doubts > 0:
        inside += settle_doubts(points, mark, tree, vertices, search)
    find_closest(points, mark, np.full(points.shape[0], -1), tree, vertices, search, found)
    return inside


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
