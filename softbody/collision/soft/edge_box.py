"""Intersection of a mesh's edge with a box: where, how deep, and along which direction they part.

The paper tests vertices only, so that a soft body sags over an edge of a box until a particle is inside (§6).
"""

from __future__ import annotations

from math import inf

from softbody.collision.boxes.sat_boxes import PlacedBox
from softbody.collision.edge_edge import PARALLEL_SINE
from softbody.compiler.jit import jit_lean
from softbody.linalg.quaternion import rotate, rotate_inverse
from softbody.linalg.vec import Vec, cross, dot, norm, scale, sub

Segment = tuple[Vec, Vec]  # both ends [m]
NOWHERE = (0.0, 0.0, 0.0)


@jit_lean
def edge_in_box(edge: Segment, box: PlacedBox, edge_before: Segment, box_before: PlacedBox) -> tuple[float, Vec, float]:
    """Return (depth [m], normal, place) of an edge in a box; a depth ≤ 0: it is outside.

    They part by `depth` along the unit `normal`, from the box to the edge: normal to a face, or to the edge and a side
    of the box that it crosses (separating axes). It is the axis that parted them before, at the latest; if none did,
    the one along which they were the least inside each other. They touch at the edge's `place`, 0 at its first end … 1
    at the other.
    """
    half = scale(0.5, box.size)
    a, b = _seen_from(box, edge)
    for axis in range(3):  # most edges are beyond a face, and need no division
        if min(a[axis], b[axis]) >= half[axis] or max(a[axis], b[axis]) <= -half[axis]:
            return 0.0, NOWHERE, 0.0
    along = sub(b, a)
    first, last = _part_between(a, along, half, -1)
    if not first < last:
        return 0.0, NOWHERE, 0.0
    a_before, b_before = _seen_from(box_before, edge_before)
    along_before = sub(b_before, a_before)
    latest, depth, normal, place = -inf, 0.0, NOWHERE, 0.0
    for k in range(6):
        now, old = _axis(k, along), _axis(k, along_before)
        if now == NOWHERE or old == NOWHERE:
            continue
        # On which side of the box was the edge, and how far apart were they, and are they?
        up = min(dot(a_before, old), dot(b_before, old)) - _reach(half, old)
        down = -max(dot(a_before, old), dot(b_before, old)) - _reach(half, old)
        way = scale(1.0 if (up > down) == (dot(now, old) > 0.0) else -1.0, now)
        gap, overlap = max(up, down), _reach(half, now) - min(dot(a, way), dot(b, way))
        # The part of its way at which it came in along this axis, above 0; or how deep it was before, negative.
        came = gap / (gap + overlap) if gap > 0.0 else gap
        if came <= latest:
            continue
        if k >= 3:
            where, along_side = _crossing(a, along, way, k - 3, half)
            if not (0.0 <= where <= 1.0 and abs(along_side) <= half[k - 3]):
                continue  # the lines cross, and not the edge and the side
            latest, depth, normal, place = came, overlap, way, min(max(where, first), last)
        else:
            latest, normal = came, way
            depth, place = _way_out_by_face(a, along, way, k, half)
    return depth, rotate(box.orientation, normal), place


@jit_lean
def _part_between(a: Vec, along: Vec, half: Vec, but: int) -> tuple[float, float]:
    """Return where on an edge, 0 … 1 `along` from `a`, it is between all opposite faces, `but` those of one axis."""
    first, last = 0.0, 1.0
    for axis in range(3):
        if axis != but and along[axis] != 0.0:
            one, other = (-half[axis] - a[axis]) / along[axis], (half[axis] - a[axis]) / along[axis]
            first, last = max(first, min(one, other)), min(last, max(one, other))
    return first, last


@jit_lean
def _way_out_by_face(a: Vec, along: Vec, normal: Vec, k: int, half: Vec) -> tuple[float, float]:
    """Return how far [m] an edge is behind face k, of a `normal`, where it is above or below it; and where most."""
    first, last = _part_between(a, along, half, k)
    rise = dot(along, normal)
    place = first if rise > 0.0 else last if rise < 0.0 else 0.5 * (first + last)
    return half[k] - (dot(a, normal) + place * rise), place


@jit_lean
def _seen_from(box: PlacedBox, edge: Segment) -> Segment:
    """Return an edge in the frame of a box."""
    return (
        rotate_inverse(box.orientation, sub(edge[0], box.position)),
        rotate_inverse(box.orientation, sub(edge[1], box.position)),
    )


@jit_lean
def _axis(k: int, along: Vec) -> Vec:
    """Return axis k = 0 … 5, of unit length: of a face, or across an edge and a side of the box; 0 if these align."""
    side = (1.0 if k % 3 == 0 else 0.0, 1.0 if k % 3 == 1 else 0.0, 1.0 if k % 3 == 2 else 0.0)
    if k < 3:
        return side
    across = cross(along, side)
    length = norm(across)
    return scale(1.0 / length, across) if length > PARALLEL_SINE * norm(along) else NOWHERE


@jit_lean
def _reach(half: Vec, axis: Vec) -> float:
    """Return how far [m] a box reaches along an axis."""
    return half[0] * abs(axis[0]) + half[1] * abs(axis[1]) + half[2] * abs(axis[2])


@jit_lean
def _crossing(a: Vec, along: Vec, normal: Vec, k: int, half: Vec) -> tuple[float, float]:
    """Return where an edge from `a` and a side of the box along axis k are nearest to each other, as lines.

    The first is a part of the edge; the other how far [m] it is from the side's middle. It is the side that is farthest
    along the normal.
    """
    side = _axis(k, along)
    corner = (
        half[0] if normal[0] > 0.0 else -half[0],
        half[1] if normal[1] > 0.0 else -half[1],
        half[2] if normal[2] > 0.0 else -half[2],
    )
    across, apart = cross(along, side), sub(corner, a)
    square = dot(across, across)
    return dot(cross(apart, side), across) / square, corner[k] + dot(cross(apart, along), across) / square
