"""Where does an edge of one mesh go through the surface of another, how deep, and along which direction?

The paper tests vertices only: two edges that cross may then pass through each other (§6).
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from softbody.collision.edge_edge import PARALLEL_SINE
from softbody.geometry.bvh import BVH, Search, closest_in_bvh
from softbody.geometry.bvh_rays import Hits
from softbody.geometry.triangle import area_vector, weighted_point
from softbody.jit import jit_lean
from softbody.vec import Vec, add, cross, dot, load, norm, scale, sub


class Crossing(NamedTuple):
    """An edge that goes through a surface; a depth ≤ 0: it does not."""

    depth: float  # [m]
    normal: Vec  # unit, from the mesh to the edge
    place: float  # on the edge, 0 at its start … 1 at its end
    triangle: int
    weights: Vec  # barycentric, of the point that it touches once they are parted


NONE = Crossing(0.0, (0.0, 0.0, 0.0), 0.0, -1, (0.0, 0.0, 0.0))

# A depth below this part of an edge's length is rounding, as where an edge meets its own mirror image.
GRAZING = 1e-9


@jit_lean
def edge_across_edge(p: Vec, q: Vec, hits: Hits, vertices: np.ndarray, triangles: np.ndarray) -> Crossing:
    """Return where the segment from `p` to `q` [m] crosses an edge of a mesh, if that is how it goes through.

    By its two `hits`; of a segment that starts inside, the triangle closest to its start and the one it leaves by. A
    triangle of −1: the two have no edge in common that it crosses. The two edges are parted by the depth along the
    normal, their common perpendicular. `vertices` (n, 3) [m], `triangles` (t, 3).
    """
    enter, one, leave, other = hits
    side = _common_side(triangles, one, other)
    if side < 0:
        return NONE
    # The common perpendicular of the two edges.
    along, up, up_other = sub(q, p), facing(triangles, one, vertices), facing(triangles, other, vertices)
    u, v = load(vertices, triangles[one, side]), load(vertices, triangles[one, (side + 1) % 3])
    edge = sub(v, u)
    across = cross(along, edge)
    square = dot(across, across)
    if not square > PARALLEL_SINE * PARALLEL_SINE * dot(along, along) * dot(edge, edge):
        return NONE
    # Where it meets both, and how deep, as seen from outside.
    place = dot(sub(u, p), cross(edge, across)) / square
    part = dot(sub(u, p), cross(along, across)) / square
    out = add(scale(norm(up_other), up), scale(norm(up), up_other))
    normal = scale((1.0 if dot(across, out) > 0.0 else -1.0) / np.sqrt(square), across)
    depth = dot(sub(u, p), normal)
    if not (enter <= place <= leave and 0.0 <= part <= 1.0 and depth > GRAZING * norm(along)):
        return NONE
    weights = (1.0 - part, part, 0.0) if side == 0 else (0.0, 1.0 - part, part)
    return Crossing(depth, normal, place, one, weights if side < 2 else (part, 0.0, 1.0 - part))


@jit_lean
def edge_through_faces(p: Vec, q: Vec, hits: Hits, tree: BVH, vertices: np.ndarray, search: Search) -> Crossing:
    """Return the crossing at the middle of what is inside of the segment from `p` to `q` [m], by its two `hits`.

    It is parted from the mesh along the shortest way out. `tree` must have been fitted to `vertices` (n, 3) [m].
    """
    enter, one, leave, _ = hits
    place = 0.5 * (enter + leave)
    if not leave - enter > GRAZING:
        return NONE
    middle = add(scale(1.0 - place, p), scale(place, q))
    triangle, weights, _ = closest_in_bvh(middle, tree, vertices, search, one)
    depth, normal = depth_and_direction(middle, vertices, tree.triangles, triangle, weights)
    return Crossing(depth, normal, place, triangle, weights)


@jit_lean
def depth_and_direction(p: Vec, vertices: np.ndarray, triangles: np.ndarray, t: int, weights: Vec) -> tuple[float, Vec]:
    """Return (depth [m], unit vector): from `p` to a point of triangle `t`, or depth 0 if `p` is in front of it.

    The shortest way out is along the triangle's normal, but where the closest point is on a reentrant edge.
    """
    a, b, c = load(vertices, triangles[t, 0]), load(vertices, triangles[t, 1]), load(vertices, triangles[t, 2])
    out = sub(weighted_point(weights, a, b, c), p)
    depth, face = norm(out), area_vector(a, b, c)
    if depth == 0.0 or dot(out, face) <= 0.0:
        return 0.0, (0.0, 0.0, 0.0)
    if depth * depth <= GRAZING * GRAZING * norm(face):  # so short a way has no direction
        return depth, scale(1.0 / norm(face), face)
    return depth, scale(1.0 / depth, out)


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
