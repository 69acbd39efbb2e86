"""Which triangles of a mesh that deforms does a ray or a segment go through? Asked of its BVH.

What is met in the boxes that the tree lists is decided from the corners of the mesh itself, as without a tree.
"""

from __future__ import annotations

import numpy as np

from softbody.geometry.aabb import box_around
from softbody.geometry.bvh import BVH, Search
from softbody.geometry.bvh_boxes import ask_box, ask_nothing, list_near
from softbody.geometry.polyhedron import UNCERTAIN, ray_hits_triangle, ray_hits_triangle_filtered
from softbody.geometry.segments import bits_not_beside, bits_not_past, end_of, start_of
from softbody.geometry.triangle import area_vector
from softbody.jit import jit_lean
from softbody.lanes import lowest_bit
from softbody.vec import Vec, cross, dot, load, sub

NEVER = np.inf  # where a segment meets nothing


@jit_lean
def point_in_bvh(p: Vec, tree: BVH, vertices: np.ndarray, search: Search) -> bool:
    """Tell whether `p` [m] is inside a closed mesh: as `point_in_polyhedron`; paper §4.6.

    The tree must have been fitted to `vertices` (n, 3) [m].
    """
    inside = False
    ask_nothing(search)
    ask_box(search, 0, p, (p[0], p[1], np.inf), tree)
    for k in range(list_near(tree, search)):
        a, b, c = _corners(tree, vertices, search.listed[k])
        inside ^= ray_hits_triangle(p, a, b, c)
    return inside


@jit_lean
def points_in_bvh_filtered(
    points: np.ndarray, asked: np.ndarray, tree: BVH, vertices: np.ndarray, search: Search
) -> tuple[int, int]:
    """Return bits: which of `points` are inside, and of which that is in doubt; `asked` (≤ 8,) are their numbers.

    The answers of `point_in_bvh`, but where the floating-point filter fails.
    """
    inside = in_doubt = 0
    ask_nothing(search)
    for lane in range(asked.shape[0]):
        p = load(points, asked[lane])
        ask_box(search, lane, p, (p[0], p[1], np.inf), tree)
    for k in range(list_near(tree, search)):
        a, b, c = _corners(tree, vertices, search.listed[k])
        meets = search.meets[k]
        while meets != 0:
            lane = lowest_bit(meets)
            meets &= meets - 1
            hit = ray_hits_triangle_filtered(load(points, asked[lane]), a, b, c)
            inside ^= (hit & 1) << lane
            in_doubt |= (hit == UNCERTAIN) << lane
    return inside & ~in_doubt, in_doubt


@jit_lean
def segment_hits(
    segments: np.ndarray,
    count: int,
    tree: BVH,
    vertices: np.ndarray,
    search: Search,
    hits: np.ndarray,
    place: np.ndarray,
) -> None:
    """Find where segments, the first `count` of `segments` (9, 8) [m], go through triangles.

    `hits` (8,) is overwritten by how often each does, and the first entries of `place` (8, t) by where, 0 at its start
    … 1 at its end, in no order. The tree must have been fitted to `vertices` (n, 3) [m].
    """
    ask_nothing(search)
    for lane in range(count):
        low, high = box_around(start_of(segments, lane), end_of(segments, lane), 0.0)
        ask_box(search, lane, low, high, tree)
        hits[lane] = 0
    for k in range(list_near(tree, search)):
        a, b, c = _corners(tree, vertices, search.listed[k])
        meets = search.meets[k] & bits_not_beside(segments, a, area_vector(a, b, c))
        meets &= bits_not_past(segments, a, b, c)
        while meets != 0:
            lane = lowest_bit(meets)
            meets &= meets - 1
            where = _place_in_triangle(start_of(segments, lane), end_of(segments, lane), a, b, c)
            if where < NEVER:
                place[lane, hits[lane]] = where
                hits[lane] += 1


@jit_lean
def _corners(tree: BVH, vertices: np.ndarray, t: int) -> tuple[Vec, Vec, Vec]:
    """Return the corners [m] of a triangle."""
    i, j, k = tree.triangles[t, 0], tree.triangles[t, 1], tree.triangles[t, 2]
    return load(vertices, i), load(vertices, j), load(vertices, k)


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
