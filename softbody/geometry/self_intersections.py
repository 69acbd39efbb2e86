"""Self-intersections of a mesh: pairs of triangles from its bounding volume hierarchy, judged exactly.

Two triangles should have in common what their common corners span, and nothing else: that they go through each other,
touch, or lie on each other is told by the signs of `predicates`, which are those of the very numbers given. Corners at
the same place count as one, so that two surfaces may share points and edges.
"""

from __future__ import annotations

import numpy as np

from softbody.compiler.jit import jit
from softbody.compiler.simd import lowest_bit
from softbody.geometry.bvh import BVH, WIDTH, Search, build_bvh, search_space
from softbody.geometry.bvh_boxes import ask_leaf, list_near
from softbody.geometry.predicates import orient2d, orient3d
from softbody.linalg.vec import Vec, load

APART, MEET, COINCIDE = 0, 1, 2

Triangle = tuple[Vec, Vec, Vec]

FIRST_ROOM = 1024  # pairs; there is more as soon as it is needed


def self_intersections(vertices: np.ndarray, triangles: np.ndarray, place: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Return the pairs (p, 2) of triangles that meet where they should not, and those (c, 2) that coincide, in order.

    `vertices` (n, 3) [m], `triangles` (t, 3), each with three corners at three places; `place` (n,) is the same number
    for all vertices that are at the same place.
    """
    tree, unfolded = build_bvh(vertices, triangles), np.zeros(len(vertices), bool)
    found = np.empty((FIRST_ROOM, 3), np.int64)
    count = find_pairs(tree, vertices, place, unfolded, search_space(tree), found)
    if count > len(found):
        found = np.empty((count, 3), np.int64)
        find_pairs(tree, vertices, place, unfolded, search_space(tree), found)
    found = found[:count]
    found = found[np.lexsort((found[:, 1], found[:, 0]))]
    return found[found[:, 2] == MEET, :2], found[found[:, 2] == COINCIDE, :2]


@jit
def find_pairs(
    tree: BVH, vertices: np.ndarray, place: np.ndarray, unfolded: np.ndarray, search: Search, found: np.ndarray
) -> int:
    """Write (t, u, MEET or COINCIDE) of pairs t < u into `found` (m, 3); return how many there are, also beyond m.

    Triangles that share a vertex which is `unfolded` (n,), see `find_unfolded`, are not looked at: most need not be.
    """
    count = 0
    for leaf in range(tree.corners.shape[0]):
        ask_leaf(search, leaf, tree, vertices, 0.0)
        for k in range(list_near(tree, search)):
            u, meets = search.listed[k], search.meets[k]
            while meets != 0:
                lane = lowest_bit(meets)
                meets &= meets - 1
                t = tree.order[WIDTH * leaf + lane]
                if t >= u or _share_one_of(unfolded, tree.triangles, t, u):
                    continue
                how = _how_they_lie(vertices, tree.triangles, place, t, u)
                if how != APART:
                    if count < found.shape[0]:
                        found[count, 0], found[count, 1], found[count, 2] = t, u, how
                    count += 1
    return count


@jit
def _share_one_of(chosen: np.ndarray, triangles: np.ndarray, t: int, u: int) -> bool:
    """Tell whether two triangles share a vertex that is `chosen` (n,)."""
    for i in range(3):
        vertex = triangles[t, i]
        is_shared = vertex == triangles[u, 0] or vertex == triangles[u, 1] or vertex == triangles[u, 2]
        if is_shared and chosen[vertex]:
            return True
    return False


@jit
def _how_they_lie(vertices: np.ndarray, triangles: np.ndarray, place: np.ndarray, t: int, u: int) -> int:
    """Tell whether two triangles MEET besides in their common corners and edge, COINCIDE, or neither."""
    shared, k, m = 0, 0, 0  # corner k of the one is corner m of the other: the last such, unless there are two
    lone = alone = 3  # the sums of the corners that are not shared: where there are two, the numbers of the third ones
    for i in range(3):
        for j in range(3):
            if place[triangles[t, i]] == place[triangles[u, j]]:
                shared += 1
                k, m = i, j
                lone, alone = lone - i, alone - j
    a, b = _turned(vertices, triangles, t, k), _turned(vertices, triangles, u, m)
    if shared == 0:
        return MEET if _meet(a, b) else APART
    if shared == 1:
        crossing = segment_meets_triangle(a[1], a[2], b) or segment_meets_triangle(b[1], b[2], a)
        return MEET if crossing else APART
    if shared == 2:
        folded = _are_folded(_turned(vertices, triangles, t, lone), load(vertices, triangles[u, alone]))
        return MEET if folded else APART
    return COINCIDE


@jit
def _turned(vertices: np.ndarray, triangles: np.ndarray, t: int, k: int) -> Triangle:
    """Return the corners [m] of a triangle, from corner `k` on."""
    return (
        load(vertices, triangles[t, k]),
        load(vertices, triangles[t, (k + 1) % 3]),
        load(vertices, triangles[t, (k + 2) % 3]),
    )


@jit
def _meet(a: Triangle, b: Triangle) -> bool:
    """Tell whether two triangles have a point in common: then an edge of one meets the other."""
    for i in range(3):
        j = (i + 1) % 3
        if segment_meets_triangle(a[i], a[j], b) or segment_meets_triangle(b[i], b[j], a):
            return True
    return False


@jit
def _are_folded(triangle: Triangle, other: Vec) -> bool:
    """Tell whether a triangle lies on its neighbour, whose corner across their common edge, 1 to 2, is `other`."""
    a, b, c = triangle
    if orient3d(a, b, c, other) != 0.0:
        return False
    axis = _steepest_axis(triangle)
    b, c = _seen_along(axis, b), _seen_along(axis, c)
    own, others = orient2d(b, c, _seen_along(axis, a)), orient2d(b, c, _seen_along(axis, other))
    return (own > 0.0 and others > 0.0) or (own < 0.0 and others < 0.0)


@jit
def segment_meets_triangle(p: Vec, q: Vec, triangle: Triangle) -> bool:
    """Tell whether the segment from `p` to `q` and a triangle [m] have a point in common, be it an end or an edge."""
    a, b, c = triangle
    before, beyond = orient3d(a, b, c, p), orient3d(a, b, c, q)
    if (before > 0.0 and beyond > 0.0) or (before < 0.0 and beyond < 0.0):
        return False
    if before == 0.0 and beyond == 0.0:
        return _meets_in_plane(p, q, triangle)
    # The line through p and q goes through the plane between them: where, as seen along it?
    return _have_one_sign(orient3d(p, q, a, b), orient3d(p, q, b, c), orient3d(p, q, c, a))


@jit
def _meets_in_plane(p: Vec, q: Vec, triangle: Triangle) -> bool:
    """Tell whether a segment in the plane of a triangle meets it."""
    axis = _steepest_axis(triangle)
    p, q = _seen_along(axis, p), _seen_along(axis, q)
    a, b, c = _seen_along(axis, triangle[0]), _seen_along(axis, triangle[1]), _seen_along(axis, triangle[2])
    if _have_one_sign(orient2d(a, b, p), orient2d(b, c, p), orient2d(c, a, p)):
        return True
    return _segments_meet(p, q, a, b) or _segments_meet(p, q, b, c) or _segments_meet(p, q, c, a)


@jit
def _have_one_sign(u: float, v: float, w: float) -> bool:
    """Tell whether none of three numbers is on the other side of 0."""
    return (u >= 0.0 and v >= 0.0 and w >= 0.0) or (u <= 0.0 and v <= 0.0 and w <= 0.0)


@jit
def _segments_meet(p: Vec, q: Vec, a: Vec, b: Vec) -> bool:
    """Tell whether two segments have a point in common, as seen from above."""
    at_p, at_q, at_a, at_b = orient2d(a, b, p), orient2d(a, b, q), orient2d(p, q, a), orient2d(p, q, b)
    if at_p == 0.0 and at_q == 0.0:  # all on one line
        return _is_between(a, b, p) or _is_between(a, b, q) or _is_between(p, q, a)
    apart = (at_p > 0.0 and at_q > 0.0) or (at_p < 0.0 and at_q < 0.0)
    return not (apart or (at_a > 0.0 and at_b > 0.0) or (at_a < 0.0 and at_b < 0.0))


@jit
def _is_between(a: Vec, b: Vec, p: Vec) -> bool:
    """Tell whether a point on the line through two others lies between them, as seen from above."""
    in_x = min(a[0], b[0]) <= p[0] <= max(a[0], b[0])
    return in_x and min(a[1], b[1]) <= p[1] <= max(a[1], b[1])


@jit
def _steepest_axis(triangle: Triangle) -> int:
    """Return the axis along which a triangle shows the largest area."""
    axis, largest = 0, -1.0
    for k in range(3):
        a, b, c = _seen_along(k, triangle[0]), _seen_along(k, triangle[1]), _seen_along(k, triangle[2])
        area = abs(orient2d(a, b, c))
        if area > largest:
            axis, largest = k, area
    return axis


@jit
def _seen_along(axis: int, p: Vec) -> Vec:
    """Return a point turned so that an axis points up."""
    if axis == 0:
        return p[1], p[2], p[0]
    if axis == 1:
        return p[2], p[0], p[1]
    return p
