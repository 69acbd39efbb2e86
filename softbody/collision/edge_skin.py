"""Where does an edge of one skin go through another skin, and which way out is shortest?

The paper tests vertices only: two ridges that cross may then pass through each other (§6).
"""

from __future__ import annotations

import numpy as np

from softbody.geometry.tree_hits import Hits
from softbody.geometry.triangle import area_vector, weighted_point
from softbody.geometry.triangle_tree import Search, TriangleTree, closest_in_tree
from softbody.jit import jit_lean
from softbody.vec import Vec, add, cross, dot, load, norm, scale, sub

Crossing = tuple[float, Vec, float, int, Vec]

NONE: Crossing = (0.0, (0.0, 0.0, 0.0), 0.0, -1, (0.0, 0.0, 0.0))

# Sine of the angle between two edges below which they count as parallel.
PARALLEL = 1e-9

# A depth below this part of an edge's length is rounding, as where an edge meets its own mirror image.
GRAZING = 1e-9


@jit_lean
def edge_over_ridge(p: Vec, q: Vec, hits: Hits, vertices: np.ndarray, triangles: np.ndarray) -> Crossing:
    """Return (depth [m], normal, place, triangle, weights) of the segment from `p` to `q` [m] across an edge of a mesh.

    By its two `hits`; of a segment that starts inside, the triangle closest to its start and the one it leaves by. A
    triangle of −1: the two have no edge in common that it crosses. The two edges are parted by `depth` along the unit
    `normal`, their common perpendicular, from the mesh to the segment; they touch then at the segment's `place`, 0 at p
    … 1 at q, and at the point with barycentric `weights` in `triangle`. `vertices` (n, 3) [m], `triangles` (t, 3).
    """
    enter, one, leave, other = hits
    side = _common_side(triangles, one, other)
    if side < 0:
        return NONE
    along, up, up_other = sub(q, p), facing(triangles, one, vertices), facing(triangles, other, vertices)
    u, v = load(vertices, triangles[one, side]), load(vertices, triangles[one, (side + 1) % 3])
    ridge = sub(v, u)
    across = cross(along, ridge)
    square = dot(across, across)
    if not square > PARALLEL * PARALLEL * dot(along, along) * dot(ridge, ridge):
        return NONE
    place = dot(sub(u, p), cross(ridge, across)) / square
    part = dot(sub(u, p), cross(along, across)) / square
    out = add(scale(norm(up_other), up), scale(norm(up), up_other))
    normal = scale((1.0 if dot(across, out) > 0.0 else -1.0) / np.sqrt(square), across)
    depth = dot(sub(u, p), normal)
    if not (enter <= place <= leave and 0.0 <= part <= 1.0 and depth > GRAZING * norm(along)):
        return NONE
    weights = (1.0 - part, part, 0.0) if side == 0 else (0.0, 1.0 - part, part)
    return depth, normal, place, one, weights if side < 2 else (part, 0.0, 1.0 - part)


@jit_lean
def edge_inside(p: Vec, q: Vec, hits: Hits, tree: TriangleTree, vertices: np.ndarray, search: Search) -> Crossing:
    """Return the same for the middle of what is inside of the segment, which the shortest way out parts from the mesh.

    `tree` must have been fitted to `vertices` (n, 3) [m].
    """
    enter, one, leave, _ = hits
    place = 0.5 * (enter + leave)
    if not leave - enter > GRAZING:
        return NONE
    middle = add(scale(1.0 - place, p), scale(place, q))
    triangle, weights, _ = closest_in_tree(middle, tree, vertices, search, one)
    depth, normal = way_out(middle, vertices, tree.triangles, triangle, weights)
    return depth, normal, place, triangle, weights


@jit_lean
def way_out(p: Vec, vertices: np.ndarray, triangles: np.ndarray, t: int, weights: Vec) -> tuple[float, Vec]:
    """Return (depth [m], unit normal): from `p` to a point of triangle `t`, or depth 0 if `p` is in front of it.

    The way to the closest point is along the triangle's normal, but where that point is on a reentrant edge.
    """
    a, b, c = load(vertices, triangles[t, 0]), load(vertices, triangles[t, 1]), load(vertices, triangles[t, 2])
    way = sub(weighted_point(weights[0], weights[1], weights[2], a, b, c), p)
    depth, face = norm(way), area_vector(a, b, c)
    if depth == 0.0 or dot(way, face) <= 0.0:
        return 0.0, (0.0, 0.0, 0.0)
    if depth * depth <= GRAZING * GRAZING * norm(face):  # so short a way has no direction
        return depth, scale(1.0 / norm(face), face)
    return depth, scale(1.0 / depth, way)


@jit_lean
def facing(triangles: np.ndarray, t: int, vertices: np.ndarray) -> Vec:
    """Return a vector along the normal of triangle `t`."""
    return area_vector(
        load(vertices, triangles[t, 0]), load(vertices, triangles[t, 1]), load(vertices, triangles[t, 2])
    )


@jit_lean
def _common_side(triangles: np.ndarray, one: int, other: int) -> int:
    """Return which side k of triangle `one`, from its corner k to the next, is one of `other` too, or −1."""
    for k in range(3):
        i, j = triangles[one, k], triangles[one, (k + 1) % 3]
        for m in range(3):
            if triangles[other, m] == j and triangles[other, (m + 1) % 3] == i:
                return k
    return -1
