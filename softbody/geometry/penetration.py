"""Points of one body inside another, how deep, and under which triangle: the narrow phase of soft bodies.

`find_penetrations` is what every World asks, for particles and for the corners of boxes.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from softbody.compiler.jit import jit, jit_lean
from softbody.compiler.simd import LANES
from softbody.geometry.aabb import AABB, bounding_box, boxes_meet
from softbody.geometry.bvh import BVH, Search, closest_in_bvh
from softbody.geometry.bvh_rays import Heading, point_in_bvh, points_in_bvh_filtered, shortest_way_out
from softbody.geometry.closest_point import closest_triangle
from softbody.geometry.polyhedron import point_in_polyhedron
from softbody.linalg.vec import Vec, add, dot, load, norm, scale, store, sub

# Some ten roundings of 1e-16, of a product of two lengths, and more.
ROUNDING = 1e-14

INSIDE = 1 << 7  # the outcode of a point that is inside; one with another is not
UNDECIDED = 1 << 7 | 1


class Points(NamedTuple):
    """Points that move together: the vertices of a mesh, or some others, such as the corners of a box."""

    position: np.ndarray  # (m, 3) [m]
    bounds: AABB
    hint: np.ndarray  # (m,) int32: the triangle closest to each when it was last inside something, −1 for none


class Penetrations(NamedTuple):
    """The points of one body that are inside another, in order; only the first `count` rows, as returned, are set."""

    point: np.ndarray  # (capacity,) int64 its number
    triangle: np.ndarray  # (capacity,) int64 the closest triangle of the other body
    weights: np.ndarray  # (capacity, 3) barycentric, of the closest point of that triangle
    depth: np.ndarray  # (capacity,) [m] the distance to it
    outcode: np.ndarray  # (capacity,) uint8 of every point, not only of those inside: see `find_outcodes`


@jit
def points_of(position: np.ndarray) -> Points:
    """Return Points at `position` (m, 3) [m], of which nothing is known yet."""
    return Points(position, bounding_box(position), np.full(position.shape[0], np.int32(-1)))


@jit
def room_for_penetrations(capacity: int) -> Penetrations:
    """Return arrays for the answers about as many points."""
    return Penetrations(
        np.empty(capacity, np.int64),
        np.empty(capacity, np.int64),
        np.empty((capacity, 3)),
        np.empty(capacity),
        np.empty(capacity, np.uint8),
    )


@jit_lean
def _write(found: Penetrations, row: int, point: int, nearest: tuple[int, Vec, float]) -> None:
    triangle, weights, depth = nearest
    found.point[row] = point
    found.triangle[row] = triangle
    store(found.weights, row, weights)
    found.depth[row] = depth


@jit_lean
def find_outcodes(points: Points, mesh: Points, outcode: np.ndarray) -> int:
    """Write on which sides of a mesh each point is outside; return how many are outside on none.

    A bit for each side of the bounding box of the mesh, and one for a plane across the line between the middles of both
    boxes: it often parts what the boxes do not. Where all ends of an edge share a bit, all of it is outside (Cohen and
    Sutherland).
    """
    # The plane: as far along the line as the farthest vertex of the mesh.
    low, high = mesh.bounds
    middle = scale(0.5, add(low, high))
    axis = sub(scale(0.5, add(points.bounds[0], points.bounds[1])), middle)
    reach = -np.inf
    for i in range(mesh.position.shape[0]):
        reach = max(reach, dot(sub(load(mesh.position, i), middle), axis))
    reach += ROUNDING * norm(axis) * norm(sub(high, low))
    # Six bits for the box, one for the plane.
    left = 0
    for i in range(points.position.shape[0]):
        p = load(points.position, i)
        bits = (p[0] < low[0]) | (p[0] > high[0]) << 1 | (p[1] < low[1]) << 2 | (p[1] > high[1]) << 3
        bits |= (p[2] < low[2]) << 4 | (p[2] > high[2]) << 5 | (dot(sub(p, middle), axis) > reach) << 6
        outcode[i] = bits
        left += bits == 0
    return left


@jit_lean
def _middle_of_both(a: AABB, b: AABB) -> Vec:
    """Return the middle of what two boxes that meet have in common."""
    low = max(a[0][0], b[0][0]), max(a[0][1], b[0][1]), max(a[0][2], b[0][2])
    high = min(a[1][0], b[1][0]), min(a[1][1], b[1][1]), min(a[1][2], b[1][2])
    return scale(0.5, add(low, high))


@jit_lean
def _find_inside(
    points: Points, mesh: Points, tree: BVH, search: Search, outcode: np.ndarray, heading: Heading
) -> tuple[int, int]:
    """Tell which points of outcode 0 are INSIDE, by a filter in floats; return how many, and how many UNDECIDED.

    Eight at a time walk down the tree.
    """
    inside = undecided = waiting = 0
    for i in range(points.position.shape[0]):
        search.point[waiting] = i
        waiting += outcode[i] == 0
        if waiting == LANES or (i == points.position.shape[0] - 1 and waiting > 0):
            asked = search.point[:waiting]
            are_inside, in_doubt = points_in_bvh_filtered(asked, points.position, tree, mesh.position, search, heading)
            for lane in range(waiting):
                if (are_inside >> lane) & 1:
                    outcode[asked[lane]] = INSIDE
                    inside += 1
                elif (in_doubt >> lane) & 1:
                    outcode[asked[lane]] = UNDECIDED
                    undecided += 1
            waiting = 0
    return inside, undecided


@jit
def _decide_exactly(
    points: Points, mesh: Points, tree: BVH, search: Search, outcode: np.ndarray, heading: Heading
) -> int:
    """Decide by exact arithmetic which of the UNDECIDED are INSIDE; return how many are."""
    inside = 0
    for i in range(points.position.shape[0]):
        if outcode[i] == UNDECIDED:
            is_inside = point_in_bvh(i, points.position, tree, mesh.position, search, heading)
            outcode[i] = INSIDE if is_inside else 0
            inside += is_inside
    return inside


@jit_lean
def _find_closest(points: Points, mesh: Points, tree: BVH, search: Search, found: Penetrations) -> None:
    """Write which triangle is closest to each point that is INSIDE, for as many as have room; hints are replaced."""
    row, rows = 0, found.point.shape[0]
    for i in range(points.position.shape[0]):
        if found.outcode[i] == INSIDE and row < rows:
            nearest = closest_in_bvh(load(points.position, i), tree, mesh.position, search, int(points.hint[i]))
            points.hint[i] = nearest[0]
            _write(found, row, i, nearest)
            row += 1


@jit_lean
def find_inside(points: Points, mesh: Points, tree: BVH, search: Search, outcode: np.ndarray) -> int:
    """Write the `outcode` of each of `points`, INSIDE for those inside a closed mesh; return how many are.

    `mesh` are its vertices, and `tree` must have been fitted to them; `search` from `search_space`. If any number is
    not finite, nothing is inside.
    """
    if find_outcodes(points, mesh, outcode) == 0:
        return 0
    heading = shortest_way_out(_middle_of_both(points.bounds, mesh.bounds), mesh.bounds)
    inside, undecided = _find_inside(points, mesh, tree, search, outcode, heading)
    if undecided > 0:
        inside += _decide_exactly(points, mesh, tree, search, outcode, heading)
    return inside


@jit_lean
def find_penetrations(points: Points, mesh: Points, tree: BVH, search: Search, found: Penetrations) -> int:
    """Find those of `points` that are inside a closed mesh, as `find_inside` does, and its triangle closest to each.

    Paper §4.3. Returns how many are inside; the first rows of `found` hold them. If there are more than it has room
    for, the rest are counted only; its outcodes need room for all.
    """
    if not boxes_meet(points.bounds, mesh.bounds):
        return 0
    inside = find_inside(points, mesh, tree, search, found.outcode)
    if inside > 0:
        _find_closest(points, mesh, tree, search, found)
    return inside


@jit
def find_penetrations_exhaustively(
    points: np.ndarray, vertices: np.ndarray, triangles: np.ndarray, found: Penetrations
) -> int:
    """Do the same by trying every one of `points` (m, 3) [m] against every triangle, as the paper does: the baseline.

    `vertices` (n, 3) [m], `triangles` (t, 3). No outcodes are found.
    """
    total = 0
    for i in range(points.shape[0]):
        p = load(points, i)
        if point_in_polyhedron(p, vertices, triangles):
            if total < found.point.shape[0]:
                _write(found, total, i, closest_triangle(p, vertices, triangles))
            total += 1
    return total
