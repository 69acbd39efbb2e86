"""Crossing of two meshes' edges: where, how deep, and along which direction they part.

The paper tests vertices only: two edges that cross may then pass through each other (§6). Neither edge is treated
otherwise than the other, and nothing depends on how vertices and triangles are numbered.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from softbody.collision.edge_edge import PARALLEL_SINE
from softbody.compiler.jit import jit_lean
from softbody.compiler.simd import bits_at_most, square_root
from softbody.geometry.segments import starts_of, ways_of
from softbody.linalg.vec import Vec, cross, dot, norm, scale, sub


class Ridge(NamedTuple):
    """An edge of a closed mesh, and what is on both sides of it [m]."""

    start: Vec
    end: Vec
    left: Vec  # third corner of the triangle that has the side from start to end
    right: Vec  # of that which has the side from end to start


class Crossing(NamedTuple):
    """Two edges that are across each other inside both bodies; a depth ≤ 0: they are not."""

    depth: float  # [m]
    normal: Vec  # unit, from the second to the first
    place: float  # on the first, 0 at its start … 1 at its end
    other_place: float  # on the second
    on_left: bool  # the second's left triangle faces the normal more than its right one


NONE = Crossing(0.0, (0.0, 0.0, 0.0), 0.0, 0.0, False)

# Sine of the angle by which a face may be on the wrong side of the plane. Without it an edge that lies on a face is on
# the knife's edge: two crossings would take turns, a step each, and what rests on them tremble.
SLACK = 0.1

# Sine of the angle by which two faces may be bent inwards at a ridge. What a ridge bears bends it flat, and one that is
# then none bears it in every second step.
FLAT = 0.02

# A depth below this part of an edge's length is rounding, as where an edge meets its own mirror image.
GRAZING = 1e-9


@jit_lean
def bits_across(segments: np.ndarray, other: Ridge, deepest: float) -> int:
    """Return bits: which of eight edges (9, 8) [m] may cross `other`, no deeper than `deepest` [m].

    No others do. It is what `edge_across_edge` asks first, of what needs not be known of the eight but their ends.
    """
    along, along_other = ways_of(segments), sub(other.end, other.start)
    across = cross(along, along_other)
    square = dot(across, across)
    way = sub(other.start, starts_of(segments))
    place, other_place = dot(way, cross(along_other, across)), dot(way, cross(along, across))
    bits = bits_at_most(0.0, place) & bits_at_most(place, square)
    bits &= bits_at_most(0.0, other_place) & bits_at_most(other_place, square)
    length_square = dot(along, along)
    bits &= ~bits_at_most(square, PARALLEL_SINE * PARALLEL_SINE * length_square * dot(along_other, along_other))
    length = square_root(square)
    left, right = sub(other.left, other.start), sub(other.right, other.start)
    rise_left, rise_right = dot(across, left), dot(across, right)
    slack_left = length * (SLACK * _distance(along_other, left))
    slack_right = length * (SLACK * _distance(along_other, right))
    depth = dot(way, scale(1.0 / length, across))
    least = GRAZING * square_root(length_square)
    up = bits_at_most(rise_left, slack_left) & bits_at_most(rise_right, slack_right)
    up &= bits_at_most(depth, deepest) & ~bits_at_most(depth, least)
    down = bits_at_most(0.0 - rise_left, slack_left) & bits_at_most(0.0 - rise_right, slack_right)
    down &= bits_at_most(-deepest, depth) & ~bits_at_most(0.0 - least, depth)
    return bits & (up | down)


@jit_lean
def _distance(along: Vec, corner: Vec) -> float:
    """Return how far a corner is from a line through the origin [m]."""
    return norm(cross(along, corner)) / norm(along)


@jit_lean
def _sine(normal: Vec, along: Vec, corner: Vec) -> float:
    """Return the sine of the angle by which the face from an edge to a corner is above the plane across a normal."""
    return dot(normal, corner) / _distance(along, corner)


@jit_lean
def _is_reentrant(along: Vec, left: Vec, right: Vec) -> bool:
    """Tell whether the right face of an edge is above the plane of its left one, by more than FLAT."""
    face = cross(along, left)
    return dot(face, right) > FLAT * norm(face) * _distance(along, right)


@jit_lean
def _facing(normal: Vec, along: Vec, left: Vec, right: Vec) -> tuple[float, float]:
    """Return how much the left and the right face of an edge face along a normal, in units that they share."""
    face_left, face_right = cross(along, left), cross(right, along)
    return dot(normal, face_left) * norm(face_right), dot(normal, face_right) * norm(face_left)


@jit_lean
def edge_across_edge(one: Ridge, other: Ridge, deepest: float) -> Crossing:
    """Return how the edge `one` of a mesh crosses the edge `other` of another; none if deeper than `deepest` [m].

    They part along their common perpendicular. Both must be ridges, and each body lie on its own side of the plane
    across it: only then is it a way out that gets no shorter if it turns (Gregorius 2013, the arcs of both ridges on
    the Gauss map cross). A face may be on the wrong side by SLACK, and a ridge bent inwards by FLAT.
    """
    along, along_other = sub(one.end, one.start), sub(other.end, other.start)
    across = cross(along, along_other)
    square = dot(across, across)
    if not square > PARALLEL_SINE * PARALLEL_SINE * dot(along, along) * dot(along_other, along_other):
        return NONE
    # Where the common perpendicular meets both.
    way = sub(other.start, one.start)
    place, other_place = dot(way, cross(along_other, across)), dot(way, cross(along, across))
    if not (0.0 <= place <= square and 0.0 <= other_place <= square):
        return NONE
    apart = dot(way, across)
    normal = scale((1.0 if apart > 0.0 else -1.0) / np.sqrt(square), across)
    depth = dot(way, normal)
    if not GRAZING * norm(along) < depth <= deepest:
        return NONE
    # Both sides of the other edge are to be below it there, and both of its own above.
    left, right, own_left, own_right = (
        sub(other.left, other.start),
        sub(other.right, other.start),
        sub(one.left, one.start),
        sub(one.right, one.start),
    )
    if max(_sine(normal, along_other, left), _sine(normal, along_other, right)) > SLACK:
        return NONE
    if min(_sine(normal, along, own_left), _sine(normal, along, own_right)) < -SLACK:
        return NONE
    if _is_reentrant(along_other, left, right) or _is_reentrant(along, own_left, own_right):
        return NONE
    # What is all but flat has level sides both ways up.
    facing_left, facing_right = _facing(normal, along_other, left, right)
    own_facing = _facing(normal, along, own_left, own_right)
    if facing_left + facing_right <= 0.0 or own_facing[0] + own_facing[1] >= 0.0:
        return NONE
    return Crossing(depth, normal, place / square, other_place / square, facing_left >= facing_right)
