"""Rays and segments through a mesh that deforms: the triangles they hit, by way of its BVH.

What is met in the boxes that the tree lists is decided from the corners of the mesh itself, as without a tree.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from softbody.compiler.jit import jit_lean
from softbody.compiler.simd import lowest_bit
from softbody.geometry.aabb import AABB, box_around
from softbody.geometry.bvh import BVH, Search
from softbody.geometry.bvh_boxes import ask_box, ask_nothing, ask_ray, list_near
from softbody.geometry.polyhedron import UNCERTAIN, ray_hits_triangle, ray_hits_triangle_filtered
from softbody.geometry.segments import bits_not_beside, bits_not_past, end_of, start_of
from softbody.geometry.triangle import area_vector
from softbody.linalg.vec import Vec, cross, dot, load, sub

NEVER = np.inf  # where a segment meets nothing


class Heading(NamedTuple):
    """Along which axis rays go, by the coordinates of a world that is turned, and may be mirrored, so that they go up.

    Which way a triangle faces is nothing to a ray.
    """

    x: int  # which coordinate is x there
    y: int
    z: int
    sign: float  # of z there: −1 where the rays go down


@jit_lean
def shortest_way_out(p: Vec, bounds: AABB) -> Heading:
    """Return along which axis a ray from `p` [m] is soonest out of some bounds; of two as soon, z before y before x."""
    best, sign, least = 2, 1.0, np.inf
    for axis in (2, 1, 0):
        ahead, behind = bounds[1][axis] - p[axis], p[axis] - bounds[0][axis]
        if ahead < least:
            best, sign, least = axis, 1.0, ahead
        if behind < least:
            best, sign, least = axis, -1.0, behind
    one, other = (best + 1) % 3, (best + 2) % 3
    return Heading(one, other, best, sign)


@jit_lean
def point_in_bvh(
    point: int, points: np.ndarray, tree: BVH, vertices: np.ndarray, search: Search, heading: Heading
) -> bool:
    """Tell whether a point, a row of `points` (m, 3) [m], is inside a closed mesh; paper §4.6.

    As `point_in_polyhedron`, but on the surface itself, where it depends on the heading which of the two it is. The
    tree must have been fitted to `vertices` (n, 3) [m].
    """
    inside, p = False, _turned(points, point, heading)
    ask_nothing(search)
    ask_ray(search, 0, load(points, point), heading.z, heading.sign > 0.0, tree)
    for k in range(list_near(tree, search)):
        a, b, c = _turned_corners(tree, vertices, search.listed[k], heading)
        inside ^= ray_hits_triangle(p, a, b, c)
    return inside


@jit_lean
def points_in_bvh_filtered(
    asked: np.ndarray, points: np.ndarray, tree: BVH, vertices: np.ndarray, search: Search, heading: Heading
) -> tuple[int, int]:
    """Return bits: which of `points` are inside, and of which that is in doubt; `asked` (≤ 8,) are their numbers.

    The answers of `point_in_bvh`, but where the floating-point filter fails.
    """
    inside = in_doubt = 0
    ask_nothing(search)
    for lane in range(asked.shape[0]):
        ask_ray(search, lane, load(points, asked[lane]), heading.z, heading.sign > 0.0, tree)
    for k in range(list_near(tree, search)):
        a, b, c = _turned_corners(tree, vertices, search.listed[k], heading)
        meets = search.meets[k]
        while meets != 0:
            lane = lowest_bit(meets)
            meets &= meets - 1
            hit = ray_hits_triangle_filtered(_turned(points, asked[lane], heading), a, b, c)
            inside ^= (hit & 1) << lane
            in_doubt |= (hit == UNCERTAIN) << lane
    return inside & ~in_doubt, in_doubt


@jit_lean
def _turned(rows: np.ndarray, i: int, heading: Heading) -> Vec:
    """Return row `i` of `rows` (n, 3) [m] in the world where rays go up; nothing is rounded."""
    return rows[i, heading.x], rows[i, heading.y], heading.sign * rows[i, heading.z]


@jit_lean
def _turned_corners(tree: BVH, vertices: np.ndarray, t: int, heading: Heading) -> tuple[Vec, Vec, Vec]:
    """Return the corners [m] of a triangle in the world where rays go up."""
    i, j, k = tree.triangles[t, 0], tree.triangles[t, 1], tree.triangles[t, 2]
    return _turned(vertices, i, heading), _turned(vertices, j, heading), _turned(vertices, k, heading)


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
