"""How far the vertices of a closed mesh may move while all of it is seen from one point, from high above each triangle.

Then nothing but neighbours is near: walls that are seen from one point, and from so high, open like a groove.
"""

from __future__ import annotations

from math import sqrt

import numpy as np

from softbody.compiler.jit import jit, jit_lean
from softbody.compiler.simd import (
    LANES,
    Lanes,
    bits_at_most,
    gather_lanes,
    in_double,
    least_lane,
    spread,
    square_root,
    where_less,
)
from softbody.geometry.affine_fit import mean_of
from softbody.linalg.vec import Vec, add, cross, dot, norm, sub
from softbody.linalg.vec_lanes import VecLanes

# The part of the lowest altitude that a vertex may move. A plane turns by no more than twice what its corners move,
# over the altitude that is left: so many times what they move over what it was.
OF_ALTITUDE = 1.0 / 3.0
TURN = 2.0 / (1.0 - 2.0 * OF_ALTITUDE)

SURE = 1e-9  # sine from which the side that a point is on is sure: far beyond rounding
TINY = 1e-300  # so that nothing is divided by 0


def corners_of(triangles: np.ndarray, place: np.ndarray) -> np.ndarray:
    """Return where the corners of triangles (t, 3) are (s,), as `place` (n,) tells it of each vertex.

    First corners of eight triangles come before their second and third ones; the last triangle fills up the lanes.
    """
    filled = np.minimum(np.arange(-(-len(triangles) // LANES) * LANES), len(triangles) - 1)
    return place[triangles[filled]].reshape(-1, LANES, 3).transpose(0, 2, 1).reshape(-1).astype(np.uint32)


def room_of_mesh(vertices: np.ndarray, triangles: np.ndarray, least: float) -> float:
    """Return what `room_of_star` says [m] of vertices (n, 3) [m] as they are seen from their mean."""
    return room_of_vertices(vertices, corners_of(triangles, 3 * np.arange(len(vertices))), least)


@jit
def room_of_vertices(vertices: np.ndarray, corners: np.ndarray, least: float) -> float:
    """Return what `room_of_star` says [m] of vertices (n, 3) [m] as they are seen from their mean."""
    numbers, mean = vertices.reshape(-1), mean_of(vertices)
    return room_of_star((numbers, numbers[1:], numbers[2:]), corners, mean, least)


@jit_lean
def room_of_star(rows: tuple[np.ndarray, np.ndarray, np.ndarray], corners: np.ndarray, eye: Vec, least: float) -> float:
    """Return how far [m] each vertex may move, beside an eye, while it sees the mesh whole and from high.

    `rows` are x, y and z [m]; see `corners_of`. The eye stays higher than `least` [m] above the
    plane of each triangle, seen from inside; not above 0: it is not now.
    """
    room, square = spread(np.inf), spread(np.inf)
    ahead = (0.0, 0.0, 0.0)
    for k in range(3):
        i = corners[k * LANES]
        ahead = add(ahead, sub((float(rows[0][i]), float(rows[1][i]), float(rows[2][i])), eye))
    far_ahead = SURE * norm(ahead)
    for t in range(0, corners.shape[0], 3 * LANES):
        a = _seen_from(eye, rows, corners, t)
        b = _seen_from(eye, rows, corners, t + LANES)
        c = _seen_from(eye, rows, corners, t + 2 * LANES)
        # Where another triangle than the first is ahead, the mesh is wrapped around the eye more than once.
        on_left = _least(_least(dot(cross(a, b), ahead), dot(cross(b, c), ahead)), dot(cross(c, a), ahead))
        aa, bb, cc = dot(a, a), dot(b, b), dot(c, c)
        behind = bits_at_most(spread(0.0) - (aa + bb + cc) * far_ahead, on_left)
        if (behind & ~1 if t == 0 else behind) != 0:
            return -1.0
        one, two, three = sub(b, a), sub(c, b), sub(a, c)
        normal = cross(one, two)
        area, side = dot(normal, normal) + TINY, _most(_most(dot(one, one), dot(two, two)), dot(three, three)) + TINY
        height = dot(a, normal)  # times twice the area, as is all that follows
        # No corner is farther from the foot of the eye than so.
        far = _most(_most(_most(aa, bb), cc) - height * height / area, spread(0.0))
        twice_area = square_root(area)
        room = _least(room, (height - least * twice_area) / (twice_area + TURN * square_root(far * side)))
        square = _least(square, area / side)
    altitude = sqrt(least_lane(square))
    is_seen = eye[0] + eye[1] + eye[2] + altitude < np.inf
    return min(least_lane(room), OF_ALTITUDE * altitude) if is_seen else -1.0


@jit_lean
def _seen_from(eye: Vec, rows: tuple[np.ndarray, np.ndarray, np.ndarray], corners: np.ndarray, i: int) -> VecLanes:
    """Return the ways [m] from an eye to eight corners."""
    return (
        in_double(gather_lanes(rows[0], corners, i)) - eye[0],
        in_double(gather_lanes(rows[1], corners, i)) - eye[1],
        in_double(gather_lanes(rows[2], corners, i)) - eye[2],
    )


@jit_lean
def _least(a: Lanes, b: Lanes) -> Lanes:
    return where_less(a, b, a, b)


@jit_lean
def _most(a: Lanes, b: Lanes) -> Lanes:
    return where_less(a, b, b, a)
