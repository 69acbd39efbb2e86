"""Triangles: area, whether a point is inside, and the closest point to another."""

from __future__ import annotations

from math import inf

import numpy as np

from softbody.compiler.jit import jit, jit_inlined, jit_lean
from softbody.compiler.simd import Lanes, where_less
from softbody.linalg.vec import Vec, add, cross, dot, load, norm, scale, store, sub
from softbody.linalg.vec_lanes import VecLanes


@jit
def area_vector(a: Vec, b: Vec, c: Vec) -> Vec:
    """Return the vector of length area [m²] along the outward (counter-clockwise) normal; paper §2.2."""
    return scale(0.5, cross(sub(b, a), sub(c, a)))


@jit
def triangle_area(a: Vec, b: Vec, c: Vec) -> float:
    """Return the area [m²] of the triangle (a, b, c)."""
    return norm(area_vector(a, b, c))


@jit
def point_in_triangle(p: Vec, a: Vec, b: Vec, c: Vec) -> bool:
    """Tell whether `p`, projected along the normal, lies in the triangle (a, b, c) or on its border; paper §4.8.

    The three sub-triangles that `p` spans with the edges must all turn the way of the whole. The paper asks
    only that they turn the way of the first one, which is also met on the extension of that edge; and a
    triangle without area, which here contains nothing, would contain everything.
    """
    n = cross(sub(b, a), sub(c, a))
    if dot(n, n) == 0.0:
        return False
    pa = sub(a, p)
    pb = sub(b, p)
    pc = sub(c, p)
    return dot(cross(pb, pc), n) >= 0.0 and dot(cross(pc, pa), n) >= 0.0 and dot(cross(pa, pb), n) >= 0.0


@jit
def _along_edge(start: Vec, edge: Vec) -> tuple[float, float]:
    """Return how far along `edge` its point closest to the origin lies, 0 … 1, and its squared distance [m²].

    `start` is where the edge starts. An edge without length is its start.
    """
    square = dot(edge, edge)
    t = -dot(start, edge) / square
    t = t if t > 0.0 else 0.0  # not if NaN: no length
    t = t if t < 1.0 else 1.0
    foot = add(start, scale(t, edge))
    return t, dot(foot, foot)


@jit
def _foot_on_face(pa: Vec, pb: Vec, pc: Vec, ab: Vec, ca: Vec) -> tuple[float, float, float, float]:
    """Return (u, v, w, d² [m²]) of the foot of the perpendicular from the origin; d² is inf if it is not inside."""
    n = cross(ca, ab)
    square = dot(n, n)
    v = dot(cross(pc, pa), n) / square  # weights are as the areas that the foot spans with the edges
    w = dot(cross(pa, pb), n) / square
    u = 1.0 - v - w
    foot = add(pa, sub(scale(v, ab), scale(w, ca)))
    least = u if u < v else v
    least = least if least < w else w
    square = dot(foot, foot)
    return u, v, w, (square if least > 0.0 else inf)  # inf if NaN: no area


@jit_inlined
def squared_distance_to_triangle(p: Vec, a: Vec, b: Vec, c: Vec) -> float:
    """Return the squared distance [m²] of `p` and the triangle (a, b, c); see `closest_point_on_triangle`.

    Without a branch, as `squared_distances_to_triangles`, which has the same bits.
    """
    pa, pb, pc = sub(a, p), sub(b, p), sub(c, p)
    ab, bc, ca = sub(b, a), sub(c, b), sub(a, c)
    _, best = _along_edge(pa, ab)
    _, square = _along_edge(pb, bc)
    best = square if square < best else best
    _, square = _along_edge(pc, ca)
    best = square if square < best else best
    _, _, _, square = _foot_on_face(pa, pb, pc, ab, ca)
    return square if square < best else best


@jit_lean
def squared_distances_to_triangles(p: Vec, a: VecLanes, b: VecLanes, c: VecLanes) -> Lanes:
    """Return the squared distances [m²] of `p` and eight triangles (a, b, c), each as above, to the bit."""
    pa, pb, pc = sub(a, p), sub(b, p), sub(c, p)
    ab, bc, ca = sub(b, a), sub(c, b), sub(a, c)
    best = _along_edges(pa, ab)
    square = _along_edges(pb, bc)
    best = where_less(square, best, square, best)
    square = _along_edges(pc, ca)
    best = where_less(square, best, square, best)
    square = _feet_on_faces(pa, pb, pc, ab, ca)
    return where_less(square, best, square, best)


@jit_lean
def _along_edges(start: VecLanes, edge: VecLanes) -> Lanes:
    """Return the squared distances [m²] of eight edges from the origin; see `_along_edge`."""
    t = (0.0 - dot(start, edge)) / dot(edge, edge)
    t = where_less(0.0, t, t, 0.0)
    t = where_less(t, 1.0, t, 1.0)
    foot = add(start, scale(t, edge))
    return dot(foot, foot)


@jit_lean
def _feet_on_faces(pa: VecLanes, pb: VecLanes, pc: VecLanes, ab: VecLanes, ca: VecLanes) -> Lanes:
    """Return the squared distances [m²] of eight feet of perpendiculars from the origin; see `_foot_on_face`."""
    n = cross(ca, ab)
    square = dot(n, n)
    v = dot(cross(pc, pa), n) / square
    w = dot(cross(pa, pb), n) / square
    u = 1.0 - v - w
    foot = add(pa, sub(scale(v, ab), scale(w, ca)))
    least = where_less(u, v, u, v)
    least = where_less(least, w, least, w)
    return where_less(0.0, least, dot(foot, foot), inf)


@jit
def closest_weights_on_triangle(p: Vec, a: Vec, b: Vec, c: Vec) -> tuple[Vec, float]:
    """Return (weights, d² [m²]) of the point of the triangle (a, b, c) closest to `p`; as above, to the bit."""
    pa, pb, pc = sub(a, p), sub(b, p), sub(c, p)
    ab, bc, ca = sub(b, a), sub(c, b), sub(a, c)
    t, best = _along_edge(pa, ab)
    weights = (1.0 - t, t, 0.0)
    t, square = _along_edge(pb, bc)
    if square < best:
        best = square
        weights = (0.0, 1.0 - t, t)
    t, square = _along_edge(pc, ca)
    if square < best:
        best = square
        weights = (t, 0.0, 1.0 - t)
    u, v, w, square = _foot_on_face(pa, pb, pc, ab, ca)
    if square < best:
        best = square
        weights = (u, v, w)
    return weights, best


@jit
def weighted_point(weights: Vec, a: Vec, b: Vec, c: Vec) -> Vec:
    """Return the point [m] with barycentric `weights` (u, v, w) in a triangle: u a + v b + w c.

    Taken from the corner with the largest weight: so a corner is met exactly, and little is lost far from the origin.
    """
    u, v, w = weights
    if u >= v and u >= w:
        return add(a, add(scale(v, sub(b, a)), scale(w, sub(c, a))))
    if v >= w:
        return add(b, add(scale(u, sub(a, b)), scale(w, sub(c, b))))
    return add(c, add(scale(u, sub(a, c)), scale(v, sub(b, c))))


@jit
def closest_point_on_triangle(p: Vec, a: Vec, b: Vec, c: Vec) -> tuple[Vec, Vec]:
    """Return (point [m], weights): the point of a triangle (a, b, c) closest to `p`; paper §4.3, Ericson 2005, §5.1.5.

    The barycentric weights, of a, b and c, are ≥ 0 and sum to 1 (to rounding). The best of four candidates: the closest
    point of each edge, and the foot of the perpendicular if that falls inside. So a triangle without area is its edges,
    and one without extent a point; of equally close candidates the first. A distance is always one to some point of the
    triangle, to rounding, however thin the triangle.
    """
    weights, _ = closest_weights_on_triangle(p, a, b, c)
    return weighted_point(weights, a, b, c), weights


@jit
def points_in_triangles(points: np.ndarray, corners: np.ndarray) -> np.ndarray:
    """Tell of each of `points` (m, 3) [m] whether it is in its own triangle, `corners` (m, 3, 3) [m]: (m,) of bool."""
    inside = np.empty(points.shape[0], np.bool_)
    for q in range(points.shape[0]):
        a, b, c = load(corners[q], 0), load(corners[q], 1), load(corners[q], 2)
        inside[q] = point_in_triangle(load(points, q), a, b, c)
    return inside


@jit
def closest_points_on_triangles(points: np.ndarray, corners: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Return (points (m, 3) [m], weights (m, 3)) on a triangle for each of `points`, `corners` (m, 3, 3) [m]."""
    closest = np.empty((points.shape[0], 3))
    weights = np.empty((points.shape[0], 3))
    for q in range(points.shape[0]):
        a, b, c = load(corners[q], 0), load(corners[q], 1), load(corners[q], 2)
        point, shares = closest_point_on_triangle(load(points, q), a, b, c)
        store(closest, q, point)
        store(weights, q, shares)
    return closest, weights
