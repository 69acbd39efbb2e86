"""Which triangles of a mesh that deforms does a ray or a segment go through? Asked of its BVH.

A box is passed over only if nothing in it can be met, in spite of any rounding: boxes are grown by more than that. What
is met in the others is decided from the corners of the mesh itself, as without a tree.
"""

from __future__ import annotations

from math import isfinite

import numpy as np

from softbody.geometry.bvh import BVH, LEVEL_SHIFT, WIDTH, Search, Vec32, in_half_sizes
from softbody.geometry.polyhedron import UNCERTAIN, ray_hits_triangle, ray_hits_triangle_filtered
from softbody.geometry.triangle import area_vector
from softbody.jit import jit, jit_inlined, jit_lean
from softbody.vec import Vec, cross, dot, load, sub

NEVER = np.inf  # where a segment meets nothing


@jit
def point_in_bvh(p: Vec, tree: BVH, vertices: np.ndarray, search: Search) -> bool:
    """Tell whether `p` [m] is inside a closed mesh: as `point_in_polyhedron`; paper §4.6.

    The tree must have been fitted to `vertices` (n, 3) [m].
    """
    inside = False
    for k in range(list_near(p, (p[0], p[1], np.inf), tree, search)):
        t = search.listed[k]
        a, b = load(vertices, tree.triangles[t, 0]), load(vertices, tree.triangles[t, 1])
        inside ^= ray_hits_triangle(p, a, b, load(vertices, tree.triangles[t, 2]))
    return inside


@jit_inlined
def point_in_bvh_filtered(p: Vec, tree: BVH, vertices: np.ndarray, search: Search) -> int:
    """Return the answer of `point_in_bvh`, 1 or 0, or UNCERTAIN where the floating-point filter fails."""
    odd = 0
    for k in range(list_near(p, (p[0], p[1], np.inf), tree, search)):
        t = search.listed[k]
        a, b = load(vertices, tree.triangles[t, 0]), load(vertices, tree.triangles[t, 1])
        hit = ray_hits_triangle_filtered(p, a, b, load(vertices, tree.triangles[t, 2]))
        if hit == UNCERTAIN:
            odd = UNCERTAIN
            break
        odd ^= hit
    return odd


@jit_inlined
def segment_hits(p: Vec, q: Vec, tree: BVH, vertices: np.ndarray, search: Search, places: np.ndarray) -> int:
    """Write into `places` (t,) where the segment from `p` to `q` [m] goes through triangles; return how many it does.

    Places are 0 at p … 1 at q, in no order. Other arguments as of `point_in_bvh`.
    """
    low = min(p[0], q[0]), min(p[1], q[1]), min(p[2], q[2])
    high = max(p[0], q[0]), max(p[1], q[1]), max(p[2], q[2])
    count = 0
    for k in range(list_near(low, high, tree, search)):
        t = search.listed[k]
        a, b = load(vertices, tree.triangles[t, 0]), load(vertices, tree.triangles[t, 1])
        place = _place_in_triangle(p, q, a, b, load(vertices, tree.triangles[t, 2]))
        if place < NEVER:
            places[count] = place
            count += 1
    return count


@jit_lean
def _place_in_triangle(p: Vec, q: Vec, a: Vec, b: Vec, c: Vec) -> float:
    """Return where the segment from `p` to `q` goes through a triangle, 0 at p … 1 at q, or NEVER.

    What passes an edge or a corner of a mesh to the last bit counts as moved aside by next to nothing, along x, then y,
    then z (simulation of simplicity, Edelsbrunner and Mücke 1990): so it goes in as often as out.
    """
    n = area_vector(a, b, c)
    before, beyond = dot(sub(p, a), n), dot(sub(q, a), n)
    if _is_positive(before, n) == _is_positive(beyond, n):
        return NEVER
    # Seen along the segment, which side of the three edges is it on?
    along = sub(q, p)
    pa, pb, pc = sub(a, p), sub(b, p), sub(c, p)
    u = _is_positive(dot(along, cross(pb, pc)), cross(along, sub(c, b)))
    v = _is_positive(dot(along, cross(pc, pa)), cross(along, sub(a, c)))
    w = _is_positive(dot(along, cross(pa, pb)), cross(along, sub(b, a)))
    if not u == v == w:
        return NEVER
    return before / (before - beyond) if before != beyond else 0.0


@jit_lean
def _is_positive(value: float, slope: Vec) -> bool:
    """Tell whether a value is > 0 or, where it is 0, becomes so with the first move along x, y, z that changes it."""
    if value != 0.0:
        return value > 0.0
    first = slope[0] if slope[0] != 0.0 else slope[1] if slope[1] != 0.0 else slope[2]
    return first > 0.0


@jit_inlined
def list_near(low: Vec, high: Vec, tree: BVH, search: Search) -> int:
    """List in `search.listed` the triangles whose boxes meet that between two corners [m]; return how many.

    None, if a vertex of the mesh or a number of `low` is not finite.
    """
    middle, per_metre = (tree.frame[0], tree.frame[1], tree.frame[2]), tree.frame[3]
    if not isfinite(per_metre * (low[0] + low[1] + low[2])):
        return 0
    asked = in_half_sizes(low, middle, per_metre), in_half_sizes(high, middle, per_metre)
    waiting, listed, gap = search.node, search.listed, search.near
    found, count = 0, 1
    waiting[0] = (tree.level_start.shape[0] - 1) << LEVEL_SHIFT
    while count > 0:
        count -= 1
        level, number = waiting[count] >> LEVEL_SHIFT, waiting[count] & ((1 << LEVEL_SHIFT) - 1)
        _find_gaps(tree.boxes, tree.level_start[level] + number, asked, gap)
        if level > 0:
            for s in range(WIDTH):
                waiting[count] = (level - 1) << LEVEL_SHIFT | (WIDTH * number + s)
                count += gap[s] <= 0.0
        else:
            # The last leaf is filled up with triangles that are there already.
            for s in range(min(WIDTH, tree.triangles.shape[0] - WIDTH * number)):
                listed[found] = tree.order[WIDTH * number + s]
                found += gap[s] <= 0.0
    return found


@jit_lean
def _find_gaps(boxes: np.ndarray, node: int, asked: tuple[Vec32, Vec32], gap: np.ndarray) -> None:
    """Write into `gap` how far each child of a node is from a box, by its low and high corner, along some axis.

    In half sizes; ≤ 0: they meet.
    """
    x0, y0, z0 = asked[0]
    x1, y1, z1 = asked[1]
    for s in range(gap.shape[0]):  # not range(8): that is unrolled, and then not vectorised
        apart = boxes[node, 0, s] - x1
        other = x0 - boxes[node, 3, s]
        apart = apart if apart > other else other
        other = boxes[node, 1, s] - y1
        apart = apart if apart > other else other
        other = y0 - boxes[node, 4, s]
        apart = apart if apart > other else other
        other = boxes[node, 2, s] - z1
        apart = apart if apart > other else other
        other = z0 - boxes[node, 5, s]
        gap[s] = apart if apart > other else other
